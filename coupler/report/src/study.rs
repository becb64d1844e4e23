//! The page of a study, made from what `study run` and `study collect` left in its folder: the study file, tables, pictures, warnings.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::page::{Section, page, table};
use draw::picture::Picture;
use draw::svg::escape;
use draw::units::four;
use runs::files::RunFiles;
use scenario::error::{Error, Refusal};

/// Rows of a table that the page shows before it counts the rest.
const MANY: usize = 500;

/// Files of pictures, and what each shows.
const PICTURES: [[&str; 2]; 4] = [
    [
        "means.svg",
        "What was measured over the key with most values, a line for each choice of the other keys; bars: 95 % intervals of means over the scenes, pale: single scenes. Numbers: `means.csv`.",
    ],
    [
        "maps.svg",
        "Means over two keys, below each half of its 95 % interval. Numbers: `means.csv`.",
    ],
    [
        "front.svg",
        "Error over cost of each setting; the front joins those that no other beats in both. Numbers: `front.csv`.",
    ],
    [
        "knobs.svg",
        "Error along the values of each key, the other keys in the middle. Numbers: `digest.txt`.",
    ],
];

/// Columns of results.csv that the page shows beside the keys, by their beginnings.
const SHOWN: [&str; 4] = ["error_", "value_", "cpu_s", "warnings"];

/// A table of comma-separated cells.
struct Cells {
    head: Vec<String>,
    rows: Vec<Vec<String>>,
}

/// Writes `report.html` into the folder of a study; returns its path.
///
/// # Errors
/// The folder has no results.csv, or the page cannot be written.
pub fn write(folder: &Path) -> Result<PathBuf, Error> {
    let Some(results) = Cells::read(folder, "results.csv") else {
        let problem = "holds no results.csv: give the folder of a study, such as runs/study-NAME, after `study run` or `study collect`";
        return Err(Refusal::file(folder, problem).into());
    };
    let text = |file: &str| {
        let text = std::fs::read_to_string(folder.join(file)).unwrap_or_default();
        match text.trim() {
            "" => text,
            text => format!("<pre>{}</pre>", escape(text)),
        }
    };
    let pictures = PICTURES.iter().filter_map(|[file, caption]| {
        Some(Picture {
            file: file.to_string(),
            caption: caption.to_string(),
            alternative: "The numbers are in the tables of this page.".into(),
            svg: std::fs::read_to_string(folder.join(file)).ok()?,
        })
    });
    let tables = ["means.csv", "front.csv"].map(|file| {
        let shown = Cells::read(folder, file).map(|cells| cells.html(|_| true));
        shown.map_or(String::new(), |html| format!("<h3>{file}</h3>{html}"))
    });
    let keys = results.keys();
    let is_shown = |name: &str| {
        let name = name.to_string();
        ["index", "status", "role"].contains(&&*name)
            || keys.contains(&name)
            || SHOWN.iter().any(|start| name.starts_with(start))
    };
    let mut sections = vec![
        Section::of_text("Warnings", results.warned()),
        Section::of_text("Settings", text("settings.toml")),
        Section::of_pictures("Pictures", pictures.collect(), Vec::new()),
        Section::of_text("In words", text("digest.txt")),
        Section::of_text("Tables", tables.concat()),
        Section::of_text("Runs", results.html(is_shown)),
    ];
    sections.retain(|section| !section.is_empty());
    let absolute = folder.canonicalize().unwrap_or(folder.into());
    let name = absolute.file_name().unwrap_or_default().to_string_lossy();
    let path = folder.join("report.html");
    let html = page(&name, &results.verdict(folder), &sections);
    std::fs::write(&path, html).map_err(Error::output(path.display()))?;
    Ok(path)
}

impl Cells {
    fn read(folder: &Path, file: &str) -> Option<Cells> {
        let text = std::fs::read_to_string(folder.join(file)).ok()?;
        let mut rows = text.lines().map(cells);
        let head = rows.next()?;
        Some(Cells {
            head,
            rows: rows.collect(),
        })
    }

