//! Fields as VTK XML unstructured grids, readable by ParaView.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use crate::error::FemError;
use crate::integrate::State;
use crate::model::Model;
use crate::probe;
use crate::wheel::{ContactStatus, NodeContact};

/// Type number of a quadrilateral in VTK.
const VTK_QUAD: u8 = 9;

/// Writes displacement, velocity and centroid stresses of a state, and the contacts of the upper edge if it has any.
pub(crate) fn write(
    path: &Path,
    model: &Model,
    state: &State,
    contacts: &[NodeContact],
) -> Result<(), FemError> {
    let folder = path.parent().map_or(Ok(()), fs::create_dir_all);
    FemError::written(path, folder)?;
    FemError::written(path, fs::write(path, document(model, state, contacts)))
}

/// The whole file as text.
fn document(model: &Model, state: &State, contacts: &[NodeContact]) -> String {
    let (mesh, layout) = (&model.mesh, model.body.layout);
    let nodes = || mesh.nodes();
    let vector = |field: &[f64], node| {
        let [x, y] = [0, 1].map(|k| field[layout.index(node, k)]);
        [x, y, 0.0]
    };
    let elements = || mesh.element_indices();
    let stress = |element| probe::stress(model, state, element, [0.0, 0.0]);
    let stresses: Vec<[f64; 3]> = elements().map(stress).collect();
    let mut file = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
        mesh.points.len(),
        mesh.elements()
    );
    file.push_str("<Points>\n");
    let points = mesh.points.iter().flat_map(|p| [p[0], p[1], 0.0]);
    array(&mut file, "points", 3, points);
    file.push_str("</Points>\n<Cells>\n");
    cells(&mut file, model);
    file.push_str("</Cells>\n<PointData>\n");
    for (name, field) in [("displacement_m", &state.u), ("velocity_m_per_s", &state.v)] {
        array(&mut file, name, 3, nodes().flat_map(|n| vector(field, n)));
    }
    if !contacts.is_empty() {
        let seam = contacts.first().filter(|_| mesh.periodic);
        let edge = || contacts.iter().chain(seam).map(status);
        let below = mesh.points.len() - edge().count();
        let status = edge().chain(std::iter::repeat_n(-1.0, below));
        array(&mut file, "node_status", 1, status);
    }
    file.push_str("</PointData>\n<CellData>\n");
    let pressure = elements().map(|element| probe::pressure(model, state, element, [0.0, 0.0]));
    array(&mut file, "hydrostatic_pressure_pa", 1, pressure);
    let names = ["sigma_xx_pa", "sigma_yy_pa", "sigma_xy_pa"];
    for (k, name) in names.into_iter().enumerate() {
        array(&mut file, name, 1, stresses.iter().map(|stress| stress[k]));
    }
    file.push_str("</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
    file
}

/// 0 open, 1 stick, 2 slip; -1 marks nodes that cannot touch the wheel.
fn status(contact: &NodeContact) -> f64 {
    match contact.status {
        ContactStatus::Open => 0.0,
        ContactStatus::Stick => 1.0,
        ContactStatus::Slip => 2.0,
    }
}

fn cells(file: &mut String, model: &Model) {
    let mesh = &model.mesh;
    let corners = mesh.element_indices().flat_map(|[i, j]| mesh.corners(i, j));
    let corners = corners.map(|node| mesh.number(node));
    integers(file, "connectivity", "Int64", corners);
    let offsets = (1..=mesh.elements()).map(|k| 4 * k);
    integers(file, "offsets", "Int64", offsets);
    let types = std::iter::repeat_n(usize::from(VTK_QUAD), mesh.elements());
    integers(file, "types", "UInt8", types);
}

/// Shortest decimal forms that read back as the same bits.
fn array(file: &mut String, name: &str, components: usize, values: impl Iterator<Item = f64>) {
    let words = values.map(|value| format!("{value:e} "));
    data(file, name, "Float64", components, words);
}

fn integers(file: &mut String, name: &str, kind: &str, values: impl Iterator<Item = usize>) {
    data(file, name, kind, 1, values.map(|value| format!("{value} ")));
}

fn data(
    file: &mut String,
    name: &str,
    kind: &str,
    components: usize,
    words: impl Iterator<Item = String>,
) {
    writeln!(
        file,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"ascii\">"
    )
    .expect("a string takes what it is given");
    file.extend(words);
    file.push_str("\n</DataArray>\n");
}
