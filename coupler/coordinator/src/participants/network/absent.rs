//! The network of a program built without links between hosts.

use std::path::Path;

use protocol::{Link, LinkError, Transport};

use scenario::error::Result;
use scenario::load::Loaded;

/// There is no value: a scenario that needs a network is refused before.
pub(crate) enum Network {}

/// Without links there is nothing to check.
pub fn check(_: &Loaded) -> Result<()> {
    Ok(())
}

impl Network {
    pub fn listen(_: &Loaded, _: u64, _: usize) -> Result<Network> {
        unreachable!("a scenario that asks for other hosts was refused")
    }

    pub fn link(&self, _: &str) -> Result<Box<dyn Link>, LinkError> {
        match *self {}
    }

    pub fn transport(&self, _: &str, _: &Path) -> Transport {
        match *self {}
    }

    pub fn complaints(&self) -> Vec<String> {
        match *self {}
    }

    pub fn endpoint(&self) -> &str {
        match *self {}
    }
}
