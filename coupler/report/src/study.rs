//! The page of a study, made from the files that `study run` and `study collect` wrote: the study file, tables, pictures, warnings.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::page::{Section, page, table};
use super::save;
use draw::picture::Picture;
use draw::svg::escape;
use draw::units::four;
use runs::files::read_json;
use scenario::error::{Error, Refusal};

/// Largest number of table rows on the page; the file has the others.
const MANY: usize = 500;

/// Files of pictures, with their captions.
const PICTURES: [[&str; 2]; 5] = [
    [
        "curves.svg",
        "Means over the scenes, with 95 % intervals, over another measure",
    ],
    [
        "means.svg",
        "Means over the scenes, with 95 % intervals; pale: single scenes",
    ],
    [
        "maps.svg",
        "Means over two keys, and half-widths of their 95 % intervals",
    ],
    [
        "front.svg",
        "Error over cost; the front joins the settings that no other setting beats in both",
    ],
    ["knobs.svg", "Error along the values of each key"],
];

/// Columns of results.csv that the page leaves out.
const HIDDEN: &str = "id exit_code attempts peak_rss_bytes element_steps contact_iterations messages hash_exchange hash_state message";

/// A table of comma-separated cells: head and rows.
struct Cells(Vec<String>, Vec<Vec<String>>);

/// Writes `report.html` into the folder of a study; returns its path.
///
/// # Errors
/// The folder has no results.csv, or the page cannot be written.
pub fn write(folder: &Path) -> Result<PathBuf, Error> {
    let read = |file: &str| std::fs::read_to_string(folder.join(file));
    let Ok(results) = read("results.csv") else {
        let problem = "has no results.csv: give the folder of a study, such as runs/study-NAME, after `study run` or `study collect`";
        return Err(Refusal::file(folder, problem).into());
    };
    let mut rows = results.lines().map(cells);
    let results = Cells(rows.next().unwrap_or_default(), rows.collect());
    let text = |file: &str| format!("<pre>{}</pre>", escape(&read(file).unwrap_or_default()));
    let pictures = PICTURES.iter().filter_map(|[file, caption]| {
        Some(Picture {
            file: file.to_string(),
            caption: caption.to_string(),
            alternative: "The numbers are below, in words.".into(),
            svg: read(file).ok()?,
        })
    });
    let texts = ["warnings", "message"];
    let warns = |row: &[String]| texts.iter().any(|k| !results.cell(row, k).is_empty());
    let warning = |name: &str| ["index", "status", "warnings", "message"].contains(&name);
    let is_shown = |name: &str| !HIDDEN.split(' ').any(|hidden| hidden == name);
    let mut sections = vec![
        Section::of_text("Warnings", results.html(warns, warning)),
        Section::of_text("Settings", text("settings.toml")),
        Section::of_pictures("Pictures", pictures.collect(), Vec::new()),
        Section::of_text("In words", text("digest.txt")),
        Section::of_text("Runs", results.html(|_| true, is_shown)),
    ];
    sections.retain(|section| !section.is_empty());
    let name = folder.canonicalize().unwrap_or(folder.into());
    let name = name.file_name().unwrap_or_default().to_string_lossy();
    let path = folder.join("report.html");
    save(&path, &page(&name, &results.verdict(folder), &sections))?;
    Ok(path)
}

