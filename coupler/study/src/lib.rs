//! Studies and comparisons of runs: distances of signals, tractions and results, and costs.
//!
//! - [`measure`]: the distance of two runs in a number;
//! - [`mod@file`]: a study as its file says it; [`plan`]: its tasks; [`task`]: one in its folder, [`heartbeats`] of who does it;
//! - [`open_study`]: a study with its folder; [`progress`]: how far a study has come; [`pool`], [`slurm`]: the engines; [`forecast`]: what is asked of a cluster;
//! - [`collect`]: rows; [`settings`], [`front`], [`varied_keys`], [`mod@ensemble`]: what they say; [`picture`], [`digest`]: in pictures and words;
//! - [`stored`]: a study that is kept for choosing by it, [`statistics`]: what it says about another scene,
//!   [`budget`]: the setting that it has for one, [`scene_front`]: a run among its settings;
//! - [`knobs`]: the numerical choices of a scene, [`draft`]: a study of them that is written, [`error_model`]: what each of them does,
//!   [`search`]: the cheapest setting within an error, [`tuning`]: the runs by which it is found.

pub mod budget;
pub mod collect;
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
