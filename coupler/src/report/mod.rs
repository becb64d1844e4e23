//! `report.html` with its pictures, made from what a run left in its directory.
//!
//! - [`fields`]: the VTK files of the participants; [`view`]: a part of the scene on a page;
//! - [`scene`]: grains and continuum around the contact, coloured by pressure;
//! - [`body`]: the whole continuum, and which of its nodes stick;
//! - [`grains`]: pressure in the cells of the grains' stress; [`arrows`]: their velocities and displacements;
//! - [`circuit`]: the flows of third body;
//! - [`movie`]: `movie.html`, a player of all moments;
//! - [`plot`]: curves over axes; [`curves`]: interface traction, friction loop, forces and sliding nodes over time.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value;

use crate::error::{Error, Refusal};
use fields::Moment;
use view::Picture;

pub mod arrows;
pub mod body;
pub mod circuit;
pub mod curves;
pub mod fields;
pub mod grains;
pub mod movie;
pub mod plot;
pub mod scene;
pub mod view;

/// Writes the pictures and `report.html` into a run directory; returns the names of the files.
pub fn write(run: &Path) -> Result<Vec<String>, Error> {
    let summary = read_summary(run)?;
    let moments = moments(&summary);
    let mut pictures = Vec::from_iter(scene::contact(run, &moments)?);
    pictures.extend(body::pressure(run, &moments)?);
    pictures.extend(grains::pressure(run, &moments)?);
    pictures.extend(arrows::velocities(run, &moments)?);
    pictures.extend(arrows::displacements(run, &phases(&summary))?);
    pictures.extend(circuit::drawn(&summary)?);
    pictures.extend(body::status(run, &moments)?);
    pictures.extend(curves::all(run)?);
    let mut names = Vec::new();
    for picture in &pictures {
        save(run, picture.file, &picture.svg)?;
        names.push(picture.file.to_string());
    }
    save(run, "report.html", &page(&summary, &pictures))?;
    names.push("report.html".into());
    Ok(names)
}

/// The moments that the participants marked for a picture, then the end of the run.
fn moments(summary: &Value) -> Vec<Moment> {
    let phases = summary["phases"].as_array().into_iter().flatten();
    let marked = phases.filter(|phase| phase["picture"] == true);
    let names = marked.filter_map(|phase| phase["name"].as_str());
    let all = names.map(|name| (name, name)).chain([("end", "run")]);
    let moment = |(name, of): (&str, &str)| Moment {
        name: name.into(),
        words: format!("end of the {of}"),
    };
    all.map(moment).collect()
}

/// Names of the phases of the load, in their order.
fn phases(summary: &Value) -> Vec<String> {
    let all = summary["phases"].as_array().into_iter().flatten();
    let names = all.filter_map(|phase| phase["name"].as_str());
    names.map(String::from).collect()
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
fn page(summary: &Value, pictures: &[Picture]) -> String {
    let text = |key: &str| escape(summary[key].as_str().unwrap_or_default());
    let mut html = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title><style>body{{font-family:sans-serif;max-width:75em;margin:2em auto;padding:0 1em}}svg{{max-width:100%;height:auto}}td{{padding:0.1em 1em 0.1em 0}}td+td{{font-family:monospace}}</style></head><body><h1>{0}</h1><p>{1} {2}</p>",
        text("scenario"),
        text("status"),
        text("message")
    );
    for picture in pictures {
        let (svg, caption) = (&picture.svg, escape(&picture.caption));
        let _ = write!(
            html,
            "<figure>{svg}<figcaption>{caption}</figcaption></figure>"
        );
    }
    html.push_str("<h2>Results</h2><table>");
    for (name, value) in summary["results"].as_object().into_iter().flatten() {
        let (name, value) = (escape(name), escape(&value.to_string()));
        let _ = write!(html, "<tr><td>{name}</td><td>{value}</td></tr>");
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
