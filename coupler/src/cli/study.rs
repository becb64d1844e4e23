//! `thirdbody study`: many runs of a scenario, compared with a reference or measured over its keys.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::time::Duration;

use nix::sys::signal::Signal;
use protocol::participate::end_with_parent;

use super::common::{VerbResult, own_program, print, threads};
use super::start::{listen, options};
use super::study_new::{self, NewStudyArguments};
use coordinator::participants::{Registry, Watch};
use coordinator::run::check::check;
use coordinator::run::session::RunOptions;
use report::results;
use runs::files::RunFiles;
use scenario::error::{CHECK_FAILED, Error, Refusal};
use study::collect::{DAMAGED, StudyRow, finished};
use study::digest::Digest;
use study::forecast::Forecast;
use study::open_study::{OpenStudy, write_in};
use study::plan::{Plan, Task, TaskRole, runs};
use study::pool;
use study::progress::StudyProgress;
use study::slurm::{Slurm, ended, queue};
use study::stored::{StoredStudy, serves_budgets};
use study::task::{SILENT, TaskFolder, TaskStage};
use terminal::print_note;

/// Arguments of `study`.
#[derive(Debug, clap::Args)]
pub struct StudyArguments {
    #[command(subcommand)]
    verb: StudyVerb,
}

#[derive(Debug, clap::Subcommand)]
enum StudyVerb {
    /// Write a study of the numerical choices of a scene and predict its cost.
    New(NewStudyArguments),
    /// List the tasks of a study and predict the cost of one.
    Plan(PlaceArguments),
    /// Run all unfinished tasks, then write results.csv, front.csv and the pictures.
    Run {
        #[command(flatten)]
        place: PlaceArguments,
        #[command(flatten)]
        engine: EngineArguments,
    },
    /// Print the state of the tasks.
    Status(PlaceArguments),
    /// Write results.csv, front.csv and the pictures of the finished tasks, even while others run.
    Collect(PlaceArguments),
    /// Write report.html of the finished tasks: settings, tables, pictures, warnings, and the build that measured them.
    Report {
        /// Folder that `study run` wrote, such as runs/study-NAME.
        folder: PathBuf,
    },
    /// Run one task.
    Exec(ExecTaskArguments),
}

/// The study and its folder.
#[derive(Debug, Default, clap::Args)]
struct PlaceArguments {
    /// Study: a folder with study.toml, a file, or a name from `thirdbody scenes`.
    file: PathBuf,
    /// Use the small form of the study that its file defines.
    #[arg(long)]
    small: bool,
    /// Override a key in all runs, including the reference; repeatable.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Folder of the tasks and results (default: runs/study-NAME, with --small runs/study-NAME-small).
    #[arg(long)]
    out: Option<PathBuf>,
}

/// The engine that runs the tasks.
#[derive(Debug, Default, clap::Args)]
pub(super) struct EngineArguments {
    /// Run tasks as processes on this machine, or as a Slurm job array.
    #[arg(long, value_enum, default_value_t = Engine::Local)]
    engine: Engine,
    /// Tasks at a time (default: the number of cores divided by the threads of a run; with Slurm, no limit).
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Repeat failed and damaged runs.
    #[arg(long)]
    retry: bool,
    /// Pass a further argument to sbatch, for example --sbatch=--partition=short; repeatable.
    #[arg(long, value_name = "ARGUMENT", allow_hyphen_values = true)]
    sbatch: Vec<String>,
    /// Seconds without a heartbeat after which a task that Slurm calls running counts as dead.
    #[arg(long, value_name = "S", default_value_t = SILENT.as_secs())]
    silent_s: u64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
enum Engine {
    #[default]
    Local,
    Slurm,
}

/// Arguments of `study exec`. The index comes last, so that engines can append it.
#[derive(Debug, clap::Args)]
struct ExecTaskArguments {
    #[command(flatten)]
    place: PlaceArguments,
    /// Planned list of tasks, which must contain this task.
    #[arg(long)]
    planned: Option<PathBuf>,
    /// End the task when the process with this id ends.
    #[arg(long)]
    parent: Option<u32>,
    /// Index of the task, as `plan` lists it.
    #[arg(long)]
    index: usize,
}

impl PlaceArguments {
    fn open(&self) -> Result<OpenStudy, Error> {
        let (plan, folder) = self.plan()?;
        if let Some(run) = &plan.file.reference.run {
            RunFiles::read(&plan.beside.join(run))?;
        }
        for measure in &plan.file.measure {
            if let Some(new) = measure.renamed() {
                print_note(&format!(
                    "measure `{}`: `{}` is the old name of `{new}`, a mean that includes sticking; the next release drops the old name",
                    measure.name, measure.of
                ));
            }
        }
        OpenStudy::of(plan, folder)
    }

