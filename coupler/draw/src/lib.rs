//! Drawings as SVG, for a page or a file. No function here can fail.
//!
//! - [`svg`]: a drawing in progress: lines, boxes, circles, text; [`picture`]: a finished drawing with its words;
//! - [`axis`]: linear and logarithmic axes, and the grid of a pair of axes; [`colour`]: the colour scale and its bar;
//! - [`plot`]: curves and clouds of dots over axes; [`bars`]: bars of parts;
//! - [`units`]: numbers with units and prefixes;
//! - [`extent`]: rectangles of a scene; [`map`]: scenes drawn to scale, one above another.

pub mod axis;
pub mod bars;
pub mod colour;
pub mod extent;
pub mod map;
pub mod picture;
pub mod plot;
pub mod svg;
pub mod units;
