//! Reads the VTK XML files of participants: arrays as text, or appended as raw bytes.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use scenario::error::{Error, Refusal, Result};

/// The data arrays of a file by their names; `points` are the coordinates.
pub type Arrays = BTreeMap<String, Vec<f64>>;

/// Range of each array of points or cells: least and largest number, or lengths of vectors; `None` for an empty array.
pub type ArrayRanges = BTreeMap<String, Option<[f64; 2]>>;

/// Start of the part that is not text.
const APPENDED: &[u8] = b"<AppendedData";

/// Longest markup in which ranges are searched (bytes); ours has 4 000.
const MARKUP: u64 = 64 << 10;

/// A data array as stored in a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StoredArray {
    /// Its section: `Points`, `Cells`, `PointData`.
    pub section: String,
    /// Its name.
    pub name: String,
    /// Type of its numbers, by its name in VTK.
    pub kind: String,
    /// Numbers in a tuple.
    pub components: usize,
    /// The numbers.
    pub numbers: Vec<f64>,
}

/// Reads every array. Of arrays with the same name (connectivity of several kinds of cells) the last is kept.
pub fn read(path: &Path) -> Result<Arrays> {
    let arrays = stored(path)?.into_iter();
    Ok(arrays.map(|array| (array.name, array.numbers)).collect())
}

/// Reads every array, with its section and type.
pub fn stored(path: &Path) -> Result<Vec<StoredArray>> {
    let bytes = fs::read(path).map_err(Error::input(path.display()))?;
    let damaged = |why: String| Refusal::file(path, format!("{why}; run the scenario again"));
    let markup = find(&bytes, APPENDED).unwrap_or(bytes.len());
    let (markup, appended) = bytes.split_at(markup);
    let text = String::from_utf8_lossy(markup);
    let mut arrays = Vec::new();
    for (section, part) in in_sections(&text) {
        let split = part.split_once('>');
        let (tag, rest) = split.ok_or_else(|| damaged("an unfinished DataArray".into()))?;
        let name = attribute(tag, "Name");
        let name = name.ok_or_else(|| damaged("a DataArray without a name".into()))?;
        let numbers = match attribute(tag, "offset") {
            None => as_text(rest),
            Some(offset) => appended_numbers(&text, appended, tag, offset),
        };
        let components = attribute(tag, "NumberOfComponents").map(str::parse);
        arrays.push(StoredArray {
            section: section.into(),
            name: name.into(),
            kind: attribute(tag, "type").unwrap_or_default().into(),
            components: components.and_then(Result::ok).unwrap_or(1),
            numbers: numbers.map_err(|why| damaged(format!("array {name} {why}")))?,
        });
    }
    Ok(arrays)
}

/// The name of the section (`Points`, `Verts`, `CellData`) and the markup of each array, from its first attribute on.
fn in_sections(markup: &str) -> Vec<(&str, &str)> {
    let is_section = |name: &&str| name.ends_with('s') || name.ends_with("Data");
    let mut section = "";
    let parts: Vec<&str> = markup.split("<DataArray ").collect();
    let pairs = parts.windows(2).map(|pair| {
        // The last opened tag; closing tags begin with a slash.
        let tags = pair[0].rsplit('<').filter(|tag| !tag.starts_with('/'));
        let mut names = tags.filter_map(|tag| tag.split([' ', '>']).next());
        section = names.find(is_section).unwrap_or(section);
        (section, pair[1])
    });
    pairs.collect()
}

/// Ranges stated in the file, computed by its author from the full numbers; empty for a file that states no ranges.
pub fn ranges(path: &Path) -> Result<ArrayRanges> {
    let mut start = Vec::new();
    File::open(path)
        .and_then(|file| file.take(MARKUP).read_to_end(&mut start))
        .map_err(Error::input(path.display()))?;
    let Some(markup) = find(&start, APPENDED) else {
        return Ok(ArrayRanges::new());
    };
    let text = String::from_utf8_lossy(&start[..markup]);
    let tags = in_sections(&text).into_iter();
    let data = tags.filter(|(section, _)| ["PointData", "CellData"].contains(section));
    let named = data.filter_map(|(_, tag)| {
        let bounds = ["RangeMin", "RangeMax"].map(|key| attribute(tag, key)?.parse().ok());
        let (name, [least, largest]) = (attribute(tag, "Name")?, bounds);
        Some((name.to_string(), Some([least?, largest?])))
    });
    Ok(named.collect())
}

