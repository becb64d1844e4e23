//! Studies and comparisons of runs: distances of signals, tractions and results, and costs.
//!
//! - [`measure`]: the distance between two runs as a number;
//! - [`mod@file`]: a study file; [`plan`]: its tasks; [`task`]: a task in its folder; [`heartbeats`]: of tasks in other processes;
//! - [`open_study`]: a study with its folder; [`progress`]: the progress of a study; [`pool`], [`slurm`]: the engines; [`forecast`]: cost;
//! - [`collect`]: rows; [`settings`], [`front`], [`varied_keys`], [`mod@ensemble`]: their evaluation; [`picture`], [`digest`]: pictures, words;
//! - [`stored`]: a study stored for `run --budget`, [`statistics`]: its prediction for another scene,
//!   [`budget`]: the setting that it chooses, [`scene_front`]: a run among its settings;
//! - [`knobs`]: the numerical choices of a scene, [`draft`]: a study of them, [`error_model`]: the error of each,
//!   [`search`]: the cheapest setting within an error, [`tuning`]: the runs that find it.

pub mod budget;
pub mod collect;
pub mod curves;
pub mod digest;
pub mod draft;
pub mod ensemble;
pub mod error_model;
pub mod file;
pub mod forecast;
pub mod front;
pub mod heartbeats;
pub mod knobs;
pub mod measure;
pub mod open_study;
pub mod picture;
pub mod plan;
pub mod pool;
pub mod progress;
pub mod scene_front;
pub mod search;
pub mod settings;
pub mod slurm;
pub mod statistics;
pub mod stored;
pub mod task;
pub mod tuning;
pub mod varied_keys;
