//! The fields of a part as VTKHDF 2.2 for `vtkHDFReader`: its VTK XML files gathered in one file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::{fs, io};

use hdf5_pure::{self as hdf5, AttrValue, File};

use crate::fields::{StoredArray, stored};
use scenario::error::{Error, Refusal, Result};

/// Sections of cells in VTK XML, and their groups in VTKHDF.
type Groups = &'static [(&'static str, &'static str)];
const GRID: Groups = &[("Cells", "")];
const POLYGONS: Groups = &[
    ("Verts", "Vertices/"),
    ("Lines", "Lines/"),
    ("Polys", "Polygons/"),
    ("Strips", "Strips/"),
];

/// Parts of the names of the offset datasets, which count meshes, points, cells and corners of cells.
const STARTS: [&str; 4] = ["Part", "Point", "Cell", "ConnectivityId"];
/// Arrays of cells.
const CELLS: [&str; 3] = ["connectivity", "offsets", "types"];

/// Gathers the files of a part (at least one), each with its time (s). Successive moments with the same points and
/// cells share them. The whole part is in memory during the call.
///
/// # Errors
/// A file cannot be read or written, or holds data that VTKHDF cannot store.
pub fn write(path: &Path, moments: &[(f64, PathBuf)]) -> Result<()> {
    let is_grid = moments[0].1.extension().is_some_and(|end| end == "vtu");
    let groups = if is_grid { GRID } else { POLYGONS };
    let mut datasets = Datasets::default();
    let (mut mesh, mut starts, mut outline) = (Vec::new(), Vec::new(), Vec::new());
    for (time_s, file) in moments {
        let is_data = |array: &StoredArray| array.section.ends_with("Data");
        let (data, new): (Vec<_>, Vec<_>) = stored(file)?.into_iter().partition(is_data);
        let of = |a: &StoredArray| format!("{} {} {} {}", a.section, a.name, a.kind, a.components);
        let own: Vec<String> = data.iter().map(of).collect();
        if !is_whole(groups, &new) || !mesh.is_empty() && own != outline {
            let problem =
                "has other arrays than the moments before, or data that VTKHDF cannot store";
            return Err(Refusal::file(file, problem).into());
        }
        if new != mesh {
            starts = datasets.append_mesh(groups, &new);
        }
        (mesh, outline) = (new, own);
        datasets.append("Steps/Values", "Float64", 1, &[*time_s]);
        datasets.append_numbers("Steps/NumberOfParts", &[1.0]);
        for (name, starts) in STARTS.iter().zip(&starts) {
            let name = format!("Steps/{name}Offsets");
            datasets.append(&name, "Int64", starts.len(), starts);
        }
        for array in &data {
            let name = format!("{}/{}", array.section, array.name);
            let offsets = format!("Steps/{}Offsets/{}", array.section, array.name);
            datasets.append_numbers(&offsets, &[datasets.rows(&name)]);
            datasets.append(&name, &array.kind, array.components, &array.numbers);
        }
    }
    // Under another name until it is complete.
    let part = path.with_extension("vtkhdf.part");
    let written = datasets.write(&part, is_grid, moments.len() as i64);
    let written = written.map_err(io::Error::other);
    let written = written.and_then(|()| fs::rename(&part, path));
    if written.is_err() {
        let _ = fs::remove_file(&part);
    }
    written.map_err(Error::output(path.display()))
}

/// True for one set of points and cells, without anything else.
fn is_whole(groups: Groups, mesh: &[StoredArray]) -> bool {
    let known = groups.iter().flat_map(|g| CELLS.map(|name| (g.0, name)));
    let has = |known: &(&str, &str)| mesh.iter().any(|a| (&*a.section, &*a.name) == *known);
    let points = mesh.iter().filter(|a| a.section == "Points").count();
    points == 1 && mesh.len() == 1 + known.filter(has).count()
}

/// Datasets by their names below `VTKHDF`.
#[derive(Default)]
struct Datasets(BTreeMap<String, StoredArray>);

impl Datasets {
    fn rows(&self, name: &str) -> f64 {
        let rows = self.0.get(name).map(|a| a.numbers.len() / a.components);
        rows.unwrap_or(0) as f64
    }

