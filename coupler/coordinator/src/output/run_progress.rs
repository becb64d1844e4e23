//! The facts about a run under way, in lines for a terminal, in one line, and as an object.

use serde_json::{Map, Value, json};

/// How far a run has come, and how it goes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunProgress {
    /// Name of the run.
    pub run: String,
    /// Part of the load history, and the share of it that has passed.
    pub phase: Option<(String, f64)>,
    /// Simulated time, and that of the end (s).
    pub t_s: f64,
    /// Simulated time of the end (s).
    pub end_s: f64,
    /// Windows done.
    pub window: u64,
    /// All windows, if none is halved.
    pub windows: u64,
    /// Repeats of the last window, and their mean; none for a run without interfaces.
    pub repeats: Option<(u32, f64)>,
    /// Share of the sliding nodes among those in contact with the wheel (%).
    pub sn_pct: Option<f64>,
    /// Tangential over normal force on the wheel.
    pub friction_coefficient: Option<f64>,
    /// Energy without account over the work, of all participants together.
    pub energy_defect_rel: Option<f64>,
    /// Shares of the time in which the coordinator waited for each participant.
    pub waited: Vec<(String, f64)>,
    /// Wall-clock time since the first window (s).
    pub spent_s: f64,
    /// Wall-clock time that is left (s), once it can be told.
    pub left_s: Option<f64>,
}

/// Characters of the bar.
const BAR: usize = 20;

impl RunProgress {
    fn done(&self) -> f64 {
        (self.t_s / self.end_s).clamp(0.0, 1.0)
    }

    /// Share of the time in which the coordinator did not wait.
    fn own(&self) -> f64 {
        let waited: f64 = self.waited.iter().map(|(_, share)| share).sum();
        (1.0 - waited).max(0.0)
    }

    /// Lines for a terminal.
    pub fn block(&self) -> Vec<String> {
        let bar = bar(self.done());
        let [percent, clock] = [self.percent(), self.clock()];
        let mut lines = vec![
            format!("{} [{bar}] {percent}  {clock}", self.run),
            format!("  {}", self.position().join("   ")),
        ];
        let judged = self.judged();
        if !judged.is_empty() {
            lines.push(format!("  {}", judged.join("   ")));
        }
        lines.push(format!("  time: {}", self.shares()));
        lines
    }

    /// The same in one line.
    pub fn line(&self) -> String {
        let words = [vec![self.percent()], self.position(), self.judged()].concat();
        let [words, shares, clock] = [words.join(", "), self.shares(), self.clock()];
        format!("{}: {words}; time: {shares}; {clock}", self.run)
    }

    fn percent(&self) -> String {
        format!("{:.0} %", (100.0 * self.done()).floor())
    }

    fn clock(&self) -> String {
        let left = self
            .left_s
            .map(|left_s| format!(", {} left", lasting(left_s)));
        lasting(self.spent_s) + " spent" + &left.unwrap_or_default()
    }

    fn position(&self) -> Vec<String> {
        let mut words = Vec::new();
        if let Some((name, part)) = &self.phase {
            words.push(format!("{name} ({:.0} %)", (100.0 * part).floor()));
        }
        let [t_ms, end_ms] = [1e3 * self.t_s, 1e3 * self.end_s];
        words.push(format!("t = {t_ms:.3} of {end_ms:.3} ms"));
        words.push(format!("window {} of {}", self.window, self.windows));
        words
    }

    fn judged(&self) -> Vec<String> {
        let repeats = self.repeats;
        let known = [
            repeats.map(|(last, mean)| format!("repeats {last}, mean {mean:.2}")),
            self.sn_pct.map(|sn| format!("Sn {sn:.0} %")),
            self.friction_coefficient
                .map(|friction| format!("F_T/F_N {friction:.3}")),
            self.energy_defect_rel
                .map(|defect| format!("energy defect {defect:.1e}")),
        ];
        known.into_iter().flatten().collect()
    }

    fn shares(&self) -> String {
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        let waited = self.waited.iter();
        let waited = waited.map(|(name, share)| format!("{name} {}", percent(*share)));
        let waited = waited.collect::<Vec<_>>().join(", ");
        format!("waits for {waited}; own work {}", percent(self.own()))
    }

