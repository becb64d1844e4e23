//! Cost and error of a single key, and whether the error falls towards the reference along its values.

use runs::curve::median;

use super::collect::{Results, StudyRow};
use super::measure::{Norm, percent};
use super::settings::{StudySetting, short};

/// A value of a key: medians over all combinations of the other keys and over all scenes.
#[derive(Clone, Debug, PartialEq)]
pub struct ValueEffect {
    /// The value.
    pub value: String,
    /// Its cost.
    pub cost: Option<f64>,
    /// Its error in each measure, including noise; it may be below the floor.
    pub errors: Vec<Option<f64>>,
    /// Deviations with their signs, if the measure is a single number.
    pub deviations: Vec<Option<f64>>,
    /// Work: element-steps and contact-iterations.
    pub work: [Option<f64>; 2],
    /// True if no run with it can be trusted.
    pub failed: bool,
    /// True if its run is the reference itself.
    pub reference: bool,
    /// ln(value / value of the reference), if the values have such an order.
    pub distance: Option<f64>,
}

/// A varied key, and its values from the farthest from the reference's value to the nearest.
#[derive(Clone, Debug)]
pub struct VariedKey {
    /// The key.
    pub key: String,
    /// Note of the study about it.
    pub note: String,
    /// The values; without an order, as in the study.
    pub positions: Vec<ValueEffect>,
    /// True if the values are positive numbers.
    pub numeric: bool,
    /// Floor of noise in each measure: the median over the scenes.
    pub floors: Vec<f64>,
}

/// Relative difference in work below which runs do the same work.
const SAME_WORK: f64 = 0.02;

impl VariedKey {
    /// True if the values are ordered by their distance from the reference's.
    pub fn is_ordered(&self) -> bool {
        self.positions.iter().all(|p| p.distance.is_some())
    }

    /// The trend in a measure, on either side of the reference.
    pub fn trend(&self, measure: usize) -> String {
        let floor = self.floors[measure];
        let errors = self.positions.iter();
        let errors = errors.filter_map(|p| Some((p, p.errors[measure]?, p.distance?)));
        let errors: Vec<(&ValueEffect, f64, f64)> = errors.collect();
        if !self.is_ordered() || errors.len() < 2 {
            return "has too few values for a trend".into();
        }
        if errors.iter().all(|(_, error, _)| *error <= floor) {
            return format!("is noise (floor {} %)", percent(floor));
        }
        for side in [1.0, -1.0] {
            let is_here = |(_, _, distance): &&(_, _, f64)| side * distance >= 0.0;
            let of_side: Vec<_> = errors.iter().filter(is_here).collect();
            let mut pairs = of_side.windows(2).map(|pair| [pair[0], pair[1]]);
            if let Some([a, b]) = pairs.find(|[a, b]| b.1 > a.1 + floor) {
                let why = self.why(measure, a.0, b.0);
                let [a, b] =
                    [a, b].map(|(p, error, _)| format!("{} ({} %)", p.value, percent(*error)));
                return format!("does not fall from {a} to {b}{why}");
            }
        }
        "falls towards the reference".into()
    }

    /// A line on the trend in each measure; empty if the values have no order.
    pub fn trends(&self, measures: &[String]) -> Vec<String> {
        if !self.is_ordered() {
            return Vec::new();
        }
        let line = |(index, name): (usize, &String)| format!("error_{name} {}", self.trend(index));
        measures.iter().enumerate().map(line).collect()
    }

