//! `thirdbody study new`: a study of the numerical choices of a scene, to be changed and run.

use std::path::PathBuf;

use super::common::{ScenarioArguments, from_anywhere, print};
use coordinator::participants::Registry;
use coordinator::run::check::check;
use scenario::error::{Error, Refusal};
use study::draft::{Draft, measures, of_choices, shortened};
use study::knobs::Knobs;
use study::open_study::write_in;
use study::plan::perturbed_participants;

/// Arguments of `study new`.
#[derive(Debug, clap::Args)]
pub(super) struct NewStudyArguments {
    #[command(flatten)]
    scenario: ScenarioArguments,
    /// Folder of study.toml, in which there is none yet; by default study-NAME, here.
    dir: Option<PathBuf>,
}

/// Seeds that a bound of an error can be told from.
const SEEDS: u64 = 5;
/// Perturbed references.
const PERTURBED: u64 = 3;

/// Sentences above a study that is written.
const HEAD: &str = "Numerical choices of a scene against a reference that is finer in all of them: each by itself, then several together.
Take out what is not needed and add what is; `thirdbody study plan` tells what it costs, `thirdbody study run` does it.";

/// Writes a study of a scene; returns its file.
pub(super) fn new(arguments: &NewStudyArguments, registry: &Registry) -> Result<PathBuf, Error> {
    let loaded = arguments.scenario.load()?;
    let threads = arguments.scenario.threads();
    check(&loaded, registry, threads)?;
    let name = &loaded.scenario.run.name;
    let folder = arguments.dir.clone();
    let folder = folder.unwrap_or_else(|| PathBuf::from(format!("study-{name}")));
    let path = folder.join(scenes::STUDY);
    if path.exists() {
        let why = "is there already; give another folder";
        return Err(Refusal::file(&path, why).into());
    }
    let knobs = Knobs::of(&loaded);
    let stands = |set: &[String]| {
        let loaded = arguments.scenario.with(set);
        loaded.is_ok_and(|loaded| check(&loaded, registry, threads).is_ok())
    };
    let draft = of_choices(&knobs, stands).ok_or_else(|| {
        let why = "it has no numerical choice that is known here: mesh, element, window, step, mass scale, tolerance";
        Refusal::argument("SCENARIO", why)
    })?;
    let measures = measures(&knobs);
    if measures.is_empty() {
        let why = "it has neither a wheel nor an interface, so that what to measure is not known: write a study by hand";
        return Err(Refusal::argument("SCENARIO", why).into());
    }
    let grains = perturbed_participants(&loaded.scenario);
    let seed = loaded.scenario.run.seed;
    let draft = Draft {
        head: HEAD.into(),
        name: name.clone(),
        scenario: from_anywhere(&arguments.scenario.scenario, &loaded),
        set: arguments.scenario.set.clone(),
        small: shortened(&knobs),
        perturb: if grains.is_empty() { 0 } else { PERTURBED },
        seeds: (seed..seed + SEEDS).collect(),
        measures,
        ..draft
    };
    write_in(&folder, scenes::STUDY, &draft.toml())?;
    print(&path.display().to_string())?;
    Ok(path)
}
