//! `thirdbody tune`: find the cheapest setting of a scene that keeps an error, and run the scene with it.
//!
//! One numerical choice at a time is refined and coarsened; from what that changes a setting and a reference are proposed, and held against
//! each other over several seeds. What came out is a study like any other, by which `run --budget` chooses from then on.

use std::path::PathBuf;
use std::time::Instant;

use super::budget::foretold_wall_s;
use super::common::{ScenarioArguments, VerbResult, foreign, from_anywhere, print, threads};
use super::run::{EndingArguments, conclude};
use super::start::{listen, options};
use super::study::{Opened, PlaceArguments, keep_list};
use coordinator::error::{CHECK_FAILED, Error, Refusal};
use coordinator::output::tell;
use coordinator::participants::{Registry, Watch};
use coordinator::run::check::check;
use coordinator::run::session::{RunBudget, run};
use coordinator::rundir::write_whole;
use coordinator::scenario::load::Loaded;
use runs::curve::median;
use runs::files::RunFiles;
use study::budget::{Budget, SceneSettings};
use study::collect::{Results, StudyRow, finished};
use study::draft::{Draft, Refined, measures, varied};
use study::error_model::{ErrorModel, KnobErrors};
use study::knobs::{KNOBS, Knob, Knobs, Levels};
use study::measure::{Measure, Norm, ReferenceNumbers, percent};
use study::plan::{perturbed_participants, scene_id};
use study::pool;
use study::progress::StudyProgress;
use study::search::{Finding, MARGIN, Proposal, Search};
use study::stored::{StoredSetting, StoredStudy};

/// Arguments of `tune`.
#[derive(Debug, clap::Args)]
pub struct TuneArguments {
    #[command(flatten)]
    scenario: ScenarioArguments,
    /// The error to keep, relative to a finer reference with the same seed: 2% or 0.02.
    #[arg(long, value_name = "ERROR")]
    error: String,
    /// What must keep it: traction, height, friction, or signals.NAME, profile.NAME, results.NAME; all of the first three by default.
    #[arg(long = "for", value_name = "MEASURE", value_delimiter = ',')]
    measures: Vec<String>,
    /// Time for finding the setting (10min, 600s, 2h); by default that of twenty runs of the scene as it is.
    #[arg(long, value_name = "TIME")]
    within: Option<String>,
    /// Folder of the runs and of study.json; by default one below runs/. A second call goes on with what is done there.
    #[arg(long, value_name = "DIR")]
    study: Option<PathBuf>,
    /// Find and store the setting only.
    #[arg(long)]
    no_run: bool,
    /// Run directory of the run with the setting that was found. By default a new one below runs/.
    #[arg(long, conflicts_with = "no_run")]
    out: Option<PathBuf>,
    #[command(flatten)]
    ending: EndingArguments,
}

/// Time for finding a setting, in runs of the scene.
const RUNS: f64 = 20.0;
/// Seeds that a setting is measured with: with fewer than the first a bound is many times the error, with more than the second it
/// hardly shrinks.
const SEEDS: [usize; 2] = [4, 6];
/// Seeds that a setting is tried with first.
const PROBED: usize = 2;
/// Time over what is foretold that a setting may take.
const SLACK: f64 = 1.15;
/// One in so many seeds may have runs that are warned of.
const MOST_WARNED: usize = 3;
/// Settings that are tried before nothing is found.
const ROUNDS: usize = 8;
/// Part of the error that is asked for below which a choice may be coarsened.
const ROOM: f64 = 0.6;

