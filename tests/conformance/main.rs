//! Rules for links, the wire, the crates and their pages.

mod circles;
mod dependencies;
mod english;
mod golden;
mod kinds;
mod link;
mod readme;
mod shm;
mod size;
mod suite;