    /// The reason for a rise between two positions, if the numbers show one.
    fn why(&self, measure: usize, a: &ValueEffect, b: &ValueEffect) -> &'static str {
        let signs = a.deviations[measure].zip(b.deviations[measure]);
        if signs.is_some_and(|(a, b)| a * b < 0.0) {
            return ": the deviation changes its sign in between";
        }
        let same = |(a, b): (Option<f64>, Option<f64>)| match (a, b) {
            (Some(a), Some(b)) => (a - b).abs() <= SAME_WORK * a.max(b),
            (a, b) => a.is_none() && b.is_none(),
        };
        let alike = |a: &ValueEffect, b: &ValueEffect| {
            a.work.iter().zip(&b.work).all(|(a, b)| same((*a, *b)))
        };
        // If a key never changes the work, equal work is no reason.
        if alike(a, b) && self.positions.iter().any(|other| !alike(a, other)) {
            return ": both do the same work within 2 %";
        }
        ""
    }

    /// Its trade-off: a sentence from the nearest value to the farthest, or a line for each value if there is no order.
    pub fn lines(&self, measures: &[String]) -> Vec<String> {
        if self.is_ordered() {
            return vec![self.sentence(measures)];
        }
        let head = format!("{}:", short(&self.key));
        let line = |position: &ValueEffect| {
            if position.failed {
                return format!("  {}: no trusted run", position.value);
            }
            let cost = position.cost.map(|cost| format!("cost {cost:.3}"));
            let error = |(name, error): (&String, &Option<f64>)| {
                error.map(|error| format!("{} % {name} error", percent(error)))
            };
            let errors = measures.iter().zip(&position.errors).filter_map(error);
            let parts: Vec<String> = cost.into_iter().chain(errors).collect();
            format!("  {}: {}", position.value, parts.join(", "))
        };
        let lines = self.positions.iter().map(line);
        [head].into_iter().chain(lines).collect()
    }

    /// Ratio of the costs of the nearest and the farthest value, and the errors of both.
    fn sentence(&self, measures: &[String]) -> String {
        let (failed, trusted): (Vec<&ValueEffect>, Vec<_>) =
            self.positions.iter().partition(|position| position.failed);
        let (Some(far), Some(near)) = (trusted.first(), trusted.last()) else {
            return format!("{}: no trusted run", short(&self.key));
        };
        let mut text = format!("{} {} -> {}", short(&self.key), near.value, far.value);
        if let Some((near, far)) = near.cost.zip(far.cost) {
            let ratio = near / far;
            let word = if ratio >= 1.0 { "cheaper" } else { "dearer" };
            text += &format!(": {:.1}x {word}", ratio.max(1.0 / ratio));
        }
        for (index, name) in measures.iter().enumerate() {
            if let Some((near, far)) = near.errors[index].zip(far.errors[index]) {
                text += &format!(", {} -> {} % {name} error", percent(near), percent(far));
            }
        }
        if !failed.is_empty() {
            let failed = Vec::from_iter(failed.iter().map(|of| of.value.as_str())).join(", ");
            text += &format!("; no trusted run at {failed}");
        }
        text
    }
}

/// The varied keys of a study without the keys of the scene, in the study's order.
pub fn varied_keys(results: &Results, settings: &[StudySetting]) -> Vec<VariedKey> {
    let keys = 0..results.file.vary.len();
    let varied = keys.filter(|index| !results.file.vary[*index].scene);
    let varied = varied.map(|index| varied_key(results, settings, index));
    varied.collect()
}

/// The settings with a value of a key.
type Same<'a> = (&'a str, Vec<&'a StudySetting<'a>>);

fn varied_key(results: &Results, settings: &[StudySetting], index: usize) -> VariedKey {
    let (vary, measures) = (&results.file.vary[index], &results.file.measure);
    let mut with: Vec<Same> = Vec::new();
    for setting in settings {
        let mut chosen = setting.chosen.iter();
        let Some((_, value)) = chosen.find(|(at, _)| *at == index) else {
            continue;
        };
        match with.iter_mut().find(|(known, _)| known == value) {
            Some((_, same)) => same.push(setting),
            None => with.push((value, vec![setting])),
        }
    }
    let zero = zero(results, &with, index);
    let distance = |value: &str| Some((number(value)? / zero?).ln());
    let is_ordered = with.iter().all(|(value, _)| distance(value).is_some());
    if is_ordered {
        let near = |(value, _): &Same| distance(value).map_or(0.0, f64::abs);
        with.sort_by(|a, b| near(b).total_cmp(&near(a)));
    }
    let position = |(value, same): &Same| {
        let each = |of: &dyn Fn(&StudySetting) -> Option<f64>| {
            median(same.iter().filter_map(|setting| of(setting)).collect())
        };
        let of_measures = |of: &dyn Fn(&StudyRow, usize) -> Option<f64>| {
            let middle = |k| each(&|setting| setting.middle(|row| of(row, k)));
            (0..measures.len()).map(middle).collect()
        };
        let is_single = |k: usize| measures[k].norm == Norm::At;
        ValueEffect {
            value: value.to_string(),
            cost: each(&|setting| setting.price()),
            errors: of_measures(&|row, k| row.error(k)),
            deviations: of_measures(&|row, k| row.deviations[k].filter(|_| is_single(k))),
            work: ["element_steps", "contact_iterations"]
                .map(|name| each(&|setting| setting.cost(name))),
            distance: distance(value).filter(|_| is_ordered),
            reference: same.iter().all(|setting| setting.is_reference(results)),
            failed: !same.iter().any(|setting| setting.is_trusted()),
        }
    };
    let floor = |measure: usize| {
        let floors = results.rows.iter().filter_map(|row| row.floors[measure]);
        median(floors.collect()).unwrap_or(0.0)
    };
    VariedKey {
        key: vary.key.clone(),
        note: vary.note.clone(),
        numeric: with.iter().all(|(value, _)| number(value).is_some()),
        positions: with.iter().map(position).collect(),
        floors: (0..measures.len()).map(floor).collect(),
    }
}