impl Cells {
    /// The cell of a row in this column; empty if the table lacks the column.
    fn cell<'a>(&self, row: &'a [String], name: &str) -> &'a str {
        let column = self.0.iter().position(|head| head == name);
        column.and_then(|k| row.get(k)).map_or("", |cell| cell)
    }

    /// These rows and columns as a table; numbers have four digits.
    fn html(&self, row: impl Fn(&[String]) -> bool, column: impl Fn(&str) -> bool) -> String {
        let columns: Vec<&String> = self.0.iter().filter(|name| column(name)).collect();
        let head: Vec<String> = columns.iter().map(|name| escape(name)).collect();
        let head: Vec<&str> = head.iter().map(String::as_str).collect();
        let shown = |cell: &str| cell.parse().map_or(escape(cell), four);
        let rows = self.1.iter().filter(|cells| row(cells)).take(MANY);
        let cells = |row: &Vec<String>| {
            let cells = columns.iter().map(|name| shown(self.cell(row, name)));
            Vec::from_iter(cells)
        };
        match table(head, &[], rows.map(cells)) {
            rows if rows.is_empty() => rows,
            rows => format!("<div style=\"overflow-x:auto\">{rows}</div>"),
        }
    }

    /// The box at the top: number of runs per ending, and the builds that made them.
    fn verdict(&self, folder: &Path) -> String {
        let mut counts: [BTreeMap<String, usize>; 2] = Default::default();
        for row in &self.1 {
            let path = folder.join("tasks").join(self.cell(row, "id")).join("run");
            let manifest = read_json(&path.join("manifest.json"));
            let made = ["software", "build", "git"].map(|key| manifest[key].as_str());
            let build = match made {
                [Some(software), Some(build), Some(git)] => {
                    format!("by {software}, build {build}, git {git}")
                }
                _ => "missing".into(),
            };
            let warned = match self.cell(row, "warnings") {
                "" => "",
                _ => " with warnings",
            };
            let ended = format!("{}{warned}", self.cell(row, "status"));
            *counts[0].entry(ended).or_default() += 1;
            *counts[1].entry(build).or_default() += 1;
        }
        let class = ["suspect", "completed"][usize::from(counts[0].keys().eq(["completed"]))];
        let [ended, builds] = counts.map(|counts| {
            let all = counts.into_iter();
            let all = all.map(|(name, count)| format!("{count} {}", escape(&name)));
            Vec::from_iter(all).join(", ")
        });
        let count = self.1.len();
        format!(
            "<div class=\"verdict {class}\" role=\"status\"><p><strong>{count} runs: {ended}.</strong></p><p>Measured: {builds}.</p></div>"
        )
    }
}

/// The cells of a line (RFC 4180): within quotes a comma is a character, and two quotes stand for one.
fn cells(line: &str) -> Vec<String> {
    let line = line.replace("\"\"", "\u{1}");
    let parts = line.split('"').enumerate().map(|(k, part)| match k % 2 {
        0 => part.to_string(),
        _ => part.replace(',', "\u{2}"),
    });
    let line = Vec::from_iter(parts).concat();
    let cell = |cell: &str| cell.replace('\u{1}', "\"").replace('\u{2}', ",");
    line.split(',').map(cell).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::scratch::Scratch;

    #[test]
    fn cells_are_read_as_they_were_written() {
        assert_eq!(cells("1,\"a, \"\"b\"\"\",,2"), ["1", "a, \"b\"", "", "2"]);
    }

    #[test]
    fn the_page_has_settings_pictures_warnings_and_the_build() {
        let scratch = Scratch::new("study-page", 1);
        let put = |file: &str, text: &str| {
            let path = scratch.path().join(file);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("writable");
            std::fs::write(path, text).expect("writable");
        };
        assert!(write(scratch.path()).is_err());
        put(
            "results.csv",
            "index,id,status,exit_code,attempts,law.friction,value_p,wall_s,cpu_s,message,role,warnings\n0,a,completed,0,1,0.3,1.25e9,2,3,,point,\n1,b,suspect,8,1,<b>,,2,3,why,point,numerical\n",
        );
        put("settings.toml", "[study]\nname = \"<i>\"\n");
        put("means.svg", "<svg width=\"3\"><path/></svg>");
        put(
            "tasks/a/run/manifest.json",
            "{\"software\": \"thirdbody 1\", \"build\": \"c0de\", \"git\": \"beef\"}",
        );
        let path = write(scratch.path()).expect("a study");
        let html = std::fs::read_to_string(path).expect("a page");
        for words in [
            "2 runs: 1 completed, 1 suspect with warnings.",
            "1 by thirdbody 1, build c0de, git beef",
            "name = &quot;&lt;i&gt;&quot;",
            "Figure 1: Means over the scenes",
            "<td>1.250e9</td>",
            "law.friction",
            "<td>why</td><td>numerical</td>",
        ] {
            assert!(html.contains(words), "{words}: {html}");
        }
        assert!(!html.contains("<b>") && !html.contains("maps.svg\""));
    }
}
