//! Studies through the real command: rows, floors, resuming, engines, budgets.

mod budget;
mod engine_slurm;
mod local;
mod plan;
mod rows;
mod seeds;
mod shipped;
mod tune;
