//! The runs with which `thirdbody tune` finds a setting.
//!
//! First runs refine and coarsen one numerical choice at a time. From their differences, the search proposes a setting and a reference,
//! which are compared over several seeds. The result is an ordinary study, from which `run --budget` can choose.

use std::path::PathBuf;
use std::time::Instant;

use super::collect::{StudyRow, finished};
use super::draft::{Draft, cases};
use super::error_model::{ErrorModel, KnobErrors};
use super::knobs::{KNOBS, Knob, Knobs, Levels};
use super::measure::{Measure, ReferenceNumbers, named_errors, percent};
use super::open_study::{OpenStudy, write_in};
use super::plan::{Plan, perturbed_participants};
use super::pool;
use super::progress::StudyProgress;
use super::search::{MARGIN, Proposal, Search, TrialOutcome};
use super::stored::StoredStudy;
use coordinator::participants::Watch;
use runs::curve::median;
use runs::files::RunFiles;
use scenario::error::{Error, Refusal};
use scenario::load::Loaded;
use terminal::{print_note, tell_progress};

/// Smallest and largest number of seeds of a setting: with fewer a bound is many times the error, with more it hardly shrinks.
const SEEDS: [usize; 2] = [4, 6];
/// Number of seeds of the first trial of a setting.
const PROBED: usize = 2;
/// Ratio of the time that a setting may take to the predicted time.
const SLACK: f64 = 1.15;
/// One in this many seeds may have runs with warnings.
const MOST_WARNED: usize = 3;
/// Largest number of settings to try.
const ROUNDS: usize = 8;
/// A choice that errs by less than this part of the target may be coarsened.
const ROOM: f64 = 0.6;

/// A search for a setting.
pub struct Tuning<'a> {
    /// The scene.
    pub loaded: &'a Loaded,
    /// The scene as a study names it.
    pub scenario: String,
    /// Overrides of all runs.
    pub set: Vec<String>,
    /// Its numerical choices.
    pub knobs: Knobs<'a>,
    /// Folder of the runs.
    pub folder: PathBuf,
    /// Measures that must keep the error.
    pub measures: Vec<Measure>,
    /// Target error.
    pub target: f64,
    /// Signals that end the search.
    pub watch: Watch,
    /// Beginning of the search.
    pub begun: Instant,
    /// Wall-clock time for finding the setting (s).
    pub limit_s: f64,
    /// Wall-clock time of the unchanged scene, if a run with the setting follows (s).
    pub run_s: f64,
    /// This program, which runs the tasks.
    pub program: PathBuf,
    /// Folder of prepared samples.
    pub cache: Option<PathBuf>,
    /// Runs at a time.
    pub jobs: usize,
}

/// Errors and costs from the runs of single choices.
#[derive(Clone, Debug)]
pub struct Explored {
    model: ErrorModel,
    /// Floors of noise by measure, if known.
    floors: Vec<Option<f64>>,
    /// True if another seed gives the same bits.
    seedless: bool,
    /// Wall-clock time of a run of the scene in parallel with others (s).
    run_s: f64,
    /// Codes of the warnings of the unchanged scene.
    warned: String,
    /// Levels of choices that are left out, and why.
    left_out: Vec<String>,
}

/// A setting that keeps the error, and the study that shows it.
#[derive(Clone, Debug)]
pub struct Found {
    /// The study.
    pub study: StoredStudy,
    /// Overrides of the setting.
    pub set: Vec<String>,
}

