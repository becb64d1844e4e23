//! Arrangement of the contacts of a state: coordination, fabric, and the distribution of forces.
//!
//! Computed once, from the state at the end of a run. Only contacts with a compressive force count.

use std::f64::consts::PI;

use protocol::larger;

use dem_kernel::bodies::Bodies;
use dem_kernel::contact::bond::{Bond, holding};
use dem_kernel::contact::graph::{agglomerates, backbone, degrees};
use dem_kernel::step::state::GrainState;

kit::results! {
    /// # Grains
    /// - `coordination`: Contacts per grain, without rattlers.
    /// - `coordination_with_rattlers`: Contacts per grain, over all grains.
    /// - `rattlers_share`: Share of rattlers: grains with fewer than two contacts.
    /// - `backbone_bodies`: Grains that remain when grains with too few contacts are removed repeatedly.
    /// - `backbone_contacts_per_body`: Contacts of the backbone over its grains: 2 in a frictionless packing that is just rigid.
    /// - `fabric_anisotropy`: Difference of the principal values of the fabric tensor: 0 where all directions of contacts are alike.
    /// - `fabric_direction_deg`: Direction in which most contacts point, from x towards y.
    /// - `contact_force_mean_n`: Mean normal force of the closed contacts.
    /// - `contact_force_max_over_mean`: The largest normal force of a closed contact over the mean.
    /// - `contact_force_deviation_over_mean`: Standard deviation of the normal forces of the closed
    ///   contacts over their mean.
    /// - `contact_force_above_mean_share`: Share of the contacts that carry more than the mean:
    ///   0.39 in a broad distribution, 0.5 in a symmetric one.
    /// # Bonds
    /// - `agglomerates`: Groups of at least two grains that bonds, or the attraction of grains that
    ///   touch, hold together at the end.
    /// - `agglomerate_grains_max`: Grains in the largest agglomerate.
    /// - `agglomerate_grains_mean`: Grains in the agglomerate of a grain, mean over all grains; 1 where each grain is alone.
}

/// Number of contacts below which a grain is a rattler: two is the least that can hold a disk.
const HELD: usize = 2;

/// Results on the arrangement of contacts.
///
/// - `coordination`: contacts per body with at least two, each counted on both its bodies; a cluster is one body. With rattlers the mean is over all
///   bodies; `rattlers_share` is the part of the bodies with fewer than two.
/// - `fabric_anisotropy`: difference of the principal values of the fabric, the mean of n (x) n over the contacts (Satake 1982):
///   0 when all directions are alike, 1 when all contacts are parallel. `fabric_direction_deg` is the direction in which
///   most contacts point, from x towards y.
/// - `contact_force_mean_n` and the next three: mean, largest and standard deviation of the normal forces, and the part of the contacts that carry
///   more than the mean: 0.39 in a broad distribution, 0.5 in a symmetric one.
/// - `backbone_bodies`: bodies that remain when bodies with too few contacts, fewer than 3 without friction and 2 with it, are removed repeatedly;
///   `backbone_contacts_per_body`: contacts of these bodies, each counted once, also with walls, wheel and glued disks, over their number: 2 in a
///   packing without friction that is just rigid (Moukarzel 1998).
pub fn results(bodies: &Bodies, state: &GrainState) -> Vec<(&'static str, f64)> {
    let slots = || state.list.pressing();
    let forces: Vec<f64> = slots().map(|slot| slot.force[0]).collect();
    let all = degrees(bodies.free, contacts(bodies, state));
    let leads = |body: &usize| bodies.clusters.leader_of(*body) == *body;
    let present = state.grains(bodies).filter(leads);
    let degrees: Vec<usize> = present.map(|body| all[body]).collect();
    let grains = degrees.len();
    let held: Vec<usize> = degrees.iter().copied().filter(|d| *d >= HELD).collect();
    let per = |sum: usize, count: usize| sum as f64 / count.max(1) as f64;
    let positions = state.positions(bodies);
    let [mut xx, mut xy, mut yy] = [0.0; 3];
    for slot in slots() {
        let [x, y] = positions.proximity(slot.a as usize, slot.b as usize).normal;
        for (sum, product) in [(&mut xx, x * x), (&mut xy, x * y), (&mut yy, y * y)] {
            *sum += product / forces.len() as f64;
        }
    }
    let count = forces.len().max(1) as f64;
    let mean = forces.iter().fold(0.0, |sum, f| sum + f) / count;
    let variance = forces.iter().fold(0.0, |sum, f| sum + (f - mean).powi(2)) / count;
    let largest = forces.iter().copied().fold(0.0, larger);
    let over_mean = |force: f64| if mean > 0.0 { force / mean } else { 0.0 };
    let deviation = over_mean(variance.sqrt());
    let strong = forces.iter().filter(|f| **f > mean).count();
    let direction = 0.5 * (2.0 * xy).atan2(xx - yy);
    let least = if bodies.law.friction == 0.0 { 3 } else { HELD };
    let backbone = backbone(bodies.free, contacts(bodies, state).collect(), least);
    let named = [
        ("backbone_bodies", backbone[0] as f64),
        ("backbone_contacts_per_body", per(backbone[1], backbone[0])),
        ("coordination", per(held.iter().sum(), held.len())),
        (
            "coordination_with_rattlers",
            per(degrees.iter().sum(), grains),
        ),
        ("rattlers_share", per(grains - held.len(), grains)),
        ("fabric_anisotropy", (xx - yy).hypot(2.0 * xy)),
        ("fabric_direction_deg", direction.to_degrees()),
        ("contact_force_mean_n", mean),
        ("contact_force_max_over_mean", over_mean(largest)),
        ("contact_force_deviation_over_mean", deviation),
        ("contact_force_above_mean_share", per(strong, forces.len())),
    ];
    let mut results = named.to_vec();
    results.extend(agglomerate_results(bodies, state));
    results
}

