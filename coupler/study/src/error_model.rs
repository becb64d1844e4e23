//! The error of a setting, from runs that refined one numerical choice at a time.
//!
//! If a choice converges, the distances between equally spaced levels shrink by a ratio q per level. The error of the finest level is then
//! d q/(1 - q), d the last distance (Richardson 1911; Roache 1994, with q = 2^-p for a method of order p). Errors of several choices add up
//! as if they were independent: root of the sum of squares. The model only proposes settings, which are then measured.

use std::ops::Range;

use super::knobs::{KNOBS, Knob, Levels};

/// Ratio if only two levels are known: first order.
const FIRST_ORDER: f64 = 0.5;
/// Accepted ratios: a larger one comes from chance or another choice, a smaller one from a distance that chance shortened.
const RATIOS: [f64; 2] = [0.1, 0.5];
/// Distances below this number of floors of noise contain no ratio.
const NOISE: f64 = 2.0;
/// Largest part of the target error that one choice may have in a reference.
const SHARE: f64 = 0.4;
/// The reference does not refine a choice with a smaller part of the largest error of a choice.
const PART: f64 = 0.4;
/// Nor a choice with a smaller part of the target error, unless its error is the largest.
const LEAST: f64 = 0.2;

/// Smallest error for logarithms.
const NOTHING: f64 = 1e-16;

/// Errors and costs of one choice by its levels.
#[derive(Clone, Debug)]
pub struct KnobErrors {
    /// Levels with runs, the coarsest first; one of them is 0.
    levels: Vec<f64>,
    /// Error by measure and level.
    errors: Vec<Vec<f64>>,
    /// Ratio of the errors of neighbours by measure.
    ratios: Vec<f64>,
    /// Logarithm of the cost relative to level 0, by level.
    costs: Vec<f64>,
}

impl KnobErrors {
    /// From runs at these levels, the coarsest first: costs relative to level 0, the floor of noise of each measure, and the distance in a
    /// measure between two levels.
    pub fn of(
        levels: &[f64],
        costs: &[f64],
        floors: &[f64],
        distance: impl Fn(usize, usize, usize) -> f64,
    ) -> KnobErrors {
        let last = levels.len() - 1;
        let of_measure = |measure: usize| {
            let d = |one: usize, other: usize| distance(measure, one, other);
            if last == 0 {
                return (vec![0.0], FIRST_ORDER);
            }
            let end = d(last - 1, last);
            let ratio = if last >= 2 && end > NOISE * floors[measure] {
                (end / d(last - 2, last - 1)).clamp(RATIOS[0], RATIOS[1])
            } else {
                FIRST_ORDER
            };
            let missed = end * ratio / (1.0 - ratio);
            let error = |level: usize| missed + if level == last { 0.0 } else { d(level, last) };
            ((0..=last).map(error).collect(), ratio)
        };
        // A finer level that costs less does so by chance.
        let log_cost = |(level, cost): (&f64, &f64)| {
            let bound = if *level < 0.0 { f64::min } else { f64::max };
            bound(cost.ln(), 0.0)
        };
        let (errors, ratios) = (0..floors.len()).map(of_measure).unzip();
        KnobErrors {
            levels: levels.to_vec(),
            errors,
            ratios,
            costs: levels.iter().zip(costs).map(log_cost).collect(),
        }
    }

    /// Errors by levels of which the finest has no error.
    pub fn below_exact(mut self) -> KnobErrors {
        for errors in &mut self.errors {
            let missed = errors[errors.len() - 1];
            errors.iter_mut().for_each(|error| *error -= missed);
        }
        self
    }

    /// True if a level other than 0 is known.
    pub fn is_known(&self) -> bool {
        self.levels.len() > 1
    }

    /// The error in a measure at a level.
    pub fn error(&self, measure: usize, level: f64) -> f64 {
        let errors = &self.errors[measure];
        let (last, finest) = (errors.len() - 1, self.levels[errors.len() - 1]);
        if level >= finest {
            let coarser = last.checked_sub(1).map(|before| self.levels[before]);
            let between = finest - coarser.unwrap_or(finest - 1.0);
            return errors[last] * self.ratios[measure].powf((level - finest) / between);
        }
        let logarithms: Vec<f64> = errors.iter().map(|e| e.max(NOTHING).ln()).collect();
        along(&self.levels, &logarithms, level).exp()
    }

    /// The cost at a level relative to level 0.
    fn cost(&self, level: f64) -> f64 {
        along(&self.levels, &self.costs, level).exp()
    }
}

