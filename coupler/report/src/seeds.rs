//! Runs of one scene with different seeds: the mean of each result with its 95 % interval, and a page that overlays the runs.

use std::path::{Path, PathBuf};

use super::page::{Section, accessible, page, table};
use super::results::groups;
use super::terminal::chosen;
use super::{save, sections};
use draw::axis::range;
use draw::svg::escape;
use draw::units::with_unit_of;
use kit::student::mean_of;
use runs::files::RunFiles;
use scenario::error::Error;

/// A result over the seeds.
#[derive(Clone, Debug)]
pub struct SeedMean {
    /// Name of the result.
    pub name: String,
    /// Its meaning, in a sentence.
    pub sentence: String,
    /// Value in each run that has the result.
    pub values: Vec<f64>,
    /// Mean of the values.
    pub mean: f64,
    /// Half of the 95 % interval of the mean, Student's t s / sqrt(n).
    pub half_width: f64,
}

/// The results that at least two of these runs have, in the order of the report.
pub fn means(runs: &[RunFiles]) -> Vec<SeedMean> {
    let all = runs.first().map(groups).unwrap_or_default();
    let results = all.iter().flat_map(|group| &group.results);
    let means = results.filter_map(|(name, _, sentence)| {
        let of = |run: &RunFiles| run.summary["results"][name].as_f64();
        let values: Vec<f64> = runs.iter().filter_map(of).collect();
        let [mean, _, half_width] = mean_of(&values)?;
        Some(SeedMean {
            name: name.to_string(),
            sentence: sentence.clone(),
            values,
            mean,
            half_width,
        })
    });
    means.collect()
}

impl SeedMean {
    /// Mean, half-width of the interval, lowest and highest value, with their unit.
    fn numbers(&self) -> [String; 4] {
        let [low, high] = range(self.values.iter().copied()).unwrap_or_default();
        [self.mean, self.half_width, low, high].map(|x| with_unit_of(&self.name, x))
    }
}

/// The means for a terminal, one per line: all of them, or the most important ones with their meanings.
pub fn lines(means: &[SeedMean], all: bool) -> Vec<String> {
    let shown = if all {
        means.iter().collect()
    } else {
        chosen(means, |mean| &mean.name)
    };
    let line = |of: &&SeedMean| {
        let [mean, half_width, low, high] = of.numbers();
        let sentence = if all { "" } else { &of.sentence };
        let text = format!(
            "  {:<30} {mean:>12} ± {half_width:<12} {low} to {high}  {sentence}",
            of.name
        );
        text.trim_end().to_string()
    };
    shown.iter().map(line).collect()
}

/// Writes `report.html` and its pictures into a folder: means over these runs, and their overlaid curves with the first run in front.
/// Returns the path of the page.
///
/// # Errors
/// A file of a run is missing or damaged, or a file cannot be written.
pub fn write(
    folder: &Path,
    title: &str,
    runs: &[RunFiles],
    means: &[SeedMean],
) -> Result<PathBuf, Error> {
    let (first, others) = runs.split_first().expect("at least two runs");
    let mut all = sections(first, &Vec::from_iter(others), None)?;
    for section in &mut all {
        if section.title == "Provenance" {
            section.title += " of the first run";
        }
    }
    let of_one = ["Verdict", "Compared with another run", "Results"];
    all.retain(|section| !of_one.contains(&&*section.title));
    let rows = means.iter().map(|of| {
        let name = format!("<code>{}</code>", escape(&of.name));
        let [mean, half_width, low, high] = of.numbers().map(|text| escape(&text));
        let (runs, sentence) = (of.values.len().to_string(), escape(&of.sentence));
        [name, mean, half_width, low, high, runs, sentence]
    });
    let head = [
        "result",
        "mean",
        "± (95 %)",
        "lowest",
        "highest",
        "runs",
        "",
    ];
    let text = table(head, &[1, 2, 3, 4, 5], rows);
    all.insert(0, Section::of_text("Means over the seeds", text));
    for picture in all.iter().flat_map(Section::pictures) {
        save(&folder.join(&picture.file), &accessible(picture))?;
    }
    let verdict = format!(
        "<div class=\"verdict completed\" role=\"status\"><p><strong>{} runs with different seeds.</strong></p><p>Each run is one random realisation. The curves of the first run are in front of the others; maps show only the first run.</p></div>",
        runs.len()
    );
    let path = folder.join("report.html");
    save(&path, &page(title, &verdict, &all))?;
    Ok(path)
}
