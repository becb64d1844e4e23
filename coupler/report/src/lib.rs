//! `report.html` with its pictures, and `movie.html`, made from the files in a run directory.
//!
//! - [`page`]: sections, tables and pictures as one file;
//! - `verdict`: how the run ended, balances, warnings, steps against their bounds; [`provenance`]: the origin of the run;
//! - `results`: the results, explained as in the book's reference; `compare`: a run against another one; [`seeds`]: several seeds;
//! - `mesh`: meshes and grains in millimetres; `scene`: meshes and grains around the contact, coloured by pressure;
//! - `body`: the whole continuum, and its nodes that stick;
//! - `bodies`: first and third body; `cycles`: the wheel's motion cycle by cycle; `profiles`: profiles across a layer of grains;
//! - `grains`: pressure in the cells of the grains' stress; `arrows`: their velocities and displacements; `chains`: their forces;
//! - `circuit`: the flows of third body; `times`: where the time went; `front`: settings with less error or less time;
//! - `curves`: loads, friction, sliding nodes, traction; `line_contact`: Hertz's pressure and the limit of friction;
//!   `ledger`: interfaces, energies, bonds, flows;
//! - [`study`]: the page of a study;
//! - [`terminal`]: the results of a run as a table for a terminal;
//! - [`movie`]: `movie.html`, a player of all moments.

use std::collections::HashSet;
use std::path::Path;

use curves::{Tables, plots};
use draw::picture::Picture;
use page::Section;
use runs::files::RunFiles;
use runs::front::MeasuredFront;
use scenario::error::Error;

mod arrows;
mod bodies;
mod body;
mod chains;
mod circuit;
mod compare;
mod curves;
mod cycles;
mod front;
mod grains;
mod ledger;
mod line_contact;
mod mesh;
pub mod movie;
pub mod page;
mod profiles;
pub mod provenance;
pub mod results;
mod rolled;
mod scene;
pub mod seeds;
pub mod study;
pub mod terminal;
mod times;
mod verdict;

/// Writes the pictures and `report.html` into a run directory, with the curves of another run and the settings of a study if they are
/// given. Returns the names of the files, and an error if a table or field differs from what its run wrote.
///
/// # Errors
/// A file of a run is missing or damaged, or a file cannot be written.
pub fn write(
    run: &Path,
    other: Option<&Path>,
    front: Option<&MeasuredFront>,
) -> Result<(Vec<String>, Option<Error>), Error> {
    let run = RunFiles::read_for_page(run)?;
    let other = other.map(RunFiles::read_for_page).transpose()?;
    let damage = run.damage().or(other.as_ref().and_then(RunFiles::damage));
    let damage = damage.or_else(|| run.field_damage());
    let sections = sections(&run, other.as_ref().as_slice(), front)?;
    let mut names = Vec::new();
    let mut known = HashSet::new();
    for picture in sections.iter().flat_map(Section::pictures) {
        if known.insert(&picture.file) {
            save(&run.path.join(&picture.file), &page::accessible(picture))?;
            names.push(picture.file.clone());
        }
    }
    let verdict = verdict::verdict(&run, damage.as_ref());
    let html = page::page(run.text("scenario"), &verdict, &sections);
    save(&run.path.join("report.html"), &html)?;
    names.push("report.html".into());
    Ok((names, damage))
}

/// The pictures of a run's report with these file names, with the curves of another run if it is given, as a section without words.
///
/// # Errors
/// A file of a run is damaged.
pub fn pictures(
    run: &RunFiles,
    other: Option<&RunFiles>,
    files: &[String],
) -> Result<Section, Error> {
    let mut chosen = Section::default();
    for section in sections(run, other.as_slice(), None)? {
        chosen.maps.extend(section.maps);
        chosen.plots.extend(section.plots);
    }
    let asked = |picture: &Picture| files.contains(&picture.file);
    chosen.maps.retain(asked);
    chosen.plots.retain(asked);
    Ok(chosen)
}

/// Writes a file of a page.
///
/// # Errors
/// The file cannot be written.
pub fn save(path: &Path, text: &str) -> Result<(), Error> {
    std::fs::write(path, text).map_err(Error::output(path.display()))
}

