//! Drawings as SVG, written into a page or a file. Nothing here can fail.
//!
//! - [`svg`]: a drawing while it is written: lines, boxes, circles, text; [`picture`]: a finished one with its words;
//! - [`axis`]: linear and logarithmic axes, and the grid of a pair of them; [`colour`]: the scale of colours and its bar;
//! - [`plot`]: curves and clouds of dots over axes; [`bars`]: bars of parts;
//! - [`units`]: numbers as people read them;
//! - [`extent`]: rectangles of a scene; [`map`]: scenes drawn to scale, one above the other.

pub mod axis;
pub mod bars;
pub mod colour;
pub mod extent;
pub mod map;
pub mod picture;
pub mod plot;
pub mod svg;
pub mod units;
