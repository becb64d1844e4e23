//! The tribological circuit with its numbers (Berthier's; Renouf, Saulot and Berthier 2006, figure 1).

use serde_json::Value;

use draw::picture::Picture;
use draw::svg::{Anchor, Svg};

/// Size of the picture (pixels).
const SIZE: [f64; 2] = [1040.0, 460.0];
/// Colours of flows, and of flows that are zero.
const BLUE: &str = "#12355b";
const GREY: &str = "#969696";
/// Half the width of an arrow's head, and its length (pixels).
const HEAD: [f64; 2] = [5.0, 11.0];

/// The boxes of the circuit: left, top, right and bottom edge (pixels), and their lines of text.
const STATIONS: [([f64; 4], &str, &str); 5] = [
    (
        [330.0, 20.0, 650.0, 80.0],
        "first bodies",
        "grains that bonds connect with a glued row",
    ),
    ([330.0, 200.0, 650.0, 290.0], "contact zone", ""),
    ([800.0, 200.0, 960.0, 290.0], "outside", "left the zone"),
    ([800.0, 390.0, 960.0, 440.0], "worn", ""),
    ([20.0, 200.0, 180.0, 290.0], "outside", "around the zone"),
];

/// An arrow of the circuit: tail and tip (pixels), words, and the accounts whose sum it carries.
type Flow = ([[f64; 2]; 2], &'static str, &'static [&'static str]);

const LEFT_THE_ZONE: &[&str] = &["q_ejected_kg", "q_left_by_zone_kg"];

#[rustfmt::skip]
const FLOWS: [Flow; 9] = [
    ([[420.0, 80.0], [420.0, 200.0]], "Qs, detached", &["q_source_kg"]),
    ([[560.0, 200.0], [560.0, 80.0]], "attached again", &["q_reattached_kg"]),
    ([[650.0, 220.0], [800.0, 220.0]], "left", LEFT_THE_ZONE),
    ([[800.0, 270.0], [650.0, 270.0]], "Qr, came back", &["q_recirculated_kg"]),
    ([[840.0, 290.0], [840.0, 390.0]], "Qw", &["q_wear_kg"]),
    ([[920.0, 390.0], [920.0, 290.0]], "after all", &["q_wear_returned_kg"]),
    ([[490.0, 390.0], [490.0, 290.0]], "Qe, fed in", &["q_external_kg"]),
    ([[180.0, 220.0], [330.0, 220.0]], "came", &["q_entered_kg"]),
    ([[180.0, 270.0], [330.0, 270.0]], "taken in", &["q_entered_by_zone_kg"]),
];

/// The circuit of a run whose summary has its accounts; `None` without them. Only flows other than zero are blue.
pub fn circuit(summary: &Value) -> Option<Picture> {
    let results = &summary["results"];
    let of = |account: &&str| results[*account].as_f64();
    let masses = FLOWS.iter().map(|flow| flow.2.iter().map(of).sum());
    let masses: Vec<f64> = masses.collect::<Option<_>>()?;
    let result = |name: &str| results[name].as_f64().map_or("none".into(), mass);
    let mut svg = Svg::default();
    for ([left, top, right, bottom], name, about) in STATIONS {
        svg.rectangle(BOX, [left, top], [right - left, bottom - top]);
        let middle = 0.5 * (left + right);
        text(&mut svg, name, [middle, top + 20.0], Anchor::Middle, 14.0);
        text(&mut svg, about, [middle, top + 44.0], Anchor::Middle, 10.0);
    }
    for (flow, mass_kg) in FLOWS.iter().zip(&masses) {
        arrow(&mut svg, flow, *mass_kg);
    }
    let held = format!("third body: {}", result("third_body_zone_kg"));
    text(&mut svg, &held, [490.0, 244.0], Anchor::Middle, 12.0);
    let [net, both] = ["q_internal_net_kg", "q_internal_abs_kg"].map(result);
    let internal = format!("Qi, through x = 0: {net} net, {both} in both directions");
    text(&mut svg, &internal, [490.0, 268.0], Anchor::Middle, 10.0);
    let detached = result("q_detached_total_kg");
    let anywhere = format!("detached anywhere: {detached}; real masses since the start, kg");
    text(&mut svg, &anywhere, [20.0, 430.0], Anchor::Start, 11.0);
    let each = FLOWS.iter().zip(&masses);
    let each = each.map(|((_, words, _), mass_kg)| format!("{words} {}", mass(*mass_kg)));
    Some(Picture {
        file: "circuit.svg".into(),
        caption: "The tribological circuit: masses of third body that flowed until the end of the run (Berthier's circuit; Renouf, Saulot and Berthier 2006, figure 1)".into(),
        alternative: Vec::from_iter(each).join("; "),
        svg: svg.page(SIZE),
    })
}

const BOX: &str = "fill=\"none\" stroke=\"#000\"";

fn mass(kg: f64) -> String {
    match kg {
        0.0 => "0 kg".into(),
        kg => format!("{kg:.2e} kg"),
    }
}

/// Text with its middle at this height.
fn text(svg: &mut Svg, words: &str, [x, y]: [f64; 2], anchor: Anchor, size: f64) {
    let style = format!("font-size=\"{size}\" fill=\"#000\"");
    svg.styled_text(&style, [x, y + 0.36 * size], anchor, words);
}

/// An arrow, with its words and mass beside its middle.
fn arrow(svg: &mut Svg, ([from, to], words, _): &Flow, mass_kg: f64) {
    let colour = if mass_kg == 0.0 { GREY } else { BLUE };
    let along = [0, 1].map(|k| (to[k] - from[k]).clamp(-1.0, 1.0));
    let [half, length] = HEAD;
    let root = [0, 1].map(|k| to[k] - length * along[k]);
    let side = [half * along[1], half * along[0]];
    let corner = |sign: f64| [0, 1].map(|k| root[k] + sign * side[k]);
    let stroke = format!("stroke=\"{colour}\" stroke-width=\"2\"");
    svg.line(&stroke, [*from, root]);
    let filled = format!("style=\"fill:{colour}\"");
    svg.line(&filled, [*to, corner(1.0), corner(-1.0)]);
    let [x, y] = [0, 1].map(|k| 0.5 * (from[k] + to[k]));
    // The text is left of an arrow downwards, right of an arrow upwards, above a level arrow.
    let (x, heights, anchor) = match along {
        [0.0, down] if down > 0.0 => (x - 10.0, [y - 9.0, y + 9.0], Anchor::End),
        [0.0, _] => (x + 10.0, [y - 9.0, y + 9.0], Anchor::Start),
        _ => (x, [y - 26.0, y - 9.0], Anchor::Middle),
    };
    text(svg, words, [x, heights[0]], anchor, 11.5);
    text(svg, &mass(mass_kg), [x, heights[1]], anchor, 11.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_flow_is_drawn_with_the_sum_of_its_accounts() {
        let mut results = json!({"third_body_zone_kg": 7e-6, "q_internal_net_kg": 0.0,
                                 "q_internal_abs_kg": 1e-6, "q_detached_total_kg": 2e-6});
        for ((.., accounts), mass) in FLOWS.iter().zip(1..) {
            for account in *accounts {
                results[*account] = json!(f64::from(mass) * 1e-9);
            }
        }
        let summary = json!({"results": results});
        let drawn = circuit(&summary).expect("it has flows");
        // The third flow carries two accounts of 3e-9 kg each.
        for mass in ["1", "2", "6", "4", "5", "6", "7", "8", "9"] {
            assert!(drawn.svg.contains(&format!("{mass}.00e-9 kg")), "{mass}");
        }
        assert!(drawn.svg.contains("third body: 7.00e-6 kg"));
    }

    #[test]
    fn a_run_without_flows_has_no_circuit() {
        let summary = json!({"results": {"q_source_kg": 1e-9}});
        assert!(circuit(&summary).is_none());
    }
}
