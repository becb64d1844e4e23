//! Budgets: the setting of a stored study that stays within an error or a time.

use std::cmp::Ordering;
use std::path::Path;

use serde_json::{Value, json};

use super::measure::{named_errors, percent};
use super::statistics::ErrorPrediction;
use super::stored::{StoredSetting, StoredStudy, known};
use runs::curve::median;
use scenario::error::{Error, Refusal};

/// A bound on the time of a run, or on its error.
#[derive(Clone, Debug, PartialEq)]
pub enum Budget {
    /// Wall-clock time (s).
    Wall(f64),
    /// Error in a measure, or in all measures.
    Error {
        /// Name of the measure; all if absent.
        measure: Option<String>,
        /// Relative error.
        error: f64,
    },
}

impl Budget {
    /// Reads `error=2%`, `MEASURE=0.02`, `wall=60s`.
    ///
    /// # Errors
    /// The text is none of these; the error says why.
    pub fn parse(text: &str) -> Result<Budget, String> {
        let usage = || {
            format!(
                "`{text}` is neither error=2%, MEASURE=2% nor wall=60s (or min, or h), with a number above 0"
            )
        };
        let (name, value) = text.split_once('=').ok_or_else(usage)?;
        let positive = |text: &str, factor: f64| {
            let number = text.trim().parse::<f64>().ok().map(|x| x * factor);
            let number = number.filter(|x| *x > 0.0 && x.is_finite());
            number.ok_or_else(usage)
        };
        if name == "wall" {
            let units = [("min", 60.0), ("h", 3600.0), ("s", 1.0)];
            let mut units = units.iter();
            let unit = units.find_map(|(unit, s)| Some((value.strip_suffix(unit)?, *s)));
            let (number, factor) = unit.unwrap_or((value, 1.0));
            return Ok(Budget::Wall(positive(number, factor)?));
        }
        let part = value.strip_suffix('%').map(|number| (number, 0.01));
        let (number, factor) = part.unwrap_or((value, 1.0));
        let error = positive(number, factor)?;
        if error >= 1.0 {
            return Err(format!(
                "`{text}` allows an error of {} %: it must be below 100 %, and a percentage needs its sign, as in error=2%",
                percent(error)
            ));
        }
        Ok(Budget::Error {
            measure: (name != "error").then(|| name.to_string()),
            error,
        })
    }
}

/// A setting of a study with which a scene can run.
#[derive(Clone, Debug)]
pub struct Candidate<'a> {
    /// The setting.
    pub setting: &'a StoredSetting,
    /// Its predicted error in each measure.
    pub predictions: Vec<ErrorPrediction>,
}

/// The settings of a study for a scene.
#[derive(Clone, Debug)]
pub struct SceneSettings<'a> {
    study: &'a StoredStudy,
    candidates: Vec<Candidate<'a>>,
}

/// The choice of the first study that covers a scene and has one: the study at this path, or the known studies in order. A study is read
/// only if those before it have no choice. `choose` gets the study and the position of the scene in it.
///
/// # Errors
/// The first refusal of a study that covers the scene; if no study covers it, the reasons of all.
pub fn first_choice<T>(
    path: Option<&Path>,
    resolved: &str,
    choose: impl Fn(&StoredStudy, &[f64]) -> Result<T, Error>,
) -> Result<T, Error> {
    let own = path.map(|path| StoredStudy::read(path).map(|study| (path.to_path_buf(), study)));
    let known = own.is_none().then(known).into_iter().flatten();
    let (mut refused, mut why) = (None, Vec::new());
    for study in own.into_iter().chain(known) {
        let (path, study) = study?;
        match study.locate(resolved).map(|at| choose(&study, &at)) {
            Ok(Err(error)) if !matches!(error, Error::Interrupted { .. }) => {
                refused = refused.or(Some(error));
            }
            Ok(chosen) => return chosen,
            Err(reason) => why.push(format!("{}: {reason}", path.display())),
        }
    }
    let problem = format!(
        "no study covers this scene, so its errors are unknown: {}; `thirdbody tune` makes a study, or give one with --study",
        why.join("; ")
    );
    Err(refused.unwrap_or_else(|| Refusal::argument("--budget", problem).into()))
}

impl<'a> SceneSettings<'a> {
    /// The settings of a study for the scene at this position.
    ///
    /// # Errors
    /// The study has too few scenes for a bound.
    pub fn new(study: &'a StoredStudy, at: &[f64]) -> Result<SceneSettings<'a>, Error> {
        let candidate = |setting: &'a StoredSetting| {
            let measures = 0..study.measures.len();
            let predictions = measures.map(|measure| study.predict(setting, measure, at));
            Some(Candidate {
                setting,
                predictions: predictions.collect::<Option<_>>()?,
            })
        };
        // A warning that the reference does not have means that a setting errs in more than the measures.
        let all = study.settings.iter();
        let stand = all.filter(|setting| setting.warned.is_empty());
        let candidates: Vec<Candidate> = stand.filter_map(candidate).collect();
        if candidates.iter().all(|c| c.setting.set == study.reference) {
            let problem = format!(
                "the study `{}` has too few scenes to bound the error of another scene: give its keys with `scene = true` more values",
                study.study
            );
            return Err(Refusal::argument("--budget", problem).into());
        }
        Ok(SceneSettings { study, candidates })
    }

