//! The digest of a study: fronts, knees, a sentence for each key, failures and unknowns; without a reference, the measured values of each
//! setting.

use std::fmt::Write as _;

use super::collect::{Results, cell, line};
use super::curves;
use super::ensemble::{self, EnsembleMean, ensemble};
use super::front::{MeasureFront, Trade, front, knee};
use super::measure::percent;
use super::picture;
use super::settings::{StudySetting, settings};
use super::varied_keys::{VariedKey, varied_keys};
use runs::curve::median;

/// A study in words and pictures.
#[derive(Clone, Debug)]
pub struct Digest<'a> {
    results: &'a Results<'a>,
    settings: Vec<StudySetting<'a>>,
    fronts: Vec<MeasureFront>,
    keys: Vec<VariedKey>,
    measures: Vec<String>,
    means: Vec<EnsembleMean>,
}

impl<'a> Digest<'a> {
    /// The digest of these rows.
    pub fn new(results: &'a Results<'a>) -> Digest<'a> {
        let settings = settings(results);
        let measures = results.file.measure.iter().map(|m| m.name.clone());
        let measures: Vec<String> = measures.collect();
        let keys = varied_keys(results, &settings);
        // The reference has no measured error and takes no part.
        let stands = |of: &StudySetting| of.is_trusted() && !of.is_reference(results);
        let fronts = measures.iter().enumerate().map(|(index, name)| {
            let trade = |setting: usize, error: Option<f64>| {
                let cost = settings[setting].price().filter(|cost| *cost > 0.0)?;
                Some(Trade::new(setting, cost, error?))
            };
            let all = || settings.iter().enumerate();
            let trades = all().filter(|(_, of)| stands(of));
            let trades = trades.filter_map(|(k, of)| trade(k, of.errors(index).and_then(median)));
            let trades: Vec<Trade> = trades.collect();
            let distance = |of: &StudySetting| of.middle(|row| row.distance(index));
            let fallen = all().filter(|(_, of)| !of.is_trusted());
            let fallen = fallen.filter_map(|(k, of)| trade(k, distance(of)));
            let front = front(&trades);
            MeasureFront {
                measure: name.clone(),
                fallen: fallen.collect(),
                knee: knee(&front),
                front,
                trades,
                floor: keys.first().map_or(0.0, |key| key.floors[index]),
            }
        });
        Digest {
            results,
            fronts: fronts.collect(),
            settings,
            keys,
            measures,
            means: ensemble(results),
        }
    }

    /// means.csv: means over the scenes with their intervals, if there are any.
    pub fn means_csv(&self) -> Option<String> {
        (!self.means.is_empty()).then(|| ensemble::csv(&self.means))
    }

    /// front.csv: the fronts of all measures, cheapest first, if there is a reference.
    pub fn front_csv(&self) -> Option<String> {
        let mut lines = line(&["measure", "setting", "cost", "error", "floor", "knee"]);
        for of in &self.fronts {
            for (index, trade) in of.front.iter().enumerate() {
                lines += &line(&[
                    of.measure.clone(),
                    self.settings[trade.setting].words(self.results),
                    cell(Some(trade.cost)),
                    cell(Some(trade.error)),
                    cell(Some(of.floor)),
                    of.mark(index, "knee"),
                ]);
            }
        }
        self.is_held().then_some(lines)
    }

    /// True if there is a reference: without one there are no errors, and no trade-off.
    fn is_held(&self) -> bool {
        self.results.file.reference.is_given()
    }

    /// front.svg and knobs.svg if there is a reference; with several scenes, or without a reference, means.svg, and maps.svg over two keys.
    pub fn pictures(&self) -> Vec<(&'static str, String)> {
        let mut pictures = Vec::new();
        if self.is_held() {
            let fronts = picture::fronts(&self.fronts, &self.settings, self.results);
            let keys = picture::knobs(&self.keys, &self.measures);
            pictures.extend([("front.svg", fronts), ("knobs.svg", keys)]);
        }
        if !self.means.is_empty() {
            let keys = &self.results.file.vary;
            pictures.push(("means.svg", picture::means(&self.means, keys)));
            let maps = picture::maps(&self.means, keys);
            pictures.extend(maps.map(|maps| ("maps.svg", maps)));
            let curves = curves::curves(&self.means, &self.results.file.curve);
            pictures.extend(curves.map(|curves| ("curves.svg", curves)));
        }
        pictures
    }

    /// The whole digest in words.
    pub fn text(&self) -> String {
        let mut text = String::new();
        if self.is_held() {
            self.trades(&mut text);
        }
        if !self.means.is_empty() {
            let scenes = self.settings.iter().any(|setting| setting.rows.len() > 1);
            let head = if scenes {
                "means over the scenes, with 95 % intervals"
            } else {
                "values"
            };
            let _ = writeln!(text, "\n{head}");
            let line = |of: &EnsembleMean| format!("  {}: {}\n", of.name, of.words());
            text.extend(self.means.iter().map(line));
        }
        let lines: Vec<String> = self.fallen().collect();
        if !lines.is_empty() {
            let head = if self.is_held() {
                "not on the fronts, or to be read with care"
            } else {
                "left out, or to be read with care"
            };
            let _ = writeln!(text, "\n{head}");
            text.extend(lines.iter().map(|line| format!("  {line}\n")));
        }
        text.trim_end().to_string()
    }

    /// Fronts, and the cost and error of each key.
    fn trades(&self, text: &mut String) {
        for of in &self.fronts {
            let floor = self.results.file.reference.floor_words(of.floor);
            let name = &of.measure;
            let _ = writeln!(text, "\nfront of error_{name} (floor of noise {floor})");
            let _ = writeln!(text, "  {:>10}  {:>10}  setting", "cost", "error %");
            for (index, trade) in of.front.iter().enumerate() {
                let words = self.settings[trade.setting].words(self.results);
                let mark = of.mark(index, "  <- knee");
                let error = percent(trade.error);
                let _ = writeln!(text, "  {:>10.4}  {error:>10}  {words}{mark}", trade.cost);
            }
        }
        let unit = match self.results.reference(0) {
            Some(_) => "relative to the reference",
            None => "in seconds",
        };
        let _ = writeln!(text, "\ncost is processor time {unit}");
        let _ = writeln!(text, "\nknobs");
        for key in &self.keys {
            for line in key.lines(&self.measures) {
                let _ = writeln!(text, "  {line}");
            }
            for line in key.trends(&self.measures) {
                let _ = writeln!(text, "    {line}");
            }
            if !key.note.is_empty() {
                let _ = writeln!(text, "    note: {}", key.note);
            }
        }
    }

    /// Finished runs that are not trusted, or that lack something.
    fn fallen(&self) -> impl Iterator<Item = String> + '_ {
        let done = (self.results.rows.iter()).filter(|row| row.exit_code.is_some());
        let shown = done.filter(|row| !row.is_trusted() || !row.message.is_empty());
        shown.map(|row| {
            let (index, role) = (row.task.index, row.task.role.word());
            format!("task {index} ({role}): {}: {}", row.status, row.message)
        })
    }
}
