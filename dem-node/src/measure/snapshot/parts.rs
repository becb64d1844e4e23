//! Parts shared by the files of grains and of contacts.

use dem_kernel::bodies::Bodies;
use dem_kernel::step::state::GrainState;
use kit::vtk::{DatasetKind, VtkFile};

use crate::measure::flow::Flow;
use crate::measure::loads::shown;

/// Everything that the fields of a moment show.
#[derive(Clone, Copy)]
pub struct FieldScene<'a> {
    /// The bodies.
    pub bodies: &'a Bodies,
    /// Their state.
    pub state: &'a GrainState,
    /// The flows of third body, where they are measured.
    pub flow: Option<&'a Flow>,
    /// Centres of all disks at the start (m).
    pub start: &'a [[f64; 2]],
    /// Thickness of the scene (m).
    pub thickness: f64,
}

/// PolyData of these numbers of points, vertices and lines.
pub(super) fn poly_data([points, vertices, lines]: [usize; 3]) -> VtkFile {
    let sizes = [
        ("NumberOfPoints", points),
        ("NumberOfVerts", vertices),
        ("NumberOfLines", lines),
        ("NumberOfStrips", 0),
        ("NumberOfPolys", 0),
    ];
    VtkFile::new("PolyData", &sizes)
}

/// Centres of all disks, folded into a strip that repeats, and more points.
pub(super) fn points(file: &mut VtkFile, scene: &FieldScene, more: impl Iterator<Item = [f64; 2]>) {
    let centres = scene.state.centres.iter().copied();
    let points = centres.chain(more).map(|point| {
        let [x, y] = shown(scene.bodies, point);
        [x, y, 0.0]
    });
    file.array(DatasetKind::Float64, "points", points);
}

/// Cells of `points` points each.
pub(super) fn cells(
    file: &mut VtkFile,
    points: usize,
    numbers: impl ExactSizeIterator<Item = f64>,
) {
    let cells = numbers.len() / points;
    file.array(DatasetKind::Int64, "connectivity", numbers.map(|n| [n]));
    let offsets = (1..=cells).map(|cell| [(points * cell) as f64]);
    file.array(DatasetKind::Int64, "offsets", offsets);
}
