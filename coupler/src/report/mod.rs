//! `report.html` with its pictures, made from what a run left in its directory.
//!
//! - [`fields`]: reading the VTK files of the participants;
//! - [`scene`]: grains and continuum around the contact, coloured by pressure;
//! - [`body`]: the whole continuum, and which of its nodes stick;
//! - [`curves`]: interface traction, friction loop, forces and sliding nodes over time.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value;

use crate::error::{Error, Refusal};

pub mod body;
pub mod curves;
pub mod fields;
pub mod scene;

/// Writes the pictures and `report.html` into a run directory; returns the names of the files.
pub fn write(run: &Path) -> Result<Vec<String>, Error> {
    let summary = read_summary(run)?;
    let mut pictures = Vec::new();
    if let Some(svg) = scene::at_the_hold(run)? {
        pictures.push((
            "scene.svg",
            "Hydrostatic pressure in the rail and pressure on the grains at the end of the hold",
            svg,
        ));
    }
    if let Some(svg) = body::pressure(run)? {
        pictures.push((
            "pressure.svg",
            "Hydrostatic pressure in the whole body at the end of the hold",
            svg,
        ));
    }
    pictures.extend(body::status(run)?);
    for (name, caption, svg) in curves::all(run)? {
        pictures.push((name, caption, svg));
    }
    let mut names = Vec::new();
    for (name, _, svg) in &pictures {
        save(run, name, svg)?;
        names.push(name.to_string());
    }
    save(run, "report.html", &page(&summary, &pictures))?;
    names.push("report.html".into());
    Ok(names)
}

fn read_summary(run: &Path) -> Result<Value, Error> {
    let path = run.join("summary.json");
    let text = std::fs::read_to_string(&path).map_err(Error::input(path.display()))?;
    serde_json::from_str(&text).map_err(|error| Refusal::file(path, error.to_string()).into())
}

fn save(run: &Path, name: &str, text: &str) -> Result<(), Error> {
    let path = run.join(name);
    std::fs::write(&path, text).map_err(Error::output(path.display()))
}

/// One page that needs nothing else: the pictures are part of it.
fn page(summary: &Value, pictures: &[(&str, &str, String)]) -> String {
    let text = |key: &str| escape(summary[key].as_str().unwrap_or_default());
    let mut html = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title><style>body{{font-family:sans-serif;max-width:75em;margin:2em auto;padding:0 1em}}svg{{max-width:100%;height:auto}}td{{padding:0.1em 1em 0.1em 0}}td+td{{font-family:monospace}}</style></head><body><h1>{0}</h1><p>{1} {2}</p>",
        text("scenario"),
        text("status"),
        text("message")
    );
    for (_, caption, svg) in pictures {
        let _ = write!(
            html,
            "<figure>{svg}<figcaption>{}</figcaption></figure>",
            escape(caption)
        );
    }
    html.push_str("<h2>Results</h2><table>");
    for (name, value) in summary["results"].as_object().into_iter().flatten() {
        let _ = write!(
            html,
            "<tr><td>{}</td><td>{}</td></tr>",
            escape(name),
            escape(&value.to_string())
        );
    }
    html.push_str("</table></body></html>\n");
    html
}

/// Names come from scenarios that may not be ours.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
