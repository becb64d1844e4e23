//! The runs by which `thirdbody tune` finds a setting.

use std::path::PathBuf;
use std::time::Instant;

use super::common::{ScenarioArguments, foreign, from_anywhere, print, threads};
use super::study::{Opened, PlaceArguments, keep_list};
use coordinator::output::{tell, tell_progress};
use coordinator::participants::{Registry, Watch};
use runs::curve::median;
use runs::files::RunFiles;
use runs::run_dir::write_whole;
use scenario::error::{Error, Refusal};
use scenario::load::Loaded;
use study::collect::{Results, StudyRow, finished};
use study::draft::{Draft, Refined, varied};
use study::error_model::{ErrorModel, KnobErrors};
use study::knobs::{KNOBS, Knob, Knobs, Levels};
use study::measure::{Measure, ReferenceNumbers, named_errors, percent};
use study::plan::perturbed_participants;
use study::pool;
use study::progress::StudyProgress;
use study::search::{MARGIN, Proposal, Search, TrialOutcome};
use study::stored::StoredStudy;

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

/// A setting that is looked for.
pub(super) struct Tuning<'a> {
    /// The scene, as it was asked for and as it was read.
    pub(super) scenario: &'a ScenarioArguments,
    pub(super) loaded: &'a Loaded,
    pub(super) registry: &'a Registry,
    /// Its numerical choices.
    pub(super) knobs: Knobs<'a>,
    /// Folder of the runs.
    pub(super) folder: PathBuf,
    /// Measures that must keep the error.
    pub(super) measures: Vec<Measure>,
    /// The error.
    pub(super) target: f64,
    pub(super) watch: Watch,
    pub(super) begun: Instant,
    /// Wall-clock time for finding the setting (s).
    pub(super) limit_s: f64,
    /// Wall-clock time of the scene as it is, if a run with the setting follows (s).
    pub(super) run_s: f64,
}

/// Errors and costs that the runs of single choices told.
struct Explored {
    model: ErrorModel,
    /// Floors of noise by measure, 0 where they are not known.
    floors: Vec<f64>,
    is_noise_known: bool,
    /// True where another seed gives the same bits.
    seedless: bool,
    /// Wall-clock time of a run of the scene beside others (s).
    run_s: f64,
    /// Codes of what the scene as it is is warned of.
    warned: String,
    /// Levels of choices that do not stand, and why.
    left_out: Vec<String>,
}

/// A setting that keeps the error: its overrides, and the study that says so.
pub(super) struct Found {
    pub(super) study: StoredStudy,
    pub(super) set: Vec<String>,
}