    /// An object for programs, units in its keys; what is not known is left out.
    pub fn object(&self) -> Value {
        let waited = self.waited.iter();
        let waited = waited.map(|(name, share)| (name.clone(), json!(share)));
        let (phase, part) = self.phase.clone().unzip();
        let (last, mean) = self.repeats.unzip();
        let object = json!({
            "run": self.run,
            "done_rel": self.done(),
            "t_s": self.t_s,
            "end_s": self.end_s,
            "window": self.window,
            "windows": self.windows,
            "waited_rel": waited.collect::<Map<String, Value>>(),
            "own_rel": self.own(),
            "spent_wall_s": self.spent_s,
            "phase": phase,
            "phase_done_rel": part,
            "repeats": last,
            "repeats_mean": mean,
            "sn_pct": self.sn_pct,
            "friction_coefficient": self.friction_coefficient,
            "energy_defect_rel": self.energy_defect_rel,
            "left_wall_s": self.left_s,
        });
        known(object).into()
    }
}

/// The keys of an object that have a value.
pub fn known(object: Value) -> Map<String, Value> {
    let Value::Object(keys) = object else {
        return Map::new();
    };
    let known = keys.into_iter().filter(|(_, value)| !value.is_null());
    known.collect()
}

/// A bar of which this share is full.
pub(super) fn bar(share: f64) -> String {
    let done = (BAR as f64 * share.clamp(0.0, 1.0)) as usize;
    "#".repeat(done) + &"-".repeat(BAR - done)
}

/// A time in the unit that people take.
pub(super) fn lasting(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 100.0 => format!("{s:.0} s"),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::super::stderr::cut;
    use super::*;

    fn run_progress() -> RunProgress {
        RunProgress {
            run: "quick".into(),
            phase: Some(("hold".into(), 0.425)),
            t_s: 0.67e-3,
            end_s: 1.733e-3,
            window: 1095,
            windows: 2833,
            repeats: Some((1, 0.013)),
            sn_pct: None,
            friction_coefficient: Some(-0.0312),
            energy_defect_rel: Some(3.21e-5),
            waited: vec![("rail".into(), 0.41), ("third-body".into(), 0.32)],
            spent_s: 1.25,
            left_s: Some(131.0),
        }
    }

    #[test]
    fn a_block_has_a_line_for_each_question() {
        let expected = [
            "quick [#######-------------] 38 %  1.2 s spent, 2 min left",
            "  hold (42 %)   t = 0.670 of 1.733 ms   window 1095 of 2833",
            "  repeats 1, mean 0.01   F_T/F_N -0.031   energy defect 3.2e-5",
            "  time: waits for rail 41 %, third-body 32 %; own work 27 %",
        ];
        assert_eq!(run_progress().block(), expected);
    }

    #[test]
    fn no_line_of_a_block_is_longer_than_the_terminal() {
        let mut run_progress = run_progress();
        run_progress
            .waited
            .push(("a-participant-of-a-rather-long-name".into(), 0.1));
        run_progress.run = "n".repeat(100);
        for columns in [20, 80] {
            let block = cut(&run_progress.block(), columns);
            assert!(
                block.iter().all(|line| line.chars().count() <= columns),
                "{block:?}"
            );
        }
    }

    #[test]
    fn a_line_and_an_object_tell_the_same() {
        assert_eq!(
            run_progress().line(),
            "quick: 38 %, hold (42 %), t = 0.670 of 1.733 ms, window 1095 of 2833, repeats 1, mean 0.01, F_T/F_N -0.031, energy defect 3.2e-5; time: waits for rail 41 %, third-body 32 %; own work 27 %; 1.2 s spent, 2 min left"
        );
        let object = run_progress().object();
        assert_eq!(
            (&object["phase"], &object["repeats"]),
            (&json!("hold"), &json!(1))
        );
        assert_eq!(object["friction_coefficient"], json!(-0.0312));
        assert_eq!(object["waited_rel"]["rail"], json!(0.41));
        assert!(object.get("sn_pct").is_none(), "{object}");
    }
}