    fn plan(&self) -> Result<(Plan, PathBuf), Error> {
        let plan = Plan::read(&self.file, self.small, &self.set)?;
        let small = if self.small { "-small" } else { "" };
        let named = || PathBuf::from(format!("runs/study-{}{small}", plan.file.study.name));
        let folder = self.out.clone().unwrap_or_else(named);
        let folder = std::path::absolute(&folder).map_err(Error::output(folder.display()))?;
        Ok((plan, folder))
    }
}

/// Runs a verb of `study`.
pub fn study(arguments: &StudyArguments, registry: &Registry) -> VerbResult {
    match &arguments.verb {
        StudyVerb::New(arguments) => {
            let place = PlaceArguments {
                file: study_new::new(arguments, registry)?,
                ..PlaceArguments::default()
            };
            plan(&place, registry)
        }
        StudyVerb::Plan(place) => plan(place, registry),
        StudyVerb::Run { place, engine } => run(&place.open()?, engine, registry),
        StudyVerb::Status(place) => status(&place.open()?),
        StudyVerb::Collect(place) => collect(&place.open()?),
        StudyVerb::Report { folder } => print(&report::study::write(folder)?.display().to_string()),
        StudyVerb::Exec(arguments) => exec(arguments, registry),
    }
}

fn quiet<'a>(plan: &Plan, registry: &'a Registry) -> Result<RunOptions<'a>, Error> {
    options(None, plan.file.study.threads.into(), registry)
}

/// Prints one line per task, and keeps the list and the cost of the first task in the folder.
fn plan(place: &PlaceArguments, registry: &Registry) -> VerbResult {
    let opened = place.open()?;
    if let Some((_, why)) = refused(&opened, registry).next() {
        return Err(why);
    }
    let planned = opened.keep_list()?;
    print(opened.listed().trim_end())?;
    let tasks = &opened.tasks;
    let forecast = predict(&opened, registry)?;
    print_note(&format!(
        "{} runs in {} rows, listed in {}; task 0 is predicted to take at most {:.0} s and {:.0} MB",
        runs(tasks).len(),
        tasks.len(),
        planned.display(),
        forecast.wall_s,
        forecast.memory_bytes as f64 * 1e-6
    ));
    if let Some(words) = serves_budgets(&opened.plan.file, tasks) {
        print_note(&words);
    }
    Ok(0)
}

/// The tasks that `check` refuses; only tasks that are the first with some value of a key are checked.
fn refused<'a>(
    opened: &'a OpenStudy,
    registry: &Registry,
) -> impl Iterator<Item = (&'a Task, Error)> {
    let mut seen = BTreeSet::new();
    let threads = opened.plan.file.study.threads.into();
    opened.tasks.iter().filter_map(move |task| {
        let values = task.values.iter().enumerate();
        let new = values.filter(|value| seen.insert(*value)).count();
        let why = || check(&task.loaded, registry, threads).err();
        Some((task, (new > 0).then(why)??))
    })
}

