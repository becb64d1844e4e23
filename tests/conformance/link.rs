//! Duties of every `Link`, and those of shared memory besides.
//!
//! A new link passes [`suite::check`] unchanged. The time limits here only tell a failure from a link that
//! hangs; nothing is asserted about speed.

use protocol::link::channel;

use crate::suite;

#[test]
fn channel_is_a_link() {
    suite::check(|| {
        let (left, right) = channel::pair();
        (Box::new(left), Box::new(right))
    });
}
