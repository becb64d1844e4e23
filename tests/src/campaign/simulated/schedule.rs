//! One schedule: a run among participants behind a simulated network, and the verdict on it.
//!
//! Two ends are right:
//! - the run completes with the hashes of exchange and state of the undisturbed run, which used in-process channels;
//! - a named end: a lost participant, a broken conversation or a missed deadline (exit codes 4 and 5; 2 where the flipped bit is
//!   in the protocol's version). Its message names a participant, and comes at most a deadline after the coordinator last
//!   received something. If there is a checkpoint, the run resumes from it, without faults, to the hashes of the
//!   undisturbed run.
//!
//! If the faults only delayed messages, by less than a deadline in total, only the first end is right. Everything else is wrong:
//! another hash, another end, an endless run, a panic.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use protocol::Transport;

use super::bodies::{DEADLINE_S, registry, scenes};
use super::network::{Network, Traces, Wrap};
use super::network_faults::{NetworkFault, NetworkFaults};
use coordinator::participants::{Launcher, OtherEnd, Peer, Peers, Watch};
use coordinator::run::checkpoint::{RestartPoint, find};
use coordinator::run::session::{Ended, RunOptions, fresh_run_id, run, run_among};
use kit::scratch::Scratch;
use lab::quiet::whole;
use scenario::error::Error;
use scenario::load::Loaded;

/// Name of a program that no simulated run starts.
const PROGRAM: &str = "thirdbody";

/// The coordinator's waits end a little after their deadline, by one look at its connections.
const SLACK_S: f64 = 0.1;

/// The end of a schedule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScheduleEnd {
    /// It completed, bit-equal.
    Completed,
    /// It ended early with a named fault.
    Named,
    /// It ended early with a named fault, and a run resumed from its checkpoint, bit-equal.
    Resumed,
}

/// A scene with the end of its undisturbed run.
struct Reference {
    loaded: Loaded,
    end: (i32, String),
    messages: u64,
}

/// Simulated runs of all scenes.
pub struct Simulation {
    references: Vec<Reference>,
    wrap: Wrap,
}

impl Simulation {
    /// Runs each scene undisturbed, over in-process channels and behind a network without faults: both must be equal.
    pub fn new(wrap: Wrap) -> Result<Simulation, String> {
        let loaded = scenes().map_err(|error| error.to_string())?;
        let references = loaded.into_iter().map(|loaded| {
            let out = Scratch::in_memory("undisturbed", fresh_run_id());
            let registry = registry();
            let options = RunOptions::quiet(Some(out.path()), &registry, PROGRAM.as_ref());
            let ended = run(&loaded, &options);
            let end = hashes(ended)?;
            let (ended, traces) = attempt(&loaded, NetworkFaults::default(), wrap, None);
            if hashes(ended)? != end {
                return Err("a simulated network without faults changes the bits".into());
            }
            Ok(Reference {
                loaded,
                end,
                messages: traces.messages,
            })
        });
        Ok(Simulation {
            references: references.collect::<Result<_, String>>()?,
            wrap,
        })
    }

    /// Runs the schedule of a seed; the error describes a wrong end.
    pub fn schedule(&self, seed: u64) -> Result<ScheduleEnd, String> {
        let reference = &self.references[(seed % self.references.len() as u64) as usize];
        let network_faults = NetworkFaults::new(seed, reference.messages);
        let out = Scratch::in_memory("schedule", fresh_run_id());
        let (loaded, place) = (&reference.loaded, Some(out.path()));
        let (ended, traces) = attempt(loaded, network_faults, self.wrap, place);
        let judged = self.judge(reference, ended, &traces, out.path());
        judged.map_err(|why| format!("schedule {seed}, faults {:?}: {why}", traces.faults))
    }

    fn judge(
        &self,
        reference: &Reference,
        ended: Result<Ended, Error>,
        traces: &Traces,
        out: &Path,
    ) -> Result<ScheduleEnd, String> {
        if let Some(broken) = &traces.broken {
            return Err(broken.clone());
        }
        let error = match whole(ended) {
            Err(error) => error,
            Ok(ended) if end_of(&ended) == reference.end => return Ok(ScheduleEnd::Completed),
            Ok(_) => return Err("it completed with other hashes".into()),
        };
        named(&error, traces)?;
        self.resumed(reference, out)
    }

