//! The entries of a log.

use protocol::{Frame, Kind};

/// Sender name of the coupler's frames in the log.
pub const COUPLER: &str = "coupler";

/// One event of the run.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// A frame was sent.
    Exchange(Exchange),
    /// The window ended.
    WindowEnd(u64),
}

/// A frame with its sender and receiver.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exchange {
    /// Name of the interface.
    pub interface: String,
    /// Its sender.
    pub sender: String,
    /// Its receiver.
    pub receiver: String,
    /// The recorded frame.
    pub frame: Frame,
}

impl Exchange {
    /// Name of its channel in the log.
    pub(super) fn topic(&self) -> String {
        let kind = kind_name(self.frame.header.kind);
        format!("{}/{}/{kind}", self.interface, self.sender)
    }
}

/// Key of a channel's metadata that names its interface.
pub(super) const INTERFACE: &str = "interface";

/// The name of a kind, or its number if it has none.
pub(super) fn kind_name(kind: u32) -> String {
    Kind::from_number(kind).map_or_else(|| kind.to_string(), |kind| format!("{kind:?}"))
}