/// A number at a level, by linear interpolation and extrapolation.
fn along(levels: &[f64], numbers: &[f64], at: f64) -> f64 {
    if levels.len() == 1 {
        return numbers[0];
    }
    let inner = levels[1..levels.len() - 1].iter();
    let k = inner.filter(|level| **level <= at).count();
    let slope = (numbers[k + 1] - numbers[k]) / (levels[k + 1] - levels[k]);
    numbers[k] + slope * (at - levels[k])
}

/// Errors and costs of all choices of a scene.
#[derive(Clone, Debug)]
pub struct ErrorModel {
    /// Errors and costs by choice.
    pub knobs: Vec<KnobErrors>,
    /// Target error.
    pub target: f64,
    /// Smallest level of windows or steps in a reference with lighter grains than the scene, which need shorter ones.
    pub shorter: f64,
}

impl ErrorModel {
    /// Indices of the measures.
    pub fn measures(&self) -> Range<usize> {
        0..self.knobs[0].errors.len()
    }

    /// Error in a measure at these levels.
    pub fn error(&self, measure: usize, levels: &Levels) -> f64 {
        let all = self.knobs.iter().zip(levels);
        root(all.map(|(knob, level)| knob.error(measure, *level)))
    }

    /// Cost at these levels relative to the scene.
    pub fn cost(&self, levels: &Levels) -> f64 {
        let all = self.knobs.iter().zip(levels);
        all.map(|(knob, level)| knob.cost(*level)).product()
    }

    /// The reference of a setting: nowhere coarser than the scene or the setting, and finer by a level in each choice that contributes to the
    /// setting's error (by half a level if the choice errs little, or if `nearest` is set). The reference's own error is small against the
    /// target error.
    pub fn reference(&self, setting: &Levels, nearest: bool) -> Levels {
        let error = |k: usize, m: usize, level: f64| self.knobs[k].error(m, level);
        let largest = |m: usize| {
            let errors = (0..KNOBS.len()).map(|k| error(k, m, setting[k]));
            errors.fold(0.0, f64::max)
        };
        let all = self.measures().map(largest);
        let worst = all.clone().fold(0.0, f64::max);
        let least = |error: f64| (PART * error).max(LEAST * self.target).min(worst);
        let bounds: Vec<f64> = all.map(least).collect();
        let mut reference: Levels = std::array::from_fn(|k| {
            let own = setting[k].max(0.0);
            if !self.knobs[k].is_known() {
                return own;
            }
            let mut measures = self.measures();
            let has_part = measures.any(|m| error(k, m, setting[k]) >= bounds[m]);
            let small = |level: f64, share: f64| {
                let mut measures = self.measures();
                measures.all(|m| error(k, m, level) <= share * self.target)
            };
            let levels = KNOBS[k].reference_levels().iter().copied();
            let from = |least: f64| levels.clone().filter(move |level| *level >= least.max(own));
            let near = from(setting[k] + 0.5).next();
            match (has_part, near) {
                (false, _) => from(own).find(|level| small(*level, SHARE)),
                (true, Some(near)) if nearest || small(near, SHARE / 2.0) => Some(near),
                (true, _) => from(setting[k] + 1.0).find(|level| small(*level, SHARE)),
            }
            .or(from(own).next_back())
            .unwrap_or(own)
        });
        if reference[Knob::MassScale.index()] > 0.0 {
            for k in [Knob::Window.index(), Knob::Step.index()] {
                if self.knobs[k].is_known() {
                    reference[k] = reference[k].max(self.shorter);
                }
            }
        }
        reference
    }

    /// The distance of a setting from a reference in a measure.
    pub fn distance(&self, measure: usize, setting: &Levels, reference: &Levels) -> f64 {
        let between = (0..KNOBS.len()).map(|k| {
            let error = |levels: &Levels| self.knobs[k].error(measure, levels[k]);
            error(setting) - error(reference)
        });
        root(between)
    }

    /// All combinations of levels of the known choices, without longer windows for lighter grains.
    pub fn settings(&self) -> Vec<Levels> {
        let mut all = vec![[0.0; KNOBS.len()]];
        let known = (0..KNOBS.len()).filter(|k| self.knobs[*k].is_known());
        for k in known {
            let levels = KNOBS[k].levels().iter().copied();
            let levels = levels.filter(|level| *level >= self.knobs[k].levels[0]);
            let with = |setting: &Levels, level: f64| {
                let mut setting = *setting;
                setting[k] = level;
                setting
            };
            let each = |setting| levels.clone().map(move |level| with(setting, level));
            all = all.iter().flat_map(each).collect();
        }
        let [window, step, mass] = [Knob::Window, Knob::Step, Knob::MassScale].map(Knob::index);
        all.retain(|levels| levels[mass] <= 0.0 || levels[window].min(levels[step]) >= 0.0);
        all
    }
}