    /// Resumes an ended run, if it left a checkpoint.
    fn resumed(&self, reference: &Reference, left: &Path) -> Result<ScheduleEnd, String> {
        let loaded = &reference.loaded;
        let found = find(left, loaded, None).map_err(|error| error.to_string())?;
        let Some(restart) = found.0 else {
            return Ok(ScheduleEnd::Named);
        };
        let out = Scratch::in_memory("resumed", fresh_run_id());
        let network = Network::new(NetworkFaults::default());
        let ended = run_behind(&network, loaded, self.wrap, out.path(), Some(&restart));
        network.end();
        if hashes(ended)? != reference.end {
            return Err("it resumed from a checkpoint to other hashes".into());
        }
        Ok(ScheduleEnd::Resumed)
    }
}

/// Refuses an error without a named fault, too late, or without cause.
fn named(error: &Error, traces: &Traces) -> Result<(), String> {
    let faults = || traces.faults.iter().map(|(_, fault)| *fault);
    let flipped = faults().any(|fault| matches!(fault, NetworkFault::Flipped(_)));
    let code = error.exit_code();
    let said = error.to_string();
    let names = ["block", "left", "right"];
    let named = names.iter().any(|name| said.contains(&format!("`{name}`")));
    if !named || !(matches!(code, 4 | 5) || (flipped && code == 2)) {
        return Err(format!("it ended with code {code}: {said}"));
    }
    if traces.unheard_s > DEADLINE_S + SLACK_S {
        return Err(format!("{said}, but only after {} s", traces.unheard_s));
    }
    let takes = |fault| match fault {
        NetworkFault::Late(time_s) | NetworkFault::Stall(time_s) => time_s,
        _ => f64::INFINITY,
    };
    let lost_s: f64 = faults().map(takes).sum();
    if lost_s < DEADLINE_S - SLACK_S {
        return Err(format!("{said}, although the faults took only {lost_s} s"));
    }
    Ok(())
}

/// A run behind a network, its directory at `out` or nowhere.
fn attempt(
    loaded: &Loaded,
    network_faults: NetworkFaults,
    wrap: Wrap,
    out: Option<&Path>,
) -> (Result<Ended, Error>, Traces) {
    let network = Network::new(network_faults);
    let scratch = Scratch::in_memory("without-faults", fresh_run_id());
    let out = out.unwrap_or(scratch.path());
    let tried = catch_unwind(AssertUnwindSafe(|| {
        run_behind(&network, loaded, wrap, out, None)
    }));
    let mut traces = network.end();
    let ended = tried.unwrap_or_else(|_| {
        traces.broken = Some("the coordinator panicked".into());
        Err(Error::Diverged("the coordinator panicked".into()))
    });
    (ended, traces)
}

/// Runs or resumes with participants behind a network.
fn run_behind(
    network: &Network,
    loaded: &Loaded,
    wrap: Wrap,
    out: &Path,
    from: Option<&RestartPoint>,
) -> Result<Ended, Error> {
    let registry = registry();
    let options = RunOptions::quiet(Some(out), &registry, PROGRAM.as_ref());
    let launch = |launcher: &Launcher| start(launcher, network, wrap);
    run_among(loaded, &options, from, &launch)
}

/// Starts the participants behind the network.
fn start(launcher: &Launcher, network: &Network, wrap: Wrap) -> Result<Peers, Error> {
    let scenario = &launcher.loaded.scenario;
    let peers = scenario.participant.iter().map(|participant| {
        let build = launcher.registry.find(participant)?.build;
        let session = launcher.session(participant, Transport::Channel);
        let (link, end) = network.join(session, build, wrap);
        Ok(Peer::new(&participant.name, link, OtherEnd::Simulated(end)))
    });
    let peers = peers.collect::<Result<_, Error>>()?;
    let (run_id, watch) = (launcher.run_id, Watch::default());
    Ok(Peers::new(peers, None, run_id, scenario, watch))
}

/// Exit code and hashes of a run that came to its end.
fn end_of(ended: &Ended) -> (i32, String) {
    let hashes = ended.summary.value()["hashes"].to_string();
    (ended.summary.exit_code, hashes)
}

/// Exit code and hashes of a run that must have come to its end.
fn hashes(ended: Result<Ended, Error>) -> Result<(i32, String), String> {
    let ended = whole(ended).map_err(|error| error.to_string())?;
    Ok(end_of(&ended))
}
