//! Drawings as SVG, written into a page or a file.
//!
//! [`picture`]: a drawing with its words; [`axis`]: numbers at an axis; [`colour`]: scales of colour; [`plot`]: curves over a pair of axes.

pub mod axis;
pub mod colour;
pub mod page;
pub mod picture;
pub mod plot;