    fn append(&mut self, name: &str, kind: &str, components: usize, numbers: &[f64]) {
        let dataset = self.0.entry(name.into()).or_default();
        (dataset.kind, dataset.components) = (kind.into(), components);
        dataset.numbers.extend(numbers);
    }

    fn append_numbers(&mut self, name: &str, numbers: &[f64]) {
        self.append(name, "Int64", 1, numbers);
    }

    /// Appends a mesh; returns its offsets in the order of [`STARTS`].
    fn append_mesh(&mut self, groups: Groups, mesh: &[StoredArray]) -> Vec<Vec<f64>> {
        let meshes = self.rows("NumberOfPoints");
        let mut starts = vec![vec![meshes], vec![self.rows("Points")], vec![], vec![]];
        let points = mesh.iter().find(|array| array.section == "Points");
        let points = points.expect("a whole mesh has points");
        self.append("Points", &points.kind, 3, &points.numbers);
        self.append_numbers("NumberOfPoints", &[points.numbers.len() as f64 / 3.0]);
        for (section, group) in groups {
            let [ids, ends, types] = CELLS.map(|name| {
                let is_it = |a: &&StoredArray| a.section == *section && a.name == name;
                let array = mesh.iter().find(is_it);
                array.map_or(Vec::new(), |array| array.numbers.clone())
            });
            // Each mesh has one more offset than cells.
            starts[2].push(self.rows(&format!("{group}Offsets")) - meshes);
            starts[3].push(self.rows(&format!("{group}Connectivity")));
            for (name, numbers) in [
                ("NumberOfCells", vec![ends.len() as f64]),
                ("NumberOfConnectivityIds", vec![ids.len() as f64]),
                ("Connectivity", ids),
                ("Offsets", [vec![0.0], ends].concat()),
            ] {
                self.append_numbers(&format!("{group}{name}"), &numbers);
            }
            if groups == GRID {
                self.append("Types", "UInt8", 1, &types);
            }
        }
        starts
    }

    fn write(self, path: &Path, is_grid: bool, steps: i64) -> Result<(), hdf5::Error> {
        let file = File::create(path)?;
        let names = self.0.keys().filter_map(|name| name.rsplit_once('/'));
        let groups: BTreeSet<&str> = names.map(|(group, _)| group).collect();
        let top = file.root().create_group("VTKHDF")?;
        for group in groups {
            top.create_group(group)?;
        }
        let kind = ["PolyData", "UnstructuredGrid"][usize::from(is_grid)];
        top.set_attr("Type", AttrValue::AsciiString(kind.into()))?;
        top.set_attr("Version", AttrValue::I64Array(vec![2, 2]))?;
        top.group("Steps")?
            .set_attr("NSteps", AttrValue::I64(steps))?;
        for (name, of) in self.0 {
            let shape = [of.numbers.len() / of.components, of.components].map(|n| n as u64);
            top.create_dataset(&name, |to| fill(to, &of.kind, &of.numbers, &shape))?;
            file.commit()?;
        }
        file.close()
    }
}

