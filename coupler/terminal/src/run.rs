//! Events of a run: a block that is redrawn on a terminal, an occasional line elsewhere, objects for a program.

use std::sync::{Mutex, PoisonError};

use coordinator::events::{Listener, RunEvent, RunProgress};
use coordinator::summary::known;
use serde_json::{Map, Value, json};

use crate::stderr::{StderrMode, columns, draw, leave, print_event, stderr_mode};

/// A line is printed after each tenth of a run, and at the latest [`LINE_EVERY_S`] after the line before.
const PARTS: f64 = 10.0;
/// Longest time between two lines (s).
pub(crate) const LINE_EVERY_S: f64 = 60.0;

/// Time between two objects (s).
pub(crate) const OBJECT_EVERY_S: f64 = 1.0;

/// A listener that prints the events of runs on stderr, one run after the other.
pub fn listener() -> Listener {
    let shown: Mutex<Option<Shown>> = Mutex::default();
    Listener::new(move |event| {
        let mut shown = shown.lock().unwrap_or_else(PoisonError::into_inner);
        match event {
            RunEvent::Prepare { run, participants } => {
                *shown = None;
                prepare(run, participants);
            }
            RunEvent::Prepares {
                participant,
                waited_s,
                limit_s,
            } => prepares(participant, *waited_s, *limit_s),
            RunEvent::Warning(warning) => {
                let object = serde_json::to_value(warning).unwrap_or_default();
                print_event("warning", object, || warning.line());
            }
            RunEvent::Progress(run_progress) => show(&mut shown, run_progress),
            RunEvent::Ended => leave(),
        }
    })
}

/// State of a run when its progress was last shown.
#[derive(Clone, Copy)]
struct Shown {
    /// Wall-clock time spent (s).
    spent_s: f64,
    /// Tenths of the run done.
    parts: u64,
}

/// Shows the progress of a run, if an update is due.
fn show(shown: &mut Option<Shown>, run_progress: &RunProgress) {
    let parts = |t_s: f64| (PARTS * t_s / run_progress.end_s + 1e-9) as u64;
    let words = Words(run_progress);
    let last = shown.unwrap_or(Shown {
        spent_s: 0.0,
        parts: parts(run_progress.from_s),
    });
    let now = Shown {
        spent_s: run_progress.spent_s,
        parts: parts(run_progress.t_s),
    };
    let since_s = now.spent_s - last.spent_s;
    let over = run_progress.t_s >= run_progress.end_s * (1.0 - 1e-9);
    match (stderr_mode(), columns()) {
        (StderrMode::Quiet, _) => return,
        (StderrMode::JsonLines, _) if since_s < OBJECT_EVERY_S && !over => return,
        (StderrMode::JsonLines, _) => print_event("progress", words.object(), String::new),
        (_, Some(columns)) => draw(&words.block(), columns),
        _ if now.parts == last.parts && since_s < LINE_EVERY_S => return,
        _ => print_event("progress", Value::Null, || words.line()),
    }
    *shown = Some(now);
}

/// Shows that the participants of a run prepare, which may take long.
fn prepare(run: &str, participants: &[&str]) {
    let object = json!({ "run": run, "participants": participants });
    let line = format!("{run}: {} prepare", participants.join(", "));
    match (stderr_mode(), columns()) {
        (StderrMode::JsonLines, _) => print_event("prepare", object, String::new),
        (StderrMode::Progress, Some(columns)) => draw(&[line], columns),
        _ => {}
    }
}

/// Time after which a line reports a set-up that still runs (s); the next lines follow whenever the time has doubled.
const SETUP_LINE_S: f64 = 10.0;

