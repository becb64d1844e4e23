//! Fields as VTK XML unstructured grids, readable by ParaView.

use std::iter::repeat_n;
use std::path::Path;

use fem_kernel::integrate::state::NodalState;
use fem_kernel::wheel::node_contact::{ContactStatus, NodeContact};
use kit::vtk::{DatasetKind, VtkFile};

use crate::error::FemError;
use crate::model::Model;
use crate::model::heat::HeatState;
use crate::output::probe;
use crate::output::profile::ContactProfile;

/// Type number of a quadrilateral in VTK.
const VTK_QUAD: f64 = 9.0;

/// Contacts of the upper edge and their tractions, where there are any, and the heat of the body.
pub(crate) type SurfaceFields<'a> = (&'a [NodeContact], Option<&'a ContactProfile>, &'a HeatState);

/// Writes displacement, velocity, stresses at the centroids and, of a plastic body, the plastic strain there (mean of the points
/// of the element), temperatures, and the contacts of the upper edge, if it has any. Points are positions in the undeformed body.
pub(crate) fn write(
    path: &Path,
    model: &Model,
    state: &NodalState,
    (contacts, profile, heat): SurfaceFields,
) -> Result<(), FemError> {
    let mesh = &model.mesh;
    let sizes = [
        ("NumberOfPoints", mesh.points.len()),
        ("NumberOfCells", mesh.elements()),
    ];
    let mut file = VtkFile::new("UnstructuredGrid", &sizes);
    file.section("Points", |file| {
        let points = mesh.points.iter().map(|p| [p[0], p[1], 0.0]);
        file.array(DatasetKind::Float64, "points", points);
    });
    file.section("Cells", |file| cells(file, model));
    file.section("PointData", |file| {
        point_data(file, model, state);
        contact_data(file, model, contacts, profile);
        if let Some(of) = &model.heat {
            let each = |node| [of.start + of.body.rise(&heat.field, node)];
            let all = mesh.nodes().map(each);
            file.array(DatasetKind::Float64, "temperature_k", all);
        }
    });
    file.section("CellData", |file| cell_data(file, model, state));
    let folder = path.parent().map_or(Ok(()), std::fs::create_dir_all);
    FemError::written(path, folder.and_then(|()| file.write(path)))
}

fn cells(file: &mut VtkFile, model: &Model) {
    let mesh = &model.mesh;
    let corners = mesh.element_indices().map(|[i, j]| {
        let corners = mesh.corners(i, j);
        corners.map(|node| mesh.number(node) as f64)
    });
    // One number per tuple: otherwise a reader takes the corners of an element for a vector.
    let corners = corners.flatten().map(|node| [node]);
    file.array(DatasetKind::Int64, "connectivity", corners);
    let offsets = (1..=mesh.elements()).map(|k| [4.0 * k as f64]);
    file.array(DatasetKind::Int64, "offsets", offsets);
    let types = repeat_n([VTK_QUAD], mesh.elements());
    file.array(DatasetKind::UInt8, "types", types);
}

fn point_data(file: &mut VtkFile, model: &Model, state: &NodalState) {
    let layout = model.body.layout;
    for (name, field) in [("displacement_m", &state.u), ("velocity_m_per_s", &state.v)] {
        let vector = |node| {
            let [x, y] = [0, 1].map(|k| field[layout.index(node, k)]);
            [x, y, 0.0]
        };
        file.array(DatasetKind::Float64, name, model.mesh.nodes().map(vector));
    }
}

/// Status and tractions of the upper edge, whose nodes come first; nodes below have neither.
fn contact_data(
    file: &mut VtkFile,
    model: &Model,
    contacts: &[NodeContact],
    profile: Option<&ContactProfile>,
) {
    if contacts.is_empty() {
        return;
    }
    let nodes = model.mesh.points.len();
    // A periodic mesh repeats its first node at its right edge.
    let edge = |values: Vec<f64>, below: f64| {
        let seam = values.first().copied().filter(|_| model.mesh.periodic);
        let all = values.into_iter().chain(seam);
        all.chain(std::iter::repeat(below))
            .take(nodes)
            .map(|value| [value])
    };
    let statuses = contacts.iter().map(status).collect();
    file.array(DatasetKind::Int8, "node_status", edge(statuses, -1.0));
    if let Some(profile) = profile {
        for (name, values) in [
            ("contact_pressure_pa", &profile.pressure),
            ("contact_shear_pa", &profile.shear),
        ] {
            file.array(DatasetKind::Float64, name, edge(values.clone(), 0.0));
        }
    }
}

/// 0 open, 1 stick, 2 slip; -1 marks nodes that cannot touch the wheel.
fn status(contact: &NodeContact) -> f64 {
    match contact.status {
        ContactStatus::Open => 0.0,
        ContactStatus::Stick => 1.0,
        ContactStatus::SlipForward | ContactStatus::SlipBackward => 2.0,
    }
}

fn cell_data(file: &mut VtkFile, model: &Model, state: &NodalState) {
    const CENTROID: [f64; 2] = [0.0, 0.0];
    let elements = || model.mesh.element_indices();
    let pressures = elements().map(|element| probe::pressure(model, state, element, CENTROID));
    let pressures: Vec<f64> = pressures.collect();
    let stresses = elements().map(|element| probe::stress(model, state, element, CENTROID));
    let stresses: Vec<[f64; 3]> = stresses.collect();
    let pressure = pressures.iter().map(|pressure| [*pressure]);
    file.array(DatasetKind::Float64, "hydrostatic_pressure_pa", pressure);
    let names = ["sigma_xx_pa", "sigma_yy_pa", "sigma_xy_pa"];
    for (k, name) in names.into_iter().enumerate() {
        let component = stresses.iter().map(|stress| [stress[k]]);
        file.array(DatasetKind::Float64, name, component);
    }
    // The pressure is a third of the trace, out of the plane included.
    let across = stresses.iter().zip(&pressures);
    let across = across.map(|([xx, yy, _], pressure)| [-3.0 * pressure - xx - yy]);
    file.array(DatasetKind::Float64, "sigma_zz_pa", across);
    if model.plastic().is_some() {
        let strain = |element| [model.body.plastic_strain(&state.history, element, CENTROID)[3]];
        let strains = elements().map(strain);
        file.array(DatasetKind::Float64, "plastic_strain", strains);
    }
}
