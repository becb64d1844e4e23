//! Settings that a study measured for the scene of a run, as the pages of a run show them.

/// A setting of a study.
#[derive(Clone, Debug)]
pub struct MeasuredSetting {
    /// Its values in words.
    pub words: String,
    /// Overrides that make the scenario of the run it; none where it has these values already.
    pub overrides: Vec<String>,
    /// Codes of warnings for which the study does not trust it.
    pub warned: Vec<String>,
    /// True for the setting from whose runs errors are measured.
    pub is_reference: bool,
    /// Its processor time over that of the reference.
    pub cost: f64,
    /// What its relative error is expected to be by each measure, and the bound of it.
    pub errors: Vec<[f64; 2]>,
}

/// What a study knows of the scene of a run. Settings are told by their indices in `settings`.
#[derive(Clone, Debug)]
pub struct MeasuredFront {
    /// Name of the study.
    pub study: String,
    /// Build that ran it.
    pub build: String,
    /// Names of its measures.
    pub measures: Vec<String>,
    /// The settings whose errors it can tell, the most accurate first.
    pub settings: Vec<MeasuredSetting>,
    /// The front of each measure, cheapest first.
    pub fronts: Vec<Vec<usize>>,
    /// The setting of the run, or the one from which it differs in the fewest keys; without errors.
    pub nearest: MeasuredSetting,
    /// Error of the reference itself by measure, by extrapolation; empty where that is not known.
    pub reference_misses: Vec<f64>,
    /// The setting of the run; `None` where it differs from all, and where the study cannot tell its errors.
    pub own: Option<usize>,
    /// The cheapest one that is expected to err at most half as much as the run, by every measure.
    pub half_error: Option<usize>,
    /// The most accurate one that costs at most half as much.
    pub half_time: Option<usize>,
}
