//! Errors of the mapping.

use thiserror::Error;

/// Reason why two sets of points cannot be related.
#[derive(Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum MappingError {
    #[error("one side of the interface has no points")]
    Empty,
    #[error(
        "{what} {first} and {second} have the same position ({x_m:.6e}, {y_m:.6e}) m along the surface"
    )]
    Repeated {
        what: &'static str,
        first: usize,
        second: usize,
        x_m: f64,
        y_m: f64,
    },
    #[error(
        "glued point {point} at ({x_m:.6e}, {y_m:.6e}) m lies beyond the ends of the surface line: the points lie between x = {:.6e} and {:.6e} m, the line between {:.6e} and {:.6e} m; {cure}", points_m[0], points_m[1], line_m[0], line_m[1]
    )]
    Beyond {
        point: usize,
        x_m: f64,
        y_m: f64,
        /// From where to where points and line reach along x.
        points_m: [f64; 2],
        line_m: [f64; 2],
        /// Remedy.
        cure: &'static str,
    },
    #[error(
        "the surface nodes lie between x = {left_m:.6e} and {right_m:.6e} m, which is longer than their period of {period_m:.6e} m: list each node once"
    )]
    Longer {
        left_m: f64,
        right_m: f64,
        period_m: f64,
    },
}