    /// The cell of a row in this column; empty where there is none.
    fn cell<'a>(&self, row: &'a [String], name: &str) -> &'a str {
        let column = self.head.iter().position(|head| head == name);
        column
            .and_then(|column| row.get(column))
            .map_or("", |cell| cell)
    }

    /// The columns between `attempts` and what was measured: the keys.
    fn keys(&self) -> Vec<String> {
        let after = self
            .head
            .iter()
            .skip_while(|name| *name != "attempts")
            .skip(1);
        let measured = ["error_", "value_", "wall_s"];
        let keys = after.take_while(|name| !measured.iter().any(|start| name.starts_with(start)));
        keys.cloned().collect()
    }

    /// A table of the columns that are to be shown and have anything in them; numbers have four digits.
    fn html(&self, is_shown: impl Fn(&str) -> bool) -> String {
        let any = |k: usize| {
            self.rows
                .iter()
                .any(|row| row.get(k).is_some_and(|cell| !cell.is_empty()))
        };
        let columns = 0..self.head.len();
        let columns: Vec<usize> = columns
            .filter(|k| is_shown(&self.head[*k]) && any(*k))
            .collect();
        let head: Vec<String> = columns.iter().map(|k| escape(&self.head[*k])).collect();
        let head: Vec<&str> = head.iter().map(String::as_str).collect();
        let shown = |cell: &String| cell.parse().map_or(escape(cell), four);
        let rows = self.rows.iter().take(MANY).map(|row| {
            let cells = columns
                .iter()
                .map(|k| row.get(*k).map_or(String::new(), shown));
            cells.collect::<Vec<String>>()
        });
        let rest = match self.rows.len().saturating_sub(MANY) {
            0 => String::new(),
            rest => format!("<p>and {rest} more, in the file</p>"),
        };
        table(head, &[], rows) + &rest
    }

    /// The runs that warned of something, failed, or miss a number.
    fn warned(&self) -> String {
        let rows = self.rows.iter().map(|row| {
            ["index", "status", "warnings", "message"].map(|name| escape(self.cell(row, name)))
        });
        let warned =
            rows.filter(|[_, _, warnings, message]| !(warnings.is_empty() && message.is_empty()));
        table(["run", "status", "warnings", ""], &[0], warned.take(MANY))
    }

    /// The box at the top: how many runs ended how, and the builds that made them.
    fn verdict(&self, folder: &Path) -> String {
        let mut ended: BTreeMap<&str, usize> = BTreeMap::new();
        let mut builds: BTreeMap<String, usize> = BTreeMap::new();
        for row in &self.rows {
            *ended.entry(self.cell(row, "status")).or_default() += 1;
            let path = folder.join("tasks").join(self.cell(row, "id")).join("run");
            let manifest = RunFiles {
                path,
                ..RunFiles::default()
            }
            .manifest();
            let [software, build, git] =
                ["software", "build", "git"].map(|key| manifest[key].as_str().unwrap_or_default());
            if !build.is_empty() {
                *builds
                    .entry(format!("{software}, build {build}, git {git}"))
                    .or_default() += 1;
            }
        }
        let warned = self
            .rows
            .iter()
            .filter(|row| !self.cell(row, "warnings").is_empty())
            .count();
        let class = match (ended.keys().all(|status| *status == "completed"), warned) {
            (true, 0) => "completed",
            _ => "suspect",
        };
        let counted = |all: Vec<(String, usize)>| {
            let all = all
                .into_iter()
                .map(|(name, count)| format!("{count} {}", escape(&name)));
            Vec::from_iter(all).join(", ")
        };
        let ended = counted(
            ended
                .into_iter()
                .map(|(name, count)| (name.into(), count))
                .collect(),
        );
        let builds = counted(
            builds
                .into_iter()
                .map(|(name, count)| (format!("by {name}"), count))
                .collect(),
        );
        format!(
            "<div class=\"verdict {class}\" role=\"status\"><p><strong>{} runs: {ended}; {warned} with warnings.</strong></p><p>Measured: {builds}.</p></div>",
            self.rows.len()
        )
    }
}

/// The cells of a line, as RFC 4180 has them; no cell of a study holds a line break.
fn cells(line: &str) -> Vec<String> {
    let mut all = vec![String::new()];
    let (mut quoted, mut closed) = (false, false);
    for letter in line.chars() {
        let last = all.len() - 1;
        match letter {
            '"' => {
                // A mark that follows the end of a quotation is part of it.
                if closed {
                    all[last].push('"');
                }
                quoted = !quoted;
                closed = !quoted;
                continue;
            }
            ',' if !quoted => all.push(String::new()),
            _ => all[last].push(letter),
        }
        closed = false;
    }
    all
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
            "2 runs: 1 completed, 1 suspect; 1 with warnings.",
            "1 by thirdbody 1, build c0de, git beef",
            "name = &quot;&lt;i&gt;&quot;",
            "Figure 1: What was measured",
            "<td>1.250e9</td>",
            "law.friction",
            "<td>numerical</td><td>why</td>",
        ] {
            assert!(html.contains(words), "{words}: {html}");
        }
        assert!(!html.contains("<b>") && !html.contains("maps.svg\""));
    }
}
