//! Checks of a participant's description at the handshake, before it is used.

use nalgebra::DMatrix;
use protocol::{Description, Surface};

/// Largest difference between the entries (i, j) and (j, i) of columns, over the largest entry: rounding gives 1e-12, a
/// wrong order of rows or a force on the wrong component gives order 1.
const ASYMMETRY: f64 = 1e-3;

/// Longest name of a signal, a set or a term.
const LONGEST_NAME: usize = 100;

/// The fault of a description, if it has one.
pub fn fault_of_description(description: &Description) -> Option<String> {
    let lengths = [
        ("step_s", description.step_s),
        ("step_limit_s", description.step_limit_s),
        ("end_s", description.end_s),
        ("first_period_s", description.first_period_s),
    ];
    let limits = description.accuracy_limits.iter();
    let limits = limits.map(|limit| (&*limit.name, Some(limit.limit_s)));
    let is_wrong = |value: &f64| !(value.is_finite() && *value > 0.0);
    let all = lengths.into_iter().chain(limits);
    let mut wrong = all.filter_map(|(what, value)| Some((what, value.filter(is_wrong)?)));
    if let Some((what, value)) = wrong.next() {
        return Some(format!(
            "describes its {} as {value}: it must be a finite time above zero, or absent",
            what.escape_debug()
        ));
    }
    for phase in &description.phases {
        let [start, end] = [phase.t0_s, phase.t1_s];
        if !(start >= 0.0 && end >= start && end.is_finite()) {
            return Some(format!(
                "has a phase `{}` from {start} to {end} s: a phase must begin at zero or later and must not end before it begins",
                phase.name.escape_debug()
            ));
        }
    }
    let terms = description.ledger.iter().map(|term| &term.name);
    // Both are columns of signals.csv, beside the time.
    let columns = terms.clone().map(|term| format!("{term}_j"));
    let columns = Vec::from_iter(columns.chain(["t_s".into()]));
    let mut signals = description.signals.iter();
    if let Some(signal) = signals.find(|signal| columns.contains(signal)) {
        return Some(format!(
            "has a signal `{}`, which is the name of the time or of one of its ledger terms in signals.csv: give the signal another name",
            signal.escape_debug()
        ));
    }
    fault_of_names("signal", description.signals.iter())
        .or_else(|| fault_of_names("set", description.sets.iter()))
        .or_else(|| fault_of_names("ledger term", terms))
        .or_else(|| fault_of_outward(description))
        .or_else(|| fault_of_period(description))
}

/// Checks names, which become columns of files and keys of summaries.
pub(super) fn fault_of_names<'a>(
    what: &str,
    names: impl Iterator<Item = &'a String>,
) -> Option<String> {
    let mut known: Vec<&str> = Vec::new();
    for name in names {
        let shown = name.escape_debug();
        if name.is_empty() || name.len() > LONGEST_NAME {
            return Some(format!(
                "has a {what} whose name has {} bytes: names have 1 to {LONGEST_NAME}",
                name.len()
            ));
        }
        if name.chars().any(|c| c.is_control() || c == '"' || c == ',') {
            return Some(format!(
                "has a {what} `{shown}`: names must not contain commas, quotes or control characters"
            ));
        }
        if known.contains(&name.as_str()) {
            return Some(format!("names the {what} `{shown}` twice"));
        }
        known.push(name);
    }
    None
}

fn fault_of_outward(description: &Description) -> Option<String> {
    let mut normals = description.outward.iter();
    let is_unit = |[x, y]: &[f64; 2]| (x.hypot(*y) - 1.0).abs() < 1e-6;
    let (set, [x, y]) = normals.find(|(_, normal)| !is_unit(normal))?;
    Some(format!(
        "describes the outward normal of `{}` as ({x}, {y}): it must have the length 1",
        set.escape_debug()
    ))
}

fn fault_of_period(description: &Description) -> Option<String> {
    let mut periods = description.period_m.iter();
    let (set, period) = periods.find(|(_, period)| !(period.is_finite() && **period > 0.0))?;
    Some(format!(
        "says that `{}` repeats after {period} m: a period must be a finite length above zero, or absent",
        set.escape_debug()
    ))
}

/// The fault of a surface, if it has one. Points without mass are allowed here: glued disks have no mass.
pub fn fault_of_surface(surface: &Surface) -> Option<String> {
    if surface.is_empty() {
        return Some("sent a surface without points".into());
    }
    let finite = |value: f64| value.is_finite();
    let some = |value: f64| value.is_finite() && value >= 0.0;
    let positive = |value: f64| value.is_finite() && value > 0.0;
    type Rule = (&'static str, fn(f64) -> bool, &'static str);
    let rules: [Rule; 5] = [
        ("x (m)", finite, "be finite"),
        ("y (m)", finite, "be finite"),
        ("mass (kg)", some, "be finite and not below zero"),
        ("radius (m)", some, "be finite and not below zero"),
        ("length (m)", positive, "be finite and above zero"),
    ];
    let mut columns = surface.columns().into_iter().zip(rules);
    columns.find_map(|(values, (what, sound, must))| {
        let point = values.iter().position(|value| !sound(*value))?;
        Some(format!(
            "sent a surface whose point {point} has the {what} {}: it must {must}",
            values[point]
        ))
    })
}