fn root(parts: impl Iterator<Item = f64>) -> f64 {
    parts.map(|part| part * part).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quantity 1 + c h^p at h = 2, 1, 1/2.
    fn of_order(c: f64, p: f64) -> KnobErrors {
        let value = |k: usize| c * 2f64.powf(p * (1.0 - k as f64));
        KnobErrors::of(&[-1.0, 0.0, 1.0], &[0.5, 1.0, 2.0], &[0.0], |_, a, b| {
            (value(a) - value(b)).abs()
        })
    }

    fn unknown() -> KnobErrors {
        KnobErrors::of(&[0.0], &[1.0], &[0.0], |_, _, _| 0.0)
    }

    /// Richardson's extrapolation is exact for one power of h, of any order.
    #[test]
    fn one_power_of_the_length_is_known_at_all_levels() {
        for p in [1.0, 2.0] {
            let knob = of_order(0.01, p);
            for level in [-1.0, -0.5, 0.0, 0.5, 1.0, 2.0] {
                let exact = 0.01 * 2f64.powf(-p * level);
                assert!(
                    (knob.error(0, level) / exact - 1.0).abs() < 1e-12,
                    "{p} {level}"
                );
            }
            assert!(
                (knob.cost(2.0) - 4.0).abs() < 1e-12
                    && (knob.cost(-0.5) - 0.5f64.sqrt()).abs() < 1e-12
            );
        }
    }

    /// 0.03 after 0.3 gives a ratio of 0.1; with a floor of 0.02 it is noise: first order, with an error as large as the last distance.
    #[test]
    fn noise_gives_no_order() {
        let position = [0.0f64, 0.3, 0.33];
        let missed = |floor: f64| {
            let distance = |_, a: usize, b: usize| (position[a] - position[b]).abs();
            KnobErrors::of(&[-1.0, 0.0, 1.0], &[1.0; 3], &[floor], distance).error(0, 1.0)
        };
        assert!((missed(0.02) - 0.03).abs() < 1e-12);
        assert!((missed(0.0) - 0.03 / 9.0).abs() < 1e-12);
    }

    fn model(target: f64) -> ErrorModel {
        let knobs = KNOBS.map(|knob| match knob {
            Knob::Mesh => of_order(0.02, 1.0),
            Knob::Window => of_order(0.001, 2.0),
            _ => unknown(),
        });
        ErrorModel {
            knobs: knobs.into(),
            target,
            shorter: 0.0,
        }
    }

    /// The mesh errs by 2 % / 2^level, windows by 0.1 % / 4^level. For a target of 1 %, a reference errs by at most 0.4 % in one choice;
    /// windows of twice the length, which err by 0.4 %, contribute to the error.
    #[test]
    fn a_reference_is_finer_where_it_matters() {
        let model = model(0.01);
        let reference = |mesh: f64, window: f64, nearest| {
            model.reference(&[mesh, 0.0, window, 0.0, 0.0, 0.0, 0.0], nearest)
        };
        assert_eq!(
            reference(1.0, -1.0, false),
            [2.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        );
        assert_eq!(
            reference(1.0, -1.0, true),
            [1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        );
        assert_eq!(
            reference(2.5, 0.0, false),
            [3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        );
        let distance = model.distance(
            0,
            &[1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0],
            &reference(1.0, -1.0, false),
        );
        let exact = (0.01 - 0.02 * 2f64.powf(-2.5)).hypot(0.003);
        assert!((distance / exact - 1.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_missed_below_an_exact_level() {
        let knob = KnobErrors::of(&[-1.0, 0.0], &[0.5, 1.0], &[0.0], |_, _, _| 0.01);
        let knob = knob.below_exact();
        assert!((knob.error(0, -1.0) / 0.01 - 1.0).abs() < 1e-12);
        assert_eq!(knob.error(0, 0.0), 0.0);
    }

    /// A setting that errs by less than the target is still compared with a finer one: compared with itself it has no error.
    #[test]
    fn no_setting_is_its_own_reference() {
        let reference = model(1.0).reference(&[0.0; KNOBS.len()], false);
        assert_eq!(reference, [0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    }
}
