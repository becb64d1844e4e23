//! The line contact of a scene after Hertz, and its limit of friction, for comparison with the traction of a run.

use std::f64::consts::PI;

use draw::units::with_unit;
use runs::files::RunFiles;
use runs::scene::Setup;
use scenario::overrides::{self, value_at};

/// Points of the half ellipse.
const POINTS: i32 = 200;

/// A rigid wheel on the crown of one elastic body: a = sqrt(4 P R / (π E*)), p0 = 2 P / (π a), p(x) = p0 sqrt(1 - (x/a)²), with P the
/// load over the thickness (Johnson, Contact Mechanics, 1985, equations 4.43 to 4.46).
pub(super) struct LineContact {
    load_n_per_m: f64,
    /// 1/R = 1/R of the crown + 1/R of the wheel; a flat face adds nothing.
    radius_m: f64,
    /// E* = E / (1 - ν²) in plane strain and E in plane stress, for a rigid wheel.
    modulus_pa: f64,
}

impl LineContact {
    /// The contact of a scene with one elastic body of known crown below a smooth wheel; `None` for any other scene.
    pub(super) fn of(run: &RunFiles) -> Option<LineContact> {
        let keys = run.scenario_table();
        let setup = Setup::from(&keys);
        let number = |key: String| overrides::number(value_at(&keys, &key)?);
        let text = |key: &str| Some(value_at(&keys, key)?.as_str()?.to_string());
        let kind = |name: &&String| text(&format!("participant.{name}.kind"));
        let all = setup.participants.iter();
        let mut continua = all.filter(|name| kind(name).as_deref() == Some("fem"));
        let (body, None) = (continua.next()?, continua.next()) else {
            return None;
        };
        let key = |key: &str| format!("participant.{body}.config.{key}");
        if text(&key("material.kind"))? != "elastic" {
            return None;
        }
        let wheel = setup.wheel?.radius_m;
        let crown = number(key("mesh.crown_radius_m")).unwrap_or(0.0);
        let curvatures = [wheel, crown].into_iter().filter(|radius| *radius > 0.0);
        let curvature: f64 = curvatures.map(f64::recip).sum();
        let [young_pa, poisson] = ["material.young_pa", "material.poisson"].map(key);
        let (young_pa, poisson) = (number(young_pa)?, number(poisson)?);
        let across = match text(&key("plane")).as_deref() {
            Some("stress") => 0.0,
            _ => poisson,
        };
        let contact = LineContact {
            load_n_per_m: run.number("results.load_n")? / number("run.thickness_m".into())?,
            radius_m: curvature.recip(),
            modulus_pa: young_pa / (1.0 - across * across),
        };
        (curvature > 0.0 && contact.load_n_per_m > 0.0).then_some(contact)
    }

    /// The half ellipse: positions (m) and pressures (Pa).
    pub(super) fn hertz(&self) -> (Vec<f64>, Vec<f64>) {
        let width = 4.0 * self.load_n_per_m * self.radius_m / (PI * self.modulus_pa);
        let half = width.sqrt();
        let largest = 2.0 * self.load_n_per_m / (PI * half);
        let shares = (-POINTS..=POINTS).map(|k| f64::from(k) / f64::from(POINTS));
        let point = |share: f64| (half * share, largest * (1.0 - share * share).sqrt());
        shares.map(point).unzip()
    }

    /// Words in a legend.
    pub(super) fn words(&self) -> String {
        let [modulus, radius] = [(self.modulus_pa, "Pa"), (self.radius_m, "m")];
        let [modulus, radius] = [modulus, radius].map(|(value, unit)| with_unit(value, unit));
        format!("Hertz, E* = {modulus}, R = {radius}")
    }
}

/// The coefficient of friction of the surface, if it has one: of the contact with the wheel, or of a layer with a single law.
pub(super) fn friction(run: &RunFiles) -> Option<f64> {
    let keys = run.scenario_table();
    let setup = Setup::from(&keys);
    let number = |key: String| overrides::number(value_at(&keys, &key)?);
    let config = |name: &String, key: &str| format!("participant.{name}.config.{key}");
    let found = setup.participants.iter().find_map(|name| {
        let several = ["law.pairs", "sample.surface.friction"].map(|key| config(name, key));
        let one = several.iter().all(|key| value_at(&keys, key).is_none());
        let mut laws = ["contact.friction", "law.friction"].into_iter();
        laws.find_map(|key| number(config(name, key)).filter(|_| one))
    });
    found.filter(|friction| *friction > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::scratch::Scratch;
    use serde_json::json;

    fn run(scratch: &Scratch, material: &str) -> RunFiles {
        let text = format!(
            "[run]\nthickness_m = 1e-3\n[[participant]]\nname = \"rail\"\nkind = \"fem\"\n[participant.config]\nplane = \"strain\"\nmesh.crown_radius_m = 0.3\nmaterial = {{ kind = \"{material}\", young_pa = 102.5e9, poisson = 0.3 }}\n[[participant]]\nname = \"layer\"\nkind = \"dem\"\n[participant.config]\nlaw.friction = 0.3\nwheel.radius_m = 0.0\n"
        );
        std::fs::create_dir_all(scratch.path()).expect("writable");
        std::fs::write(scratch.path().join("scenario.toml"), text).expect("writable");
        RunFiles {
            path: scratch.path().into(),
            summary: json!({"results": {"load_n": 8000.0}}),
            ..RunFiles::default()
        }
    }

    /// a = sqrt(4 8e6 0.3 / (π 102.5e9 / 0.91)) = 5.2086 mm, p0 = 2 8e6 / (π a) = 977.81 MPa.
    #[test]
    fn the_half_ellipse_has_the_width_and_the_load_of_the_textbook() {
        let scratch = Scratch::new("line-contact", 1);
        let of = run(&scratch, "elastic");
        let contact = LineContact::of(&of).expect("a wheel on a crown");
        let (x, p) = contact.hertz();
        assert!(
            (x[x.len() - 1] - 5.2086e-3).abs() < 2e-7,
            "{}",
            x[x.len() - 1]
        );
        assert!(
            (p[p.len() / 2] - 977.8e6).abs() < 0.1e6,
            "{}",
            p[p.len() / 2]
        );
        let under = x.windows(2).zip(p.windows(2));
        let load: f64 = under
            .map(|(x, p)| 0.5 * (x[1] - x[0]) * (p[0] + p[1]))
            .sum();
        assert!((load / 8e6 - 1.0).abs() < 1e-3, "{load}");
        assert_eq!(friction(&of), Some(0.3));
    }

    #[test]
    fn a_plastic_body_has_no_half_ellipse() {
        let scratch = Scratch::new("line-contact-plastic", 1);
        assert!(LineContact::of(&run(&scratch, "j2")).is_none());
    }
}
