//! VTK XML files with arrays appended as raw bytes, little-endian, each after its length as 64 bits.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Write as _};
use std::path::Path;

use crate::bounds::wider;

/// Type of the numbers of an array, by its name in VTK.
#[derive(Clone, Copy, Debug)]
pub enum DatasetKind {
    /// Any number.
    Float64,
    /// A whole number below 2^53.
    Int64,
    /// A whole number of 32 bits.
    Int32,
    /// A whole number from -128 to 127.
    Int8,
    /// A whole number from 0 to 255.
    UInt8,
}

/// A file of one piece that is being made: its markup, and the arrays that follow it.
pub struct VtkFile {
    dataset: &'static str,
    markup: String,
    appended: Vec<u8>,
}

impl VtkFile {
    /// A piece of a dataset (`PolyData`, `UnstructuredGrid`) of these sizes.
    pub fn new(dataset: &'static str, sizes: &[(&str, usize)]) -> VtkFile {
        let sizes = sizes.iter();
        let sizes = sizes.map(|(name, size)| format!(" {name}=\"{size}\""));
        let sizes = sizes.collect::<String>();
        VtkFile {
            dataset,
            markup: format!(
                "<?xml version=\"1.0\"?>\n<VTKFile type=\"{dataset}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<{dataset}>\n<Piece{sizes}>\n"
            ),
            appended: Vec::new(),
        }
    }

    /// Adds a section (`PointData`, ...) with the arrays that `fill` adds.
    pub fn section(&mut self, name: &str, fill: impl FnOnce(&mut VtkFile)) {
        self.markup += &format!("<{name}>\n");
        fill(self);
        self.markup += &format!("</{name}>\n");
    }

    /// Adds an array of tuples, with its range as VTK defines it: of its numbers, or of the lengths of its vectors; NaN if one of them is NaN.
    pub fn array<const N: usize>(
        &mut self,
        kind: DatasetKind,
        name: &str,
        tuples: impl Iterator<Item = [f64; N]>,
    ) {
        let offset = self.appended.len();
        self.appended.extend([0; 8]);
        let mut range = None;
        for tuple in tuples {
            let size = match tuple[..] {
                [value] => value,
                _ => tuple.iter().map(|x| x * x).sum::<f64>().sqrt(),
            };
            range = Some(wider(range, size));
            for value in tuple {
                kind.append(value, &mut self.appended);
            }
        }
        let bytes = (self.appended.len() - offset - 8) as u64;
        self.appended[offset..offset + 8].copy_from_slice(&bytes.to_le_bytes());
        let range = range.map_or(String::new(), |[least, largest]| {
            format!(" RangeMin=\"{least:e}\" RangeMax=\"{largest:e}\"")
        });
        let _ = writeln!(
            self.markup,
            "<DataArray type=\"{kind:?}\" Name=\"{name}\" NumberOfComponents=\"{N}\" format=\"appended\" offset=\"{offset}\"{range}/>"
        );
    }

    /// Writes the file.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(mut self, path: &Path) -> io::Result<()> {
        let _ = write!(
            self.markup,
            "</Piece>\n</{}>\n<AppendedData encoding=\"raw\">\n_",
            self.dataset
        );
        let mut file = File::create(path)?;
        file.write_all(self.markup.as_bytes())?;
        file.write_all(&self.appended)?;
        file.write_all(b"\n</AppendedData>\n</VTKFile>\n")
    }
}

impl DatasetKind {
    fn append(self, value: f64, bytes: &mut Vec<u8>) {
        match self {
            DatasetKind::Float64 => bytes.extend_from_slice(&value.to_le_bytes()),
            DatasetKind::Int64 => bytes.extend_from_slice(&(value as i64).to_le_bytes()),
            DatasetKind::Int32 => bytes.extend_from_slice(&(value as i32).to_le_bytes()),
            DatasetKind::Int8 => bytes.extend_from_slice(&(value as i8).to_le_bytes()),
            DatasetKind::UInt8 => bytes.push(value as u8),
        }
    }
}
