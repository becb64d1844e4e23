//! Measurements of what the machine gives.

pub mod exchange;
pub mod log;
pub mod mapping;
pub mod participant;
pub mod pieces;
pub mod stability;
