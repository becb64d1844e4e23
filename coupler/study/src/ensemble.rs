//! Means of the measures over the scenes of a study, with their scatter: if scenes differ by their seeds, each run is one random draw,
//! and only means can be told apart.

use std::collections::BTreeSet;

use super::collect::{Results, cell, line};
use super::settings::{StudySetting, settings};
use draw::units::{axis_words, unit};
use kit::student::{mean_of, student};

/// A result of a setting over all scenes.
#[derive(Clone, Debug, PartialEq)]
pub struct EnsembleMean {
    /// Index of its measure.
    pub measure: usize,
    /// Name of the measure.
    pub name: String,
    /// Its unit; empty for a dimensionless number.
    pub unit: &'static str,
    /// The setting in words.
    pub setting: String,
    /// Values of its keys by their indices; empty for the reference.
    pub chosen: Vec<(usize, String)>,
    /// True for the reference.
    pub reference: bool,
    /// The values of the trusted runs; runs with the same bits are one draw and have one value.
    pub values: Vec<f64>,
    /// Number of those runs, counted in each scene.
    pub runs: usize,
    /// Mean of the values.
    pub mean: f64,
    /// Standard deviation; 0 for one value, as is the half-width.
    pub deviation: f64,
    /// Half-width of the 95 % interval of the mean, t s / sqrt(n).
    pub half_width: f64,
    /// Difference of the mean from the reference's, and half-width of its interval (Welch 1947).
    pub difference: Option<[f64; 2]>,
}

/// Difference of two means, and half-width of its 95 % interval, for unequal variances (Welch 1947).
fn difference(a: &[f64], b: &[f64]) -> Option<[f64; 2]> {
    let [of_a, of_b] = [mean_of(a)?, mean_of(b)?];
    let part = |of: [f64; 3], count: usize| of[1] * of[1] / count as f64;
    let parts = [part(of_a, a.len()), part(of_b, b.len())];
    let variance = parts[0] + parts[1];
    let below = parts[0].powi(2) / (a.len() - 1) as f64 + parts[1].powi(2) / (b.len() - 1) as f64;
    // Without scatter the ratio is NaN, and the maximum is 1.
    let freedom = (variance * variance / below).max(1.0) as usize;
    Some([of_a[0] - of_b[0], student(freedom) * variance.sqrt()])
}

/// The means of all measures that are results, setting by setting; empty with a single scene. Without a reference, the means of all
/// measures, where a single value is its own mean.
pub fn ensemble(results: &Results) -> Vec<EnsembleMean> {
    let settings = settings(results);
    let values = |setting: &StudySetting, measure: usize| -> Vec<f64> {
        let mut seen = BTreeSet::new();
        let rows = setting.rows.iter().filter(|row| row.is_trusted());
        let draws = rows.filter(|row| seen.insert(row.draw()));
        draws.filter_map(|row| row.numbers[measure]).collect()
    };
    let held = results.file.reference.is_given();
    let mut all = settings.iter();
    let reference = all.find(|setting| setting.is_reference(results));
    let mut means = Vec::new();
    let measures = results.file.measure.iter().enumerate();
    for (measure, of) in measures.filter(|(_, of)| of.is_result() || !held) {
        let reference_values = reference.map(|setting| values(setting, measure));
        means.extend(settings.iter().filter_map(|setting| {
            let values = values(setting, measure);
            let rows = setting.rows.iter().filter(|row| row.is_trusted());
            let runs = rows.filter(|row| row.numbers[measure].is_some()).count();
            let is_single = values.len() == 1 && (!held || runs > 1);
            let single = || is_single.then(|| [values[0], 0.0, 0.0]);
            let [mean, deviation, half_width] = mean_of(&values).or_else(single)?;
            let is_reference = setting.is_reference(results);
            let other = reference_values.as_ref().filter(|_| !is_reference);
            Some(EnsembleMean {
                measure,
                name: of.name.clone(),
                unit: unit(&of.of),
                setting: setting.words(results),
                chosen: setting.chosen.clone(),
                reference: is_reference,
                difference: other.and_then(|other| difference(&values, other)),
                values,
                runs,
                mean,
                deviation,
                half_width,
            })
        }));
    }
    means
}

