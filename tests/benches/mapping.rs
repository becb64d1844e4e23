//! Time of a mapping between nodes and glued points: one N and one N^T for all points, on flat and curved lines of 10 to 10 000 nodes.
//!
//! ```sh
//! cargo bench -p tests --bench mapping
//! ```
//!
//! `cargo test -p tests --test coupling mapping -- --nocapture` prints the errors of the mappings and their ripple.

use divan::{Bencher, black_box};
use harness::mapped_line::MappedLine;
use scheme::keys::MappingKind::{self, Linear, Mortar, Nearest};

const KINDS: [(MappingKind, &str); 6] = [
    (Mortar, "flat"),
    (Linear, "flat"),
    (Nearest, "flat"),
    (Mortar, "curved"),
    (Linear, "curved"),
    (Nearest, "curved"),
];

fn main() {
    divan::main();
}

#[divan::bench(args = KINDS, consts = [10, 100, 1_000, 10_000])]
fn application<const NODES: usize>(bencher: Bencher, (kind, shape): (MappingKind, &str)) {
    let line = MappedLine::new(kind, shape, NODES).expect("regular input");
    let (force, motion) = (line.force(), line.motion());
    bencher.bench(|| {
        black_box(line.mapping.motion(black_box(&motion)));
        line.mapping.force(black_box(&force))
    });
}