/// Shows how long the set-up of a participant has run: `before` at the last call, `now` at this one (s). `limit_s` is its deadline.
fn prepares(participant: &str, [before, now]: [f64; 2], limit_s: f64) {
    let object = json!({ "participant": participant, "waited_s": now, "limit_s": limit_s });
    let line = format!(
        "{participant} prepares: {now:.0} s so far; run.deadlines.setup_s allows {limit_s} s"
    );
    let next_second = now.floor() > before.floor();
    match (stderr_mode(), columns()) {
        (StderrMode::Quiet, _) => {}
        (StderrMode::JsonLines, _) if next_second => print_event("prepares", object, String::new),
        (StderrMode::Progress, Some(columns)) if next_second => draw(&[line], columns),
        (StderrMode::Progress, None) if doubles([before, now]) => {
            print_event("prepares", object, || line)
        }
        _ => {}
    }
}

/// True if a wait passes 10, 20, 40, .. s.
fn doubles(times: [f64; 2]) -> bool {
    let [before, now] = times.map(|s| (s / SETUP_LINE_S).log2().floor());
    now >= 0.0 && now > before
}

/// Characters of the bar.
const BAR: usize = 20;

/// Progress of a run, in words.
struct Words<'a>(&'a RunProgress);

impl Words<'_> {
    fn done(&self) -> f64 {
        (self.0.t_s / self.0.end_s).clamp(0.0, 1.0)
    }

    /// Share of the time in which the coordinator did not wait.
    fn own(&self) -> f64 {
        let waited: f64 = self.0.waited.iter().map(|(_, share)| share).sum();
        (1.0 - waited).max(0.0)
    }

    /// Lines for a terminal.
    fn block(&self) -> Vec<String> {
        let bar = bar(self.done());
        let [percent, clock] = [self.percent(), self.clock()];
        let mut lines = vec![
            format!("{} [{bar}] {percent}  {clock}", self.0.run),
            format!("  {}", self.position().join("   ")),
        ];
        let judged = self.judged();
        if !judged.is_empty() {
            lines.push(format!("  {}", judged.join("   ")));
        }
        lines.push(format!("  time: {}", self.shares()));
        lines
    }

    /// The same words in one line.
    fn line(&self) -> String {
        let words = [vec![self.percent()], self.position(), self.judged()].concat();
        let [words, shares, clock] = [words.join(", "), self.shares(), self.clock()];
        format!("{}: {words}; time: {shares}; {clock}", self.0.run)
    }

    fn percent(&self) -> String {
        format!("{:.0} %", (100.0 * self.done()).floor())
    }

    fn clock(&self) -> String {
        let left = |left_s| format!(", {} left", lasting(left_s));
        lasting(self.0.spent_s) + " spent" + &self.0.left_s.map(left).unwrap_or_default()
    }

    fn position(&self) -> Vec<String> {
        let mut words = Vec::new();
        if let Some((name, part)) = &self.0.phase {
            words.push(format!("{name} ({:.0} %)", (100.0 * part).floor()));
        }
        let [t_ms, end_ms] = [1e3 * self.0.t_s, 1e3 * self.0.end_s];
        words.push(format!("t = {t_ms:.3} of {end_ms:.3} ms"));
        words.push(format!("window {} of {}", self.0.window, self.0.windows));
        words
    }

    fn judged(&self) -> Vec<String> {
        let (of, defect) = (self.0, self.0.energy_defect_rel);
        let known = [
            of.repeats
                .map(|(last, mean)| format!("repeats {last}, mean {mean:.2}")),
            of.sn_pct.map(|sn| format!("Sn {sn:.0} %")),
            of.traction_ratio.map(|ratio| format!("F_T/F_N {ratio:.3}")),
            defect.map(|defect| format!("energy defect {defect:.1e}")),
        ];
        known.into_iter().flatten().collect()
    }

    fn shares(&self) -> String {
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        let waited = self.0.waited.iter();
        let waited = waited.map(|(name, share)| format!("{name} {}", percent(*share)));
        let waited = waited.collect::<Vec<_>>().join(", ");
        format!("waits for {waited}; own work {}", percent(self.own()))
    }

    /// An object for programs, with units in its keys; unknown values are left out.
    fn object(&self) -> Value {
        let waited = self.0.waited.iter();
        let waited = waited.map(|(name, share)| (name.clone(), json!(share)));
        let (phase, part) = self.0.phase.clone().unzip();
        let (last, mean) = self.0.repeats.unzip();
        let object = json!({
            "run": self.0.run,
            "done_rel": self.done(),
            "t_s": self.0.t_s,
            "end_s": self.0.end_s,
            "window": self.0.window,
            "windows": self.0.windows,
            "waited_rel": waited.collect::<Map<String, Value>>(),
            "own_rel": self.own(),
            "spent_wall_s": self.0.spent_s,
            "phase": phase,
            "phase_done_rel": part,
            "repeats": last,
            "repeats_mean": mean,
            "sn_pct": self.0.sn_pct,
            "traction_ratio": self.0.traction_ratio,
            "energy_defect_rel": self.0.energy_defect_rel,
            "left_wall_s": self.0.left_s,
        });
        known(object).into()
    }
}