/// Finds a setting, stores it, and runs the scene with it.
pub fn tune(arguments: &TuneArguments, registry: &Registry) -> VerbResult {
    let refuse = |key: &str| {
        let key = key.to_string();
        move |why: String| Error::from(Refusal::argument(&key, why))
    };
    let error = match Budget::parse(&format!("error={}", arguments.error)) {
        Ok(Budget::Error { error, .. }) => error,
        Ok(Budget::Wall(_)) | Err(_) => {
            let why = format!("`{}` is neither 2% nor 0.02", arguments.error);
            return Err(refuse("--error")(why));
        }
    };
    let within =
        arguments
            .within
            .as_ref()
            .map(|text| match Budget::parse(&format!("wall={text}")) {
                Ok(Budget::Wall(seconds)) => Ok(seconds),
                _ => Err(refuse("--within")(format!(
                    "`{text}` is neither 90s nor 10min nor 2h"
                ))),
            });
    let loaded = arguments.scenario.load()?;
    for warning in check(&loaded, registry, arguments.scenario.threads())? {
        tell(&warning.line());
    }
    let (measures, asked) =
        chosen_measures(&loaded, &arguments.measures).map_err(refuse("--for"))?;
    let within = within.transpose()?;
    let begun = Instant::now();
    let scene_s = foretold_wall_s(&loaded, arguments.scenario.threads(), registry)?;
    let limit_s = within.unwrap_or(RUNS * scene_s);
    tell(&format!(
        "tune: the scene takes about {scene_s:.1} s, and a setting is looked for in {limit_s:.0} s at most"
    ));
    let tuning = Tuning {
        arguments,
        registry,
        knobs: Knobs::of(&loaded),
        loaded: &loaded,
        folder: folder(arguments, &loaded)?,
        measures,
        asked,
        target: error,
        watch: listen()?,
        begun,
        scene_s,
        limit_s,
    };
    let Some(Found { study, set, .. }) = tuning.find()? else {
        return Ok(CHECK_FAILED);
    };
    let at = study.locate(&loaded.resolved).map_err(refuse("--error"))?;
    let settings = SceneSettings::new(&study, &at)?;
    let chosen = settings
        .with(&set)
        .ok_or("it was stored")
        .map_err(|why| refuse("--error")(why.into()))?;
    print(&settings.words(chosen))?;
    if arguments.no_run {
        return Ok(0);
    }
    let threads = arguments.scenario.threads();
    let mut options = options(arguments.out.as_deref(), threads, registry)?;
    options.progress = true;
    options.strict = arguments.ending.strict;
    options.budget = Some(RunBudget {
        told: settings.told(chosen, &format!("error={}", arguments.error), None),
        wall_s: None,
    });
    conclude(
        run(&arguments.scenario.with(&set)?, &options)?,
        arguments.ending,
    )
}

/// What is measured, and which of it must keep the error.
fn chosen_measures(
    loaded: &Loaded,
    named: &[String],
) -> Result<(Vec<Measure>, Vec<usize>), String> {
    let mut all = measures(loaded);
    let mut asked = Vec::new();
    for name in named {
        let known = all
            .iter()
            .position(|measure| measure.name == *name || measure.of == *name);
        let own = Measure {
            name: name.replace('.', "-"),
            of: name.clone(),
            norm: if name.starts_with("results.") {
                Norm::At
            } else {
                Norm::L2
            },
            at_s: None,
            bin_m: None,
        };
        asked.push(match known {
            Some(index) => index,
            None if own.table().is_some() => {
                all.push(own);
                all.len() - 1
            }
            None => {
                let known: Vec<&str> = all.iter().map(|measure| measure.name.as_str()).collect();
                let known = if known.is_empty() { String::new() } else { known.join(", ") + ", " };
                return Err(format!(
                    "`{name}` is not measured; for this scene there are {known}signals.NAME, profile.NAME and results.NAME"
                ));
            }
        });
    }
    if all.is_empty() {
        let why = "the scene has neither a wheel nor an interface: say what must keep the error, signals.NAME or results.NAME";
        return Err(why.into());
    }
    if asked.is_empty() {
        asked = (0..all.len()).collect();
    }
    Ok((all, asked))
}

/// The folder of the runs: scenes that differ in more than their seed have different ones.
fn folder(arguments: &TuneArguments, loaded: &Loaded) -> Result<PathBuf, Error> {
    let (name, id) = (&loaded.scenario.run.name, scene_id(loaded));
    let named = || PathBuf::from(format!("runs/tune-{name}-{id}"));
    let folder = arguments.study.clone().unwrap_or_else(named);
    std::path::absolute(&folder).map_err(Error::output(folder.display()))
}

