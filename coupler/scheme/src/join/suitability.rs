//! Refusals of schemes that do not suit the sides that they join.

use protocol::Description;

use crate::error::{Result, Unfit};
use crate::keys::{CouplingScheme, Dirichlet, Interface, Policy};
use crate::source::ComplianceSource;

/// Refuses a scheme that one of the sides cannot follow. Each side comes with its name.
pub(super) fn refuse_unsuited(
    interface: &Interface,
    [continuum, layer]: [(&str, &Description); 2],
) -> Result<()> {
    refuse_finer_than_solver(interface, layer)?;
    refuse_without_prescribed_velocity(interface, continuum)?;
    refuse_what_is_not_offered(interface, [continuum, layer])
}

/// A fixed point iterates on the answers of the contact solver, so it cannot be more accurate than they are. The other
/// schemes close the gap for any residual of the contact solver.
fn refuse_finer_than_solver(
    interface: &Interface,
    (name, layer): (&str, &Description),
) -> Result<()> {
    let through_answers = matches!(interface.scheme(), CouplingScheme::FixedPoint { .. });
    match &layer.tolerance {
        Some(own) if through_answers && interface.tolerance_rel < own.value => {
            let problem = format!(
                "is {:e}, below participant.{name}.config.{} of {:e}: a fixed point iterates on the solver's answers and cannot be more accurate than they are; raise the first, lower the second, or take scheme = \"dual-schur\"",
                interface.tolerance_rel, own.key, own.value
            );
            Err(Unfit::interface_key(interface, "tolerance_rel", problem).into())
        }
        _ => Ok(()),
    }
}

/// Refuses a scheme that prescribes velocities for a continuum that cannot follow one.
fn refuse_without_prescribed_velocity(
    interface: &Interface,
    (name, continuum): (&str, &Description),
) -> Result<()> {
    let key = match interface.scheme() {
        CouplingScheme::Velocity { .. } => "scheme = \"velocity\"",
        _ if interface.scheme().dirichlet() == Dirichlet::ForceDriven => {
            "dirichlet = \"continuum\""
        }
        _ => return Ok(()),
    };
    if continuum.capabilities.prescribed_velocity {
        return Ok(());
    }
    let problem = format!(
        "prescribes the velocity of participant `{name}`, which cannot follow a prescribed velocity: a built-in continuum can if its material is elastic with small strains; take scheme = \"dual-schur\", or \"dual-schur-secant\" for a nonlinear continuum"
    );
    Err(Unfit::interface_key(interface, key, problem).into())
}

/// Refuses a scheme that requires a capability which one of the sides lacks. Each side comes with its name.
fn refuse_what_is_not_offered(
    interface: &Interface,
    [continuum, layer]: [(&str, &Description); 2],
) -> Result<()> {
    let refuse = |key, problem| Err(Unfit::interface_key(interface, key, problem).into());
    let mut sides = [continuum, layer].into_iter();
    if let Some((name, _)) = sides.find(|(_, side)| !side.capabilities.rollback) {
        let why =
            format!("repeats windows, which participant `{name}` cannot (it has no `checkpoint`)");
        if !matches!(interface.scheme(), CouplingScheme::Staggered { .. }) {
            let problem = format!("{why}: take scheme = \"staggered-serial\"");
            return refuse("scheme", problem);
        }
        if interface.on_not_converged == Policy::Halve {
            let problem = format!("= \"halve\" {why}: take \"stop\" or \"accept\"");
            return refuse("on_not_converged", problem);
        }
    }
    let source = ComplianceSource::of(&interface.scheme());
    let ((continuum, gives), (layer, takes)) = (continuum, layer);
    if source != ComplianceSource::Rigid && !takes.capabilities.compliant_boundary {
        let problem = format!(
            "moves the points of participant `{layer}` by the compliance of the body they are glued to, but the participant takes only a rigid boundary: take scheme = \"fixed-point-serial\" or \"staggered-serial\", with dirichlet = \"wall\""
        );
        return refuse("scheme", problem);
    }
    if source == ComplianceSource::Columns && !gives.capabilities.columns {
        let problem = format!(
            "= \"columns\" asks participant `{continuum}` for columns of its compliance, which it does not offer: set compliance = \"mass\", or take scheme = \"fixed-point-serial\""
        );
        return refuse("compliance", problem);
    }
    Ok(())
}

/// Refuses a compliance from masses where a point has no mass.
pub(super) fn refuse_weightless(
    interface: &Interface,
    continuum: &str,
    mass_kg: &[f64],
) -> Result<()> {
    let by_mass = ComplianceSource::of(&interface.scheme()) == ComplianceSource::Mass;
    let weightless = mass_kg.iter().position(|mass| *mass == 0.0);
    let Some(point) = weightless.filter(|_| by_mass) else {
        return Ok(());
    };
    let problem = format!(
        "= \"mass\" divides by the masses of the exchanged points of participant `{continuum}`, but its exchanged point {point} has no mass: give it one, set compliance = \"columns\", or take scheme = \"fixed-point-serial\""
    );
    Err(Unfit::interface_key(interface, "compliance", problem).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interface(scheme: &str, tolerance_rel: f64) -> Interface {
        let text = format!(
            "name = \"base\"\nbetween = [\"a.x\", \"b.y\"]\nscheme = \"{scheme}\"\nsubsteps = 2\ntolerance_rel = {tolerance_rel:e}"
        );
        toml::from_str(&text).expect("the keys are valid")
    }

    #[test]
    fn a_fixed_point_is_refused_below_the_tolerance_of_the_solver() {
        let motion_driven = Description {
            tolerance: Some(protocol::Tolerance {
                key: "solver.tolerance".into(),
                value: 1e-4,
            }),
            ..Description::default()
        };
        let refused = |scheme: &str, tolerance_rel: f64, motion_driven: &Description| {
            let interface = interface(scheme, tolerance_rel);
            refuse_finer_than_solver(&interface, ("layer", motion_driven)).err()
        };
        for scheme in ["fixed-point-serial", "fixed-point-parallel"] {
            let error = refused(scheme, 0.99e-4, &motion_driven)
                .expect("it is below")
                .to_string();
            for said in [
                "interface.base.tolerance_rel",
                "participant.layer.config.solver.tolerance",
            ] {
                assert!(error.contains(said), "{error}");
            }
            assert!(refused(scheme, 1e-4, &motion_driven).is_none());
            assert!(refused(scheme, 1e-9, &Description::default()).is_none());
        }
        assert!(refused("dual-schur", 1e-9, &motion_driven).is_none());
    }
}
