//! The numbers in the VTK files that participants wrote.

pub use coordinator::output::vtk_arrays::{Arrays, read};

/// The numbers of an array; none where a file does not hold it.
pub fn numbers<'a>(arrays: &'a Arrays, name: &str) -> &'a [f64] {
    arrays.get(name).map_or(&[], Vec::as_slice)
}

/// The points of a file (m): nodes before the deformation, current centres of grains.
pub fn points(arrays: &Arrays) -> Vec<[f64; 2]> {
    let points = numbers(arrays, "points").chunks_exact(3);
    points.map(|p| [p[0], p[1]]).collect()
}

/// A flag of each point of a file; false where the file has no such array.
pub fn flags(arrays: &Arrays, name: &str) -> Vec<bool> {
    let flags = numbers(arrays, name);
    let all = 0..numbers(arrays, "points").len() / 3;
    all.map(|k| flags.get(k).is_some_and(|flag| *flag > 0.0))
        .collect()
}
