//! Speed against accuracy: a run among the settings that a study measured for its scene, and settings with half its error or half its time.

use super::page::{Section, names};
use super::provenance::{quoted, scenario_file};
use draw::axis::{AxisPair, Grid, PlotAxis, number};
use draw::picture::Picture;
use draw::svg::{Svg, escape};
use runs::files::RunFiles;
use runs::front::{MeasuredFront, MeasuredSetting};
use scenario::overrides::{key_of, value_at};

/// SVG attributes of settings, bounds, the front, and marks.
const DOTS: &str = "fill=\"#787878\"";
const BOUNDS: &str = "stroke=\"#aabed2\" stroke-width=\"1.5\"";
const FRONT: &str = "stroke=\"#12355b\" stroke-width=\"1.8\"";
const MARKS: &str = "fill=\"none\" stroke=\"#e27d1e\" stroke-width=\"2.4\"";
/// Words of the marks, and their outlines relative to the middle.
const MARKED: [[&str; 2]; 3] = [
    ["Ring: this run", "m-7 0a7 7 0 1 0 14 0a7 7 0 1 0-14 0"],
    ["Square: half the error", "m-7-7h14v14h-14z"],
    ["Diamond: half the time", "m0-9l9 9-9 9-9-9z"],
];
/// Size of a picture, edges of the area between its axes (pixels).
const SIZE: [f64; 2] = [530.0, 290.0];
const ACROSS: [f64; 2] = [78.0, 518.0];
const DOWN: [f64; 2] = [12.0, 244.0];

/// The section; empty without a study and a budget.
pub(super) fn section(run: &RunFiles, front: Option<&MeasuredFront>) -> Section {
    let title = "Speed against accuracy";
    let promised = promised(run).map_or(String::new(), |text| paragraph(&text));
    let Some(front) = front else {
        return Section::of_text(title, promised);
    };
    let own = paragraph(&own_words(run, front));
    let pictures = (0..front.measures.len()).filter_map(|k| picture(front, k));
    Section {
        text: paragraph(&origin(run, front)) + &promised + &own + &halves(run, front),
        ..Section::of_pictures(title, vec![], pictures.collect())
    }
}

fn paragraph(text: &str) -> String {
    format!("<p>{}</p>", names(&escape(text)))
}

/// An error in per cent, two digits.
fn percent(error: f64) -> String {
    let rounded = format!("{:.1e}", 100.0 * error).parse();
    format!("{} %", number(rounded.unwrap_or(f64::NAN)))
}

/// The bounds that `run --budget` promised.
fn promised(run: &RunFiles) -> Option<String> {
    let budget = run.summary.get("budget")?;
    let [asked, study] = ["budget", "study"].map(|key| budget[key].as_str().unwrap_or_default());
    let start = format!("The run was made with `--budget {asked}`, by the study `{study}`");
    if budget["set"] == budget["reference"] {
        return Some(format!(
            "{start}, with its reference: no bound was promised."
        ));
    }
    let errors = budget["errors"].as_object().into_iter().flatten();
    let errors = errors.filter_map(|(name, of)| Some((name, of["bound"].as_f64()?)));
    let errors = errors.map(|(name, bound)| format!("{name} {}", percent(bound)));
    let errors = Vec::from_iter(errors).join(", ");
    Some(format!(
        "{start}, which promised errors below these bounds, each in 39 of 40 scenes: {errors}."
    ))
}

/// Names the study and the reference of its errors.
fn origin(run: &RunFiles, front: &MeasuredFront) -> String {
    let (study, count, build) = (&front.study, front.settings.len(), &front.build);
    let mut text = format!(
        "The study `{study}` has measured {count} settings for this scene. Errors are distances from the study's reference, which has errors of its own. An expected error is a median; 39 of 40 scenes stay below the bound."
    );
    let missed = front.measures.iter().zip(&front.reference_misses);
    let missed = missed.map(|(name, error)| format!("{name} {}", percent(*error)));
    let missed = Vec::from_iter(missed).join(", ");
    if !missed.is_empty() {
        text += &format!(" By extrapolation the reference itself errs by {missed}.");
    }
    if run.manifest()["build"] != **build {
        text += &format!(
            " The study is of another build, {build}: its errors are assumed to hold for this run."
        );
    }
    text
}

