//! The coordinator of a run: it launches participants, couples them window by window, and writes down what they say.
//!
//! In reading order:
//! - [`output`], [`cost`]: what comes about while a run goes on, where its time went; its files are of [`runs`], its keys of [`scenario`];
//! - [`participants`]: starting participants, keeping watch over them, speaking to them;
//! - [`summary`]: how the judgement of a run is written down; [`events`]: what happens, for whoever listens;
//! - [`mod@run`]: the loop over windows, checkpoints, a whole run.
//!
//! # A run, step by step
//!
//! 1. [`scenario`] reads and checks the file; each participant's own keys are checked by the participant.
//! 2. [`participants`] launches the processes and greets them; each tells its step, its limits and what it offers.
//! 3. [`join`](scheme::join::join) asks for the surfaces, makes N ([`Mapping`](scheme::mapping::Mapping)), and refuses what does not fit.
//! 4. [`Compliance::prepare`](scheme::compliance::Compliance::prepare) gets C, and tells the grains W_g.
//! 5. [`predict`](scheme::predict) runs the scheme itself on linear stand-ins of both sides. What will grow is refused.
//! 6. [`run::time_loop`] goes over the windows; [`Coupling::window`](scheme::coupling::Coupling::window) solves one by its scheme, judges it
//!    ([`scheme::criteria`]), and accepts, halves or ends by the scenario's policy. An accepted window is committed on all sides.
//! 7. [`exchange_log`] keeps every message, [`runs`] the signals and energies of each window, [`run::checkpoint`] all states to go on from.
//! 8. [`runs::plausible`] judges the end, [`summary`] writes it down; `replay` of `lab` runs each solver again from the log alone and compares bits.

pub mod cost;
pub mod events;
pub mod output;
pub mod participants;
pub mod run;
pub mod summary;
