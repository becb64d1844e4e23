//! Settings that a study measured for the scene of a run, for the pages of a run.

/// A setting of a study.
#[derive(Clone, Debug)]
pub struct MeasuredSetting {
    /// Its values in words.
    pub words: String,
    /// Overrides that give the run's scenario this setting; empty if it has these values already.
    pub overrides: Vec<String>,
    /// Codes of the warnings because of which the study distrusts it.
    pub warned: Vec<String>,
    /// True for the reference setting, from which errors are measured.
    pub is_reference: bool,
    /// Its processor time over the reference's.
    pub cost: f64,
    /// Expected relative error by each measure, and its bound.
    pub errors: Vec<[f64; 2]>,
}

/// Results of a study for the scene of a run. Settings are given by their indices in `settings`.
#[derive(Clone, Debug)]
pub struct MeasuredFront {
    /// Name of the study.
    pub study: String,
    /// Build that ran the study.
    pub build: String,
    /// Names of its measures.
    pub measures: Vec<String>,
    /// The settings with known errors, the most accurate first.
    pub settings: Vec<MeasuredSetting>,
    /// The front of each measure, cheapest first.
    pub fronts: Vec<Vec<usize>>,
    /// The setting of the run, or the setting that differs from it in the fewest keys; without errors.
    pub nearest: MeasuredSetting,
    /// Error of the reference itself by measure, from extrapolation; empty if unknown.
    pub reference_misses: Vec<f64>,
    /// The setting of the run; `None` if it differs from all settings, or if the study does not know its errors.
    pub own: Option<usize>,
    /// The cheapest setting with at most half of the run's expected error, by every measure.
    pub half_error: Option<usize>,
    /// The most accurate setting with at most half of the run's cost.
    pub half_time: Option<usize>,
}
