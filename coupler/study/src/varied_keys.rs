//! What a single key costs and loses, and whether the error falls towards the reference along its values.

use runs::curve::median;
use std::collections::BTreeMap;

use super::collect::Results;
use super::measure::{Norm, percent};
use super::settings::{StudySetting, short};

/// A value of a key: the middle over all combinations of the others and over all scenes.
#[derive(Clone, Debug, PartialEq)]
pub struct ValueEffect {
    /// The value.
    pub value: String,
    /// Its cost.
    pub cost: Option<f64>,
    /// Its error by each measure, noise included: one below the floor is given as it is.
    pub errors: Vec<Option<f64>>,
    /// Deviations with their signs, where the measure is a single number.
    pub deviations: Vec<Option<f64>>,
    /// Work: element-steps and contact-iterations.
    pub work: [Option<f64>; 2],
    /// True where no run with it is to be trusted.
    pub failed: bool,
    /// True where its run is the reference itself.
    pub reference: bool,
    /// ln(value / value of the reference), where the values have such an order.
    pub distance: Option<f64>,
}

/// A key that is varied, and its values from the one that is farthest from the reference's to the nearest.
#[derive(Clone, Debug)]
pub struct VariedKey {
    /// The key.
    pub key: String,
    /// Note of the study about it.
    pub note: String,
    /// The values. Those without an order are in that of the study.
    pub positions: Vec<ValueEffect>,
    /// True where the values are positive numbers.
    pub numeric: bool,
    /// Floor of noise by each measure: the middle over the scenes.
    pub floors: Vec<f64>,
}

/// Part by which the work of runs differs that do the same.
const SAME_WORK: f64 = 0.02;

impl VariedKey {
    /// True where the values are ordered by their distance from the reference's.
    pub fn is_ordered(&self) -> bool {
        let mut positions = self.positions.iter();
        positions.all(|position| position.distance.is_some())
    }