/// Predicts the cost of the first task, and refuses measures that this task does not report.
fn predict(opened: &OpenStudy, registry: &Registry) -> Result<Forecast, Error> {
    let (plan, task) = (&opened.plan, &opened.tasks[0]);
    let forecast = Forecast::of(task, &opened.folder, &quiet(plan, registry)?)?;
    let (results, of_cycles) = (results::names(), results::of_full_cycles());
    let checked = forecast.check(&plan.file.measure, task, &results, &of_cycles);
    checked.map_err(|why| Refusal::file(&plan.path, why))?;
    Ok(forecast)
}

fn run(opened: &OpenStudy, engine: &EngineArguments, registry: &Registry) -> VerbResult {
    let watch = do_runs(opened, engine, registry)?;
    let code = collect(opened)?;
    watch.interrupted().map_or(Ok(code), Err)
}

/// Runs all unfinished tasks; a signal ends them in order.
pub(super) fn do_runs(
    opened: &OpenStudy,
    engine: &EngineArguments,
    registry: &Registry,
) -> Result<Watch, Error> {
    let exec = opened.command(own_program()?, registry.cache.as_deref())?;
    if engine.retry {
        forget_failed(opened)?;
    }
    let watch = listen()?;
    let stopped = || watch.interrupted().is_some();
    for (task, why) in refused(opened, registry) {
        if task.index == 0 {
            return Err(why);
        }
        print_note(&format!("task {} will be refused: {why}", task.index));
    }
    let mut progress = StudyProgress::new(opened);
    let forecast = predict(opened, registry)?;
    let threads_each = opened.plan.file.study.threads;
    match engine.engine {
        Engine::Local => {
            let cores = threads(None) / usize::from(threads_each);
            let jobs = engine.jobs.map_or(cores, usize::from);
            pool::run(&mut progress, &exec, jobs, stopped)?;
        }
        Engine::Slurm => {
            let slurm = Slurm {
                study: opened,
                exec,
                throttle: engine.jobs,
                ask: forecast.ask(threads_each),
                extra: engine.sbatch.clone(),
                silent: Duration::from_secs(engine.silent_s),
            };
            slurm.run(&mut progress, stopped)?;
        }
    }
    Ok(watch)
}

/// Makes failed and damaged runs unfinished again; suspect runs are not failed.
fn forget_failed(opened: &OpenStudy) -> Result<(), Error> {
    for task in runs(&opened.tasks) {
        let folder = opened.task_folder(task);
        let done = matches!(folder.stage()?, TaskStage::Done(_));
        if done && !matches!(finished(&opened.folder, task), Ok(Some(_))) {
            folder.forget()?;
        }
    }
    Ok(())
}

/// Writes and prints the results. The exit code is 8 if a run is missing or damaged, or if the reference is not to be trusted.
fn collect(opened: &OpenStudy) -> VerbResult {
    let results = opened.results()?;
    let digest = Digest::new(&results);
    let write = |name: &str, text: &str| write_in(&opened.folder, name, text);
    let tables = [
        ("settings.toml", Some(opened.settings()?)),
        ("results.csv", Some(results.csv())),
        ("front.csv", digest.front_csv()),
        ("means.csv", digest.means_csv()),
    ];
    for (name, text) in tables
        .iter()
        .filter_map(|(name, text)| Some((name, text.as_ref()?)))
    {
        write(name, text)?;
    }
    if results.rows.iter().any(|row| row.exit_code.is_some()) {
        for (name, svg) in digest.pictures() {
            write(name, &svg)?;
        }
        let text = digest.text();
        write("digest.txt", &format!("{text}\n"))?;
        print(&text)?;
        // A study without a reference measures values, which serve no budget.
        if opened.plan.file.reference.is_given() {
            match StoredStudy::of(&results) {
                Ok(stored) => drop(write("study.json", &(stored.json() + "\n"))?),
                Err(why) => {
                    print(&format!("\nno study.json for `run --budget`: {why}"))?;
                }
            }
        }
        print("")?;
    }
    let code = status(opened)?;
    let fell = |row: &StudyRow| {
        row.status == DAMAGED || (row.task.role == TaskRole::Reference && !row.is_trusted())
    };
    let fell = results.rows.iter().any(fell);
    Ok(if fell { CHECK_FAILED } else { code })
}

