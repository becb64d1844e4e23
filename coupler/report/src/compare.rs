//! A run beside another one: distances as `compare` tells them.

use std::collections::BTreeMap;

use super::page::table;
use super::units::{four, told};
use coordinator::error::Error;
use draw::picture::escape;
use runs::compare::{Compared, Comparison, difference, ratio};
use runs::files::RunFiles;
use runs::finished::Finished;

/// Tables of the distances of a run from another one.
///
/// # Errors
/// One of them cannot be read.
pub(super) fn distances(run: &RunFiles, other: &RunFiles) -> Result<String, Error> {
    let [own, reference] = [Finished::read(&run.path)?, Finished::read(&other.path)?];
    let found = Comparison::new(&own, &reference, None);
    let same = if found.same_exchange {
        "All messages between the participants were the same, bit for bit."
    } else {
        "Distances are over those of the other run: L2 over its length, largest over its largest value."
    };
    let mut html = format!(
        "<p>Held against <code>{}</code>. {same}</p>",
        escape(&other.path.display().to_string())
    );
    html += &curves("Signals", &found.signals);
    html += &curves("Traction on the surface", &found.profile);
    let numbers = |name: &str, pair: [Option<f64>; 2], third: Option<f64>| {
        let each = pair.map(|x| x.map_or("none".into(), |x| escape(&told(name, x))));
        let [own, other] = each;
        vec![escape(name), own, other, third.map_or(String::new(), four)]
    };
    let results = found
        .results
        .iter()
        .map(|(name, pair)| numbers(name, *pair, difference(*pair)));
    html += "<h3>Results</h3>";
    html += &table(
        &["result", "this run", "other", "relative difference"],
        &[1, 2, 3],
        &results.collect::<Vec<_>>(),
    );
    let cost = found
        .cost
        .iter()
        .map(|(name, pair)| numbers(name, *pair, ratio(*pair)));
    html += "<h3>Cost</h3>";
    html += &table(
        &["cost", "this run", "other", "ratio"],
        &[1, 2, 3],
        &cost.collect::<Vec<_>>(),
    );
    Ok(html)
}

/// Distances of curves; those that are the same, or cannot be compared, are counted.
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
            Ok(distance) => {
                let part = |x: Option<f64>| x.map_or("none".into(), four);
                rows.push(vec![
                    escape(name),
                    escape(&told(name, distance.rms)),
                    part(distance.l2_rel),
                    escape(&told(name, distance.max)),
                    part(distance.max_rel),
                ]);
            }
            Err(why) => without.entry(why).or_default().push(escape(name)),
        }
    }
    let mut html = format!("<h3>{title}</h3>");
    if same > 0 {
        html += &format!("<p>{same} of {} are the same.</p>", all.len());
    }
    for (why, names) in without {
        html += &format!(
            "<p>{} cannot be compared, {}: {}.</p>",
            names.len(),
            escape(why),
            names.join(", ")
        );
    }
    let head = [
        "curve",
        "rms",
        "L2, relative",
        "largest",
        "largest, relative",
    ];
    if !rows.is_empty() {
        html += &table(&head, &[1, 2, 3, 4], &rows);
    }
    html
}