impl Tuning<'_> {
    pub(super) fn find(&self) -> Result<Option<Found>, Error> {
        let explored = self.explore()?;
        print(&self.table(&explored))?;
        let mut noise = self.measures.iter().zip(&explored.floors);
        if let Some((measure, floor)) = noise.find(|(_, floor)| **floor > self.target) {
            let (name, floor) = (&measure.name, percent(*floor));
            let why = format!(
                "{name} of two runs that differ by 1e-12 of a radius lie {floor} % apart, and less is no error"
            );
            return self.end(None, &why);
        }
        let is_had = |levels: &Levels| self.knobs.set(levels).is_some();
        let mut search = Search::new(explored.model.clone(), is_had);
        let mut best = None;
        let mut seeds = if explored.seedless { [1, 1] } else { SEEDS };
        for _ in 0..ROUNDS {
            let Some(wished) = search.next(false) else {
                break;
            };
            let count = |proposal: &Proposal| {
                let count = self.affordable(explored.run_s, proposal, seeds);
                count.map(|count| (*proposal, count))
            };
            // Where there is no time for the reference that it should have, the nearest one does: what that misses itself is told.
            let near = || search.next(true).and_then(|near| count(&near).ok());
            let (proposal, count) = match count(&wished).or_else(|why| near().ok_or(why)) {
                Ok(found) => found,
                Err(why) => return self.end(best, &why),
            };
            let [own, of_reference] =
                [proposal.setting, proposal.reference].map(|l| self.knobs.words(&l));
            tell_progress(&format!("tune: {own} against {of_reference}"));
            let all = [&search.found[..], &[proposal.setting]].concat();
            // Two seeds tell whether others are worth their time.
            let (mut outcome, mut study) = (TrialOutcome::Warned, None);
            for few in [count.min(PROBED), count] {
                let first = self.loaded.scenario.run.seed;
                let few: Vec<u64> = (first..first + few as u64).collect();
                let Some(measured) = self.measure(&explored, &proposal.reference, &all, &few)?
                else {
                    return self.end(best, "the time was over before one was measured, and a longer --within goes on from there");
                };
                (outcome, study) = measured;
                if !matches!(outcome, TrialOutcome::Keeps(_)) {
                    break;
                }
            }
            search.learn(&proposal, &outcome);
            if let (TrialOutcome::Keeps(_), Some(study)) = (outcome, study) {
                seeds = [count, count];
                let set = self.knobs.set(&proposal.setting).unwrap_or_default();
                best = Some(Found { study, set });
                let [trial, kept] = ["trial.toml", "study.toml"].map(|name| self.folder.join(name));
                std::fs::copy(trial, &kept).map_err(Error::output(kept.display()))?;
            }
        }
        self.end(best, "none that was measured keeps it, and finer ones than two levels below the scene are not looked at")
    }

    /// Stores what was found, or says why nothing was, and what would help.
    fn end(&self, best: Option<Found>, why: &str) -> Result<Option<Found>, Error> {
        self.watch.interrupted().map_or(Ok(()), Err)?;
        if let Some(found) = &best {
            let text = found.study.json() + "\n";
            write_whole(&self.folder.join("study.json"), text.as_bytes())?;
            return Ok(best);
        }
        let (asked, spent_s) = (percent(self.target), self.begun.elapsed().as_secs_f64());
        let folder = self.folder.display();
        print(&format!(
            "no setting for an error of {asked} %: {why}. {spent_s:.0} s were spent; what is done stays in {folder}"
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
            let mut measures = first.model.measures();
            let small = measures.all(|m| errors.error(m, 0.0) < ROOM * self.target);
            let level = knob.second().filter(|level| *level > 0.0 || small)?;
            Refined::of(&self.knobs, *knob, level)
        };
        let more: Vec<Refined> = all.iter().filter_map(second).collect();
        all.extend(more);
        all.sort_by_key(|refined| refined.knob.index());
        let explored = self.runs_of(&all)?;
        for line in &explored.left_out {
            tell(&format!("tune: {line}"));
        }
        Ok(explored)
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
            let (index, path) = (row.index, opened.plan.path.display());
            let why = format!(
                "the time is over before task {index} of {path}; what is done stays there, and a longer time goes on from there"
            );
            return Err(Refusal::argument("--within", why).into());
        }
        if !rows[0].is_trusted() {
            let why = format!("as it is it ends {}: {}", rows[0].status, rows[0].message);
            return Err(Refusal::argument("SCENARIO", why).into());
        }
        let is_noise_known = rows[0].floors.iter().all(Option::is_some);
        let floors = rows[0].floors.iter().map(|floor| floor.unwrap_or(0.0));
        let floors: Vec<f64> = floors.collect();
        let base = finished(&self.folder, &opened.tasks[0])?.unwrap_or_default();
        for measure in &self.measures {
            if let Err(why) = measure.deviation(&base, ReferenceNumbers::Run(&base)) {
                let why = format!("{}: {why}; choose others with --for", measure.name);
                return Err(Refusal::argument("--for", why).into());
            }
        }
        let seed = &rows[1 + draft.perturb as usize];
        let as_it_is = rows[..=seed.index].iter();
        let walls = as_it_is.filter_map(|row| row.cost.get("wall_s").copied());
        let mut ran: Vec<(&Refined, &StudyRow, RunFiles)> = Vec::new();
        let mut left_out = Vec::new();
        for (k, refined) in refined.iter().enumerate() {
            let row = &rows[seed.index + 1 + k];
            match finished(&self.folder, &opened.tasks[row.index])? {
                Some(files) if row.is_trusted() => ran.push((refined, row, files)),
                _ => {
                    let [status, message, words] = [&row.status, &row.message, &refined.words];
                    let name = refined.knob.name();
                    left_out.push(format!("{name} {words} is left out: {status} {message}"));
                }
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
                target: self.target,
                shorter: 0.0,
            },
            seedless: seed.hashes == rows[0].hashes && !seed.hashes[1].is_empty(),
            run_s: median(walls.collect()).unwrap_or(0.0),
            warned: rows[0].warnings.clone(),
            left_out,
            floors,
            is_noise_known,
        })
    }

    /// The errors of one choice, from runs at its levels.
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

    /// The errors of the single choices, a line each.
    fn table(&self, explored: &Explored) -> String {
        let line = |name: &str, cells: Vec<String>| {
            let cells = cells.iter().map(|cell| format!("{cell:>12}"));
            format!("{name:<12}{}", cells.collect::<String>())
        };
        let numbers = |of: &dyn Fn(usize) -> f64| {
            let all = (0..self.measures.len()).map(|m| percent(of(m)));
            all.collect::<Vec<String>>()
        };
        let unknown = || vec!["not known".to_string()];
        let names = self.measures.iter().map(|measure| measure.name.clone());
        let head = line("choice", names.collect());
        let mut lines = vec![head + "   error of the scene as it is, by extrapolation (%)"];
        for (knob, known) in KNOBS.iter().zip(&explored.model.knobs) {
            if known.is_known() {
                lines.push(line(knob.name(), numbers(&|m| known.error(m, 0.0))));
            } else if self.knobs.at(*knob, 1.0).is_some() {
                lines.push(line(knob.name(), unknown()));
            }
        }
        let scene = [0.0; KNOBS.len()];
        lines.push(line(
            "together",
            numbers(&|m| explored.model.error(m, &scene)),
        ));
        let noise = explored
            .is_noise_known
            .then(|| numbers(&|m| explored.floors[m]));
        lines.push(line("noise", noise.unwrap_or_else(unknown)));
        lines.join("\n")
    }

    /// Number of seeds that there is time for, as many as are wished for at the most; how long it would take where there are too few.
    fn affordable(
        &self,
        run_s: f64,
        proposal: &Proposal,
        wished: [usize; 2],
    ) -> Result<usize, String> {
        let seed_s =
            SLACK * run_s * (proposal.reference_cost + proposal.cost) / threads(None) as f64;
        let others_s = self.begun.elapsed().as_secs_f64() + self.run_s * proposal.cost;
        let [least, most] = wished;
        let count = ((self.limit_s - others_s) / seed_s).max(0.0) as usize;
        if count >= least {
            return Ok(count.min(most));
        }
        let [own, reference] = [proposal.setting, proposal.reference].map(|l| self.knobs.words(&l));
        let needed_s = others_s + least as f64 * seed_s;
        Err(format!(
            "{own} against {reference} would take until {needed_s:.0} s, and there are {:.0} s; --within {:.0}s has the time",
            self.limit_s,
            (1.2 * needed_s).ceil()
        ))
    }

    /// Holds settings against a reference, with these seeds. Returns the outcome of the last setting, and the study where it keeps the error; `None`
    /// where the time was over before.
    fn measure(
        &self,
        explored: &Explored,
        reference: &Levels,
        settings: &[Levels],
        seeds: &[u64],
    ) -> Result<Option<(TrialOutcome, Option<StoredStudy>)>, Error> {
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
        let opened = self.open("trial", &draft)?;
        self.run(&opened)?;
        let mut results = Results::read(&opened.plan, &opened.tasks, &self.folder)?;
        if let Some(row) = results.rows.iter().find(|row| row.exit_code.is_none()) {
            let done = &seeds[..row.scene];
            if done.len() < SEEDS[0] {
                return Ok(None);
            }
            return self.measure(explored, reference, settings, done);
        }
        // A run that is warned of says so itself: what is told holds for those that are not.
        let each = settings.len() + 1;
        // The reference may be warned of what the scene as it is is, a setting of what its reference is.
        let is_bad = |rows: &[StudyRow], k: usize| {
            let known = if k == 0 {
                &explored.warned
            } else {
                &rows[0].warnings
            };
            let mut codes = rows[k].warnings.split_whitespace();
            let is_known = |code: &str| code == "advice" || known.split(' ').any(|own| own == code);
            !rows[k].is_trusted() || codes.any(|code| !is_known(code))
        };
        let many = |count: usize| count * MOST_WARNED > seeds.len();
        let scenes = || results.rows.chunks(each);
        let warned = |k: usize| scenes().filter(|rows| is_bad(rows, k)).count();
        let is_good = |rows: &[StudyRow]| !(0..each).any(|k| is_bad(rows, k));
        let good = scenes().zip(seeds).filter(|(rows, _)| is_good(rows));
        let good: Vec<u64> = good.map(|(_, seed)| *seed).collect();
        if many(warned(0)) {
            return Ok(Some((TrialOutcome::NoReference, None)));
        }
        if many(warned(each - 1)) || many(seeds.len() - good.len()) {
            return Ok(Some((TrialOutcome::Warned, None)));
        }
        if good.len() < seeds.len() {
            // So few tell no bound: others take their places, until the time is over.
            let least = if seeds.len() > PROBED { SEEDS[0] } else { 0 };
            let others = (1..).map(|k| seeds[seeds.len() - 1] + k);
            let others = others.take(least.saturating_sub(good.len()));
            let kept: Vec<u64> = good.into_iter().chain(others).collect();
            tell(&format!(
                "tune: with some of the seeds {seeds:?} a run is warned of: {kept:?} are taken"
            ));
            return self.measure(explored, reference, settings, &kept);
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
        let Some(bounds) = self.bounds(&study, settings.last()) else {
            return Ok(Some((TrialOutcome::Warned, None)));
        };
        let (told, count) = (named_errors(&self.measures, &bounds), seeds.len());
        tell_progress(&format!("tune: with {count} seeds below {told}"));
        if bounds.iter().any(|bound| *bound > self.target) {
            return Ok(Some((TrialOutcome::Exceeds(bounds), None)));
        }
        Ok(Some((TrialOutcome::Keeps(bounds), Some(study))))
    }

    /// The bound of each error, of few seeds what it may become; `None` where there is none.
    fn bounds(&self, study: &StoredStudy, setting: Option<&Levels>) -> Option<Vec<f64>> {
        let set = self.knobs.set(setting?)?;
        let setting = study.settings.iter().find(|setting| setting.set == set)?;
        // Scenes differ in nothing but their seeds.
        let bound = |m: usize| match &setting.errors[m][..] {
            [one, other] => Some(MARGIN * (one * other).sqrt()),
            _ => study.predict(setting, m, &[]).map(|found| found.bound),
        };
        (0..self.measures.len()).map(bound).collect()
    }

    /// The keys that all studies of the scene have alike.
    fn draft(&self) -> Draft {
        let ScenarioArguments { scenario, set, .. } = self.scenario;
        let mut set = set.clone();
        // Threads wait for each other at less cost than processes; the bits are the same.
        if foreign(&self.loaded.scenario).is_none() {
            set.push("run.transport=channel".into());
        }
        Draft {
            name: format!("tune-{}", self.loaded.scenario.run.name),
            scenario: from_anywhere(scenario, self.loaded),
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
        PlaceArguments::of(&path, Some(&self.folder)).open()
    }

    /// Does the tasks of a study that are not done, until the time is over.
    fn run(&self, opened: &Opened) -> Result<(), Error> {
        let planned = keep_list(opened)?;
        let place = PlaceArguments::of(&opened.plan.path, Some(&self.folder));
        let exec = place.exec(opened, &planned, self.registry)?;
        let mut progress = StudyProgress::new(&opened.tasks, &self.measures, &self.folder);
        let over = || self.begun.elapsed().as_secs_f64() > self.limit_s;
        let stopped = || self.watch.interrupted().is_some() || over();
        pool::run(&mut progress, &exec, threads(None), stopped)?;
        self.watch.interrupted().map_or(Ok(()), Err)
    }
}
