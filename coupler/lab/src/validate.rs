//! Verification by scenes: a folder with a scenario and `expected.toml`, which contains the expected results and their sources.
//!
//! ```toml
//! [[case]]
//! name = "Hertz line contact, 8 000 N"
//! source = "Hertz (1882); Johnson, Contact Mechanics (1985), section 4.2"
//! set = ["participant.rail.config.contact.friction=0"]     # overrides, none by default
//! [[case.number]]
//! path = "results.p0_pa"             # in summary.json, or signals.<column>.<last | max | min | mean | t_max | t_min>
//! expected = 977.8e6
//! tolerance_rel = 0.03               # or tolerance_abs, or ratio = [least, largest]
//! ```
//!
//! `full = true` reserves a long case for `--full`; `seeds = [1, 2, 3]` runs a case with each seed. `scene = "../../quick"` at the top of the
//! file runs a scenario in another folder. A case that must fail says how: `exit_code = 3`, `says = ["starved"]`.
//!
//! - [`case`](mod@case): the file; `signals`: numbers of signals.csv;
//! - [`suite`]: running the cases of a folder; [`page`]: a page of the results.

pub mod case;
pub mod page;
mod signals;
pub mod suite;