fn find(bytes: &[u8], mark: &[u8]) -> Option<usize> {
    bytes.windows(mark.len()).position(|window| window == mark)
}

/// The value of an attribute of a tag.
fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = tag.split_once(&format!("{name}=\""))?;
    rest.split('"').next()
}

fn as_text(rest: &str) -> Result<Vec<f64>, String> {
    let body = rest.split("</DataArray>").next().unwrap_or_default();
    let numbers: Result<Vec<f64>, _> = body.split_ascii_whitespace().map(str::parse).collect();
    numbers.map_err(|_| "is neither text nor appended as raw bytes".into())
}

/// Numbers of an appended array, after their length in bytes.
fn appended_numbers(
    markup: &str,
    appended: &[u8],
    tag: &str,
    offset: &str,
) -> Result<Vec<f64>, String> {
    let foreign = [
        ("compressor=", "compressed"),
        ("byte_order=\"BigEndian\"", "big-endian"),
    ];
    for (mark, what) in foreign {
        if markup.contains(mark) {
            return Err(format!("is {what}, which is not supported"));
        }
    }
    let begin = find(appended, b"_").ok_or("has no data behind it")? + 1;
    if !String::from_utf8_lossy(&appended[..begin]).contains("\"raw\"") {
        return Err("is not encoded as raw, which is not supported".into());
    }
    let offset: usize = offset.parse().map_err(|_| "has no number as its offset")?;
    let short = || format!("reaches beyond the end of the file (offset {offset})");
    let is_long = markup.contains("header_type=\"UInt64\"");
    let header = if is_long { 8 } else { 4 };
    let bytes = appended.get(begin + offset..).ok_or_else(short)?;
    let (length, bytes) = bytes.split_at_checked(header).ok_or_else(short)?;
    let length = length.iter().rev();
    let length = length.fold(0, |sum, byte| sum << 8 | usize::from(*byte));
    let bytes = bytes.get(..length).ok_or_else(short)?;
    let kind = attribute(tag, "type").unwrap_or_default();
    let (size, number) = kind_of(kind).ok_or(format!("has numbers of the kind `{kind}`"))?;
    Ok(bytes.chunks_exact(size).map(number).collect())
}

/// The value of a number from its bytes.
type Value = fn(&[u8]) -> f64;

/// Size of a number (bytes) of this kind, and its value.
fn kind_of(kind: &str) -> Option<(usize, Value)> {
    /// The bytes of a number; chunks have its size.
    fn exact<const N: usize>(bytes: &[u8]) -> [u8; N] {
        bytes.try_into().expect("chunks have this size")
    }
    Some(match kind {
        "Float64" => (8, |b| f64::from_le_bytes(exact(b))),
        "Float32" => (4, |b| f32::from_le_bytes(exact(b)).into()),
        "Int64" => (8, |b| i64::from_le_bytes(exact(b)) as f64),
        "UInt64" => (8, |b| u64::from_le_bytes(exact(b)) as f64),
        "Int32" => (4, |b| i32::from_le_bytes(exact(b)).into()),
        "UInt32" => (4, |b| u32::from_le_bytes(exact(b)).into()),
        "Int16" => (2, |b| i16::from_le_bytes(exact(b)).into()),
        "UInt16" => (2, |b| u16::from_le_bytes(exact(b)).into()),
        "Int8" => (1, |b| i8::from_le_bytes(exact(b)).into()),
        "UInt8" => (1, |b| b[0].into()),
        _ => return None,
    })
}

