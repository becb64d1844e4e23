//! Where the wall-clock time went, a bar for each process.

use std::fmt::Write as _;

use super::units::with_unit;
use draw::picture::Picture;
use draw::picture::drawing;
use draw::picture::escape;
use runs::files::RunFiles;

/// Size of the picture's parts (pixels).
const LEFT: f64 = 150.0;
const LENGTH: f64 = 800.0;
const ROW: f64 = 34.0;

/// Kinds of time, with the lightness that tells them apart in grey.
const KINDS: [(&str, &str); 4] = [
    ("set-up", "#aabed2"),
    ("at work", "#12355b"),
    ("waiting", "#f3e3c3"),
    ("rest: closing, outputs", "#e27d1e"),
];

/// A process and the parts of its time (s), in the order of the kinds.
struct Bar {
    name: String,
    parts: [f64; 4],
}

/// The bars; none where the run tells no times.
pub(super) fn bars(run: &RunFiles) -> Option<Picture> {
    let wall = run.number("wall_s").filter(|wall| *wall > 0.0)?;
    let mut bars: Vec<Bar> = run
        .entries("participants")
        .map(|(name, of)| {
            let number = |key: &str| of[key].as_f64().unwrap_or(0.0);
            bar(
                name,
                wall,
                [
                    number("setup_wall_s"),
                    number("solve_wall_s"),
                    number("wait_s"),
                ],
            )
        })
        .collect();
    let own = ["setup_wall_s", "coupling.own_wall_s"].map(|path| run.number(path).unwrap_or(0.0));
    let waits =
        ["coupling.solve_wall_s", "coupling.wait_s"].map(|path| run.number(path).unwrap_or(0.0));
    if run.number("coupling.own_wall_s").is_some() {
        bars.push(bar(
            "coordinator",
            wall,
            [own[0], own[1], waits[0] + waits[1]],
        ));
    }
    if bars.is_empty() {
        return None;
    }
    let each = bars.iter().map(|bar| {
        let parts = KINDS
            .iter()
            .zip(bar.parts)
            .map(|((kind, _), s)| format!("{kind} {}", with_unit(s, "s")));
        format!(
            "{}: {}",
            bar.name,
            parts.collect::<Vec<String>>().join(", ")
        )
    });
    Some(Picture {
        file: "times.svg".into(),
        caption: format!(
            "Wall-clock time of each process, {} in all. The coordinator waits while participants work; participants wait while the others work.",
            with_unit(wall, "s")
        ),
        alternative: each.collect::<Vec<String>>().join("; "),
        svg: draw(&bars, wall),
    })
}

/// A bar whose rest is what the kinds leave of the whole.
fn bar(name: &str, wall: f64, [setup, work, wait]: [f64; 3]) -> Bar {
    let rest = (wall - setup - work - wait).max(0.0);
    Bar {
        name: name.into(),
        parts: [setup, work, wait, rest],
    }
}

fn draw(bars: &[Bar], wall: f64) -> String {
    let mut inside = String::new();
    for (place, (kind, colour)) in KINDS.iter().enumerate() {
        let x = LEFT + 200.0 * place as f64;
        let _ = write!(
            inside,
            "<path fill=\"{colour}\" stroke=\"#444\" d=\"M{x} 6h18v12h-18z\"/><text x=\"{}\" y=\"17\">{kind}</text>",
            x + 24.0
        );
    }
    for (row, bar) in bars.iter().enumerate() {
        let y = 30.0 + ROW * row as f64;
        let _ = write!(
            inside,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>",
            LEFT - 10.0,
            y + 17.0,
            escape(&bar.name)
        );
        let total: f64 = bar.parts.iter().sum::<f64>().max(wall);
        let mut x = LEFT;
        for ((_, colour), seconds) in KINDS.iter().zip(bar.parts) {
            let width = LENGTH * seconds / total;
            let _ = write!(
                inside,
                "<path fill=\"{colour}\" stroke=\"#444\" stroke-width=\".6\" d=\"M{x:.1} {y}h{width:.1}v24h-{width:.1}z\"/>"
            );
            if width > 60.0 {
                let ink = if *colour == "#12355b" { "#fff" } else { "#222" };
                let _ = write!(
                    inside,
                    "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\" fill=\"{ink}\">{}</text>",
                    x + 0.5 * width,
                    y + 17.0,
                    with_unit(seconds, "s")
                );
            }
            x += width;
        }
    }
    drawing(
        LEFT + LENGTH + 20.0,
        36.0 + ROW * bars.len() as f64,
        &inside,
    )
}