impl EnsembleMean {
    /// The values and the ends of the interval of the mean.
    pub fn reach(&self) -> impl Iterator<Item = f64> + '_ {
        let interval = [self.mean - self.half_width, self.mean + self.half_width];
        self.values.iter().copied().chain(interval)
    }

    /// Its measure with the unit for numbers like these, after the factor from SI to the unit.
    pub fn title(&self, numbers: impl Iterator<Item = f64>) -> (f64, String) {
        let size = numbers.fold(0.0, |most: f64, x| most.max(x.abs()));
        axis_words(&self.name, self.unit, size)
    }

    /// A line of text, without the name of the measure.
    pub fn words(&self) -> String {
        let [mean, half, scatter] = [self.mean, self.half_width, self.deviation];
        let (setting, count) = (&self.setting, self.values.len());
        let repeated = match self.runs - count {
            0 => String::new(),
            more => format!("; {more} more repeat the bits of another run and do not count"),
        };
        if count == 1 {
            return format!("{setting}: {mean:.4e}{repeated}");
        }
        let comparison = match self.difference {
            None if self.reference => ": the reference".to_string(),
            None => String::new(),
            Some([difference, half]) => {
                let share = 100.0 * difference / (mean - difference);
                let chance = ["within", "beyond"][usize::from(difference.abs() > half)];
                format!(": {share:+.0} % from the reference, {chance} chance")
            }
        };
        format!(
            "{setting}: {mean:.3e} +- {half:.1e} ({count} runs, scatter {scatter:.1e}{repeated}){comparison}"
        )
    }
}

/// means.csv.
pub fn csv(means: &[EnsembleMean]) -> String {
    let mut text = String::from(
        "measure,setting,scenes,mean,standard_deviation,half_width_95,difference,difference_half_width_95\n",
    );
    for of in means {
        let several = of.values.len() > 1;
        let numbers = [
            Some(of.mean),
            Some(of.deviation).filter(|_| several),
            Some(of.half_width).filter(|_| several),
            of.difference.map(|[difference, _]| difference),
            of.difference.map(|[_, half_width]| half_width),
        ];
        let first = [&of.name, &of.setting, &of.values.len().to_string()].map(String::clone);
        text += &line(&[&first[..], &numbers.map(cell)].concat());
    }
    text
}

#[cfg(test)]
impl EnsembleMean {
    /// The mean of a single run, for tests of the pictures.
    pub(super) fn single(
        name: &str,
        unit: &'static str,
        chosen: Vec<(usize, String)>,
        mean: f64,
    ) -> EnsembleMean {
        EnsembleMean {
            measure: 0,
            name: name.into(),
            unit,
            setting: String::new(),
            chosen,
            reference: false,
            values: vec![mean],
            runs: 1,
            mean,
            deviation: 0.0,
            half_width: 0.0,
            difference: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means 2 and 5, deviations 1 and 2: variance 1/3 + 4/3, freedom (5/3)^2 / ((1/9)/2 + (16/9)/2) = 2.94, t = 4.303 of 2.
    #[test]
    fn means_and_their_differences_have_the_intervals_of_the_textbook() {
        let [mean, deviation, half] = mean_of(&[1.0, 2.0, 3.0]).expect("three");
        assert_eq!((mean, deviation), (2.0, 1.0));
        assert!((half - 4.303 / 3f64.sqrt()).abs() < 1e-12, "{half}");
        let [difference, half] = difference(&[1.0, 2.0, 3.0], &[3.0, 5.0, 7.0]).expect("both");
        assert_eq!(difference, -3.0);
        assert!((half - 4.303 * (5f64 / 3.0).sqrt()).abs() < 1e-12, "{half}");
        assert_eq!(mean_of(&[1.0]), None);
    }

    #[test]
    fn samples_without_scatter_differ_beyond_chance_or_not_at_all() {
        assert_eq!(difference(&[1.0, 1.0], &[1.0, 1.0]), Some([0.0, 0.0]));
        assert_eq!(difference(&[2.0, 2.0], &[1.0, 1.0]), Some([1.0, 0.0]));
    }
}
