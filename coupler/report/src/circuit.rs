//! The tribological circuit with its numbers (Berthier's; Renouf, Saulot and Berthier 2006, figure 1).

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use serde_json::Value;

use coordinator::error::{Error, Refusal};
use draw::page::{picture, svg};
use draw::picture::Picture;

/// Size of the picture (pixels).
const SIZE: (u32, u32) = (1040, 460);
/// Colour of what passed.
const BLUE: RGBColor = RGBColor(18, 53, 91);
/// Half the width of an arrow's head, and its length (pixels).
const HEAD: (i32, i32) = (5, 11);

type Page<'a, 'b> = DrawingArea<SVGBackend<'b>, Shift>;

/// A box of the circuit: left, top, right and bottom edge (pixels), and the lines in it.
struct Station {
    edges: [i32; 4],
    lines: [&'static str; 2],
}

const STATIONS: [Station; 5] = [
    Station {
        edges: [330, 20, 650, 80],
        lines: ["first bodies", "grains that bonds connect with the base"],
    },
    Station {
        edges: [330, 200, 650, 290],
        lines: ["contact zone", ""],
    },
    Station {
        edges: [800, 200, 960, 290],
        lines: ["outside", "left the zone"],
    },
    Station {
        edges: [800, 390, 960, 440],
        lines: ["worn", ""],
    },
    Station {
        edges: [20, 200, 180, 290],
        lines: ["outside", "around the zone"],
    },
];

/// An arrow of the circuit: its ends (pixels), its words, and the accounts whose sum it carries.
struct Flow {
    from: (i32, i32),
    to: (i32, i32),
    words: &'static str,
    accounts: &'static [&'static str],
}

const FLOWS: [Flow; 9] = [
    Flow {
        from: (420, 80),
        to: (420, 200),
        words: "Qs, detached",
        accounts: &["q_source_kg"],
    },
    Flow {
        from: (560, 200),
        to: (560, 80),
        words: "attached again",
        accounts: &["q_reattached_kg"],
    },
    Flow {
        from: (650, 220),
        to: (800, 220),
        words: "left",
        accounts: &["q_ejected_kg", "q_left_by_zone_kg"],
    },
    Flow {
        from: (800, 270),
        to: (650, 270),
        words: "Qr, came back",
        accounts: &["q_recirculated_kg"],
    },
    Flow {
        from: (840, 290),
        to: (840, 390),
        words: "Qw",
        accounts: &["q_wear_kg"],
    },
    Flow {
        from: (920, 390),
        to: (920, 290),
        words: "after all",
        accounts: &["q_wear_returned_kg"],
    },
    Flow {
        from: (490, 390),
        to: (490, 290),
        words: "Qe, fed in",
        accounts: &["q_external_kg"],
    },
    Flow {
        from: (180, 220),
        to: (330, 220),
        words: "came",
        accounts: &["q_entered_kg"],
    },
    Flow {
        from: (180, 270),
        to: (330, 270),
        words: "taken in",
        accounts: &["q_entered_by_zone_kg"],
    },
];

/// The circuit of a run whose summary has its accounts; none without them. Only what passed is blue.
pub fn drawn(summary: &Value) -> Result<Option<Picture>, Error> {
    let results = &summary["results"];
    let of = |account: &&str| results[*account].as_f64();
    let masses = FLOWS.iter().map(|flow| flow.accounts.iter().map(of).sum());
    let Some(masses): Option<Vec<f64>> = masses.collect() else {
        return Ok(None);
    };
    let told = |name: &str| results[name].as_f64().map_or("none".into(), mass);
    let svg = svg(SIZE, |page| {
        for station in &STATIONS {
            let [left, top, right, bottom] = station.edges;
            let corners = [(left, top), (right, bottom)];
            let frame = Rectangle::new(corners, BLACK.stroke_width(1));
            page.draw(&frame).map_err(picture)?;
            let middle = (left + right) / 2;
            let [name, about] = station.lines;
            text(page, name, (middle, top + 20), HPos::Center, 17)?;
            text(page, about, (middle, top + 44), HPos::Center, 12)?;
        }
        for (flow, mass_kg) in FLOWS.iter().zip(&masses) {
            arrow(page, flow, *mass_kg)?;
        }
        let held = format!("third body: {}", told("third_body_zone_kg"));
        text(page, &held, (490, 244), HPos::Center, 15)?;
        let internal = format!(
            "Qi, through x = 0: {} net, {} in both directions",
            told("q_internal_net_kg"),
            told("q_internal_abs_kg")
        );
        text(page, &internal, (490, 268), HPos::Center, 12)?;
        let anywhere = format!(
            "detached anywhere: {}; real masses since the start, kg",
            told("q_detached_total_kg")
        );
        text(page, &anywhere, (20, 430), HPos::Left, 13)
    })
    .map_err(Refusal::Picture)?;
    let each = FLOWS.iter().zip(&masses);
    let each = each.map(|(flow, mass_kg)| format!("{} {}", flow.words, mass(*mass_kg)));
    Ok(Some(Picture {
        file: "circuit.svg".into(),
        caption: "The tribological circuit: masses of third body that passed until the end of the run (Berthier's circuit; Renouf, Saulot and Berthier 2006, figure 1)".into(),
        alternative: each.collect::<Vec<String>>().join("; "),
        svg,
    }))
}