fn fill(to: &mut hdf5::DatasetBuilder, kind: &str, numbers: &[f64], shape: &[u64; 2]) {
    let to = match kind {
        "Float32" => to.with_f32_data(&numbers.iter().map(|n| *n as f32).collect::<Vec<_>>()),
        "Int64" => to.with_i64_data(&numbers.iter().map(|n| *n as i64).collect::<Vec<_>>()),
        "Int32" => to.with_i32_data(&numbers.iter().map(|n| *n as i32).collect::<Vec<_>>()),
        "Int8" => to.with_i8_data(&numbers.iter().map(|n| *n as i8).collect::<Vec<_>>()),
        "UInt8" => to.with_u8_data(&numbers.iter().map(|n| *n as u8).collect::<Vec<_>>()),
        _ => to.with_f64_data(numbers),
    };
    // Numbers are a list, vectors a table.
    to.with_shape(&shape[..1 + usize::from(shape[1] > 1)]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::scratch::Scratch;
    use kit::vtk::{DatasetKind, VtkFile};

    /// Points at these positions; the first ones are cells with one number each.
    fn grains(path: &Path, x_m: &[f64], cells: usize, array: &str) -> PathBuf {
        let sizes = [("NumberOfPoints", x_m.len()), ("NumberOfVerts", cells)];
        let mut file = VtkFile::new("PolyData", &sizes);
        file.section("Points", |file| {
            let points = x_m.iter().map(|x| [*x, 0.0, 0.0]);
            file.array(DatasetKind::Float64, "points", points);
        });
        file.section("Verts", |file| {
            let ids = (0..cells).map(|cell| [cell as f64]);
            file.array(DatasetKind::Int64, "connectivity", ids);
            let ends = (1..=cells).map(|end| [end as f64]);
            file.array(DatasetKind::Int64, "offsets", ends);
        });
        file.section("CellData", |file| {
            let numbers = (0..cells).map(|cell| [cell as f64]);
            file.array(DatasetKind::UInt8, array, numbers);
        });
        file.write(path).expect("it can be written");
        path.into()
    }

    fn folder(name: &str) -> Scratch {
        let scratch = Scratch::new(name, 1);
        fs::create_dir_all(scratch.path()).expect("a folder");
        scratch
    }

    #[test]
    fn an_unchanged_mesh_is_stored_once_and_each_moment_has_the_start_of_its_rows() {
        let scratch = folder("vtkhdf");
        let file = |name: &str, x_m: &[f64], cells| {
            grains(&scratch.path().join(name), x_m, cells, "status")
        };
        let moments = [
            (0.0, file("a-1.vtp", &[0.1, 0.2], 2)),
            (1.0, file("a-2.vtp", &[0.1, 0.2], 2)),
            (2.0, file("a-3.vtp", &[0.3, 0.4, 0.5], 0)),
            (3.0, file("a-4.vtp", &[0.6], 1)),
        ];
        let path = scratch.path().join("a.vtkhdf");
        write(&path, &moments).expect("it is writable");
        let file = File::open(&path).expect("it is ours");
        let read = |name: &str| {
            let dataset = file
                .dataset(&format!("VTKHDF/{name}"))
                .expect("it is there");
            (
                dataset.shape().expect("a shape"),
                dataset.read_f64().expect("numbers"),
            )
        };
        let row = |numbers: &[f64]| (vec![numbers.len() as u64], numbers.to_vec());
        assert_eq!(read("Steps/Values"), row(&[0.0, 1.0, 2.0, 3.0]));
        assert_eq!(read("Steps/PartOffsets"), row(&[0.0, 0.0, 1.0, 2.0]));
        assert_eq!(read("Steps/PointOffsets"), row(&[0.0, 0.0, 2.0, 5.0]));
        assert_eq!(
            read("Steps/CellDataOffsets/status"),
            row(&[0.0, 2.0, 4.0, 4.0])
        );
        assert_eq!(read("NumberOfPoints"), row(&[2.0, 3.0, 1.0]));
        assert_eq!(
            read("Vertices/Offsets"),
            row(&[0.0, 1.0, 2.0, 0.0, 0.0, 1.0])
        );
        assert_eq!(read("CellData/status"), row(&[0.0, 1.0, 0.0, 1.0, 0.0]));
        assert_eq!(read("Points").0, [6, 3]);
        assert_eq!(read("Steps/CellOffsets").0, [4, 4]);
        assert_eq!(read("Steps/CellOffsets").1[12], 2.0);
    }

    #[test]
    fn a_moment_with_another_array_is_refused_and_leaves_no_file() {
        let scratch = folder("vtkhdf-other");
        let [one, other] = ["status", "glued"].map(|array| {
            let path = scratch.path().join(format!("a-{array}.vtp"));
            (0.0, grains(&path, &[0.1], 1, array))
        });
        let path = scratch.path().join("a.vtkhdf");
        let error = write(&path, &[one.clone(), other]).expect_err("`glued` is new");
        assert!(error.to_string().contains("a-glued.vtp"), "{error}");
        let left = fs::read_dir(scratch.path()).expect("it is there").count();
        assert_eq!(left, 2, "the input files");
        let nowhere = scratch.path().join("none/a.vtkhdf");
        let error = write(&nowhere, &[one]).expect_err("there is no such folder");
        assert!(matches!(error, Error::Output { .. }), "{error}");
        assert!(error.to_string().contains("none/a.vtkhdf"), "{error}");
    }
}
