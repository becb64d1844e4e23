//! A run against another one: distances as `compare` prints them.

use std::collections::BTreeMap;

use super::page::table;
use draw::svg::escape;
use draw::units::{four, with_unit_of};
use runs::compare::{Compared, Comparison, NumberPair, by_change, difference, ratio};
use runs::files::RunFiles;
use scenario::error::Error;

/// Tables of the distances of a run from another one.
///
/// # Errors
/// One of them cannot be read.
pub(super) fn distances(run: &RunFiles, other: &RunFiles) -> Result<String, Error> {
    let [own, reference] = [RunFiles::read(&run.path)?, RunFiles::read(&other.path)?];
    let found = Comparison::new(&own, &reference, None);
    let same = if found.same_exchange {
        "All messages between the participants were the same, bit for bit."
    } else {
        "Distances are relative to the other run: L2 over its length, largest over its largest value."
    };
    let path = escape(&other.path.display().to_string());
    let mut html = format!("<p>Compared with <code>{path}</code>. {same}</p>");
    let keys = found.keys.iter().map(|(key, [reference, own])| {
        let shown = |value: &Option<String>| escape(value.as_deref().unwrap_or("not given"));
        [escape(key), shown(own), shown(reference)]
    });
    html += &table(["key", "this run", "other"], &[], keys);
    html += &curves("Signals", &found.signals);
    html += &curves("Traction on the surface", &found.profile);
    let pairs = |title: &str, head: [&str; 4], all: &BTreeMap<String, NumberPair>, of: OfPair| {
        let rows = by_change(all).into_iter().map(|(name, pair)| {
            let shown = |x: f64| escape(&with_unit_of(name, x));
            let [own, other] = pair.map(|x| x.map_or("none".into(), shown));
            let last = of(pair).map_or(String::new(), four);
            [escape(name), own, other, last]
        });
        format!("<h3>{title}</h3>{}", table(head, &[1, 2, 3], rows))
    };
    let head = ["result", "this run", "other", "relative difference"];
    html += &pairs("Results", head, &found.results, difference);
    let head = ["cost", "this run", "other", "ratio"];
    html += &pairs("Cost", head, &found.cost, ratio);
    Ok(html)
}

/// Computes the last column from the numbers of both runs.
type OfPair = fn(NumberPair) -> Option<f64>;

/// Distances of curves; curves that are the same, or cannot be compared, are counted.
fn curves(title: &str, all: &[(String, Compared)]) -> String {
    if all.is_empty() {
        return String::new();
    }
    let mut same = 0;
    let mut rows = Vec::new();
    let mut without: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for (name, compared) in all {
        match compared {
            Ok(distance) if distance.max == 0.0 => same += 1,
            Ok(d) => {
                let [rms, max] = [d.rms, d.max].map(|x| escape(&with_unit_of(name, x)));
                let [l2, part] = [d.l2_rel, d.max_rel].map(|x| x.map_or("none".into(), four));
                rows.push([escape(name), rms, l2, max, part]);
            }
            Err(why) => without.entry(why).or_default().push(escape(name)),
        }
    }
    let mut html = format!("<h3>{title}</h3>");
    if same > 0 {
        html += &format!("<p>{same} of {} are the same.</p>", all.len());
    }
    for (why, names) in without {
        let (count, why, names) = (names.len(), escape(why), names.join(", "));
        html += &format!("<p>{count} cannot be compared, {why}: {names}.</p>");
    }
    let [l2, part] = ["L2, relative", "largest, relative"];
    html + &table(["curve", "rms", l2, "largest", part], &[1, 2, 3, 4], rows)
}
