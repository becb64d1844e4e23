//! Masses of the points on the boundary, which each node needs to move by when the continuum is the side that follows.

use protocol::{Description, Surface};

use crate::error::{Result, Unfit};
use crate::keys::Interface;
use crate::mapping::Mapping;
use crate::nodal_mass::{massless_node, nodal_mass};

/// The key and its value as in messages.
const KEY: &str = "dirichlet = \"continuum\"";

/// The masses (kg) of a set's points from the description of the solver on the boundary, all of them positive.
pub(super) fn point_masses(
    interface: &Interface,
    participant: &str,
    set: &str,
    motion_driven: &Description,
    points: usize,
) -> Result<Vec<f64>> {
    let refuse = |why: String| {
        let problem = format!(
            "moves the points of participant `{participant}` by forces and needs their masses, but {why}; take dirichlet = \"wall\", or scheme = \"velocity\""
        );
        Err(Unfit::interface_key(interface, KEY, problem).into())
    };
    let Some(masses) = motion_driven.point_mass_kg.get(set) else {
        return refuse(format!("it describes none for its set `{set}`"));
    };
    if masses.len() != points {
        let count = masses.len();
        return refuse(format!(
            "it describes {count} for the {points} points of `{set}`"
        ));
    }
    let sound = |mass: &f64| *mass > 0.0 && mass.is_finite();
    match masses.iter().position(|mass| !sound(mass)) {
        None => Ok(masses.clone()),
        Some(point) => refuse(format!(
            "the mass of point {point} of `{set}` is {:e} kg",
            masses[point]
        )),
    }
}

/// Each node needs a mass of its own to move by. `mapping` is the interface's own, restricted to the exchanged nodes.
pub(super) fn refuse_massless(
    interface: &Interface,
    mapping: &Mapping,
    nodes: &Surface,
    points: &Surface,
) -> Result<()> {
    let masses = nodal_mass(mapping, &points.mass_kg, &(0..nodes.len()));
    match massless_node(&masses) {
        None => Ok(()),
        Some(node) => {
            let problem = format!(
                "moves each surface node by the masses of the points on it, but the node at ({:.6e}, {:.6e}) m has no mass beyond its neighbours': {} points hang on {} nodes; take a coarser mesh, smaller grains or another mapping, or dirichlet = \"wall\"",
                nodes.x_m[node],
                nodes.y_m[node],
                points.len(),
                nodes.len()
            );
            Err(Unfit::interface_key(interface, KEY, problem).into())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn description(masses: &[f64]) -> Description {
        Description {
            point_mass_kg: [("base".to_string(), masses.to_vec())].into(),
            ..Description::default()
        }
    }

    #[test]
    fn masses_that_are_missing_or_nonsense_are_refused_by_name() {
        let text = "name = \"glue\"\nbetween = [\"a.x\", \"b.base\"]\nscheme = \"fixed-point-serial\"\nsubsteps = 2\ntolerance_rel = 1e-5\ndirichlet = \"continuum\"";
        let interface: Interface = toml::from_str(text).expect("the keys are valid");
        let masses = |motion_driven: &Description| {
            point_masses(&interface, "layer", "base", motion_driven, 2)
        };
        assert_eq!(
            masses(&description(&[1.0, 2.0])).expect("sound"),
            [1.0, 2.0]
        );
        let cases = [
            (Description::default(), "none for its set `base`"),
            (description(&[1.0]), "1 for the 2 points"),
            (description(&[1.0, 0.0]), "point 1 of `base` is 0e0 kg"),
            (description(&[f64::NAN, 1.0]), "point 0"),
            (description(&[1.0, -1.0]), "-1e0 kg"),
        ];
        for (motion_driven, said) in cases {
            let error = masses(&motion_driven)
                .expect_err("it must be refused")
                .to_string();
            for said in [said, "interface.glue.dirichlet", "`layer`"] {
                assert!(error.contains(said), "no {said} in {error}");
            }
        }
    }
}
