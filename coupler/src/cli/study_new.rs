//! `thirdbody study new`: a study of the numerical choices of a scene, to edit and run.

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
    /// Folder for study.toml, which it must not contain yet (default: study-NAME in the current folder).
    dir: Option<PathBuf>,
}

/// Number of seeds that a bound of an error needs.
const SEEDS: u64 = 5;
/// Number of perturbed references.
const PERTURBED: u64 = 3;

/// Comment at the head of a written study.
const HEAD: &str = "Numerical choices of a scene against a reference that is finer in all of them: each by itself, then several together.
Remove and add entries as you need; `thirdbody study plan` predicts the cost, `thirdbody study run` runs the study.";

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
        let why = "exists already; give another folder";
        return Err(Refusal::file(&path, why).into());
    }
    let knobs = Knobs::of(&loaded);
    let stands = |set: &[String]| {
        let loaded = arguments.scenario.with(set);
        loaded.is_ok_and(|loaded| check(&loaded, registry, threads).is_ok())
    };
    let draft = of_choices(&knobs, stands).ok_or_else(|| {
        let why = "the scene has no numerical choice that a study can vary: mesh, element, window, step, mass scale, tolerance, modes";
        Refusal::argument("SCENARIO", why)
    })?;
    let measures = measures(&knobs);
    if measures.is_empty() {
        let why = "the scene has neither a wheel nor an interface, and thus no usual measure: write a study by hand";
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