/// `agglomerates`: number with at least two grains; `agglomerate_grains_max`, `agglomerate_grains_mean`: grains in the largest, and on average in the
/// agglomerate of a grain, 1 where all are alone. Empty where nothing holds grains together.
fn agglomerate_results(bodies: &Bodies, state: &GrainState) -> Vec<(&'static str, f64)> {
    let Some(sizes) = agglomerate_sizes(bodies, state) else {
        return Vec::new();
    };
    let present: Vec<u32> = state.grains(bodies).map(|grain| sizes[grain]).collect();
    // Each of n grains counts the n-th part of its agglomerate.
    let joined = present.iter().filter(|size| **size > 1);
    let parts = joined.map(|size| 1.0 / f64::from(*size));
    let largest = present.iter().max().copied().unwrap_or_default();
    let sum: f64 = present.iter().map(|size| f64::from(*size)).sum();
    vec![
        ("agglomerates", parts.sum::<f64>().round() + 0.0),
        ("agglomerate_grains_max", f64::from(largest)),
        ("agglomerate_grains_mean", sum / present.len().max(1) as f64),
    ]
}

/// Number of grains in the agglomerate of each free grain, connected by unbroken bonds or by the contacts of grains that attract each other.
pub fn agglomerate_sizes(bodies: &Bodies, state: &GrainState) -> Option<Vec<u32>> {
    if bodies.law.cohesion.is_some() {
        return Some(agglomerates(bodies.free, holding(&state.bonds)));
    }
    bodies.attracts().then(|| {
        let touching = state.list.pressing().filter(|slot| slot.attraction > 0.0);
        agglomerates(bodies.free, touching.map(|slot| (slot.a, slot.b)))
    })
}

/// Tensile and shear strength of a bonded packing as a material (Pa), phi Z F/(pi d t), after Rumpf (1958), in the plane. A cut of unit length
/// crosses 2 phi Z/(pi d^2) d |cos| bonds of each direction, and each bears F |cos| across it, the mean of cos^2 being a half. Z is the number of
/// bonds per grain, F the mean force that breaks a bond in tension, l sqrt(w Cn), or in shear, l sqrt(w Ct), d the mean diameter, t the thickness.
/// `None` without bonds.
pub fn bonded_strength(
    bodies: &Bodies,
    bonds: &[Bond],
    solid_fraction: f64,
    thickness_m: f64,
) -> Option<[f64; 2]> {
    let law = bodies.law.cohesion.filter(|_| !bonds.is_empty())?;
    let ends = bonds.iter().flat_map(|bond| [bond.a, bond.b]);
    let ends = ends.filter(|end| (*end as usize) < bodies.free).count();
    let coordination = ends as f64 / bodies.free as f64;
    let area = bonds.iter().map(|bond| bond.area).sum::<f64>() / bonds.len() as f64;
    let crossed = solid_fraction * coordination / (PI * 2.0 * bodies.mean_radius() * thickness_m);
    let strength = |stiffness: f64| crossed * area * (law.energy * stiffness).sqrt();
    Some([law.normal, law.tangential].map(strength))
}

/// The bodies of the contacts that press, clusters as one body.
fn contacts(bodies: &Bodies, state: &GrainState) -> impl Iterator<Item = [usize; 2]> {
    let leader = |body: u32| bodies.clusters.leader_of(body as usize);
    let pressing = state.list.pressing();
    pressing.map(move |slot| [leader(slot.a), leader(slot.b)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use dem_kernel::law::Law;
    use dem_kernel::law::cohesion::{Cohesion, HPrime};

    /// A triangular lattice of disks that touch, phi = pi/(2 sqrt(3)), Z = 6: across its rows two bonds a disk bear F cos 30 degrees each,
    /// so that the lattice breaks at sqrt(3) F/(d t).
    #[test]
    fn a_triangular_lattice_breaks_at_the_strength_of_rumpf() {
        let (radius, thickness) = (0.5e-3, 2e-3);
        let cohesion = Cohesion {
            normal: 4e14,
            tangential: 1e14,
            energy: 16.0,
            viscosity: 0.0,
            power: 1.0,
            h_prime: HPrime::One,
            thickness,
            alert: 1e-9,
            bonds_min: 0,
            damping: 0.0,
        };
        let bodies = Bodies {
            free: 100,
            radii: vec![radius; 100],
            law: Law {
                cohesion: Some(cohesion),
                ..Law::default()
            },
            ..Bodies::default()
        };
        // Three bonds for each grain, two of them to the next row, in a strip that repeats.
        let bonds: Vec<Bond> = (0..300)
            .map(|k| Bond::new(&bodies, &cohesion, [k % 100, (k + 1) % 100], 0.0))
            .collect();
        let solid_fraction = PI / (2.0 * f64::sqrt(3.0));
        let found = bonded_strength(&bodies, &bonds, solid_fraction, thickness);
        // l = r/2 t, and F = l sqrt(w Cn) = 0.5e-6 x 8e7 = 40 N; Ct is a quarter of Cn.
        let tension = f64::sqrt(3.0) * 40.0 / (2.0 * radius * thickness);
        let [in_tension, in_shear] = found.expect("it is bonded");
        assert!((in_tension / tension - 1.0).abs() < 1e-12, "{in_tension:e}");
        assert!((in_shear / tension - 0.5).abs() < 1e-12, "{in_shear:e}");
        assert_eq!(
            bonded_strength(&bodies, &[], solid_fraction, thickness),
            None
        );
    }
}