/// Prints the number of runs in each state, and details of unfinished and failed runs; exit code 0 only if all are finished.
fn status(opened: &OpenStudy) -> VerbResult {
    let runs = runs(&opened.tasks);
    let in_slurm = opened.folder.join("slurm").exists();
    let queue = in_slurm.then(|| queue(opened, &runs).ok());
    let queue = queue.flatten().unwrap_or_default();
    let [mut waiting, mut running, mut suspect, mut failed, mut fine] = [0; 5];
    let mut lines = Vec::new();
    for task in &runs {
        let folder = opened.task_folder(task);
        let queued = queue.get(&task.index);
        let job = queued.map(|queued| format!(", {} in Slurm is {}", queued.job, queued.state));
        let (index, attempts) = (task.index, folder.attempts());
        match folder.stage()? {
            TaskStage::Done(outcome) if outcome.exit_code == 0 => fine += 1,
            TaskStage::Done(outcome) if outcome.exit_code == CHECK_FAILED => suspect += 1,
            TaskStage::Done(done) => {
                failed += 1;
                lines.push(format!("task {index} {}: {}", done.status, done.message));
            }
            TaskStage::Running => {
                running += 1;
                let (beat, job) = (folder.heartbeat(), job.unwrap_or_default());
                lines.push(format!("task {index} is run by {}{job}", beat.trim()));
            }
            TaskStage::Waiting => {
                waiting += 1;
                let last = folder.last_job().filter(|_| queued.is_none());
                let ended = last.map(|job| format!(", {job} ended as {}", ended(&job)));
                if attempts > 0 || queued.is_some() {
                    let job = job.or(ended).unwrap_or_default();
                    lines.push(format!("task {index} waits after {attempts} attempts{job}"));
                }
            }
        }
    }
    print(&format!(
        "study    {}\nfolder   {}\nruns     {} ({} rows)\ndone     {fine}\nsuspect  {suspect}\nfailed   {failed}\nrunning  {running}\nwaiting  {waiting}",
        opened.plan.file.study.name,
        opened.folder.display(),
        runs.len(),
        opened.tasks.len(),
    ))?;
    for line in lines {
        print(&line)?;
    }
    let left = waiting + running > 0;
    Ok(if left { CHECK_FAILED } else { 0 })
}

/// Runs one task and returns the exit code of its run.
fn exec(arguments: &ExecTaskArguments, registry: &Registry) -> VerbResult {
    if let Some(parent) = arguments.parent {
        end_with_parent(parent, Signal::SIGTERM).map_err(Refusal::from)?;
    }
    let (plan, folder) = arguments.place.plan()?;
    let Some(task) = plan.task(arguments.index)? else {
        let (last, index) = (plan.task_count() - 1, arguments.index);
        let problem = format!("the study has the tasks 0 to {last}, got {index}");
        return Err(Refusal::argument("--index", problem).into());
    };
    if let Some(planned) = &arguments.planned {
        let list = fs::read_to_string(planned).map_err(Error::input(planned.display()))?;
        let (index, id) = (task.index, &task.id);
        let own = format!("{index},{id},");
        if !list.lines().any(|line| line.starts_with(&own)) {
            let problem = format!(
                "has no task {index} with the id {id}: the study, the scenario or the build has changed since the plan; run the study again"
            );
            return Err(Refusal::file(planned, problem).into());
        }
    }
    let (folder, options) = (TaskFolder::new(&folder, &task.id), quiet(&plan, registry)?);
    let (message, code) = match folder.execute(&task.loaded, task.keep_logs, &options)? {
        TaskStage::Done(done) => (format!("{} {}", done.status, done.message), done.exit_code),
        TaskStage::Running => ("another process runs this task".into(), 0),
        TaskStage::Waiting => ("stopped; the task must run again".into(), CHECK_FAILED),
    };
    print(&message)?;
    Ok(code)
}
