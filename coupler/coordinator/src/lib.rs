//! The coordinator of a run: it launches participants, couples them window by window, and records the exchange.
//!
//! In reading order:
//! - [`output`], [`cost`]: means, balances and progress during a run, and where its time went; its files belong to
//!   [`runs`], its keys to [`scenario`];
//! - [`participants`]: starting participants, watching them, exchanging frames with them;
//! - [`summary`]: the record of a run's judgement; [`events`]: the events of a run, for a listener;
//! - [`mod@run`]: the loop over windows, checkpoints, a whole run.
//!
//! # A run, step by step
//!
//! 1. [`scenario`] reads and checks the file; each participant's own keys are checked by the participant.
//! 2. [`participants`] launches the processes and greets them; each describes its step, its limits and its
//!    capabilities.
//! 3. [`join`](scheme::join::join) requests the surfaces, makes N ([`Mapping`](scheme::mapping::Mapping)), and refuses
//!    sides that do not fit.
//! 4. [`Compliance::prepare`](scheme::compliance::Compliance::prepare) gets C, and sends W_g to the grains.
//! 5. [`predict`](scheme::predict) runs the scheme itself on linear models of both sides. A scheme with growing
//!    disturbances is refused.
//! 6. [`run::time_loop`] runs the windows; [`Coupling::window`](scheme::coupling::Coupling::window) solves one by its
//!    scheme, judges it ([`scheme::criteria`]), and accepts it, halves it or ends the run by the scenario's policy. All
//!    sides commit an accepted window.
//! 7. [`exchange_log`] stores every message, [`runs`] the signals and energies of each window, [`run::checkpoint`] all
//!    states for a resumed run.
//! 8. [`runs::plausible`] judges the end, [`summary`] records it; `replay` of `lab` runs each solver again from the log
//!    alone and compares bits.

pub mod cost;
pub mod events;
pub mod output;
pub mod participants;
pub mod run;
pub mod summary;
