//! Duties of every `Link`.
//!
//! A new link passes [`suite::check`] unchanged. The time limits only detect a link that hangs; nothing is asserted about speed.

use protocol::link::channel;

use crate::suite;

#[test]
fn channel_is_a_link() {
    suite::check(|| {
        let (left, right) = channel::pair();
        (Box::new(left), Box::new(right))
    });
}
