//! The surface of an interface as VTK XML PolyData, for ParaView.

use std::path::Path;

use kit::vtk::{DatasetKind, VtkFile};

use scenario::error::{Error, Result};
use scheme::coupling::Coupling;
use scheme::group::Patch;

use crate::profile::places;

/// Writes the continuum's nodes of an interface as a line, in the undeformed body and by ascending x. Point data:
/// displacement_m, as sent to the other side; traction_pa of that side on the continuum in the last window; pressure_pa
/// and shear_pa, its components along the normal and along the surface as in profile.csv, compression positive.
pub fn write(path: &Path, coupling: &Coupling, patch: &Patch, thickness_m: f64) -> Result<()> {
    let (nodes, state) = (&coupling.group().nodes, &coupling.state);
    let places = places(nodes, patch);
    let order: Vec<usize> = places.iter().map(|place| place.node).collect();
    let lines = order.len().saturating_sub(1);
    let tractions = order.iter().map(|node| {
        let area_m2 = nodes.length_m[*node] * thickness_m;
        [0, 1].map(|k| state.lambda[2 * node + k] / area_m2)
    });
    let tractions: Vec<[f64; 2]> = tractions.collect();
    let sizes = [("NumberOfPoints", order.len()), ("NumberOfLines", lines)];
    let mut file = VtkFile::new("PolyData", &sizes);
    file.section("Points", |file| {
        let points = order.iter().map(|n| [nodes.x_m[*n], nodes.y_m[*n], 0.0]);
        file.array(DatasetKind::Float64, "points", points);
    });
    file.section("Lines", |file| {
        let ends = (0..lines).flat_map(|line| [[line as f64], [(line + 1) as f64]]);
        file.array(DatasetKind::Int64, "connectivity", ends);
        let offsets = (1..=lines).map(|line| [2.0 * line as f64]);
        file.array(DatasetKind::Int64, "offsets", offsets);
    });
    file.section("PointData", |file| {
        let moved = order.iter().map(|node| {
            let [x, y] = [0, 1].map(|k| state.displacement[2 * node + k]);
            [x, y, 0.0]
        });
        file.array(DatasetKind::Float64, "displacement_m", moved);
        let vectors = tractions.iter().map(|[x, y]| [*x, *y, 0.0]);
        file.array(DatasetKind::Float64, "traction_pa", vectors);
        let faced = || places.iter().zip(&tractions);
        let pressures = faced().map(|(place, traction)| [place.pressing(*traction)]);
        file.array(DatasetKind::Float64, "pressure_pa", pressures);
        let shears = faced().map(|(place, traction)| [place.shearing(*traction)]);
        file.array(DatasetKind::Float64, "shear_pa", shears);
    });
    file.write(path).map_err(Error::output(path.display()))
}
