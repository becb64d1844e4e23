//! Fields as VTK XML unstructured grids, readable by ParaView.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use crate::error::FemError;
use crate::integrate::State;
use crate::model::Model;
use crate::probe;
use crate::wheel::{Status, Touch};

/// Type number of a quadrilateral in VTK.
const VTK_QUAD: u8 = 9;

/// Writes displacement, velocity and centroid stresses of a state, and the contacts of the upper edge if it has any.
pub(crate) fn write(
    path: &Path,
    model: &Model,
    state: &State,
    touches: &[Touch],
) -> Result<(), FemError> {
    let failed = |error: std::io::Error| FemError::Write {
        path: path.into(),
        reason: error.to_string(),
    };
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(failed)?;
    }
    fs::write(path, document(model, state, touches)).map_err(failed)
}

/// The whole file as text.
fn document(model: &Model, state: &State, touches: &[Touch]) -> String {
    let (mesh, layout) = (&model.mesh, model.body.layout());
    let nodes = || mesh.nodes();
    let vector = |field: &[f64], node| {
        [
            field[layout.index(node, 0)],
            field[layout.index(node, 1)],
            0.0,
        ]
    };
    let stresses = probe::centroid_stresses(model, state);
    let mut file = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
        mesh.points().len(),
        mesh.elements()
    );
    file.push_str("<Points>\n");
    array(
        &mut file,
        "points",
        3,
        mesh.points().iter().flat_map(|p| [p[0], p[1], 0.0]),
    );
    file.push_str("</Points>\n<Cells>\n");
    cells(&mut file, model);
    file.push_str("</Cells>\n<PointData>\n");
    array(
        &mut file,
        "displacement_m",
        3,
        nodes().flat_map(|n| vector(&state.u, n)),
    );
    array(
        &mut file,
        "velocity_m_per_s",
        3,
        nodes().flat_map(|n| vector(&state.v, n)),
    );
    if !touches.is_empty() {
        let seam = touches.first().filter(|_| mesh.periodic());
        let edge = || touches.iter().chain(seam).map(status);
        let below = mesh.points().len() - edge().count();
        let status = edge().chain(std::iter::repeat_n(-1.0, below));
        array(&mut file, "node_status", 1, status);
    }
    file.push_str("</PointData>\n<CellData>\n");
    let pressure = probe::centroid_pressures(model, state).into_iter();
    array(&mut file, "hydrostatic_pressure_pa", 1, pressure);
    for (k, name) in ["sigma_xx_pa", "sigma_yy_pa", "sigma_xy_pa"]
        .into_iter()
        .enumerate()
    {
        array(&mut file, name, 1, stresses.iter().map(|stress| stress[k]));
    }
    file.push_str("</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
    file
}

/// 0 open, 1 stick, 2 slip; -1 marks nodes that cannot touch the wheel.
fn status(touch: &Touch) -> f64 {
    match touch.status {
        Status::Open => 0.0,
        Status::Stick => 1.0,
        Status::Slip => 2.0,
    }
}

fn cells(file: &mut String, model: &Model) {
    let mesh = &model.mesh;
    let corners = mesh.places().flat_map(|[i, j]| mesh.corners(i, j));
    let corners = corners.map(|node| mesh.number(node));
    integers(file, "connectivity", "Int64", corners);
    integers(
        file,
        "offsets",
        "Int64",
        (1..=mesh.elements()).map(|k| 4 * k),
    );
    let types = std::iter::repeat_n(usize::from(VTK_QUAD), mesh.elements());
    integers(file, "types", "UInt8", types);
}

/// Shortest decimal forms that read back as the same bits.
fn array(file: &mut String, name: &str, components: usize, values: impl Iterator<Item = f64>) {
    open(file, name, "Float64", components);
    for value in values {
        write!(file, "{value:e} ").expect("a string takes what it is given");
    }
    file.push_str("\n</DataArray>\n");
}

fn integers(file: &mut String, name: &str, kind: &str, values: impl Iterator<Item = usize>) {
    open(file, name, kind, 1);
    for value in values {
        write!(file, "{value} ").expect("a string takes what it is given");
    }
    file.push_str("\n</DataArray>\n");
}

fn open(file: &mut String, name: &str, kind: &str, components: usize) {
    writeln!(
        file,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"ascii\">"
    )
    .expect("a string takes what it is given");
}