/// A paragraph for a run whose fields are VTKHDF files, which a report does not read.
fn unread_fields(run: &RunFiles) -> String {
    if run.field_files(".vtkhdf").is_empty() {
        return String::new();
    }
    "<p>The fields are VTKHDF files, which a report does not read: their pictures are left out. ParaView opens them; with <code>run.output.fields_format = \"vtk-xml\"</code> the report draws them.</p>".into()
}

/// The sections for which the run has content.
fn sections(
    run: &RunFiles,
    others: &[&RunFiles],
    front: Option<&MeasuredFront>,
) -> Result<Vec<Section>, Error> {
    let names = match others {
        [other] => vec![name(other)],
        // The first name represents all in legends.
        _ => Vec::from_iter(others.iter().enumerate().map(|(k, _)| match k {
            0 => "other seeds".to_string(),
            _ => String::new(),
        })),
    };
    let signals = others.iter().map(|other| curves::signals(other));
    let signals = signals.collect::<Result<Vec<_>, Error>>()?;
    let tables = Tables {
        own: curves::signals(run)?,
        others: signals.into_iter().zip(names.clone()).collect(),
    };
    let beside = match others {
        [other] => compare::distances(run, other)?,
        _ => String::new(),
    };
    let named = Vec::from_iter(others.iter().copied().zip(names));
    let charts =
        |title, charts: Vec<_>| Section::of_pictures(title, Vec::new(), plots(&tables, &charts));
    let mut all = vec![
        Section::of_text("Verdict", verdict::judged(run)),
        Section::of_text("Compared with another run", beside),
        Section::of_text("Provenance", provenance::provenance(run)),
        Section {
            maps: scene(run)?,
            ..Section::of_text("Scene", unread_fields(run))
        },
        Section::of_pictures(
            "Load, friction and contact",
            body::status(run)?,
            contact(run, &tables, &named),
        ),
        Section::of_pictures("Third body", third_body(run)?, layer(run, &tables)),
        charts("Interfaces", ledger::interfaces(run)),
        charts("Energies", ledger::energies(run)),
        Section::of_text("Steps against their bounds", verdict::steps(run)),
        Section {
            maps: Vec::from_iter(times::times(run)),
            ..Section::of_text("Where the time went", provenance::processes(run))
        },
        front::section(run, front),
        Section::of_text("Results", results::grouped(run)),
    ];
    all.retain(|section| !section.is_empty());
    Ok(all)
}

/// Name of a run in legends: its directory's, or its scenario's if the directory is called `run`, as many are.
fn name(run: &RunFiles) -> String {
    let name = run.path.file_name().filter(|name| *name != "run");
    let name = name.map(|name| name.to_string_lossy().into_owned());
    name.unwrap_or_else(|| run.text("scenario").into())
}

fn scene(run: &RunFiles) -> Result<Vec<Picture>, Error> {
    let mut maps = Vec::from_iter(scene::contact(run)?);
    maps.extend(bodies::first_and_third(run)?);
    let bodies = body::pressures(run)?;
    // A single body without grains is its own scene.
    let own = bodies.len() == 1 && maps.iter().all(|scene| !scene.caption.contains("grains"));
    if !own {
        maps.extend(bodies);
    }
    maps.extend(grains::pressure(run)?);
    Ok(maps)
}

fn contact(run: &RunFiles, tables: &Tables, others: &[(&RunFiles, String)]) -> Vec<Picture> {
    let mut all = plots(tables, &curves::wheel());
    all.extend(plots(tables, &[ledger::reactions(&tables.own)]));
    all.extend(plots(tables, &ledger::loops(&tables.own)));
    all.extend(curves::traction(run, others));
    all.extend(rolled::traction(run));
    all.extend(plots(tables, &[curves::sliding()]));
    all.extend(curves::sliding_over_velocity(&tables.own));
    all
}

fn third_body(run: &RunFiles) -> Result<Vec<Picture>, Error> {
    let mut maps = chains::chains(run)?;
    maps.extend(arrows::at_last(run)?);
    maps.extend(arrows::displacements(run)?);
    maps.extend(circuit::circuit(&run.summary));
    Ok(maps)
}

fn layer(run: &RunFiles, tables: &Tables) -> Vec<Picture> {
    let mut all = plots(tables, &ledger::third_body());
    all.extend(curves::cycle_flows(run));
    all.extend(profiles::profiles(run));
    all
}
