//! `thirdbody tune`: find the cheapest setting of a scene that keeps an error, and run the scene with it.

use std::path::PathBuf;
use std::time::Instant;

use super::budget::predicted_wall_s;
use super::common::{
    self, ScenarioArguments, VerbResult, foreign, from_anywhere, own_program, print,
};
use super::run::{EndingArguments, conclude};
use super::start::{listen, options};
use coordinator::participants::Registry;
use coordinator::run::check::check;
use coordinator::run::session::{RunBudget, run};
use scenario::error::{CHECK_FAILED, Error, Refusal};
use scenario::load::Loaded;
use study::budget::{Budget, SceneSettings};
use study::draft::{further_measures, measures};
use study::knobs::Knobs;
use study::measure::{Measure, percent};
use study::plan::scene_id;
use study::tuning::{Found, Tuning};
use terminal::{print_note, tell_progress};

/// Arguments of `tune`.
#[derive(Debug, clap::Args)]
pub struct TuneArguments {
    #[command(flatten)]
    scenario: ScenarioArguments,
    /// Error to keep, relative to a finer reference with the same seed: 2% or 0.02.
    #[arg(long, value_name = "ERROR", value_parser = error)]
    error: f64,
    /// Measures that must keep the error: pressure, height, friction, shear, traction (the vector of pressure and shear), signals.NAME,
    /// profile.NAME or results.NAME (default: the measures of `study new`).
    #[arg(long = "for", value_name = "MEASURE", value_delimiter = ',')]
    measures: Vec<String>,
    /// Time for finding the setting: 10min, 600s or 2h (default: the time of eighteen runs of the scene as it is).
    #[arg(long, value_name = "TIME", value_parser = seconds)]
    within: Option<f64>,
    /// Folder of the runs and of study.json, where a second call continues (default: a folder in runs/).
    #[arg(long, value_name = "DIR")]
    study: Option<PathBuf>,
    /// Find and store the setting, but do not run the scene with it.
    #[arg(long)]
    no_run: bool,
    /// Run directory of the run with the chosen setting, new or empty (default: a new folder in runs/).
    #[arg(long, conflicts_with = "no_run")]
    out: Option<PathBuf>,
    #[command(flatten)]
    ending: EndingArguments,
}

/// Default time for finding a setting, in runs of the scene.
const RUNS: f64 = 18.0;

/// Finds a setting, stores it, and runs the scene with it.
pub fn tune(arguments: &TuneArguments, registry: &Registry) -> VerbResult {
    let loaded = arguments.scenario.load()?;
    let threads = arguments.scenario.threads();
    for warning in check(&loaded, registry, threads)? {
        print_note(&warning.line());
    }
    let knobs = Knobs::of(&loaded);
    let measures = chosen_measures(&knobs, &arguments.measures);
    let measures = measures.map_err(|why| Refusal::argument("--for", why))?;
    let begun = Instant::now();
    let scene_s = predicted_wall_s(&loaded, threads, registry)?;
    let limit_s = arguments.within.unwrap_or(RUNS * scene_s);
    tell_progress(&format!(
        "tune: the scene takes about {scene_s:.1} s, and the search for a setting at most {limit_s:.0} s"
    ));
    let mut set = arguments.scenario.set.clone();
    // Threads wait for each other at a lower cost than processes; the bits are the same.
    if foreign(&loaded.scenario).is_none() {
        set.push("run.transport=channel".into());
    }
    let tuning = Tuning {
        scenario: from_anywhere(&arguments.scenario.scenario, &loaded),
        set,
        knobs,
        loaded: &loaded,
        folder: folder(arguments, &loaded)?,
        measures,
        target: arguments.error,
        watch: listen()?,
        begun,
        limit_s,
        run_s: if arguments.no_run { 0.0 } else { scene_s },
        program: own_program()?,
        cache: registry.cache.clone(),
        jobs: common::threads(None),
    };
    let explored = tuning.explore()?;
    print(&tuning.table(&explored))?;
    let Found { study, set } = match tuning.find(&explored)? {
        Ok(found) => found,
        Err(why) => {
            print(&why)?;
            return Ok(CHECK_FAILED);
        }
    };
    let settings = SceneSettings::new(&study, &[])?;
    let lost = || Refusal::argument("--error", "the study has lost its setting");
    let chosen = settings.with(&set).ok_or_else(lost)?;
    print(&settings.words(chosen))?;
    if arguments.no_run {
        return Ok(0);
    }
    let mut options = options(arguments.out.as_deref(), threads, registry)?;
    options.listener = terminal::listener();
    options.strict = arguments.ending.strict;
    let budget = format!("error={}%", percent(arguments.error));
    options.budget = Some(RunBudget {
        told: settings.summary(chosen, &budget, None),
        wall_s: None,
    });
    let ended = run(&arguments.scenario.with(&set)?, &options)?;
    conclude(ended, arguments.ending)
}

/// Reads an error: 2% or 0.02.
fn error(text: &str) -> Result<f64, String> {
    match Budget::parse(&format!("error={text}")) {
        Ok(Budget::Error { error, .. }) => Ok(error),
        _ => Err("expected an error below 100 %, such as 2% or 0.02".into()),
    }
}

/// Reads a time (s): 90s, 10min or 2h.
fn seconds(text: &str) -> Result<f64, String> {
    match Budget::parse(&format!("wall={text}")) {
        Ok(Budget::Wall(seconds)) => Ok(seconds),
        _ => Err("expected a time, such as 90s, 10min or 2h".into()),
    }
}

/// The measures that must keep the error: the named ones, or the usual ones of the scene.
fn chosen_measures(knobs: &Knobs, named: &[String]) -> Result<Vec<Measure>, String> {
    let usual = measures(knobs);
    if usual.is_empty() && named.is_empty() {
        let why = "the scene has neither a wheel nor an interface: name what must keep the error, signals.NAME or results.NAME";
        return Err(why.into());
    }
    let known = [&usual[..], &further_measures(knobs)].concat();
    let names = known.iter().map(|measure| format!("{}, ", measure.name));
    let names = names.collect::<String>();
    let of_name = |name: &String| {
        let own = Measure::new(&name.replace('.', "-"), name.clone());
        let is_it = |measure: &&Measure| [&measure.name, &measure.of].contains(&name);
        let found = known.iter().find(is_it).cloned();
        let found = found.or_else(|| own.table().is_some().then(|| own.clone()));
        found.ok_or_else(|| format!("`{name}` is not measured; this scene has {names}signals.NAME, profile.NAME and results.NAME"))
    };
    match named {
        [] => Ok(usual),
        named => named.iter().map(of_name).collect(),
    }
}

/// The folder of the runs: scenes that differ in more than their seed have different folders.
fn folder(arguments: &TuneArguments, loaded: &Loaded) -> Result<PathBuf, Error> {
    let (name, id) = (&loaded.scenario.run.name, scene_id(loaded));
    let named = || PathBuf::from(format!("runs/tune-{name}-{id}"));
    let folder = arguments.study.clone().unwrap_or_else(named);
    std::path::absolute(&folder).map_err(Error::output(folder.display()))
}