    /// The cheapest setting whose errors stay below the budget.
    ///
    /// # Errors
    /// The budget is below the floor of noise, or below the bound of the study's reference; or the study lacks the measure.
    pub fn within_error(&self, measure: Option<&str>, error: f64) -> Result<&Candidate<'a>, Error> {
        let refuse = |problem: String| Refusal::argument("--budget", problem);
        let measures = &self.study.measures;
        let asked = |index: &usize| measure.is_none_or(|name| name == measures[*index].name);
        let indices: Vec<usize> = (0..measures.len()).filter(asked).collect();
        if let (Some(name), []) = (measure, &indices[..]) {
            let known = Vec::from_iter(measures.iter().map(|m| m.name.as_str())).join(", ");
            let study = &self.study.study;
            let problem = format!("the study `{study}` measures {known}, and not `{name}`");
            return Err(refuse(problem).into());
        }
        let is_noise = |index: &&usize| error < self.study.floor(**index);
        if let Some(index) = indices.iter().find(is_noise) {
            let name = &measures[*index].name;
            let [error, floor] = [error, self.study.floor(*index)].map(percent);
            let problem = format!(
                "{error} % is below the floor of noise: references that differ by 1e-12 of a radius lie {floor} % apart in `{name}`, and a smaller distance is noise"
            );
            return Err(refuse(problem).into());
        }
        let fits = |c: &&Candidate| indices.iter().all(|k| c.predictions[*k].bound <= error);
        let fitting = self.candidates.iter().filter(fits);
        let cheapest = fitting.min_by(|a, b| a.setting.cpu_rel.total_cmp(&b.setting.cpu_rel));
        let none = "no setting of the study is known to keep this error, not even its reference";
        Ok(cheapest.ok_or_else(|| refuse(none.into()))?)
    }

    /// The setting with these overrides.
    pub fn with(&self, set: &[String]) -> Option<&Candidate<'a>> {
        let mut all = self.candidates.iter();
        all.find(|candidate| candidate.setting.set == set)
    }

    /// The settings sorted by their largest bound, the most accurate first.
    pub fn by_accuracy(&self) -> Vec<&Candidate<'a>> {
        let mut all: Vec<&Candidate> = self.candidates.iter().collect();
        // The largest bound over all measures.
        let worst = |c: &Candidate| c.predictions.iter().map(|p| p.bound).fold(0.0, f64::max);
        let key = |c: &Candidate| (worst(c), c.setting.cpu_rel);
        all.sort_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(Ordering::Equal));
        all
    }

    /// The choice as an object for summary.json.
    pub fn summary(&self, chosen: &Candidate, budget: &str, wall_s: Option<f64>) -> Value {
        let measures = self.study.measures.iter().zip(&chosen.predictions);
        let errors = measures.enumerate().map(|(index, (measure, prediction))| {
            let error = json!({
                "of": measure.of,
                "expected": prediction.expected,
                "bound": prediction.bound,
                "floor": median(self.study.floors[index].clone()).unwrap_or(0.0),
                "reference_misses": self.study.reference_misses.get(index),
            });
            (measure.name.clone(), error)
        });
        json!({
            "budget": budget,
            "study": self.study.study,
            "setting": chosen.setting.words,
            "set": chosen.setting.set,
            "reference": self.study.reference,
            "errors": Value::Object(errors.collect()),
            "cpu_over_reference": chosen.setting.cpu_rel,
            "study_wall_s": chosen.setting.wall_s,
            "foretold_wall_s": wall_s,
        })
    }

    /// The choice in words.
    pub fn words(&self, chosen: &Candidate) -> String {
        if chosen.setting.set == self.study.reference {
            return format!(
                "budget: study `{}` has only its reference within this budget, and a study does not measure the error of its own reference",
                self.study.study
            );
        }
        let errors = self.study.measures.iter().zip(&chosen.predictions);
        let errors = errors.map(|(measure, prediction)| {
            let [expected, bound] = [prediction.expected, prediction.bound].map(percent);
            let scenes = if self.study.seedless {
                "with any seed".into()
            } else {
                format!("below {bound} % in 39 of 40 scenes")
            };
            format!("{} {expected} % ({scenes})", measure.name)
        });
        let mut errors = Vec::from_iter(errors).join(", ");
        let missed = named_errors(&self.study.measures, &self.study.reference_misses);
        if !missed.is_empty() {
            errors += &format!("; by extrapolation, the reference itself errs by {missed}");
        }
        let StoredSetting { words, cpu_rel, .. } = chosen.setting;
        format!(
            "budget: study `{}` chooses {words}: {cpu_rel:.3} of the processor time of its reference; expected errors against a reference of this scene: {errors}",
            self.study.study
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_are_read_with_their_units() {
        let error = |measure: Option<&str>, error: f64| Budget::Error {
            measure: measure.map(String::from),
            error,
        };
        assert_eq!(Budget::parse("error=2%"), Ok(error(None, 0.02)));
        assert_eq!(
            Budget::parse("pressure=0.5"),
            Ok(error(Some("pressure"), 0.5))
        );
        assert_eq!(Budget::parse("wall=60s"), Ok(Budget::Wall(60.0)));
        assert_eq!(Budget::parse("wall=2min"), Ok(Budget::Wall(120.0)));
        assert_eq!(Budget::parse("wall=1.5"), Ok(Budget::Wall(1.5)));
        for wrong in [
            "error",
            "error=",
            "error=-1%",
            "wall=0",
            "wall=1d",
            "error=nan",
            "error=5",
            "error=1",
            "pressure=150%",
        ] {
            assert!(Budget::parse(wrong).is_err(), "{wrong}");
        }
    }

    fn setting(words: &str, error: f64, cpu_rel: f64) -> Value {
        json!({ "words": words, "set": [format!("a.b={words}")], "errors": [[error, 1.1 * error, error, 0.9 * error, error]],
                "cpu_rel": cpu_rel, "wall_s": 10.0 * cpu_rel })
    }

    /// Five scenes that differ only by their seeds, with a floor of 1e-4.
    fn study() -> StoredStudy {
        let study = json!({
            "schema": "thirdbody.study/1", "study": "s", "build": "b", "scenario": "[x]\ny = 1\n", "reference": ["a.b=ref"],
            "scene_keys": [{ "key": "run.seed", "any": true, "values": [1, 2, 3, 4, 5] }],
            "measures": [{ "name": "m", "of": "results.x", "norm": "at" }],
            "floors": [[1e-4, 5e-5, 1e-4, 1e-4, 1e-4]],
            "settings": [setting("ref", 1e-4, 1.0), setting("fine", 0.002, 0.5), setting("fast", 0.02, 0.1), setting("odd", 0.05, 0.2)],
        });
        serde_json::from_value(study).expect("a stored study")
    }

    #[test]
    fn the_cheapest_setting_within_the_error_is_chosen() {
        let study = study();
        let choice = SceneSettings::new(&study, &[]).expect("five scenes will do");
        let words = |error: f64| {
            let chosen = choice.within_error(None, error);
            chosen
                .map(|c| c.setting.words.clone())
                .map_err(|e| e.to_string())
        };
        assert_eq!(words(0.03), Ok("fast".into()));
        assert_eq!(words(0.01), Ok("fine".into()));
        // The bound of `fine` is about 1.3 times its error.
        assert_eq!(words(0.0021), Ok("ref".into()));
        let below = words(5e-5).expect_err("the floor is 1e-4");
        assert!(
            below.contains("0.0050 % is below the floor of noise") && below.contains("0.010 %"),
            "{below}"
        );
        let unknown = choice
            .within_error(Some("n"), 0.1)
            .expect_err("it measures m")
            .to_string();
        assert!(unknown.contains("measures m, and not `n`"), "{unknown}");
        let order: Vec<&str> = choice
            .by_accuracy()
            .iter()
            .map(|c| c.setting.words.as_str())
            .collect();
        assert_eq!(order, ["ref", "fine", "fast", "odd"]);
        let reference = choice.within_error(None, 0.0021).expect("the reference");
        let words = choice.words(reference);
        assert!(
            words.contains("does not measure the error of its own reference")
                && !words.contains('%'),
            "{words}"
        );
    }

    #[test]
    fn a_setting_with_warnings_is_not_chosen() {
        let mut study = study();
        study.settings[2].warned.push("energy_balance".into());
        let choice = SceneSettings::new(&study, &[]).expect("five scenes will do");
        let chosen = choice.within_error(None, 0.03).expect("another one");
        assert_eq!(chosen.setting.words, "fine");
    }

    #[test]
    fn a_scene_that_differs_elsewhere_is_not_covered() {
        let study = study();
        assert_eq!(
            study.locate("[run]\nseed = 77\n[x]\ny = 1\n[a]\nb = 3\n"),
            Ok(vec![])
        );
        let other = study
            .locate("[run]\nseed = 77\n[x]\ny = 2\n")
            .expect_err("y differs");
        assert_eq!(other, "it has x.y = 1, and this scene 2");
        // A scene without a seed has the default seed.
        assert_eq!(study.locate("[x]\ny = 1\n"), Ok(vec![]));
    }
}
