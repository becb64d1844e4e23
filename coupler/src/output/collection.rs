//! The moments at which participants write their fields, and `fields/<participant>.pvd`: a participant's snapshots over time, as
//! ParaView opens them.

use std::path::Path;

use protocol::Phase;

use crate::error::Refusal;

/// Most moments within a phase: a folder with more files is nobody's wish.
const MOST: f64 = 10_000.0;

/// A moment at which the participants write their fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moment {
    /// Name of the snapshot.
    pub name: String,
    /// Simulated time (s).
    pub time_s: f64,
    /// The end of the phase in which results are sampled.
    pub sampled: bool,
}

/// The ends of all phases and, with `run.output.fields_every_s`, moments so many seconds apart within each, from its start on:
/// the k-th within `cycling` is called `cycling-k`. From the last phase to the end of the run (s), without phases from its start,
/// they are called `run-k`; the end itself is always written.
///
/// # Errors
/// More than 10 000 moments in a phase.
pub fn moments(phases: &[Phase], every_s: Option<f64>, end_s: f64) -> Result<Vec<Moment>, Refusal> {
    let mut moments = Vec::new();
    for phase in phases {
        let span = [phase.t0_s, phase.t1_s];
        moments.extend(within(&phase.name, span, every_s)?);
        moments.push(Moment {
            name: phase.name.clone(),
            time_s: phase.t1_s,
            sampled: phase.sampled,
        });
    }
    let rest = [phases.last().map_or(0.0, |phase| phase.t1_s), end_s];
    moments.extend(within("run", rest, every_s)?);
    Ok(moments)
}

/// Moments within a span of time (s), ends excluded.
fn within(
    name: &str,
    [start, end]: [f64; 2],
    every_s: Option<f64>,
) -> Result<impl Iterator<Item = Moment>, Refusal> {
    let every = every_s.unwrap_or(f64::INFINITY);
    let parts = (end - start) * (1.0 - 1e-9) / every;
    if parts > MOST {
        let problem = format!(
            "= {every:e} makes {parts:.0} snapshots of `{name}`: make them {MOST} or fewer"
        );
        return Err(Refusal::key("run.output.fields_every_s", problem));
    }
    Ok((1..=parts as u64).map(move |k| Moment {
        name: format!("{name}-{k}"),
        time_s: start + k as f64 * every,
        sampled: false,
    }))
}

/// The collection of a participant, of those snapshots, with their times (s), of which `fields` holds a file; `None` without any.
pub fn pvd(fields: &Path, participant: &str, snapshots: &[(&str, f64)]) -> Option<String> {
    let mut sets = String::new();
    for (name, time_s) in snapshots {
        let stem = format!("{participant}-{name}");
        let files = ["vtu", "vtp"].map(|extension| format!("{stem}.{extension}"));
        if let Some(file) = files.iter().find(|file| fields.join(file).exists()) {
            let set = format!("<DataSet timestep=\"{time_s:e}\" part=\"0\" file=\"{file}\"/>\n");
            sets.push_str(&set);
        }
    }
    (!sets.is_empty()).then(|| {
        format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>\n{sets}</Collection>\n</VTKFile>\n"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rundir::Scratch;

    #[test]
    fn a_phase_ends_with_a_moment_and_holds_those_that_are_asked_for() {
        let phase = |name: &str, [t0_s, t1_s]: [f64; 2]| Phase {
            name: name.into(),
            t0_s,
            t1_s,
            sampled: name == "hold",
            picture: true,
        };
        let phases = [phase("hold", [0.5, 2.0]), phase("cycling", [2.0, 6.0])];
        let told = |every| {
            let all = moments(&phases, every, 6.0).expect("they are few");
            Vec::from_iter(all.into_iter().map(|m| (m.name, m.time_s, m.sampled)))
        };
        let ends = [("hold", 2.0, true), ("cycling", 6.0, false)];
        let inner = [("hold-1", 1.5, false), ("cycling-1", 3.0, false)];
        let last = [("cycling-2", 4.0, false), ("cycling-3", 5.0, false)];
        let own = |all: &[(&str, f64, bool)]| {
            Vec::from_iter(all.iter().map(|(name, t, s)| (name.to_string(), *t, *s)))
        };
        assert_eq!(told(None), own(&ends));
        let all = [inner[0], ends[0], inner[1], last[0], last[1], ends[1]];
        assert_eq!(told(Some(1.0)), own(&all));
        let error = moments(&phases, Some(1e-4), 6.0).expect_err("they are many");
        assert!(error.to_string().contains("fields_every_s"), "{error}");
    }

    #[test]
    fn a_run_without_phases_or_beyond_them_has_the_moments_that_are_asked_for() {
        let told = |phases: &[Phase], every| {
            let all = moments(phases, every, 3.0).expect("they are few");
            Vec::from_iter(all.into_iter().map(|m| (m.name, m.time_s)))
        };
        let two = [("run-1".to_string(), 1.0), ("run-2".to_string(), 2.0)];
        assert_eq!(told(&[], Some(1.0)), two);
        assert_eq!(told(&[], None), []);
        let phase = Phase {
            name: "ramp".into(),
            t0_s: 0.0,
            t1_s: 1.5,
            sampled: false,
            picture: true,
        };
        let beyond = [
            ("ramp-1".to_string(), 1.0),
            ("ramp".to_string(), 1.5),
            ("run-1".to_string(), 2.5),
        ];
        assert_eq!(told(&[phase], Some(1.0)), beyond);
    }

    #[test]
    fn only_files_that_exist_are_listed() {
        let scratch = Scratch::new("pvd", 1);
        std::fs::create_dir_all(scratch.path()).expect("a folder");
        let moments = ["hold", "cycling", "end"].map(|name| (name, 0.5));
        assert_eq!(pvd(scratch.path(), "rail", &moments), None);
        for file in ["rail-hold.vtu", "grains-end.vtp"] {
            std::fs::write(scratch.path().join(file), "").expect("a file");
        }
        let rail = pvd(scratch.path(), "rail", &moments).expect("one file");
        assert!(rail.contains("timestep=\"5e-1\" part=\"0\" file=\"rail-hold.vtu\""));
        assert!(!rail.contains("rail-end"));
        let grains = pvd(scratch.path(), "grains", &moments).expect("one file");
        assert_eq!(grains.matches("<DataSet").count(), 1);
    }
}
