//! Throughput of the exchange log: 64 MB of messages of 100, 1 000 and 10 000 doubles, written as in a run, with the end of the
//! file, and read back with every checksum verified.
//!
//! ```sh
//! cargo bench -p tests --bench log
//! ```
//!
//! `MB/s` count payload, `Kitem/s` count messages; the files are in the system's temporary folder.

use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};
use harness::random_log::{count, frames, write};
use harness::runs::Scratch;

/// Doubles written for each row.
const DOUBLES: usize = 8_000_000;
/// Doubles of a message.
const SIZES: [usize; 3] = [100, 1_000, 10_000];

fn main() {
    divan::main();
}

#[divan::bench(args = SIZES, sample_count = 10, sample_size = 1)]
fn written(bencher: Bencher, doubles: usize) {
    let (scratch, frames) = (Scratch::new("log"), frames(doubles));
    let path = scratch.path().join("exchange.mcap");
    counting(bencher, doubles)
        .bench(|| write(&path, &frames, DOUBLES / doubles).expect("the folder is writable"));
}

#[divan::bench(args = SIZES, sample_count = 10, sample_size = 1)]
fn read_back(bencher: Bencher, doubles: usize) {
    let scratch = Scratch::new("log");
    let path = scratch.path().join("exchange.mcap");
    write(&path, &frames(doubles), DOUBLES / doubles).expect("the folder is writable");
    counting(bencher, doubles).bench(|| count(&path).expect("it was closed"));
}

/// A bencher that counts payload and messages.
fn counting<'a, 'b>(bencher: Bencher<'a, 'b>, doubles: usize) -> Bencher<'a, 'b> {
    let messages = DOUBLES / doubles;
    let payload = BytesCount::of_many::<f64>(messages * doubles);
    bencher.counter(payload).counter(ItemsCount::new(messages))
}
