//! Where the wall-clock time went: one bar per process.

use draw::bars::{PartKind, bars};
use draw::picture::Picture;
use draw::units::with_unit;
use runs::files::RunFiles;

/// Kinds of time, whose lightness tells them apart in grey.
const KINDS: [PartKind; 4] = [
    ["set-up", "#aabed2", "#222"],
    ["at work", "#12355b", "#fff"],
    ["waiting", "#f3e3c3", "#222"],
    ["rest: closing, outputs", "#e27d1e", "#222"],
];

/// The bars; `None` if the summary has no times.
pub(super) fn times(run: &RunFiles) -> Option<Picture> {
    let wall = run.number("wall_s").filter(|wall| *wall > 0.0)?;
    let seconds = |s: f64| with_unit(s, "s");
    // The rest is the wall-clock time without set-up, work and waiting.
    let bar = |name: &str, [setup, work, wait]: [f64; 3]| {
        let rest = (wall - setup - work - wait).max(0.0);
        (name.to_string(), [setup, work, wait, rest])
    };
    let participants = run.entries("participants").map(|(name, of)| {
        let parts = ["setup_wall_s", "solve_wall_s", "wait_s"];
        bar(name, parts.map(|key| of[key].as_f64().unwrap_or(0.0)))
    });
    let mut all: Vec<(String, [f64; 4])> = participants.collect();
    if let Some(own) = run.number("coupling.own_wall_s") {
        let number = |path: &str| run.number(path).unwrap_or(0.0);
        let waits = number("coupling.solve_wall_s") + number("coupling.wait_s");
        all.push(bar("coordinator", [number("setup_wall_s"), own, waits]));
    }
    if all.is_empty() {
        return None;
    }
    let each = all.iter().map(|(name, parts)| {
        let parts = KINDS.iter().zip(parts);
        let parts = parts.map(|([kind, ..], s)| format!("{kind} {}", seconds(*s)));
        format!("{name}: {}", Vec::from_iter(parts).join(", "))
    });
    Some(Picture {
        file: "times.svg".into(),
        caption: format!(
            "Wall-clock time of each process, {} in total. The coordinator waits while participants work; participants wait while the others work.",
            seconds(wall)
        ),
        alternative: Vec::from_iter(each).join("; "),
        svg: bars(&KINDS, &all, wall, seconds),
    })
}
