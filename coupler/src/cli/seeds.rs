//! `thirdbody run --seeds`: runs a scene in parallel under several seeds and prints means with their scatter.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use super::common::{ScenarioArguments, VerbResult, from_anywhere, print};
use super::study::{EngineArguments, do_runs};
use coordinator::participants::Registry;
use report::seeds::{SeedMean, lines, means};
use runs::files::RunFiles;
use scenario::error::{CHECK_FAILED, Error, Refusal};
use scenario::overrides::key_of;
use study::collect::StudyRow;
use study::open_study::{OpenStudy, write_in};
use study::plan::Plan;

/// The key that differs between the runs.
const SEED: &str = "run.seed";

/// Runs a scene under `count` seeds, counted up from its own, and prints the mean of each result. The means leave out a run that is
/// missing or not to be trusted, and the exit code is then 8.
pub(super) fn run(
    scenario: &ScenarioArguments,
    count: u64,
    (out, json, all): (Option<&Path>, bool, bool),
    registry: &Registry,
) -> VerbResult {
    let opened = opened(scenario, count, out)?;
    let watch = do_runs(&opened, &EngineArguments::default(), registry)?;
    let results = opened.results()?;
    write_in(&opened.folder, "results.csv", &results.csv())?;
    let rows = || results.rows.iter();
    let draws = rows().filter(|row| row.is_trusted());
    let draws: BTreeSet<&[String]> = draws.map(StudyRow::draw).collect();
    let path = |row: &StudyRow| opened.task_folder(row.task).run();
    let trusted: Vec<PathBuf> = rows().filter(|row| row.is_trusted()).map(path).collect();
    if trusted.len() > 1 && draws.len() == 1 {
        let problem = "all runs have the same bits: nothing in this scene depends on run.seed, so one run is enough";
        return Err(Refusal::argument("--seeds", problem).into());
    }
    let read = trusted.iter().map(|run| RunFiles::read_for_page(run));
    let read = read.collect::<Result<Vec<_>, Error>>()?;
    let means = means(&read);
    let name = &opened.plan.file.study.name;
    let page = match &read[..] {
        [] | [_] => None,
        read => Some(report::seeds::write(&opened.folder, name, read, &means)?),
    };
    let runs: Vec<Value> = rows()
        .map(|row| json!({ "seed": row.task.values[0], "path": path(row), "status": row.status, "exit_code": row.exit_code, "message": row.message }))
        .collect();
    let values = means.iter().map(|of| {
        let SeedMean { mean, values, .. } = of;
        let value = json!({ "mean": mean, "half_width_95": of.half_width, "values": values });
        (of.name.clone(), value)
    });
    let values: Map<String, Value> = values.collect();
    let ensemble = json!({ "folder": opened.folder, "runs": runs, "results": values });
    write_in(&opened.folder, "means.json", &format!("{ensemble:#}\n"))?;
    if json {
        print(&ensemble.to_string())?;
    } else {
        let [done, of] = [trusted.len(), rows().count()];
        print(&format!(
            "runs      {done} of {of} completed, in {}",
            opened.folder.display()
        ))?;
        for run in &runs {
            let texts = ["seed", "status", "path", "message"];
            let [seed, status, path, message] =
                texts.map(|key| run[key].as_str().unwrap_or_default());
            print(format!("seed {seed:<4} {status} {path} {message}").trim_end())?;
        }
        print("Mean, half-width of its 95 % interval, lowest to highest")?;
        print(&lines(&means, all).join("\n"))?;
        if let Some(page) = &page {
            print(&format!("report    {}", page.display()))?;
        }
    }
    let fell = trusted.len() < results.rows.len();
    let code = if fell { CHECK_FAILED } else { 0 };
    watch.interrupted().map_or(Ok(code), Err)
}

/// The study of one key that describes these runs, written into its folder.
fn opened(
    scenario: &ScenarioArguments,
    count: u64,
    out: Option<&Path>,
) -> Result<OpenStudy, Error> {
    let loaded = scenario.load()?;
    let run = &loaded.scenario.run;
    let named = || format!("runs/{}-seeds", run.name).into();
    let folder = out.map_or_else(named, Path::to_path_buf);
    let folder = std::path::absolute(&folder).map_err(Error::output(folder.display()))?;
    let last = run.seed.checked_add(count - 1);
    if last.is_none_or(|last| i64::try_from(last).is_err()) {
        let (seed, most) = (run.seed, i64::MAX);
        let problem =
            format!("counts up from run.seed = {seed} to more than {most}: lower run.seed");
        return Err(Refusal::argument(format!("--seeds {count}"), problem).into());
    }
    let set = scenario.set.iter().filter(|set| key_of(set) != SEED);
    let study = json!({ "study": {
        "name": format!("{}-seeds", run.name),
        "scenario": from_anywhere(&scenario.scenario, &loaded),
        "set": Vec::from_iter(set),
        "threads": scenario.threads.unwrap_or(1),
    }, "vary": [{ "key": SEED, "values": Vec::from_iter(run.seed..run.seed.saturating_add(count)) }] });
    let text = toml::to_string(&study).expect("its seeds are integers of TOML");
    let file = write_in(&folder, scenes::STUDY, &text)?;
    OpenStudy::of(Plan::read(&file, false, &[])?, folder)
}