/// Names the setting of the run with its errors, or else the nearest setting.
fn own_words(run: &RunFiles, front: &MeasuredFront) -> String {
    let (nearest, words) = (&front.nearest, &front.nearest.words);
    let table = run.scenario_table();
    let differs = nearest.overrides.iter().map(|set| {
        let own = value_at(&table, key_of(set));
        let own = own.map_or("nothing".into(), ToString::to_string);
        format!("`{set}` (this run: {own})")
    });
    let differs = Vec::from_iter(differs).join(", ");
    match front.own.map(|own| (own, &front.settings[own])) {
        None if !differs.is_empty() => format!(
            "This run has a setting that the study did not measure. The nearest is `{words}`, which has {differs}."
        ),
        None => format!(
            "This run has the setting `{words}`, whose errors the study does not state. Warnings of its runs that the reference does not have: {}.",
            nearest.warned.join(", ")
        ),
        Some((own, setting)) => {
            let on = front.measures.iter().zip(&front.fronts);
            let on = on.filter(|(_, front)| front.contains(&own));
            let on = on.map(|(name, _)| name.as_str());
            let on = match Vec::from_iter(on).join(", ") {
                on if on.is_empty() => "no measure".into(),
                on => on,
            };
            let (cost, errors) = (number(setting.cost), errors(front, setting));
            format!(
                "This run has the setting `{words}`, at {cost} of the processor time of the reference. {errors} It lies on the front in {on}."
            )
        }
    }
}

fn errors(front: &MeasuredFront, setting: &MeasuredSetting) -> String {
    if setting.is_reference {
        return "It is the reference; these errors do not include its own.".into();
    }
    let errors = front.measures.iter().zip(&setting.errors);
    let errors = errors.map(|(name, error)| {
        let [expected, bound] = error.map(percent);
        format!("{name} {expected} (bound {bound})")
    });
    format!("Expected errors: {}.", Vec::from_iter(errors).join(", "))
}

/// Commands for half the error and for half the time, if the study has such settings.
fn halves(run: &RunFiles, front: &MeasuredFront) -> String {
    let Some(own) = front.own.map(|own| &front.settings[own]) else {
        return String::new();
    };
    let paragraphs = |half: Option<usize>, found: &str, none: &str| {
        let Some(half) = half.map(|half| &front.settings[half]) else {
            return paragraph(none);
        };
        let (words, errors) = (&half.words, errors(front, half));
        let cost = number(half.cost / own.cost);
        let text = format!("{found} `{words}`: {cost} times this run's processor time. {errors}");
        let mut command = format!("thirdbody run {}", scenario_file(run));
        for set in &half.overrides {
            command += &format!(" \\\n    --set {}", quoted(set));
        }
        format!("{}<pre>{}</pre>", paragraph(&text), escape(&command))
    };
    let error = paragraphs(
        front.half_error,
        "The cheapest setting with half the error in every measure is",
        "No setting of the study has half the error in every measure.",
    );
    let time = paragraphs(
        front.half_time,
        "The most accurate setting within half the processor time is",
        "No setting of the study takes half the processor time.",
    );
    error + &time
}

/// Error over cost by one measure; `None` for a single setting, which shows no trade-off.
fn picture(front: &MeasuredFront, measure: usize) -> Option<Picture> {
    let (name, settings) = (&front.measures[measure], &front.settings);
    let is_drawn = |k: &usize| !settings[*k].is_reference;
    let drawn: Vec<usize> = (0..settings.len()).filter(is_drawn).collect();
    if drawn.len() < 2 {
        return None;
    }
    let ends = |k: &usize| settings[*k].errors[measure].map(|error| 100.0 * error);
    let costs = settings.iter().map(|of| of.cost);
    let errors = drawn.iter().flat_map(ends);
    let axes = AxisPair {
        x: PlotAxis::logarithmic("processor time relative to the reference", costs),
        y: PlotAxis::logarithmic(&format!("expected error in {name} (%)"), errors),
        across: ACROSS,
        down: DOWN,
    };
    let points = |k: &usize| ends(k).map(|error| axes.at((settings[*k].cost, error)));
    let mut svg = Svg::default();
    axes.draw(&mut svg, Grid::Lines);
    for k in &drawn {
        svg.line(BOUNDS, points(k));
        svg.circle(DOTS, points(k)[0], 3.5);
    }
    let line = front.fronts[measure].iter().filter(|k| is_drawn(k));
    svg.line(FRONT, line.map(|k| points(k)[0]));
    let mut marked = String::new();
    let marks = [front.own, front.half_error, front.half_time];
    for ([words, outline], k) in MARKED.iter().zip(marks) {
        let Some(k) = k.filter(is_drawn) else {
            continue;
        };
        let [x, y] = points(&k)[0];
        svg.path(MARKS, &format!("M{x:.1} {y:.1}{outline}"));
        let [expected, _] = settings[k].errors[measure].map(percent);
        marked += &format!(" {words}, {expected}.");
    }
    Some(Picture {
        file: format!("front-{}.svg", measure + 1),
        caption: format!(
            "Error in {name} over processor time: one dot per setting, with a line up to its bound; a line joins the front. The reference, at 1, has no error to draw.{marked}"
        ),
        alternative: format!("{} settings.", drawn.len()),
        svg: svg.page(SIZE),
    })
}