/// The fault of columns of a compliance or an impedance, if they have one. In a passive body a force at i moves j as a
/// force at j moves i (Maxwell and Betti), a force moves its own component along and not against it, and some component
/// moves.
pub fn fault_of_columns(matrix: &DMatrix<f64>) -> Option<String> {
    let largest = matrix.amax();
    if largest == 0.0 {
        return Some(
            "sent columns that are all zero: none of its exchanged components can move".into(),
        );
    }
    let n = matrix.nrows();
    if let Some(i) = (0..n).find(|i| matrix[(*i, *i)] < 0.0) {
        return Some(format!(
            "sent columns whose entry ({i}, {i}) is {:e}: a component moves with the force on it, not against it",
            matrix[(i, i)]
        ));
    }
    let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (i, j)));
    let apart = |(i, j): (usize, usize)| (matrix[(i, j)] - matrix[(j, i)]).abs();
    let (i, j) = pairs.max_by(|a, b| apart(*a).total_cmp(&apart(*b)))?;
    (apart((i, j)) > ASYMMETRY * largest).then(|| {
        format!(
            "sent columns that are not symmetric: entry ({i}, {j}) is {:e} and entry ({j}, {i}) is {:e}, the largest of all {largest:e}; the columns of a linear body are symmetric (Maxwell and Betti)",
            matrix[(i, j)],
            matrix[(j, i)]
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::{Phase, Role, Term};

    fn sound() -> Description {
        Description {
            step_s: Some(1e-8),
            signals: vec!["a_m".into(), "b m".into()],
            sets: vec!["top".into()],
            phases: vec![Phase {
                t1_s: 1.0,
                ..Phase::default()
            }],
            outward: [("top".to_string(), [0.6, -0.8])].into(),
            period_m: [("top".to_string(), 0.5)].into(),
            ..Description::default()
        }
    }

    #[test]
    fn a_description_with_a_wrong_number_or_name_is_refused() {
        assert_eq!(fault_of_description(&sound()), None);
        type Harm = fn(&mut Description);
        let harms: [(&str, Harm); 18] = [
            ("step_s", |d| d.step_s = Some(0.0)),
            ("step_s", |d| d.step_s = Some(-1e-8)),
            ("step_s", |d| d.step_s = Some(f64::NAN)),
            ("step_limit_s", |d| d.step_limit_s = Some(0.0)),
            ("end_s", |d| d.end_s = Some(f64::INFINITY)),
            ("first_period_s", |d| d.first_period_s = Some(-1.0)),
            ("phase", |d| d.phases[0].t0_s = 2.0),
            ("signal", |d| d.signals[1] = "a_m".into()),
            ("signal", |d| d.signals[1] = "a,b".into()),
            ("signal", |d| d.signals[1] = "a\nb".into()),
            ("signal `t_s`", |d| d.signals[1] = "t_s".into()),
            ("signal `springs_j`", |d| {
                d.signals[1] = "springs_j".into();
                d.ledger.push(Term {
                    name: "springs".into(),
                    role: Role::Stored,
                });
            }),
            ("set", |d| d.sets[0] = String::new()),
            ("ledger term", |d| {
                let term = Term {
                    name: "x".repeat(101),
                    role: Role::Work,
                };
                d.ledger.push(term);
            }),
            ("outward", |d| {
                d.outward.insert("top".into(), [0.0, 2.0]);
            }),
            ("repeats after 0 m", |d| {
                d.period_m.insert("top".into(), 0.0);
            }),
            ("repeats after -1 m", |d| {
                d.period_m.insert("top".into(), -1.0);
            }),
            ("repeats after inf m", |d| {
                d.period_m.insert("top".into(), f64::INFINITY);
            }),
        ];
        for (word, harm) in harms {
            let mut description = sound();
            harm(&mut description);
            let fault = fault_of_description(&description).expect(word);
            assert!(fault.contains(word), "{fault}");
        }
    }

    #[test]
    fn a_surface_with_an_impossible_value_is_refused() {
        let sound = || {
            Surface::from_rows(&[0.0, 1.0, 0.0, 0.0, 0.1, 0.1, 1.0, 2.0, 0.05, 0.1])
                .expect("two rows")
        };
        assert_eq!(fault_of_surface(&sound()), None);
        assert!(fault_of_surface(&Surface::default()).is_some());
        type Harm = fn(&mut Surface);
        let harms: [(&str, Harm); 8] = [
            ("x (m) NaN", |s| s.x_m[1] = f64::NAN),
            ("y (m) inf", |s| s.y_m[1] = f64::INFINITY),
            ("mass (kg) -1", |s| s.mass_kg[1] = -1.0),
            ("mass (kg) NaN", |s| s.mass_kg[1] = f64::NAN),
            ("radius (m) -1", |s| s.radius_m[1] = -1.0),
            ("length (m) NaN", |s| s.length_m[1] = f64::NAN),
            ("length (m) 0", |s| s.length_m[1] = 0.0),
            ("length (m) -1", |s| s.length_m[1] = -1.0),
        ];
        for (words, harm) in harms {
            let mut surface = sound();
            harm(&mut surface);
            let fault = fault_of_surface(&surface).expect(words);
            assert!(
                fault.contains(&format!("point 1 has the {words}")),
                "{fault}"
            );
        }
    }

    #[test]
    fn columns_of_no_passive_body_are_refused() {
        let fault = |entries: &[f64]| fault_of_columns(&DMatrix::from_column_slice(2, 2, entries));
        assert_eq!(fault(&[2.0, 1.0, 1.0, 2.0]), None);
        // A held component.
        assert_eq!(fault(&[2.0, 0.0, 0.0, 0.0]), None);
        assert_eq!(fault(&[2.0, 1.0, 1.0019, 2.0]), None);
        for (word, entries) in [
            ("not symmetric", [2.0, 1.0, 1.0021, 2.0]),
            ("all zero", [0.0; 4]),
            ("(1, 1)", [2.0, 1.0, 1.0, -2.0]),
        ] {
            let fault = fault(&entries).expect(word);
            assert!(fault.contains(word), "{fault}");
        }
    }
}
