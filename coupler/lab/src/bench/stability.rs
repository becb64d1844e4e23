//! Stability of every scheme over mass ratio, substeps, CFL number, theta and stiffness ratio.
//!
//! An elastic bar of ten elements takes explicit steps. Its far end is held, so that every wave comes back; at its other end is a mass
//! behind a spring (or glued), which takes one implicit step per window. Growth is the spectral radius of one window of both, from the
//! scheme on the matrices of the bar's window. A sample of cells also runs window by window and must give the same forces.
//! Fixed-point schemes have the constant relaxation 0.5; other relaxations are adaptive. If the continuum follows the boundary, the
//! point on it weighs 1 % of the mass behind it.
//!
//! - [`bar`]: the continuum;
//! - [`setup`]: schemes on it and the masses;
//! - [`map`](mod@map): growth in every cell;
//! - [`limits`](mod@limits): predicted and measured limits of stability;
//! - [`picture`]: the map as a picture.

use std::fmt;
use std::path::Path;

use map::{Axes, Cell};
use protocol::larger;
use scenario::error::Error;
use scheme::keys::CouplingScheme;
use scheme::predict::prediction::NEUTRAL;
use terminal::print_note;

pub mod bar;
pub mod limits;
pub mod map;
pub mod picture;
pub mod setup;

/// One in this many cells runs through the real coupler.
const SAMPLE: usize = 97;
/// Largest departure of its forces from the window matrix, over the largest force: rounding, and the gap of a fixed point.
const DEPARTURE: f64 = 1e-6;
/// Windows of such a run.
const SAMPLE_WINDOWS: usize = 12;

/// Findings of the bench.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Findings {
    /// Cells of the map.
    pub cells: usize,
    /// Cells that grow.
    pub unstable: usize,
    /// Unstable cells of the dual Schur and velocity schemes at theta = 1, for which these schemes are offered.
    pub unstable_default: usize,
    /// Cells predicted to be stable that grow.
    pub missed: usize,
    /// Cells predicted to grow that do not.
    pub false_alarms: usize,
    /// Cells that ran through the real coupler.
    pub sampled: usize,
    /// Largest departure of a force from the window matrix, over the largest force.
    pub departure: f64,
    /// Limits that were predicted and measured.
    pub limits: usize,
    /// Largest difference between measured and predicted limit, over the predicted one.
    pub limit_difference_rel: f64,
}

/// Computes the map and writes stability.csv, limits.csv and stability.svg into a folder.
pub fn bench(folder: &Path) -> Result<Findings, Error> {
    // First, so that an unwritable folder is an error before minutes of work.
    std::fs::create_dir_all(folder).map_err(Error::output(folder.display()))?;
    let axes = Axes::full();
    let cells = map::map(&axes)?;
    let limits = limits::limits(&[1, 3, 10, 100], &[0.5, 0.9])?;
    let write = |name: &str, text: String| {
        let path = folder.join(name);
        std::fs::write(&path, text).map_err(Error::output(path.display()))
    };
    write("stability.csv", map::csv(&cells))?;
    write("stability.svg", picture::svg(&axes, &cells))?;
    write("limits.csv", limits::csv(&limits))?;
    let mut findings = findings(&cells, SAMPLE)?;
    findings.limits = limits.len();
    let differences = limits.iter().map(limits::Limit::difference_rel);
    findings.limit_difference_rel = differences.fold(0.0, larger);
    Ok(findings)
}

/// Counts cells, and runs one cell in `every` through the real coupler.
pub fn findings(cells: &[Cell], every: usize) -> Result<Findings, Error> {
    let grows = |cell: &Cell| cell.growth > 1.0 + NEUTRAL;
    let offered = |cell: &Cell| {
        let monolithic = matches!(
            cell.setup.keys.scheme(),
            CouplingScheme::DualSchur { .. } | CouplingScheme::Velocity { .. }
        );
        monolithic && cell.setup.boundary_inertia.theta == 1.0
    };
    let count = |which: &dyn Fn(&Cell) -> bool| cells.iter().filter(|cell| which(cell)).count();
    let sample: Vec<&Cell> = cells.iter().step_by(every).collect();
    let mut departure = 0.0f64;
    for cell in &sample {
        let here = map::departure(cell, SAMPLE_WINDOWS)?;
        if here > DEPARTURE {
            let note = format!("the scheme departs from its window matrix by {here:e}: {cell:?}");
            print_note(&note);
        }
        departure = larger(departure, here);
    }
    Ok(Findings {
        cells: cells.len(),
        unstable: count(&grows),
        unstable_default: count(&|cell| offered(cell) && grows(cell)),
        missed: count(&|cell| cell.predicted_stable && grows(cell)),
        false_alarms: count(&|cell| !cell.predicted_stable && !grows(cell)),
        sampled: sample.len(),
        departure,
        ..Findings::default()
    })
}

impl Findings {
    /// True if the map keeps the coupler's promises.
    pub fn hold(&self) -> bool {
        self.unstable_default == 0
            && self.missed == 0
            && self.departure <= DEPARTURE
            && self.limit_difference_rel <= 0.05
    }

    /// The findings as a table for a terminal.
    pub fn table(&self) -> String {
        let offered = "unstable, dual Schur, velocity at theta = 1";
        let departure = format!("{:.1e}", self.departure);
        let difference = format!("{:.4}", self.limit_difference_rel);
        let rows: [(&str, &dyn fmt::Display); 9] = [
            ("cells", &self.cells),
            ("unstable", &self.unstable),
            (offered, &self.unstable_default),
            ("predicted stable, but unstable", &self.missed),
            ("predicted unstable, but stable", &self.false_alarms),
            ("cells run through the real coupler", &self.sampled),
            ("largest departure of its forces, relative", &departure),
            ("limits predicted and measured", &self.limits),
            ("largest difference of both, relative", &difference),
        ];
        Vec::from_iter(rows.map(|(words, found)| format!("{words:<45}{found}"))).join("\n")
    }
}