fn mass(kg: f64) -> String {
    if kg == 0.0 {
        "0 kg".into()
    } else {
        format!("{kg:.2e} kg")
    }
}

fn text(page: &Page, words: &str, at: (i32, i32), side: HPos, size: i32) -> Result<(), String> {
    let font = ("sans-serif", size).into_font().color(&BLACK);
    let style = font.pos(Pos::new(side, VPos::Center));
    page.draw(&Text::new(words, at, style)).map_err(picture)
}

/// An arrow, and beside its middle what it carries.
fn arrow(page: &Page, flow: &Flow, mass_kg: f64) -> Result<(), String> {
    let colour = if mass_kg == 0.0 {
        RGBColor(150, 150, 150)
    } else {
        BLUE
    };
    let Flow {
        from, to, words, ..
    } = flow;
    let shaft = PathElement::new([*from, *to], colour.stroke_width(2));
    page.draw(&shaft).map_err(picture)?;
    let along = ((to.0 - from.0).signum(), (to.1 - from.1).signum());
    let (half, length) = HEAD;
    let root = (to.0 - length * along.0, to.1 - length * along.1);
    let side = (half * along.1, half * along.0);
    let corners = [
        *to,
        (root.0 + side.0, root.1 + side.1),
        (root.0 - side.0, root.1 - side.1),
    ];
    page.draw(&Polygon::new(corners, colour.filled()))
        .map_err(picture)?;
    let middle = ((from.0 + to.0) / 2, (from.1 + to.1) / 2);
    let said = mass(mass_kg);
    if along.0 == 0 {
        // Left of an arrow downwards, right of one upwards.
        let (at, side) = if along.1 > 0 {
            (middle.0 - 10, HPos::Right)
        } else {
            (middle.0 + 10, HPos::Left)
        };
        text(page, words, (at, middle.1 - 9), side, 14)?;
        return text(page, &said, (at, middle.1 + 9), side, 13);
    }
    text(page, words, (middle.0, middle.1 - 26), HPos::Center, 14)?;
    text(page, &said, (middle.0, middle.1 - 9), HPos::Center, 13)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_flow_is_drawn_with_the_sum_of_its_accounts() {
        let mut results = json!({"third_body_zone_kg": 7e-6, "q_internal_net_kg": 0.0,
                                 "q_internal_abs_kg": 1e-6, "q_detached_total_kg": 2e-6});
        for (flow, mass) in FLOWS.iter().zip(1..) {
            for account in flow.accounts {
                results[*account] = json!(f64::from(mass) * 1e-9);
            }
        }
        let summary = json!({"results": results});
        let drawn = drawn(&summary).expect("it is drawn").expect("it has flows");
        // The third carries two accounts of 3e-9 kg each.
        for mass in ["1", "2", "6", "4", "5", "6", "7", "8", "9"] {
            assert!(drawn.svg.contains(&format!("{mass}.00e-9 kg")), "{mass}");
        }
        assert!(drawn.svg.contains("third body: 7.00e-6 kg"));
    }

    #[test]
    fn a_run_without_flows_has_no_circuit() {
        let summary = json!({"results": {"q_source_kg": 1e-9}});
        assert!(drawn(&summary).expect("nothing is drawn").is_none());
    }
}