/// The numbers of an array; empty if the file does not hold it.
pub fn numbers<'a>(arrays: &'a Arrays, name: &str) -> &'a [f64] {
    arrays.get(name).map_or(&[], Vec::as_slice)
}

/// The points of a file (m): nodes before the deformation, current centres of grains.
pub fn points(arrays: &Arrays) -> Vec<[f64; 2]> {
    let points = numbers(arrays, "points").chunks_exact(3);
    points.map(|p| [p[0], p[1]]).collect()
}

/// A flag for each point of a file; false if the file has no such array.
pub fn flags(arrays: &Arrays, name: &str) -> Vec<bool> {
    let flags = numbers(arrays, name);
    let all = 0..numbers(arrays, "points").len() / 3;
    all.map(|k| flags.get(k).is_some_and(|flag| *flag > 0.0))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use kit::scratch::Scratch;
    use kit::vtk::{DatasetKind, VtkFile};

    fn file(name: &str) -> (Scratch, std::path::PathBuf) {
        let scratch = Scratch::new(name, 1);
        fs::create_dir_all(scratch.path()).expect("a folder");
        let path = scratch.path().join("two-hold.vtp");
        (scratch, path)
    }

    fn written(path: &Path) {
        let mut file = VtkFile::new("PolyData", &[("NumberOfPoints", 2)]);
        file.section("Points", |file| {
            let points = [[0.1, 0.2, 0.0], [f64::MIN_POSITIVE, -1e300, 0.0]];
            file.array(DatasetKind::Float64, "points", points.into_iter());
        });
        file.section("PointData", |file| {
            let speeds = [[3.0, 4.0, 0.0], [0.0, -1.0, 0.0]];
            file.array(DatasetKind::Float64, "velocity_m_per_s", speeds.into_iter());
            let counts = [[-7.0], [2.0]];
            file.array(DatasetKind::Int64, "count", counts.into_iter());
            file.array(
                DatasetKind::Float64,
                "gap_m",
                std::iter::empty::<[f64; 1]>(),
            );
        });
        file.write(path).expect("it can be written");
    }

    #[test]
    fn appended_arrays_come_back_with_all_their_bits_and_their_ranges() {
        let (_scratch, path) = file("vtk-bits");
        written(&path);
        let arrays = read(&path).expect("it is ours");
        let points = [0.1, 0.2, 0.0, f64::MIN_POSITIVE, -1e300, 0.0];
        assert_eq!(arrays["points"], points);
        assert_eq!(arrays["count"], [-7.0, 2.0]);
        let ranges = ranges(&path).expect("it is ours");
        assert_eq!(ranges["velocity_m_per_s"], Some([1.0, 5.0]));
        assert_eq!(ranges["count"], Some([-7.0, 2.0]));
        assert!(!ranges.contains_key("points"), "no data of points");
    }

    #[test]
    fn a_file_that_ends_early_is_refused_with_the_name_of_the_array() {
        let (_scratch, path) = file("vtk-torn");
        written(&path);
        let bytes = fs::read(&path).expect("it is there");
        fs::write(&path, &bytes[..bytes.len() - 60]).expect("it can be cut");
        let error = read(&path)
            .expect_err("the last arrays are cut")
            .to_string();
        assert!(error.contains("beyond the end of the file"), "{error}");
        assert!(error.contains("two-hold.vtp"), "{error}");
    }

    #[test]
    fn arrays_as_text_are_read_and_other_encodings_are_refused() {
        let (_scratch, path) = file("vtk-text");
        let array = |body: &str| {
            format!(
                "<DataArray type=\"Float64\" Name=\"radius_m\" format=\"ascii\">{body}</DataArray>"
            )
        };
        fs::write(&path, array(" 1e-3 2 ")).expect("a file");
        assert_eq!(read(&path).expect("it is text")["radius_m"], [1e-3, 2.0]);
        assert!(ranges(&path).expect("it states no ranges").is_empty());
        fs::write(&path, array("AAAA")).expect("a file");
        let error = read(&path).expect_err("it is base64").to_string();
        assert!(error.contains("radius_m"), "{error}");
    }
}
