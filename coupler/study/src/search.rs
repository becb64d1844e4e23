//! The search for the cheapest setting that keeps an error: it proposes the next measurement from the previous ones.

use super::error_model::ErrorModel;
use super::knobs::{KNOBS, Knob, Levels};

/// Ratio of the bound of an error to its median, until it is measured.
pub const MARGIN: f64 = 2.5;
/// Accepted range of the ratio of a bound to the error of the model.
const MARGINS: [f64; 2] = [1.0, 6.0];
/// The search does not begin with the unchanged scene if its error is smaller than the target by this factor.
const TOO_GOOD: f64 = 4.0;
/// Largest cost of the next setting to try, relative to the best setting found.
const CHEAPER: f64 = 0.85;
/// Levels by which windows of a reference with lighter grains become shorter after each warning.
const SHORTER: f64 = 0.5;

/// A setting and the reference to compare it with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proposal {
    /// Levels of the setting.
    pub setting: Levels,
    /// Levels of the reference.
    pub reference: Levels,
    /// Cost of the setting relative to the scene.
    pub cost: f64,
    /// Cost of the reference relative to the scene; 0 if its runs are done.
    pub reference_cost: f64,
}

/// The outcome of a proposal.
#[derive(Clone, Debug, PartialEq)]
pub enum TrialOutcome {
    /// Bounds of the errors, all within the target.
    Keeps(Vec<f64>),
    /// Bounds of the errors, at least one beyond the target.
    Exceeds(Vec<f64>),
    /// The setting has warnings, or does not complete.
    Warned,
    /// Its reference has warnings, or does not complete.
    NoReference,
}

/// A search in progress.
#[derive(Clone, Debug)]
pub struct Search {
    model: ErrorModel,
    /// Measured settings that keep the error, the cheapest last.
    pub found: Vec<Levels>,
    left: Vec<Levels>,
    /// Ratio of the bound to the error of the model, by measure.
    margins: Vec<f64>,
    reference: Option<Levels>,
    is_over: bool,
}

impl Search {
    /// A search among the settings of a model that are possible.
    pub fn new(model: ErrorModel, is_had: impl Fn(&Levels) -> bool) -> Search {
        let left = model.settings().into_iter().filter(is_had).collect();
        Search {
            margins: vec![MARGIN; model.measures().len()],
            model,
            found: Vec::new(),
            left,
            reference: None,
            is_over: false,
        }
    }

    /// The next proposal: the unchanged scene, some of whose runs are done, if it may keep the error and nothing much cheaper does; else the
    /// cheapest setting that keeps the error in the model. `None` if no such setting is left, or none cheaper than the best one. With a
    /// `nearest` reference, less of the error is measured and more is extrapolated.
    pub fn next(&self, nearest: bool) -> Option<Proposal> {
        if self.is_over {
            return None;
        }
        let scene = [0.0; KNOBS.len()];
        let is_first = self.left.contains(&scene)
            && self.keeps(&scene, 1.0)
            && !self.keeps(&scene, TOO_GOOD)
            && self.found.is_empty();
        let all = self.left.iter().filter(|setting| self.keeps(setting, 1.0));
        let cost = |setting: &Levels| self.model.cost(setting);
        let cheapest = all.min_by(|a, b| cost(a).total_cmp(&cost(b)));
        let setting = if is_first { scene } else { *cheapest? };
        let dear = |found: &Levels| cost(&setting) > CHEAPER * cost(found);
        if self.found.last().is_some_and(dear) {
            return None;
        }
        // One reference serves all settings as long as it is the finer one.
        let own = self.model.reference(&setting, nearest);
        let finer = |old: Levels| std::array::from_fn(|k| old[k].max(own[k]));
        let reference = self.reference.map_or(own, finer);
        let is_done = self.reference == Some(reference);
        Some(Proposal {
            setting,
            reference,
            cost: cost(&setting),
            reference_cost: if is_done { 0.0 } else { cost(&reference) },
        })
    }

    /// True if the error of a setting, times this factor and the known margins, is within the target in the model.
    fn keeps(&self, setting: &Levels, times: f64) -> bool {
        let reference = self.model.reference(setting, false);
        self.model.measures().all(|m| {
            let distance = self.model.distance(m, setting, &reference);
            times * self.margins[m] * distance <= self.model.target
        })
    }

