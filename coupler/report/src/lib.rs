//! `report.html` with its pictures, made from what a run left in its directory.
//!
//! - [`run`]: its files; [`tables`]: their tables; `fields`: the VTK files of the participants;
//! - `page`: sections, tables and pictures as one file; `picture`: a picture; `units`: numbers as people read them;
//! - `verdict`: how the run ended, balances, warnings, steps against their bounds; `provenance`: where it comes from;
//! - `results`: the results, explained by `RESULTS.md`; `compare`: a run beside another one;
//! - `view`: a part of the scene on a page; `colour`: the scale of maps; `axis`: places of labels;
//! - `scene`: grains and continuum around the contact, coloured by pressure;
//! - `body`: the whole continuum, and which of its nodes stick;
//! - `grains`: pressure in the cells of the grains' stress; `arrows`: their velocities and displacements; `chains`: their forces;
//! - [`movie`]: `movie.html`, a player of all moments;
//! - `circuit`: the flows of third body; `times`: where the time went;
//! - `plot`: curves over axes; `curves`: loads, friction, sliding nodes, traction; `ledger`: interfaces, energies, bonds, flows.

use std::collections::HashSet;
use std::path::Path;

use coordinator::error::Error;
use curves::{Chart, Tables};
use draw::picture::Picture;
use page::Section;
use runs::files::RunFiles;

mod arrows;
mod body;
mod chains;
mod circuit;
mod compare;
mod curves;
mod grains;
mod ledger;
pub mod movie;
mod page;
mod provenance;
mod results;
mod scene;
mod times;
mod units;
mod verdict;
pub(crate) mod view;

/// Writes the pictures and `report.html` into a run directory, laid over those of another run where one is given; returns the names of
/// the files.
///
/// # Errors
/// A file of a run is missing or damaged, or one cannot be written.
pub fn write(run: &Path, other: Option<&Path>) -> Result<Vec<String>, Error> {
    let run = RunFiles::read(run)?;
    let other = other.map(RunFiles::read).transpose()?;
    let sections = sections(&run, other.as_ref())?;
    let mut names = Vec::new();
    let mut known = HashSet::new();
    for picture in sections.iter().flat_map(Section::pictures) {
        if known.insert(&picture.file) {
            save(&run.path.join(&picture.file), &page::accessible(picture))?;
            names.push(picture.file.clone());
        }
    }
    let html = page::page(run.text("scenario"), &verdict::verdict(&run), &sections);
    save(&run.path.join("report.html"), &html)?;
    names.push("report.html".into());
    Ok(names)
}

fn save(path: &Path, text: &str) -> Result<(), Error> {
    std::fs::write(path, text).map_err(Error::output(path.display()))
}

/// The sections that the run has something for.
fn sections(run: &RunFiles, other: Option<&RunFiles>) -> Result<Vec<Section>, Error> {
    let own = curves::signals(run);
    let others = other.map(|other| (curves::signals(other), name(other)));
    let tables = Tables {
        own: &own,
        other: others
            .as_ref()
            .map(|(columns, name)| (columns, name.clone())),
    };
    let mut all = vec![judged(run)];
    if let Some(other) = other {
        all.push(Section {
            text: compare::distances(run, other)?,
            ..Section::new("Beside another run")
        });
    }
    all.push(Section {
        text: provenance::provenance(run),
        ..Section::new("Provenance")
    });
    all.push(scene(run)?);
    all.push(contact(run, &tables, other)?);
    all.push(third_body(run, &tables)?);
    all.push(Section {
        plots: plots(&tables, ledger::interfaces(run)),
        ..Section::new("Interfaces")
    });
    all.push(Section {
        plots: plots(&tables, ledger::energies(run)),
        ..Section::new("Energies")
    });
    all.push(Section {
        text: verdict::steps(run).unwrap_or_default(),
        ..Section::new("Steps against their bounds")
    });
    all.push(Section {
        text: provenance::processes(run),
        maps: times::bars(run).into_iter().collect(),
        ..Section::new("Where the time went")
    });
    all.push(Section {
        text: results::grouped(run),
        ..Section::new("Results")
    });
    all.retain(|section| !section.is_empty());
    Ok(all)
}

/// Name of a run in legends: that of its directory.
fn name(run: &RunFiles) -> String {
    let name = run
        .path
        .file_name()
        .map(|name| name.to_string_lossy().into_owned());
    name.unwrap_or_else(|| run.text("scenario").into())
}

fn judged(run: &RunFiles) -> Section {
    let mut text =
        verdict::warned(run).map_or(String::new(), |table| format!("<h3>Warnings</h3>{table}"));
    text += "<h3>Balances</h3>";
    text += &verdict::balances(run);
    Section {
        text,
        ..Section::new("Verdict")
    }
}

fn scene(run: &RunFiles) -> Result<Section, Error> {
    let mut maps = Vec::from_iter(scene::contact(run)?);
    let bodies = body::pressures(run)?;
    // A single body without grains is its own scene.
    let own = bodies.len() == 1 && maps.iter().all(|scene| !scene.caption.contains("grains"));
    if !own {
        maps.extend(bodies);
    }
    maps.extend(grains::pressure(run)?);
    Ok(Section {
        maps,
        ..Section::new("Scene")
    })
}

fn contact(run: &RunFiles, tables: &Tables, other: Option<&RunFiles>) -> Result<Section, Error> {
    let mut all = plots(tables, curves::wheel());
    all.extend(plots(tables, ledger::reactions(tables.own)));
    all.extend(curves::traction(
        run,
        other.map(|other| (other, name(other))),
    ));
    all.extend(plots(tables, vec![curves::sliding()]));
    all.extend(curves::sliding_over_velocity(tables.own));
    Ok(Section {
        maps: body::status(run)?,
        plots: all,
        ..Section::new("Load, friction and contact")
    })
}

fn third_body(run: &RunFiles, tables: &Tables) -> Result<Section, Error> {
    let mut maps = chains::chains(run)?;
    maps.extend(arrows::velocities(run)?);
    maps.extend(arrows::moved(run)?);
    maps.extend(arrows::displacements(run)?);
    maps.extend(circuit::drawn(&run.summary)?);
    Ok(Section {
        maps,
        plots: plots(tables, ledger::third_body()),
        ..Section::new("Third body")
    })
}

/// The charts whose signals the run has.
fn plots(tables: &Tables, charts: Vec<Chart>) -> Vec<Picture> {
    let drawn = charts
        .iter()
        .filter_map(|chart| curves::drawn(tables, chart));
    drawn.collect()
}
