//! Energies that a body dissipates in a window, by components and elements.
//!
//! Every component sums its own energies over the steps, so the sums do not depend on strips, regions or threads. A component that a repeat of the
//! window does not reach keeps its sums.

use std::ops::Range;

use crate::element::layout::Layout;

/// Dissipation since the start of the window (J), in the order of [`crate::element::layout::Layout`], except the last, which has one number for each
/// element, row after row with padding. Empty for mechanisms that the scene does not have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dissipated<T> {
    /// Numerical dissipation over (b-1/2), without its part that telescopes: sum of du dF - b h^2/2 da M da.
    pub numerical: T,
    /// Mass damping: sum of [(1-b) c v + b c' v'] M du.
    pub mass_damping: T,
    /// Stiffness damping: sum of [(1-b) d + b d'] du.
    pub stiffness_damping: T,
    /// Plastic flow.
    pub plastic: T,
}

/// The mechanisms by which a body dissipates: a damping parameter above 1/2, mass and stiffness damping above 0, a material that yields.
pub type Mechanisms = Dissipated<bool>;

impl Dissipated<Vec<f64>> {
    /// Nothing dissipated yet.
    pub(crate) fn new(layout: Layout, mechanisms: Mechanisms) -> Dissipated<Vec<f64>> {
        let zero = |present: bool, len: usize| vec![0.0; if present { len } else { 0 }];
        let elements = layout.rows * layout.padded_columns();
        Dissipated {
            numerical: zero(mechanisms.numerical, layout.len()),
            mass_damping: zero(mechanisms.mass_damping, layout.len()),
            stiffness_damping: zero(mechanisms.stiffness_damping, layout.len()),
            plastic: zero(mechanisms.plastic, elements),
        }
    }

    /// Begins a window.
    pub fn clear(&mut self) {
        self.nodal_mut()
            .into_iter()
            .for_each(|field| field.fill(0.0));
        self.plastic.fill(0.0);
    }

    /// Energies of the components.
    pub(crate) fn nodal(&self) -> [&Vec<f64>; 3] {
        [&self.numerical, &self.mass_damping, &self.stiffness_damping]
    }

    /// The same, mutable.
    pub fn nodal_mut(&mut self) -> [&mut Vec<f64>; 3] {
        [
            &mut self.numerical,
            &mut self.mass_damping,
            &mut self.stiffness_damping,
        ]
    }

    /// All of them.
    pub(crate) fn whole(&mut self) -> Dissipated<&mut [f64]> {
        Dissipated {
            numerical: &mut self.numerical,
            mass_damping: &mut self.mass_damping,
            stiffness_damping: &mut self.stiffness_damping,
            plastic: &mut self.plastic,
        }
    }
}

impl<'a> Dissipated<&'a mut [f64]> {
    /// Cuts off the first `components` and `elements`, as far as there are any.
    pub(crate) fn cut(&mut self, components: usize, elements: usize) -> Dissipated<&'a mut [f64]> {
        Dissipated {
            numerical: cut(&mut self.numerical, components),
            mass_damping: cut(&mut self.mass_damping, components),
            stiffness_damping: cut(&mut self.stiffness_damping, components),
            plastic: cut(&mut self.plastic, elements),
        }
    }

    /// Energies of these components.
    pub(crate) fn row(&mut self, of: Range<usize>) -> Dissipated<&mut [f64]> {
        Dissipated {
            numerical: self.numerical.get_mut(of.clone()).unwrap_or_default(),
            mass_damping: self.mass_damping.get_mut(of.clone()).unwrap_or_default(),
            stiffness_damping: self.stiffness_damping.get_mut(of).unwrap_or_default(),
            plastic: &mut [],
        }
    }
}

/// Takes the first numbers of a slice, or all if it has fewer.
pub(super) fn cut<'a>(slice: &mut &'a mut [f64], len: usize) -> &'a mut [f64] {
    let all = std::mem::take(slice);
    let (first, rest) = all.split_at_mut(len.min(all.len()));
    *slice = rest;
    first
}
