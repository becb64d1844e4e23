//! Answers to faults: bad scenarios, bad peers, processes that die or fall silent, disks that are full.

mod bad_scenario;
mod campaign;
mod commands;
mod conform;
mod foreign;
mod full_disk;
mod limits;
mod lost_peer;
mod mistakes;
mod movie;
mod newcomer;
mod plausible;
mod progress;
mod resume;
mod same_bits;
mod scene;
mod schema;
mod shipped;
mod simulated;
mod suites;
mod unstable_step;
