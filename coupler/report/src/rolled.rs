//! Traction below a wheel that rolls, at the end of the run, with the zones in which the contact sticks and slips.

use draw::picture::Picture;
use draw::plot::{BACKGROUND, PlotCurve, plot};
use kit::rolling::nearest_image;
use runs::files::RunFiles;
use scenario::overrides::{number, value_at};

use super::curves::{PRESSED, column};
use super::line_contact::{LineContact, friction};

/// Width of the picture in half-widths of the contact to either side.
const REACH: f64 = 1.5;

/// A point of the surface: distance ahead of the wheel's centre (m), pressure and shear in the direction of rolling (Pa), status.
type Point = (f64, [f64; 2], String);

/// The picture; `None` for a wheel that does not roll, and without a table of its tractions.
pub(super) fn traction(run: &RunFiles) -> Option<Picture> {
    let points = points(run)?;
    let pressures = points.iter().map(|(_, [p, _], _)| *p);
    let largest = pressures.fold(0.0, f64::max);
    let is_pressed = |(_, [p, _], _): &&Point| *p > PRESSED * largest;
    let pressed = || points.iter().filter(is_pressed);
    let half = pressed().fold(0.0, |far: f64, (x, ..)| far.max(x.abs()));
    let near = |x: f64| x.abs() < REACH * half;
    let curve = |label: &str, style: usize, of: &dyn Fn(&Point) -> Option<f64>| {
        let shown = points.iter().filter(|(x, ..)| near(*x));
        let points = shown.map(|point| (1e3 * point.0, 1e-6 * of(point).unwrap_or(f64::NAN)));
        PlotCurve {
            label: label.into(),
            points: points.collect(),
            style,
        }
    };
    let mut curves = vec![
        curve("pressure", 0, &|(_, [p, _], _)| Some(*p)),
        curve("shear", 1, &|(_, [_, q], _)| Some(*q)),
    ];
    if let Some(contact) = LineContact::of(run) {
        let (x, y) = contact.hertz();
        let hertz = x.iter().zip(&y).map(|(x, y)| (1e3 * x, 1e-6 * y));
        curves.push(PlotCurve {
            label: contact.words(),
            points: hertz.collect(),
            style: 4,
        });
    }
    if let Some(friction) = friction(run) {
        let label = format!("limit of friction, {friction} p");
        for (label, sign) in [(label.as_str(), 1.0), ("", -1.0)] {
            let limit = |(_, [p, _], _): &Point| Some(sign * friction * p);
            curves.push(curve(label, BACKGROUND, &limit));
        }
    }
    for (status, label, style) in [("stick", "sticks", 2), ("slip", "slips", 5)] {
        let zone = |(_, _, own): &Point| (own == status).then_some(0.0);
        if points.iter().any(|(_, _, own)| own == status) {
            curves.push(curve(label, style, &zone));
        }
    }
    let ahead = "ahead of the wheel's centre (mm)";
    let stuck = pressed().filter(|(_, _, own)| own == "stick").count();
    Some(Picture {
        file: "rolling-traction.svg".into(),
        caption: "Traction below the rolling wheel at the end; it rolls to the right".into(),
        alternative: format!(
            "Pressure and shear at {} points of the contact, of which {stuck} stick.",
            pressed().count()
        ),
        svg: plot([ahead, "traction on the surface (MPa)"], false, &curves),
    })
}

/// The surface from the rear to the front.
fn points(run: &RunFiles) -> Option<Vec<Point>> {
    let keys = run.scenario_table();
    let setup = run.scenario();
    let wheel = setup.wheel_of.as_ref()?;
    let of = |name: &str, key: &str| value_at(&keys, &format!("participant.{name}.config.{key}"));
    let speed = number(of(wheel, "wheel.rolling.speed_m_per_s")?)?;
    let centre = *column(&run.signals, "wheel_x_m")?.last()?;
    let of_body = |name: &str| {
        let repeats = of(name, "mesh.periodic_x")?.as_bool()?;
        number(of(name, "mesh.width_m")?).filter(|_| repeats)
    };
    let of_layer = |name: &str| {
        let ends = of(name, "sample.periodic_x_m")?.as_array()?;
        Some(number(ends.get(1)?)? - number(ends.first()?)?)
    };
    let mut sides = setup.participants.iter();
    let period = sides.find_map(|name| of_body(name).or_else(|| of_layer(name)));
    let text = std::fs::read_to_string(run.field_files("-end-profile.csv").first()?).ok()?;
    let rows = text.lines().skip(1).filter_map(|line| {
        let [x, pressure, shear, status] = Vec::from_iter(line.split(',')).try_into().ok()?;
        let number = |cell: &str| cell.parse::<f64>().ok();
        let (x, pressure, shear) = (number(x)?, number(pressure)?, number(shear)?);
        let apart = nearest_image(x - centre, period);
        let along = 1.0_f64.copysign(speed);
        Some((along * apart, [pressure, along * shear], status.to_string()))
    });
    let mut points = Vec::from_iter(rows);
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    (points.len() > 1).then_some(points)
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::scratch::Scratch;
    use runs::table::Table;

    /// A wheel that rolls to the left and stands at x = -4.5 m, on a body that repeats after 10 m: the points at 5 and -4 m lie 0.5 m ahead of it and
    /// 0.5 m behind, and shear along x is against the rolling.
    #[test]
    fn points_are_ahead_of_the_centre_in_the_direction_of_rolling() {
        let scratch = Scratch::new("rolled", 1);
        let put = |file: &str, text: &str| {
            let path = scratch.path().join(file);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("writable");
            std::fs::write(path, text).expect("writable");
        };
        let scenario = |kind: &str, repeats: &str| {
            format!(
                "[[participant]]\nname = \"rail\"\nkind = \"{kind}\"\n[participant.config]\n{repeats}\ncontact.friction = 0.5\nwheel = {{ radius_m = 1.0, rolling.speed_m_per_s = -2.0 }}\n"
            )
        };
        let body = scenario("fem", "mesh = { width_m = 10.0, periodic_x = true }");
        put("scenario.toml", &body);
        put(
            "fields/rail-end-profile.csv",
            "x_m,pressure_pa,shear_pa,status\n-4e0,2e6,1e6,slip\n0e0,0e0,0e0,open\n5e0,3e6,-1e6,stick\n",
        );
        let run = RunFiles {
            path: scratch.path().into(),
            signals: Table {
                columns: vec![("rail.wheel_x_m".into(), vec![0.0, -4.5])],
            },
            ..RunFiles::default()
        };
        let found = points(&run).expect("it rolls");
        let expected: [(f64, [f64; 2], &str); 3] = [
            (-4.5, [0.0, 0.0], "open"),
            (-0.5, [2e6, -1e6], "slip"),
            (0.5, [3e6, 1e6], "stick"),
        ];
        for ((x, tractions, status), expected) in found.iter().zip(expected) {
            assert_eq!((*x, *tractions, status.as_str()), expected);
        }
        let layer = scenario("dem", "sample = { periodic_x_m = [-5.0, 5.0] }");
        put("scenario.toml", &layer);
        assert_eq!(points(&run), Some(found), "grains that repeat");
        put("scenario.toml", &body);
        let picture = traction(&run).expect("a picture");
        assert!(
            picture
                .alternative
                .contains("2 points of the contact, of which 1 stick")
        );
        for words in ["sticks", "slips", "limit of friction, 0.5 p"] {
            assert!(picture.svg.contains(words), "{words}");
        }
    }
}
