//! Settings: values of the keys that trade speed for accuracy, over all scenes of a study.

use runs::curve::median;
use std::collections::BTreeMap;

use super::collect::{Results, StudyRow};
use super::plan::TaskRole;

/// A setting with its rows, scene by scene.
#[derive(Clone, Debug)]
pub struct StudySetting<'a> {
    /// Its values by the index of the key, without keys that are not varied.
    pub chosen: Vec<(usize, String)>,
    /// Its rows, one per scene.
    pub rows: Vec<&'a StudyRow<'a>>,
}

impl StudySetting<'_> {
    /// True if the results of all scenes can be trusted.
    pub fn is_trusted(&self) -> bool {
        self.rows.iter().all(|row| row.is_trusted())
    }

    /// True if its runs are the references themselves, or the same bit for bit.
    pub fn is_reference(&self, results: &Results) -> bool {
        let same = |row: &&StudyRow| {
            let bits = |of: &StudyRow| !row.hashes[1].is_empty() && of.hashes == row.hashes;
            let reference = results.reference(row.task.scene);
            reference.is_some_and(|of| of.task.id == row.task.id || bits(of))
        };
        self.rows.iter().all(same)
    }

    /// Its values in words, with the last parts of the keys.
    pub fn words(&self, results: &Results) -> String {
        if self.chosen.is_empty() {
            return "reference".into();
        }
        let word = |(index, value): &(usize, String)| {
            format!("{} = {value}", short(&results.file.vary[*index].key))
        };
        Vec::from_iter(self.chosen.iter().map(word)).join(", ")
    }

    /// Errors in a measure, one per scene and at least the floor of noise; `None` if one is missing.
    pub fn errors(&self, measure: usize) -> Option<Vec<f64>> {
        let error =
            |row: &&StudyRow| Some(row.error(measure)?.max(row.floors[measure].unwrap_or(0.0)));
        self.rows.iter().map(error).collect()
    }

    /// The median of a number over its scenes; `None` if one is missing.
    pub fn middle(&self, of: impl Fn(&StudyRow) -> Option<f64>) -> Option<f64> {
        let numbers = self.rows.iter().map(|row| of(row));
        numbers.collect::<Option<Vec<f64>>>().and_then(median)
    }

    /// The median of a cost relative to the reference.
    pub fn cost_rel(&self, name: &str) -> Option<f64> {
        self.middle(|row| row.cost_rel.get(name).copied())
    }

    /// The median of a cost.
    pub fn cost(&self, name: &str) -> Option<f64> {
        self.middle(|row| row.cost.get(name).copied())
    }

    /// Its price: processor time relative to the reference, or in seconds if the reference is no run of the study.
    pub fn price(&self) -> Option<f64> {
        self.cost_rel("cpu_s").or_else(|| self.cost("cpu_s"))
    }
}

/// The last parts of a key that identify it: `mass_scale`, `solver.tolerance`.
pub fn short(key: &str) -> &str {
    let mut dots = key.rmatch_indices('.').map(|(at, _)| at);
    let (last, before) = (dots.next(), dots.next());
    let name = last.map_or(key, |at| &key[at + 1..]);
    // A word that occurs in several tables of solvers is ambiguous alone.
    if ["tolerance", "kind", "step_s", "value"].contains(&name) {
        return before.map_or(key, |at| &key[at + 1..]);
    }
    name
}

/// The settings of a study: the reference, if it is a run of the study, then the points in order.
pub fn settings<'a>(results: &'a Results) -> Vec<StudySetting<'a>> {
    let mut all: Vec<StudySetting> = Vec::new();
    let mut known: BTreeMap<Vec<(usize, String)>, usize> = BTreeMap::new();
    let rows = results.rows.iter();
    for row in rows.filter(|row| !matches!(row.task.role, TaskRole::Perturbed(_))) {
        let varied = (results.file.vary.iter().enumerate())
            .filter(|(index, vary)| row.task.varied[*index] && !vary.scene);
        let chosen = varied.map(|(index, _)| (index, row.task.values[index].clone()));
        let chosen: Vec<(usize, String)> = chosen.collect();
        let index = *known.entry(chosen.clone()).or_insert(all.len());
        if index == all.len() {
            let rows = Vec::new();
            all.push(StudySetting { chosen, rows });
        }
        all[index].rows.push(row);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_shortened_to_the_parts_that_identify_them() {
        assert_eq!(short("interface.layer-base.substeps"), "substeps");
        assert_eq!(
            short("participant.third-body.config.solver.tolerance"),
            "solver.tolerance"
        );
        assert_eq!(short("mesh"), "mesh");
    }

    #[test]
    fn the_median_of_two_is_their_mean() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![3.0, 1.0]), Some(2.0));
        assert_eq!(median(vec![]), None);
    }
}