fn number(value: &str) -> Option<f64> {
    let value = value.parse::<f64>().ok();
    value.filter(|x| *x > 0.0 && x.is_finite())
}

/// The reference's value of a key: its own, or the value with which a point is the same run as the reference.
fn zero(results: &Results, with: &[Same], index: usize) -> Option<f64> {
    let reference = results.reference(0)?.task;
    let is_same = |(_, settings): &&Same| {
        let mut rows = settings.iter().flat_map(|setting| &setting.rows);
        rows.any(|row| row.task.id == reference.id)
    };
    let same = with.iter().find(is_same);
    number(&reference.values[index]).or_else(|| number(same?.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knob(errors: &[f64], floor: f64) -> VariedKey {
        let position = |(k, error): (usize, &f64)| ValueEffect {
            value: format!("{k}"),
            cost: Some(1.0 + k as f64),
            errors: vec![Some(*error)],
            deviations: vec![None],
            work: [Some(1.0 + k as f64), None],
            failed: false,
            reference: false,
            distance: Some((errors.len() - k) as f64),
        };
        VariedKey {
            key: "interface.a.substeps".into(),
            note: String::new(),
            positions: errors.iter().enumerate().map(position).collect(),
            numeric: true,
            floors: vec![floor],
        }
    }

    #[test]
    fn trends_are_judged_beyond_the_noise() {
        let falls = "falls towards the reference";
        assert_eq!(knob(&[0.3, 0.1, 0.0], 0.0).trend(0), falls);
        assert_eq!(knob(&[0.3, 0.1, 0.12], 0.05).trend(0), falls);
        let rises = "does not fall from 1 (10 %) to 2 (20 %)";
        assert_eq!(knob(&[0.3, 0.1, 0.2], 0.05).trend(0), rises);
        let noise = "is noise (floor 5.0 %)";
        assert_eq!(knob(&[0.03, 0.01, 0.02], 0.05).trend(0), noise);
        let mut loose = knob(&[0.3, 0.1], 0.0);
        loose.positions[0].distance = None;
        assert_eq!(loose.trend(0), "has too few values for a trend");
        // 0.2 is on one side of the reference, 0.3 and 0.1 on the other.
        let mut sides = knob(&[0.3, 0.2, 0.25, 0.1], 0.0);
        let rises = "does not fall from 1 (20 %) to 2 (25 %)";
        assert_eq!(sides.trend(0), rises);
        sides.positions[1].distance = Some(-3.0);
        assert_eq!(sides.trend(0), falls);
    }

    #[test]
    fn a_rise_has_a_reason_if_the_numbers_show_one() {
        let mut rising = knob(&[0.1, 0.3], 0.0);
        assert_eq!(rising.trend(0), "does not fall from 0 (10 %) to 1 (30 %)");
        rising.positions[1].work = [Some(1.01), None];
        assert_eq!(rising.trend(0), "does not fall from 0 (10 %) to 1 (30 %)");
        rising.positions.push(ValueEffect {
            work: [Some(3.0), None],
            errors: vec![None],
            ..rising.positions[0].clone()
        });
        assert!(
            rising
                .trend(0)
                .ends_with("both do the same work within 2 %")
        );
        rising.positions[0].deviations = vec![Some(-0.1)];
        rising.positions[1].deviations = vec![Some(0.3)];
        assert!(rising.trend(0).ends_with("changes its sign in between"));
    }

    #[test]
    fn a_sentence_states_cost_and_error_from_the_nearest_to_the_farthest() {
        let sentence = knob(&[0.047, 0.022], 0.0).sentence(&["pressure".into()]);
        assert_eq!(
            sentence,
            "substeps 1 -> 0: 2.0x cheaper, 2.2 -> 4.7 % pressure error"
        );
    }

    #[test]
    fn parts_have_two_digits() {
        let shown = [0.0, 0.5, 0.0123, 1e-6, 3e-9, 2.5].map(percent);
        assert_eq!(shown, ["0", "50", "1.2", "1.0e-4", "3.0e-7", "250"]);
    }
}