    /// The trend by a measure, on either side of the reference.
    pub fn trend(&self, measure: usize) -> String {
        let floor = self.floors[measure];
        let errors = self.positions.iter();
        let errors = errors.filter_map(|p| Some((p, p.errors[measure]?, p.distance?)));
        let errors: Vec<(&ValueEffect, f64, f64)> = errors.collect();
        if !self.is_ordered() || errors.len() < 2 {
            return "has too few values to fall".into();
        }
        if errors.iter().all(|(_, error, _)| *error <= floor) {
            return format!("is noise (floor {} %)", percent(floor));
        }
        for side in [1.0, -1.0] {
            let of_side = errors.iter();
            let of_side = of_side.filter(|(_, _, distance)| side * distance >= 0.0);
            let of_side: Vec<_> = of_side.collect();
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

    /// A line on the trend by each measure; none where the values have no order.
    pub fn trends(&self, measures: &[String]) -> Vec<String> {
        if !self.is_ordered() {
            return Vec::new();
        }
        let line = |(index, name): (usize, &String)| format!("error_{name} {}", self.trend(index));
        measures.iter().enumerate().map(line).collect()
    }

    /// The reason for a rise between two positions, as far as numbers tell it.
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
        // Where a key never changes the work, that is no reason.
        if alike(a, b) && self.positions.iter().any(|other| !alike(a, other)) {
            return ": both do the same work within 2 %";
        }
        ""
    }

    /// The trade it makes: in a sentence from the nearest value to the farthest, or in a line for each value where there is no order.
    pub fn lines(&self, measures: &[String]) -> Vec<String> {
        if self.is_ordered() {
            return vec![self.sentence(measures)];
        }
        let head = format!("{}:", short(&self.key));
        let line = |position: &ValueEffect| {
            if position.failed {
                return format!("  {}: not completed without suspicion", position.value);
            }
            let cost = position.cost.map(|cost| format!("cost {cost:.3}"));
            let error = |(name, error): (&String, &Option<f64>)| {
                error.map(|error| format!("{} % {name} error", percent(error)))
            };
            let errors = measures.iter().zip(&position.errors).filter_map(error);
            let told: Vec<String> = cost.into_iter().chain(errors).collect();
            format!("  {}: {}", position.value, told.join(", "))
        };
        let lines = self.positions.iter().map(line);
        std::iter::once(head).chain(lines).collect()
    }

    /// Ratio of the costs of the nearest value and the farthest, and the errors of both.
    fn sentence(&self, measures: &[String]) -> String {
        let trusted = self.positions.iter().filter(|position| !position.failed);
        let trusted: Vec<&ValueEffect> = trusted.collect();
        let (Some(far), Some(near)) = (trusted.first(), trusted.last()) else {
            return format!("{}: no run with it completed", short(&self.key));
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
        let failed = self.positions.iter().filter(|position| position.failed);
        let failed: Vec<&str> = failed.map(|position| position.value.as_str()).collect();
        if !failed.is_empty() {
            text += &format!("; not completed without suspicion at {}", failed.join(", "));
        }
        text
    }
}

/// The keys of a study that are varied and no scene's, in its order.
pub fn varied_keys(results: &Results, settings: &[StudySetting]) -> Vec<VariedKey> {
    let keys = results.file.vary.iter().enumerate();
    let varied = keys.filter(|(_, vary)| !vary.scene);
    let varied = varied.map(|(index, _)| varied_key(results, settings, index));
    varied.collect()
}

fn varied_key(results: &Results, settings: &[StudySetting], index: usize) -> VariedKey {
    let vary = &results.file.vary[index];
    let count = results.file.measure.len();
    let mut values: Vec<String> = Vec::new();
    let mut with: BTreeMap<String, Vec<&StudySetting>> = BTreeMap::new();
    for setting in settings {
        let Some((_, value)) = setting.chosen.iter().find(|(at, _)| *at == index) else {
            continue;
        };
        if !values.contains(value) {
            values.push(value.clone());
        }
        with.entry(value.clone()).or_default().push(setting);
    }
    let order = order(results, &with, &values, index);
    if let Some(order) = &order {
        let far = |value: &String| -order[value].abs();
        values.sort_by(|a, b| far(a).total_cmp(&far(b)));
    }
    let position = |value: &String| {
        let same = &with[value];
        let each = |of: &dyn Fn(&StudySetting) -> Option<f64>| {
            median(same.iter().filter_map(|setting| of(setting)).collect())
        };
        let raw = |k: usize| each(&|setting| setting.middle(|row| row.error(k)));
        let signed = |k: usize| {
            let single = results.file.measure[k].norm == Norm::At;
            each(&|setting| setting.middle(|row| row.deviations[k])).filter(|_| single)
        };
        ValueEffect {
            value: value.clone(),
            cost: each(&|setting| setting.price()),
            errors: (0..count).map(raw).collect(),
            deviations: (0..count).map(signed).collect(),
            work: ["element_steps", "contact_iterations"]
                .map(|name| each(&|setting| setting.cost(name))),
            distance: order.as_ref().map(|order| order[value]),
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
        numeric: values.iter().all(|value| number(value).is_some()),
        positions: values.iter().map(position).collect(),
        floors: (0..count).map(floor).collect(),
    }
}

fn number(value: &str) -> Option<f64> {
    let value = value.parse::<f64>().ok();
    value.filter(|x| *x > 0.0 && x.is_finite())
}

/// Distance of each value from the reference's, ln(value / reference); `None` where there is no such order. The reference's value is
/// the one that it has for the key, or the one with which a point is the same run as the reference.
fn order(
    results: &Results,
    with: &BTreeMap<String, Vec<&StudySetting>>,
    values: &[String],
    index: usize,
) -> Option<BTreeMap<String, f64>> {
    let reference = results.reference(0)?;
    let own = number(&reference.values[index]);
    let same = || {
        let mut of = with.iter();
        let found = of.find(|(_, settings)| {
            let mut rows = settings.iter().flat_map(|setting| &setting.rows);
            rows.any(|row| row.id == reference.id)
        });
        found.and_then(|(value, _)| number(value))
    };
    let zero = own.or_else(same)?;
    let distance = |value: &String| Some((value.clone(), (number(value)? / zero).ln()));
    values.iter().map(distance).collect()
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
        assert_eq!(loose.trend(0), "has too few values to fall");
        // 0.2 lies on one side of the reference, and 0.3 and 0.1 on the other.
        let mut sides = knob(&[0.3, 0.2, 0.25, 0.1], 0.0);
        let rises = "does not fall from 1 (20 %) to 2 (25 %)";
        assert_eq!(sides.trend(0), rises);
        sides.positions[1].distance = Some(-3.0);
        assert_eq!(sides.trend(0), falls);
    }

    #[test]
    fn a_rise_has_a_reason_where_numbers_tell_one() {
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
    fn a_sentence_tells_cost_and_error_from_the_nearest_to_the_farthest() {
        let sentence = knob(&[0.047, 0.022], 0.0).sentence(&["traction".into()]);
        assert_eq!(
            sentence,
            "substeps 1 -> 0: 2.0x cheaper, 2.2 -> 4.7 % traction error"
        );
    }

    #[test]
    fn parts_are_told_with_two_digits() {
        let told = [0.0, 0.5, 0.0123, 1e-6, 3e-9, 2.5].map(percent);
        assert_eq!(told, ["0", "50", "1.2", "1.0e-4", "3.0e-7", "250"]);
    }
}