/// A setting that is looked for.
struct Tuning<'a> {
    arguments: &'a TuneArguments,
    registry: &'a Registry,
    loaded: &'a Loaded,
    knobs: Knobs<'a>,
    folder: PathBuf,
    measures: Vec<Measure>,
    asked: Vec<usize>,
    target: f64,
    watch: Watch,
    begun: Instant,
    /// Wall-clock time of the scene by itself (s), and for finding the setting.
    scene_s: f64,
    limit_s: f64,
}

/// What the runs of single choices told.
struct Explored {
    model: ErrorModel,
    /// Floors of noise by measure.
    floors: Vec<f64>,
    /// True where another seed gives the same bits.
    seedless: bool,
    /// Wall-clock time of a run of the scene beside others (s).
    run_s: f64,
    /// Codes of what the scene as it is is warned of.
    warned: String,
}

/// A setting that keeps the error: its overrides, and the study that says so.
struct Found {
    study: StoredStudy,
    set: Vec<String>,
}

impl Tuning<'_> {
    fn find(&self) -> Result<Option<Found>, Error> {
        let explored = self.explore()?;
        print(&self.table(&explored))?;
        let mut asked = self.asked.iter();
        if let Some(m) = asked.find(|m| explored.floors[**m] > self.target) {
            let (name, floor) = (&self.measures[*m].name, percent(explored.floors[*m]));
            return self.none(&format!(
                "{name} of two runs that differ by 1e-12 of a radius lie {floor} % apart: less is no error"
            ));
        }
        let is_had = |levels: &Levels| self.knobs.set(levels).is_some();
        let mut search = Search::new(explored.model.clone(), is_had);
        let (mut best, mut seeds) = (None, None);
        for _ in 0..ROUNDS {
            let Some(wished) = search.next(false) else {
                break;
            };
            // Where there is no time for the reference that it should have, the nearest one does: what that misses itself is told.
            let mut both = std::iter::once(wished).chain(search.next(true));
            let found = both.find_map(|proposal| {
                let count = self.affordable(&explored, &proposal, seeds)?;
                Some((proposal, count))
            });
            let Some((proposal, count)) = found else {
                return self.end(best, &self.too_long(&explored, &wished));
            };
            let [own, of_reference] =
                [proposal.setting, proposal.reference].map(|l| self.knobs.words(&l));
            tell(&format!("tune: {own} against {of_reference}"));
            let all = [&search.found[..], &[proposal.setting]].concat();
            // Two seeds tell whether others are worth their time.
            let (mut finding, mut study) = (Finding::Warned, None);
            for few in [count.min(PROBED), count] {
                let first = self.loaded.scenario.run.seed;
                let few: Vec<u64> = (first..first + few as u64).collect();
                let Some(measured) = self.measure(&explored, &proposal.reference, &all, &few)?
                else {
                    return self.end(best, "the time was over before one was measured");
                };
                (finding, study) = measured;
                if !matches!(finding, Finding::Keeps(_)) {
                    break;
                }
            }
            search.learn(&proposal, &finding);
            if let (Finding::Keeps(_), Some(study)) = (finding, study) {
                seeds = Some(count);
                let set = self.knobs.set(&proposal.setting).unwrap_or_default();
                best = Some(Found { study, set });
            }
        }
        self.end(best, "none that was measured keeps it, and finer ones than two levels below the scene are not looked at")
    }

    /// Stores what was found, or says that nothing was.
    fn end(&self, best: Option<Found>, why: &str) -> Result<Option<Found>, Error> {
        let Some(found) = best else {
            return self.none(why);
        };
        let text = found.study.json() + "\n";
        write_whole(&self.folder.join("study.json"), text.as_bytes())?;
        Ok(Some(found))
    }

    /// Says that nothing was found, and what would help.
    fn none(&self, why: &str) -> Result<Option<Found>, Error> {
        if let Some(error) = self.watch.interrupted() {
            return Err(error);
        }
        let (asked, spent_s) = (percent(self.target), self.begun.elapsed().as_secs_f64());
        print(&format!(
            "no setting for an error of {asked} %: {why}. {spent_s:.0} s were spent; what is done stays in {}, and a longer --within goes on from there",
            self.folder.display()
        ))?;
        Ok(None)
    }

    /// Refines one choice at a time, with the seed of the scene; coarsens those that err by little.
    fn explore(&self) -> Result<Explored, Error> {
        // What one integration point does to elements goes with their size.
        let tuned = KNOBS.iter().filter(|knob| **knob != Knob::Element);
        let finer = tuned.filter_map(|knob| Refined::of(&self.knobs, *knob, 1.0));
        let mut all: Vec<Refined> = finer.collect();
        if all.is_empty() {
            let why = "the scene has no numerical choice that is known here (mesh, window, step, mass scale, tolerance)";
            return Err(Refusal::argument("SCENARIO", why).into());
        }
        let first = self.runs_of(&all)?;
        let second = |known: &Refined| {
            let Refined { knob, .. } = known;
            let errors = &first.model.knobs[knob.index()];
            let mut asked = self.asked.iter();
            let small = asked.all(|m| errors.error(*m, 0.0) < ROOM * self.target);
            let level = knob.second().filter(|level| *level > 0.0 || small)?;
            Refined::of(&self.knobs, *knob, level)
        };
        let more: Vec<Refined> = all.iter().filter_map(second).collect();
        all.extend(more);
        all.sort_by_key(|refined| refined.knob.index());
        self.runs_of(&all)
    }

    /// Runs the scene as it is, displaced by next to nothing, with another seed, and with each of these choices.
    fn runs_of(&self, refined: &[Refined]) -> Result<Explored, Error> {
        let own = self.loaded.scenario.run.seed;
        let another = vec![format!("run.seed={}", own + 1)];
        let mut vary = vec![("seed".to_string(), vec![((own + 1).to_string(), another)])];
        vary.extend(varied(refined));
        let draft = Draft {
            head: "One numerical choice at a time, around the scene as it is.".into(),
            reference: self.knobs.set(&[0.0; KNOBS.len()]).unwrap_or_default(),
            perturb: u64::from(!perturbed_participants(&self.loaded.scenario).is_empty()),
            vary,
            ..self.draft()
        };
        let opened = self.open("explore", &draft)?;
        self.run(&opened)?;
        let results = Results::read(&opened.plan, &opened.tasks, &self.folder)?;
        let rows = &results.rows;
        if let Some(row) = rows.iter().find(|row| row.exit_code.is_none()) {
            let why = format!(
                "the time is over before task {} of {}; what is done stays there, and a longer time goes on from there",
                row.index,
                opened.plan.path.display()
            );
            return Err(Refusal::argument("--within", why).into());
        }
        if !rows[0].is_trusted() {
            let why = format!(
                "the scene as it is ends {}: {}",
                rows[0].status, rows[0].message
            );
            return Err(Refusal::argument("SCENARIO", why).into());
        }
        let floors = rows[0].floors.iter().map(|floor| floor.unwrap_or(0.0));
        let floors: Vec<f64> = floors.collect();
        let base = finished(&self.folder, &opened.tasks[0])?.unwrap_or_default();
        for m in &self.asked {
            let measure = &self.measures[*m];
            if let Err(why) = measure.deviation(&base, ReferenceNumbers::Run(&base)) {
                let why = format!("{}: {why}; choose others with --for", measure.name);
                return Err(Refusal::argument("--for", why).into());
            }
        }
        let seed = &rows[1 + draft.perturb as usize];
        let walls = rows[..=seed.index]
            .iter()
            .filter_map(|row| row.cost.get("wall_s").copied());
        let mut ran: Vec<(&Refined, &StudyRow, RunFiles)> = Vec::new();
        for (k, refined) in refined.iter().enumerate() {
            let row = &rows[seed.index + 1 + k];
            match finished(&self.folder, &opened.tasks[row.index])? {
                Some(files) if row.is_trusted() => ran.push((refined, row, files)),
                _ => tell(&format!(
                    "tune: {} {} is left out: {} {}",
                    refined.knob.name(),
                    refined.words,
                    row.status,
                    row.message
                )),
            }
        }
        let errors = |knob: &Knob| {
            let of_knob = ran.iter().filter(|(refined, ..)| refined.knob == *knob);
            let of_knob = of_knob.map(|(refined, row, files)| (refined.level, *row, files));
            self.errors_of(of_knob.chain([(0.0, &rows[0], &base)]).collect(), &floors)
        };
        Ok(Explored {
            model: ErrorModel {
                knobs: KNOBS.iter().map(errors).collect(),
                asked: self.asked.clone(),
                target: self.target,
                shorter: 0.0,
            },
            seedless: seed.hashes == rows[0].hashes && !seed.hashes[1].is_empty(),
            run_s: median(walls.collect()).unwrap_or(0.0),
            warned: rows[0].warnings.clone(),
            floors,
        })
    }

    /// What is known of one choice, from runs at its levels.
    fn errors_of(
        &self,
        mut levels: Vec<(f64, &StudyRow, &RunFiles)>,
        floors: &[f64],
    ) -> KnobErrors {
        levels.sort_by(|a, b| a.0.total_cmp(&b.0));
        // What waits beside an idle core counts as work of the processor.
        let spent = |row: &StudyRow, name: &str| row.cost.get(name).copied().unwrap_or(1.0);
        let cost = |row: &StudyRow| spent(row, "cpu_s").min(spent(row, "wall_s"));
        let here = levels.iter().position(|level| level.0 == 0.0).unwrap_or(0);
        let whole = cost(levels[here].1);
        let costs: Vec<f64> = levels.iter().map(|(_, row, _)| cost(row) / whole).collect();
        let numbers: Vec<f64> = levels.iter().map(|level| level.0).collect();
        KnobErrors::of(&numbers, &costs, floors, |m, a, b| {
            let held = ReferenceNumbers::Run(levels[b].2);
            let found = self.measures[m].deviation(levels[a].2, held);
            found.map_or(0.0, f64::abs)
        })
    }

    /// What the single choices do, a line each.
    fn table(&self, explored: &Explored) -> String {
        let names = self
            .measures
            .iter()
            .map(|measure| format!("{:>12}", measure.name));
        let mut lines = vec![format!(
            "{:<12}{}   error of the scene as it is, by extrapolation (%)",
            "choice",
            names.collect::<String>()
        )];
        let line = |name: &str, errors: Vec<f64>| {
            let errors = errors
                .iter()
                .map(|error| format!("{:>12}", percent(*error)));
            format!("{name:<12}{}", errors.collect::<String>())
        };
        let measures = || 0..self.measures.len();
        for (knob, known) in KNOBS.iter().zip(&explored.model.knobs) {
            if known.is_known() {
                lines.push(line(
                    knob.name(),
                    measures().map(|m| known.error(m, 0.0)).collect(),
                ));
            }
        }
        let scene = [0.0; KNOBS.len()];
        lines.push(line(
            "together",
            measures()
                .map(|m| explored.model.error(m, &scene))
                .collect(),
        ));
        lines.push(line("noise", explored.floors.clone()));
        lines.join("\n")
    }

    /// Time for a seed of a setting and its reference (s), and for what is to be done without seeds or is done already.
    fn costs_s(&self, explored: &Explored, proposal: &Proposal) -> [f64; 2] {
        let run_s = explored.run_s / threads(None) as f64;
        let setting_s = run_s * proposal.cost;
        let is_scene = proposal.setting == [0.0; KNOBS.len()];
        let done_s = if is_scene {
            PROBED as f64 * setting_s
        } else {
            0.0
        };
        let last_s = if self.arguments.no_run {
            0.0
        } else {
            self.scene_s * proposal.cost
        };
        [run_s * proposal.reference_cost + setting_s, last_s - done_s]
    }

    /// Number of seeds that there is time for; `None` where there are too few.
    fn affordable(
        &self,
        explored: &Explored,
        proposal: &Proposal,
        seeds: Option<usize>,
    ) -> Option<usize> {
        let [seed_s, other_s] = self.costs_s(explored, proposal);
        let left_s = self.limit_s - self.begun.elapsed().as_secs_f64() - other_s;
        let most = (left_s / (SLACK * seed_s)).max(0.0) as usize;
        let [least, wished] = match (explored.seedless, seeds) {
            (true, _) => [1, 1],
            (false, Some(seeds)) => [seeds, seeds],
            (false, None) => SEEDS,
        };
        (most >= least).then_some(most.min(wished))
    }

    /// Says how long a proposal would take.
    fn too_long(&self, explored: &Explored, proposal: &Proposal) -> String {
        let [seed_s, other_s] = self.costs_s(explored, proposal);
        let needed_s =
            self.begun.elapsed().as_secs_f64() + SLACK * SEEDS[0] as f64 * seed_s + other_s;
        format!(
            "{} against {} would take until {needed_s:.0} s, and there are {:.0} s; --within {:.0}s has the time",
            self.knobs.words(&proposal.setting),
            self.knobs.words(&proposal.reference),
            self.limit_s,
            (SLACK * needed_s).ceil()
        )
    }

    /// Holds settings against a reference, with these seeds. What came of the last setting, and the study where it keeps the error; `None`
    /// where the time was over before.
    fn measure(
        &self,
        explored: &Explored,
        reference: &Levels,
        settings: &[Levels],
        seeds: &[u64],
    ) -> Result<Option<(Finding, Option<StoredStudy>)>, Error> {
        let case = |setting: &Levels| {
            let set = self.knobs.set(setting).unwrap_or_default();
            (self.knobs.words(setting), set)
        };
        let draft = Draft {
            head: "Settings against a finer reference, each with the same seeds.".into(),
            reference: self.knobs.set(reference).unwrap_or_default(),
            seeds: seeds.to_vec(),
            vary: vec![("setting".into(), settings.iter().map(case).collect())],
            ..self.draft()
        };
        let opened = self.open("study", &draft)?;
        self.run(&opened)?;
        let mut results = Results::read(&opened.plan, &opened.tasks, &self.folder)?;
        if let Some(row) = results.rows.iter().find(|row| row.exit_code.is_none()) {
            let done = &seeds[..row.scene];
            return match done.len() >= SEEDS[0] {
                true => self.measure(explored, reference, settings, done),
                false => Ok(None),
            };
        }
        // A run that is warned of says so itself: what is told holds for those that are not.
        let each = settings.len() + 1;
        let scenes = results.rows.chunks(each).zip(seeds);
        let is_warned = |row: &StudyRow| !row.is_trusted() || self.is_warned(explored, row);
        let warned = |k: usize| {
            results
                .rows
                .chunks(each)
                .filter(|rows| is_warned(&rows[k]))
                .count()
        };
        let many = |count: usize| count * MOST_WARNED > seeds.len();
        let good = scenes.filter(|(rows, _)| !rows.iter().any(is_warned));
        let good: Vec<u64> = good.map(|(_, seed)| *seed).collect();
        if many(warned(0)) {
            return Ok(Some((Finding::NoReference, None)));
        }
        if many(warned(each - 1)) || many(seeds.len() - good.len()) {
            return Ok(Some((Finding::Warned, None)));
        }
        if good.len() < seeds.len() {
            tell(&format!(
                "tune: of the seeds {seeds:?} those are left out with which a run is warned of: {good:?} stay"
            ));
            return self.measure(explored, reference, settings, &good);
        }
        // The noise of the scene as it is stands for that of each of its settings and seeds.
        for row in &mut results.rows {
            row.floors = explored.floors.iter().copied().map(Some).collect();
        }
        let study = StoredStudy::of(&opened.plan, &opened.tasks, &results);
        let mut study = study.map_err(|why| Refusal::file(&opened.plan.path, why))?;
        study.seedless = explored.seedless;
        for setting in &mut study.settings {
            let words = setting.words.strip_prefix("setting = ");
            setting.words = words.unwrap_or(&setting.words).to_string();
        }
        let missed = (0..self.measures.len()).map(|m| explored.model.error(m, reference));
        study.reference_misses = missed.collect();
        let Some(bounds) = self.bounds(&study, settings.last())? else {
            return Ok(Some((Finding::Warned, None)));
        };
        let told = self.asked.iter().zip(&bounds);
        let told =
            told.map(|(m, bound)| format!("{} {} %", self.measures[*m].name, percent(*bound)));
        let (told, count) = (Vec::from_iter(told).join(", "), seeds.len());
        tell(&format!("tune: with {count} seeds below {told}"));
        Ok(Some(
            match bounds.iter().all(|bound| *bound <= self.target) {
                true => (Finding::Keeps(bounds), Some(study)),
                false => (Finding::Exceeds(bounds), None),
            },
        ))
    }

    /// True where a run is warned of what the scene as it is is not.
    fn is_warned(&self, explored: &Explored, row: &StudyRow) -> bool {
        let mut codes = row.warnings.split_whitespace();
        codes.any(|code| {
            code != "advice" && !explored.warned.split_whitespace().any(|own| own == code)
        })
    }

    /// The bound of each error that counts, of few seeds what it may become; `None` where there is none.
    fn bounds(
        &self,
        study: &StoredStudy,
        setting: Option<&Levels>,
    ) -> Result<Option<Vec<f64>>, Error> {
        let at = study.locate(&self.loaded.resolved);
        let at = at.map_err(|why| Refusal::argument("SCENARIO", why))?;
        let set = setting.and_then(|setting| self.knobs.set(setting));
        let found = study
            .settings
            .iter()
            .find(|setting| Some(&setting.set) == set.as_ref());
        let bound = |setting: &StoredSetting, m: usize| match &setting.errors[m][..] {
            [one, other] => Some(MARGIN * (one * other).sqrt()),
            _ => study.predict(setting, m, &at).map(|found| found.bound),
        };
        Ok(found.and_then(|setting| self.asked.iter().map(|m| bound(setting, *m)).collect()))
    }

    /// What all studies of the scene have alike.
    fn draft(&self) -> Draft {
        let ScenarioArguments { scenario, set, .. } = &self.arguments.scenario;
        let mut set = set.clone();
        // Threads wait for each other at less cost than processes; the bits are the same.
        if foreign(&self.loaded.scenario).is_none() {
            set.push("run.transport=channel".into());
        }
        Draft {
            name: format!("tune-{}", self.loaded.scenario.run.name),
            scenario: from_anywhere(scenario),
            set,
            measures: self.measures.clone(),
            ..Draft::default()
        }
    }

    /// Writes the file of a study into the folder and plans its tasks.
    fn open(&self, name: &str, draft: &Draft) -> Result<Opened, Error> {
        let path = self.folder.join(format!("{name}.toml"));
        std::fs::create_dir_all(&self.folder).map_err(Error::output(path.display()))?;
        write_whole(&path, draft.toml().as_bytes())?;
        PlaceArguments::of(&path, &self.folder).open()
    }

    /// Does the tasks of a study that are not done, until the time is over.
    fn run(&self, opened: &Opened) -> Result<(), Error> {
        let planned = keep_list(opened)?;
        let place = PlaceArguments::of(&opened.plan.path, &self.folder);
        let exec = place.exec(opened, &planned, self.registry)?;
        let mut progress = StudyProgress::new(&opened.tasks, &self.measures, &self.folder);
        let over = || self.begun.elapsed().as_secs_f64() > self.limit_s;
        let stopped = || self.watch.interrupted().is_some() || over();
        pool::run(&mut progress, &exec, threads(None), stopped)?;
        self.watch.interrupted().map_or(Ok(()), Err)
    }
}