    /// Learns from the outcome of a proposal.
    pub fn learn(&mut self, proposal: &Proposal, outcome: &TrialOutcome) {
        let Proposal {
            setting, reference, ..
        } = proposal;
        self.left.retain(|other| other != setting);
        // A cheaper setting that fails ends the search.
        self.is_over = !self.found.is_empty() && !matches!(outcome, TrialOutcome::Keeps(_));
        match outcome {
            TrialOutcome::Keeps(bounds) | TrialOutcome::Exceeds(bounds) => {
                let margin = |(m, bound): (usize, &f64)| {
                    let distance = self.model.distance(m, setting, reference);
                    (bound / distance.max(f64::MIN_POSITIVE)).clamp(MARGINS[0], MARGINS[1])
                };
                self.margins = bounds.iter().enumerate().map(margin).collect();
                if matches!(outcome, TrialOutcome::Keeps(_)) {
                    self.found.push(*setting);
                    self.reference = Some(*reference);
                }
            }
            // Coarser settings, and settings with lighter grains, would get the same warning.
            TrialOutcome::Warned => self.left.retain(|other| {
                let mut knobs = KNOBS.iter();
                knobs.any(|knob| {
                    let finer = other[knob.index()] - setting[knob.index()];
                    let sign = if *knob == Knob::MassScale { -1.0 } else { 1.0 };
                    sign * finer > 0.0
                })
            }),
            TrialOutcome::NoReference => {
                self.left.push(*setting);
                self.model.shorter += SHORTER;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error_model::KnobErrors;

    /// A mesh that errs by 2 % / 2^level and costs 4^level, with no other errors.
    fn search(target: f64) -> Search {
        let value = |k: usize| 0.04 / f64::from(1 << k);
        let knobs = KNOBS.map(|knob| match knob {
            Knob::Mesh => {
                KnobErrors::of(&[-1.0, 0.0, 1.0], &[0.25, 1.0, 4.0], &[0.0], |_, a, b| {
                    (value(a) - value(b)).abs()
                })
            }
            _ => KnobErrors::of(&[0.0], &[1.0], &[0.0], |_, _, _| 0.0),
        });
        let model = ErrorModel {
            knobs: knobs.into(),
            target,
            shorter: 0.0,
        };
        Search::new(model, |_| true)
    }

    fn mesh(proposal: Option<Proposal>) -> Option<[f64; 2]> {
        proposal.map(|p| [p.setting[0], p.reference[0]])
    }

    /// The scene is 1 % from a mesh of half the size, and keeps 3 % with any margin up to 3. If the bound of that is 1.5 %, elements larger by
    /// half a level, 1.83 % from the reference, have a bound of 2.7 %.
    #[test]
    fn the_scene_goes_first_and_then_cheaper_settings() {
        let mut search = search(0.03);
        let first = search.next(false).expect("the scene");
        assert_eq!(mesh(Some(first)), Some([0.0, 1.0]));
        search.learn(&first, &TrialOutcome::Keeps(vec![0.015]));
        let second = search.next(false).expect("a cheaper one");
        assert_eq!(mesh(Some(second)), Some([-0.5, 1.0]));
        assert_eq!(second.reference_cost, 0.0, "its runs are done");
        search.learn(&second, &TrialOutcome::Exceeds(vec![0.04]));
        assert_eq!(
            (search.next(false), search.found),
            (None, vec![[0.0; KNOBS.len()]])
        );
    }

    /// Half a level finer, the mesh is 0.71 % from its reference, or 1.8 % with the margin. If the bound is twice that, 2 % need a mesh that is
    /// finer by one and a half levels; if that has a warning, a still finer mesh, whose reference is finer by half a level.
    #[test]
    fn measurements_correct_the_model() {
        let mut search = search(0.02);
        let first = search.next(false).expect("a finer one");
        assert_eq!(mesh(Some(first)), Some([0.5, 1.5]));
        let distance = search.model.distance(0, &first.setting, &first.reference);
        search.learn(
            &first,
            &TrialOutcome::Exceeds(vec![2.0 * MARGIN * distance]),
        );
        let next = search.next(false).expect("a finer one");
        assert_eq!(mesh(Some(next)), Some([1.5, 2.5]));
        search.learn(&next, &TrialOutcome::Warned);
        assert_eq!(mesh(search.next(false)), Some([2.0, 2.5]));
    }
}
