//! The position of a mesh relative to the grains that it is joined with.
//!
//! An interface carries displacements and forces, not positions: a second continuum has its own frame, in which it has the same position
//! as the first one. Along the interface, positions in both frames agree; across it, the mesh is moved until its line of nodes meets the
//! glued grains.

use super::mesh::{MeshSide, QuadMesh, height};
use runs::fields::{Arrays, flags, numbers, points};
use runs::scene::JoinedSet;

/// Grains at the first moment, which determine the position of a mesh (m).
#[derive(Clone, Debug, Default)]
pub struct JoinedGrains {
    /// Centres of the glued grains.
    pub glued: Vec<[f64; 2]>,
    /// Centres of the free grains.
    pub free: Vec<[f64; 2]>,
    /// Largest radius.
    pub radius: f64,
}

/// The position of a mesh in the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshPosition {
    /// Distance by which the mesh is moved up (m).
    pub up: f64,
    /// The side along which the mesh carries the grains, if it does.
    pub carries: Option<MeshSide>,
    /// Remark for the page.
    pub note: Option<String>,
}

/// The position of a mesh that is joined with these grains.
///
/// # Errors
/// The position is unknown; the reason continues the name of the mesh.
pub fn beside(
    mesh: &QuadMesh,
    joint: &JoinedSet,
    grains: &JoinedGrains,
) -> Result<MeshPosition, String> {
    let side = match joint.partner_set {
        "lid" => MeshSide::Bottom,
        _ => MeshSide::Top,
    };
    let nodes = mesh.side(side);
    let line: Vec<[f64; 2]> = nodes.iter().map(|n| mesh.nodes[*n as usize]).collect();
    let gap = |grain: &[f64; 2]| Some(grain[1] - height(&line, grain[0])?);
    let gaps: Option<Vec<f64>> = grains.of(side).map(gap).collect();
    let gaps = gaps.filter(|gaps| !gaps.is_empty());
    let gaps = gaps.ok_or("has no glued grains beside it that would determine its position")?;
    let far = gaps.iter().fold(0.0, |far: f64, gap| far.max(gap.abs()));
    let carries = Some(side);
    if far <= 2.0 * grains.radius {
        return Ok(MeshPosition {
            carries,
            ..MeshPosition::default()
        });
    }
    if !["top", "bottom"].contains(&joint.set) {
        let (set, far) = (joint.set, 1e3 * far);
        return Err(format!(
            "is up to {far:.3} mm away from the grains that are glued to its set `{set}`, in an unknown frame"
        ));
    }
    let up = gaps.iter().sum::<f64>() / gaps.len() as f64;
    let (mm, set, partner, other) = (1e3 * up, joint.set, joint.partner, joint.partner_set);
    let note = format!(
        "has its own frame: drawn {mm:.3} mm higher, where its {set} meets the grains glued to it (`{partner}.{other}`)"
    );
    Ok(MeshPosition {
        up,
        carries,
        note: Some(note),
    })
}

impl JoinedGrains {
    /// The grains of a file, without the grains of a wheel and those in store.
    pub fn of_fields(arrays: &Arrays) -> JoinedGrains {
        let radii = numbers(arrays, "radius_m");
        let [glued, wheel] = ["glued", "wheel"].map(|name| flags(arrays, name));
        let centres = points(arrays).into_iter().enumerate();
        let there = |grain: usize| radii.get(grain).is_none_or(|radius| *radius > 0.0);
        let of_layer = centres.filter(|(grain, _)| there(*grain) && !wheel[*grain]);
        let (of_glued, free): (Vec<_>, Vec<_>) = of_layer.partition(|(grain, _)| glued[*grain]);
        let centres = |grains: Vec<(usize, [f64; 2])>| grains.into_iter().map(|(_, at)| at);
        JoinedGrains {
            glued: centres(of_glued).collect(),
            free: centres(free).collect(),
            radius: radii.iter().copied().fold(0.0, f64::max),
        }
    }

    /// The glued grains at the lower side of the layer, for the top of a mesh, or at the upper side, for the bottom.
    fn of(&self, side: MeshSide) -> impl Iterator<Item = &[f64; 2]> {
        let mut free = self.free.clone();
        free.sort_by(|a, b| a[0].total_cmp(&b[0]));
        self.glued.iter().filter(move |grain| {
            let middle = self.middle(&free, grain[0]);
            let below = middle.is_none_or(|middle| grain[1] < middle);
            below == (side == MeshSide::Top)
        })
    }

    /// Mean height of the free grains within five radii of a position, or the height of the nearest. `free` is sorted by x.
    fn middle(&self, free: &[[f64; 2]], x: f64) -> Option<f64> {
        let first = |x: f64| free.partition_point(|grain| grain[0] < x);
        let near = &free[first(x - 5.0 * self.radius)..first(x + 5.0 * self.radius)];
        if near.is_empty() {
            let last = free.len().checked_sub(1)?;
            return free.get(first(x).min(last)).map(|grain| grain[1]);
        }
        Some(near.iter().map(|grain| grain[1]).sum::<f64>() / near.len() as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit square below y = 0, and grains glued at 0 and at 0.5 with a free grain between them.
    fn scene() -> (QuadMesh, JoinedGrains) {
        let nodes = [[0.0, -1.0], [1.0, -1.0], [1.0, 0.0], [0.0, 0.0]];
        let mesh = QuadMesh {
            nodes: nodes.into(),
            quads: vec![[0, 1, 2, 3]],
        };
        let grains = JoinedGrains {
            glued: vec![[0.5, 0.01], [0.5, 0.51]],
            free: vec![[0.5, 0.25]],
            radius: 0.05,
        };
        (mesh, grains)
    }

    fn joint(set: &'static str, partner_set: &'static str) -> JoinedSet<'static> {
        JoinedSet {
            set,
            partner: "layer",
            partner_set,
        }
    }

    #[test]
    fn a_mesh_that_meets_its_grains_stays() {
        let (mesh, grains) = scene();
        let position = beside(&mesh, &joint("top", "base"), &grains).expect("it is known");
        let carries = Some(MeshSide::Top);
        let (up, note) = (0.0, None);
        assert_eq!(position, MeshPosition { up, carries, note });
    }

    #[test]
    fn a_second_continuum_is_moved_to_the_grains_of_the_lid() {
        let (mesh, grains) = scene();
        let position = beside(&mesh, &joint("bottom", "lid"), &grains).expect("it is known");
        assert!((position.up - 1.51).abs() < 1e-12, "{}", position.up);
        assert_eq!(position.carries, Some(MeshSide::Bottom));
        assert!(
            position
                .note
                .expect("there is a remark")
                .contains("1510.000 mm")
        );
    }

    #[test]
    fn an_unknown_position_is_refused() {
        let (mesh, grains) = scene();
        let error = beside(&mesh, &joint("crown", "lid"), &grains).expect_err("it is not known");
        assert!(error.contains("`crown`"), "{error}");
        let none = JoinedGrains::default();
        assert!(beside(&mesh, &joint("top", "base"), &none).is_err());
    }
}