/// A bar that is filled to this share.
pub(crate) fn bar(share: f64) -> String {
    let done = (BAR as f64 * share.clamp(0.0, 1.0)) as usize;
    "#".repeat(done) + &"-".repeat(BAR - done)
}

/// A time in a unit that suits its length.
pub(crate) fn lasting(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 100.0 => format!("{s:.0} s"),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stderr::cut;

    fn run_progress() -> RunProgress {
        RunProgress {
            run: "quick".into(),
            phase: Some(("hold".into(), 0.425)),
            from_s: 0.0,
            t_s: 0.67e-3,
            end_s: 1.733e-3,
            window: 1095,
            windows: 2833,
            repeats: Some((1, 0.013)),
            sn_pct: None,
            traction_ratio: Some(-0.0312),
            energy_defect_rel: Some(3.21e-5),
            waited: vec![("rail".into(), 0.41), ("third-body".into(), 0.32)],
            spent_s: 1.25,
            left_s: Some(131.0),
        }
    }

    #[test]
    fn a_block_has_lines_for_progress_position_judgement_and_time() {
        let expected = [
            "quick [#######-------------] 38 %  1.2 s spent, 2 min left",
            "  hold (42 %)   t = 0.670 of 1.733 ms   window 1095 of 2833",
            "  repeats 1, mean 0.01   F_T/F_N -0.031   energy defect 3.2e-5",
            "  time: waits for rail 41 %, third-body 32 %; own work 27 %",
        ];
        assert_eq!(Words(&run_progress()).block(), expected);
    }

    #[test]
    fn no_line_of_a_block_is_longer_than_the_terminal() {
        let mut run_progress = run_progress();
        run_progress
            .waited
            .push(("a-participant-of-a-rather-long-name".into(), 0.1));
        run_progress.run = "n".repeat(100);
        for columns in [20, 80] {
            let block = cut(&Words(&run_progress).block(), columns);
            assert!(
                block.iter().all(|line| line.chars().count() <= columns),
                "{block:?}"
            );
        }
    }

    #[test]
    fn a_line_and_an_object_agree() {
        assert_eq!(
            Words(&run_progress()).line(),
            "quick: 38 %, hold (42 %), t = 0.670 of 1.733 ms, window 1095 of 2833, repeats 1, mean 0.01, F_T/F_N -0.031, energy defect 3.2e-5; time: waits for rail 41 %, third-body 32 %; own work 27 %; 1.2 s spent, 2 min left"
        );
        let object = Words(&run_progress()).object();
        assert_eq!(
            (&object["phase"], &object["repeats"]),
            (&json!("hold"), &json!(1))
        );
        assert_eq!(object["traction_ratio"], json!(-0.0312));
        assert_eq!(object["waited_rel"]["rail"], json!(0.41));
        assert!(object.get("sn_pct").is_none(), "{object}");
    }

    #[test]
    fn a_long_set_up_is_reported_after_ten_seconds_and_at_each_doubling() {
        let reported =
            (0..2000).filter(|k| doubles([0.05 * f64::from(*k), 0.05 * f64::from(k + 1)]));
        let reported: Vec<f64> = reported
            .map(|k| (0.05 * f64::from(k + 1)).round())
            .collect();
        assert_eq!(reported, [10.0, 20.0, 40.0, 80.0]);
    }
}