impl Tuning<'_> {
    /// Finds and stores a setting; or says why no setting keeps the error, and what would help.
    ///
    /// # Errors
    /// A run cannot be started, its files cannot be read or written, or a signal came.
    pub fn find(&self, explored: &Explored) -> Result<Result<Found, String>, Error> {
        let mut best = None;
        let why = self.search(explored, &mut best)?;
        self.watch.interrupted().map_or(Ok(()), Err)?;
        if let Some(found) = best {
            write_in(&self.folder, "study.json", &(found.study.json() + "\n"))?;
            return Ok(Ok(found));
        }
        let (asked, spent_s) = (percent(self.target), self.begun.elapsed().as_secs_f64());
        let folder = self.folder.display();
        Ok(Err(format!(
            "no setting for an error of {asked} %: {why}. {spent_s:.0} s were spent; finished runs stay in {folder}"
        )))
    }

    /// Measures settings, each cheaper than the best one so far; returns the reason why it stops.
    fn search(&self, explored: &Explored, best: &mut Option<Found>) -> Result<String, Error> {
        let mut noise = self.measures.iter().zip(&explored.floors);
        if let Some((measure, floor)) = noise.find(|(_, floor)| **floor > Some(self.target)) {
            let (name, floor) = (&measure.name, percent(floor.unwrap_or(0.0)));
            return Ok(format!(
                "the floor of noise of {name} is {floor} %, the distance of two runs that differ by 1e-12 of a radius"
            ));
        }
        let is_had = |levels: &Levels| self.knobs.set(levels).is_some();
        let mut search = Search::new(explored.model.clone(), is_had);
        let mut seeds = if explored.seedless { [1, 1] } else { SEEDS };
        for _ in 0..ROUNDS {
            let Some(wished) = search.next(false) else {
                break;
            };
            let afford = |proposal: Proposal| self.affordable(explored.run_s, proposal, seeds);
            // Without time for the wanted reference, the nearest one is used; its own error is reported.
            let near = || search.next(true).and_then(|near| afford(near).ok());
            let (proposal, count) = match afford(wished).or_else(|why| near().ok_or(why)) {
                Ok(found) => found,
                Err(why) => return Ok(why),
            };
            tell_progress(&format!("tune: {}", self.words(&proposal)));
            let all = [&search.found[..], &[proposal.setting]].concat();
            // Two seeds show whether more are worth their time.
            let (mut outcome, mut study) = (TrialOutcome::Warned, None);
            for few in [count.min(PROBED), count] {
                let first = self.loaded.scenario.run.seed;
                let few: Vec<u64> = (first..first + few as u64).collect();
                let measured = self.measure(explored, &proposal.reference, &all, &few)?;
                let Some(measured) = measured else {
                    return Ok("the time ended before a setting was measured; a longer --within continues from there".into());
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
                *best = Some(Found { study, set });
                let [trial, kept] = ["trial.toml", "study.toml"].map(|name| self.folder.join(name));
                std::fs::copy(trial, &kept).map_err(Error::output(kept.display()))?;
            }
        }
        Ok("no measured setting keeps it, and settings finer than the scene by more than two levels are not tried".into())
    }

    /// Refines one choice at a time, with the seed of the scene; coarsens choices with small errors.
    ///
    /// # Errors
    /// The scene has no such choice, does not complete, or lacks a measure; or the time has ended.
    pub fn explore(&self) -> Result<Explored, Error> {
        let known = |knob: Knob, level: &f64| !cases(&self.knobs, knob, &[*level]).is_empty();
        // The error of one integration point shrinks with the size of the elements.
        let finer = |knob| Some(1.0).filter(|finer| knob != Knob::Element && known(knob, finer));
        // Nothing is finer than all elements.
        let coarser =
            |knob| Some(-1.0).filter(|coarser| knob == Knob::Modes && known(knob, coarser));
        let mut levels = KNOBS.map(|knob| Vec::from_iter(finer(knob).or_else(|| coarser(knob))));
        if levels.iter().all(Vec::is_empty) {
            let why = "the scene has no numerical choice to tune (mesh, window, step, mass scale, tolerance, modes)";
            return Err(Refusal::argument("SCENARIO", why).into());
        }
        let model = self.runs_of(&levels)?.model;
        for (knob, levels) in KNOBS.iter().zip(&mut levels) {
            let errs = |m: usize| model.knobs[knob.index()].error(m, 0.0);
            let is_small = model.measures().all(|m| errs(m) < ROOM * self.target);
            let second = knob.second().filter(|level| *level > 0.0 || is_small);
            // Grains that are only slightly heavier than real ones have a single lighter level.
            let own = |level: f64| self.knobs.value(*knob, &knob.alone(level));
            let is_other = |level: &f64| known(*knob, level) && own(*level) != own(1.0);
            let is_new = |level: &f64| !levels.is_empty() && !levels.contains(level);
            let second = second.filter(|level| is_new(level) && is_other(level));
            levels.extend(second);
        }
        let explored = self.runs_of(&levels)?;
        for line in &explored.left_out {
            print_note(&format!("tune: {line}"));
        }
        Ok(explored)
    }

    /// Runs the unchanged scene, the scene with tiny displacements, with another seed, and with each choice at these levels.
    fn runs_of(&self, levels: &[Vec<f64>; KNOBS.len()]) -> Result<Explored, Error> {
        let another = (self.loaded.scenario.run.seed + 1).to_string();
        let set = vec![format!("run.seed={another}")];
        let mut vary = vec![("seed".to_string(), vec![(another, set)])];
        let of_knobs = KNOBS.iter().zip(levels).map(|(knob, levels)| {
            let cases = cases(&self.knobs, *knob, levels);
            (knob.name().to_string(), cases)
        });
        vary.extend(of_knobs.filter(|(_, cases)| !cases.is_empty()));
        let draft = Draft {
            head: "One numerical choice at a time, around the unchanged scene.".into(),
            reference: self.knobs.set(&[0.0; KNOBS.len()]).unwrap_or_default(),
            perturb: u64::from(!perturbed_participants(&self.loaded.scenario).is_empty()),
            vary,
            ..self.draft()
        };
        let seed = 1 + draft.perturb as usize;
        let study = self.run("explore", &draft)?;
        let results = study.results()?;
        let rows = &results.rows;
        if let Some(row) = rows.iter().find(|row| row.exit_code.is_none()) {
            let (index, path) = (row.task.index, study.plan.path.display());
            let why = format!(
                "the time ended before task {index} of {path}; finished runs stay there, and a longer time continues from them"
            );
            return Err(Refusal::argument("--within", why).into());
        }
        if !rows[0].is_trusted() {
            let (status, message) = (&rows[0].status, &rows[0].message);
            let why = format!("the unchanged scene ends {status}: {message}");
            return Err(Refusal::argument("SCENARIO", why).into());
        }
        let floors = rows[0].floors.iter().map(|floor| floor.unwrap_or(0.0));
        let floors: Vec<f64> = floors.collect();
        let base = finished(&self.folder, rows[0].task)?.unwrap_or_default();
        for measure in &self.measures {
            if let Err(why) = measure.deviation(&base, ReferenceNumbers::Run(&base)) {
                let why = format!("{}: {why}; choose others with --for", measure.name);
                return Err(Refusal::argument("--for", why).into());
            }
        }
        let (as_it_is, others) = rows.split_at(seed + 1);
        let costs = as_it_is.iter().map(|row| &row.cost);
        let walls = costs.filter_map(|cost| cost.get("wall_s").copied());
        let mut others = others.iter();
        let (mut knobs, mut left_out) = (Vec::new(), Vec::new());
        for (knob, levels) in KNOBS.iter().zip(levels) {
            let mut ran = Vec::new();
            for (level, row) in levels.iter().zip(&mut others) {
                match finished(&self.folder, row.task)? {
                    Some(files) if row.is_trusted() => ran.push((*level, row, files)),
                    _ => {
                        let words = self.knobs.value(*knob, &knob.alone(*level));
                        let (name, words) = (knob.name(), words.unwrap_or_default());
                        let (status, message) = (&row.status, &row.message);
                        left_out.push(format!("{name} {words} is left out: {status} {message}"));
                    }
                }
            }
            let ran = ran.iter().map(|(level, row, files)| (*level, *row, files));
            let ran = ran.chain([(0.0, &rows[0], &base)]).collect();
            let errors = self.errors_of(ran, &floors);
            let is_exact = *knob == Knob::Modes && self.knobs.at(*knob, 1.0).is_none();
            knobs.push(if is_exact {
                errors.below_exact()
            } else {
                errors
            });
        }
        Ok(Explored {
            model: ErrorModel {
                knobs,
                target: self.target,
                shorter: 0.0,
            },
            seedless: rows[seed].hashes == rows[0].hashes && !rows[0].hashes[1].is_empty(),
            run_s: median(walls.collect()).unwrap_or(0.0),
            warned: rows[0].warnings.clone(),
            left_out,
            floors: rows[0].floors.clone(),
        })
    }

    /// The errors of one choice, from runs at its levels.
    fn errors_of(
        &self,
        mut levels: Vec<(f64, &StudyRow, &RunFiles)>,
        floors: &[f64],
    ) -> KnobErrors {
        levels.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Waiting next to an idle core counts as processor time, hence the smaller of both times.
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

    /// The errors of the single choices, one per line.
    pub fn table(&self, explored: &Explored) -> String {
        let line = |name: &str, cells: Vec<String>| {
            let cells = cells.iter().map(|cell| format!("{cell:>12}"));
            format!("{name:<12}{}", cells.collect::<String>())
        };
        let numbers = |of: &dyn Fn(usize) -> f64| {
            let all = explored.model.measures().map(|m| percent(of(m)));
            all.collect::<Vec<String>>()
        };
        let unknown = || vec!["unknown".to_string()];
        let names = self.measures.iter().map(|measure| measure.name.clone());
        let head = line("choice", names.collect());
        let mut lines = vec![head + "   error of the unchanged scene, by extrapolation (%)"];
        for (knob, known) in KNOBS.iter().zip(&explored.model.knobs) {
            if known.is_known() {
                lines.push(line(knob.name(), numbers(&|m| known.error(m, 0.0))));
            } else if self.knobs.at(*knob, 1.0).is_some() {
                lines.push(line(knob.name(), unknown()));
            }
        }
        let together = numbers(&|m| explored.model.error(m, &[0.0; KNOBS.len()]));
        let floors: Option<Vec<f64>> = explored.floors.iter().copied().collect();
        let noise = floors.map_or_else(unknown, |floors| numbers(&|m| floors[m]));
        lines.extend([line("together", together), line("noise", noise)]);
        lines.join("\n")
    }

    /// A proposal with the number of seeds that the time allows, at most `most`; or the time that it would need.
    fn affordable(
        &self,
        run_s: f64,
        proposal: Proposal,
        [least, most]: [usize; 2],
    ) -> Result<(Proposal, usize), String> {
        let seed_s = SLACK * run_s * (proposal.reference_cost + proposal.cost) / self.jobs as f64;
        let others_s = self.begun.elapsed().as_secs_f64() + self.run_s * proposal.cost;
        let count = ((self.limit_s - others_s) / seed_s).max(0.0) as usize;
        if count >= least {
            return Ok((proposal, count.min(most)));
        }
        let needed_s = others_s + least as f64 * seed_s;
        Err(format!(
            "{} would take until {needed_s:.0} s, and the limit is {:.0} s; --within {:.0}s allows it",
            self.words(&proposal),
            self.limit_s,
            (1.2 * needed_s).ceil()
        ))
    }

    /// A proposal in words.
    fn words(&self, proposal: &Proposal) -> String {
        let both = [proposal.setting, proposal.reference];
        both.map(|levels| self.knobs.words(&levels))
            .join(" against ")
    }

    /// Compares settings with a reference, with these seeds. Returns the outcome of the last setting, and the study if it keeps the error;
    /// `None` if the time ended before.
    fn measure(
        &self,
        explored: &Explored,
        reference: &Levels,
        settings: &[Levels],
        seeds: &[u64],
    ) -> Result<Option<(TrialOutcome, Option<StoredStudy>)>, Error> {
        let without_study = |outcome: TrialOutcome| Ok(Some((outcome, None)));
        let case = |(k, setting): (usize, &Levels)| {
            let set = self.knobs.set(setting).unwrap_or_default();
            let words = self.knobs.words(setting);
            // Levels may differ by less than the digits in the words.
            let is_same = |other: &Levels| self.knobs.words(other) == words;
            let number = settings[..k].iter().any(is_same).then(|| format!(" ({k})"));
            (words + &number.unwrap_or_default(), set)
        };
        let cases = settings.iter().enumerate().map(case);
        let draft = Draft {
            head: "Settings against a finer reference, each with the same seeds.".into(),
            reference: self.knobs.set(reference).unwrap_or_default(),
            seeds: seeds.to_vec(),
            vary: vec![("setting".into(), cases.collect())],
            ..self.draft()
        };
        let study = self.run("trial", &draft)?;
        let mut results = study.results()?;
        if let Some(row) = results.rows.iter().find(|row| row.exit_code.is_none()) {
            let done = &seeds[..row.task.scene];
            if done.len() < SEEDS[0] {
                return Ok(None);
            }
            return self.measure(explored, reference, settings, done);
        }
        // A run with warnings reports them itself; the study covers only runs without warnings.
        let each = settings.len() + 1;
        // The reference may have the warnings of the unchanged scene, and a setting the warnings of its reference.
        let is_bad = |rows: &[StudyRow], k: usize| {
            let reference = if k == 0 {
                &explored.warned
            } else {
                &rows[0].warnings
            };
            let known =
                |code: &str| code == "advice" || reference.split(' ').any(|own| own == code);
            !rows[k].is_trusted() || !rows[k].warnings.split_whitespace().all(known)
        };
        let many = |count: usize| count * MOST_WARNED > seeds.len();
        let scenes = || results.rows.chunks(each);
        let warned = |k: usize| scenes().filter(|rows| is_bad(rows, k)).count();
        let is_good = |rows: &[StudyRow]| !(0..each).any(|k| is_bad(rows, k));
        let good = scenes().zip(seeds).filter(|(rows, _)| is_good(rows));
        let good: Vec<u64> = good.map(|(_, seed)| *seed).collect();
        if many(warned(0)) {
            return without_study(TrialOutcome::NoReference);
        }
        if many(warned(each - 1)) || many(seeds.len() - good.len()) {
            return without_study(TrialOutcome::Warned);
        }
        if good.len() < seeds.len() {
            // The remaining seeds are too few for a bound: others replace them, until the time ends.
            let least = if seeds.len() > PROBED { SEEDS[0] } else { 0 };
            let others = (1..).map(|k| seeds[seeds.len() - 1] + k);
            let others = others.take(least.saturating_sub(good.len()));
            let kept: Vec<u64> = good.into_iter().chain(others).collect();
            print_note(&format!(
                "tune: some of the seeds {seeds:?} have runs with warnings: using {kept:?}"
            ));
            return self.measure(explored, reference, settings, &kept);
        }
        // The noise of the unchanged scene represents all its settings and seeds.
        for row in &mut results.rows {
            let floors = explored.floors.iter();
            row.floors = floors.map(|floor| floor.or(Some(0.0))).collect();
        }
        let stored = StoredStudy::of(&results);
        let mut stored = stored.map_err(|why| Refusal::file(&study.plan.path, why))?;
        stored.seedless = explored.seedless;
        for setting in &mut stored.settings {
            let words = setting.words.strip_prefix("setting = ");
            setting.words = words.unwrap_or(&setting.words).to_string();
        }
        let measures = explored.model.measures();
        let missed = measures.map(|m| explored.model.error(m, reference));
        stored.reference_misses = missed.collect();
        let Some(bounds) = self.bounds(&stored, settings.last()) else {
            return without_study(TrialOutcome::Warned);
        };
        let (errors, count) = (named_errors(&self.measures, &bounds), seeds.len());
        tell_progress(&format!("tune: with {count} seeds, errors below {errors}"));
        if bounds.iter().any(|bound| *bound > self.target) {
            return without_study(TrialOutcome::Exceeds(bounds));
        }
        Ok(Some((TrialOutcome::Keeps(bounds), Some(stored))))
    }

    /// The bound of each error, an estimate with few seeds; `None` if a bound is missing.
    fn bounds(&self, study: &StoredStudy, setting: Option<&Levels>) -> Option<Vec<f64>> {
        let set = self.knobs.set(setting?)?;
        let setting = study.settings.iter().find(|setting| setting.set == set)?;
        // Scenes differ only in their seeds.
        let bound = |m: usize| match &setting.errors[m][..] {
            [one, other] => Some(MARGIN * (one * other).sqrt()),
            _ => study.predict(setting, m, &[]).map(|found| found.bound),
        };
        (0..self.measures.len()).map(bound).collect()
    }

    /// The keys that all studies of the scene share.
    fn draft(&self) -> Draft {
        Draft {
            name: format!("tune-{}", self.loaded.scenario.run.name),
            scenario: self.scenario.clone(),
            set: self.set.clone(),
            measures: self.measures.clone(),
            ..Draft::default()
        }
    }

    /// Writes the file of a study into the folder and runs its unfinished tasks until the time ends.
    fn run(&self, name: &str, draft: &Draft) -> Result<OpenStudy, Error> {
        let file = write_in(&self.folder, &format!("{name}.toml"), &draft.toml())?;
        let plan = Plan::read(&file, false, &[])?;
        let study = OpenStudy::of(plan, self.folder.clone())?;
        let command = study.command(self.program.clone(), self.cache.as_deref())?;
        let mut progress = StudyProgress::new(&study);
        let over = || self.begun.elapsed().as_secs_f64() > self.limit_s;
        let stopped = || self.watch.interrupted().is_some() || over();
        pool::run(&mut progress, &command, self.jobs, stopped)?;
        self.watch.interrupted().map_or(Ok(study), Err)
    }
}
