//! Steps of a body on one thread or several.

use rayon::prelude::*;

use super::cut::CutStep;
use super::fields::StepFields;
use super::front::Front;
use super::scratch::Scratch;
use super::strip::{Columns, Part, Strip, split};
use super::unstructured::Unstructured;
use crate::element::body::Body;
use crate::material::nonlinear::NonlinearLaw;
use crate::pack::lanes::LANES;
use crate::scheme::{Damping, NewmarkScheme, Rule};
use crate::wheel::rigid::Wheel;
use crate::wheel::run::WheelRun;

/// Below this number of elements for each thread, waking the threads costs more than they save: with 2 820 each,
/// two threads are 1.7 times faster than one, with 705 each not at all.
const ELEMENTS_PER_THREAD: usize = 2_500;

/// Steps a body, on one thread or several, with the same bits for any number of threads.
#[derive(Clone, Debug)]
pub struct Integrator {
    /// Scheme and mass damping of the next step.
    pub rule: Rule,
    law: Option<NonlinearLaw>,
    scratch: Vec<Scratch>,
    /// In place of `scratch` for an unstructured mesh.
    unstructured: Option<Unstructured>,
}

impl Integrator {
    /// An integrator for a body, which may use up to `threads` threads.
    pub fn new(
        body: &Body,
        scheme: NewmarkScheme,
        law: Option<NonlinearLaw>,
        threads: usize,
    ) -> Integrator {
        let worthwhile = threads.min(body.elements() / ELEMENTS_PER_THREAD);
        Integrator::with_strips(body, scheme, law, worthwhile.max(1))
    }

    fn with_strips(
        body: &Body,
        scheme: NewmarkScheme,
        law: Option<NonlinearLaw>,
        strips: usize,
    ) -> Integrator {
        Integrator {
            rule: Rule {
                scheme,
                damping: Damping {
                    start: scheme.mass_damping,
                    end: scheme.mass_damping,
                },
            },
            law,
            scratch: vec![Scratch::new(body, law.as_ref()); strips],
            unstructured: body
                .connectivity
                .as_ref()
                .map(|connectivity| Unstructured::new(body, connectivity, law, strips)),
        }
    }

    /// Number of strips of rows that are stepped at the same time.
    pub fn strips(&self) -> usize {
        self.scratch.len()
    }

    /// One step of the rows `first .. end` under the applied forces at its end and the forces of the wheel. All other rows are and stay at rest; an
    /// unstructured mesh is always stepped whole.
    pub fn step(
        &mut self,
        body: &Body,
        fields: &mut StepFields,
        rows: [usize; 2],
        wheel: Option<(&Wheel, &mut WheelRun)>,
    ) {
        self.begin_damping(body, fields);
        let rule = &self.rule;
        if let Some(unstructured) = &mut self.unstructured {
            return unstructured.step(body, rule, fields, wheel);
        }
        let mut strips = split(body, (rule, self.law), fields, &mut self.scratch, rows);
        if let Some(strip) = strips.first_mut() {
            strip.wheel = wheel;
        }
        match strips.as_mut_slice() {
            [one] => one.step(),
            many => many.par_iter_mut().for_each(Strip::step),
        }
    }

    /// One step of a part of the body; `increments` belong to the nodes beside it, empty under a law without history.
    pub fn step_part(
        &mut self,
        body: &Body,
        fields: &mut StepFields,
        (front, increments): (&Front, &[f64]),
    ) {
        match (front, &mut self.unstructured) {
            (Front::Columns(columns), _) => {
                let part = Part {
                    columns: Columns::OfRows(columns),
                    predicted: Columns::OfRows(columns),
                    increments,
                };
                self.sweep(body, fields, part);
            }
            (Front::Nodes(part), Some(unstructured)) => {
                unstructured.step_part(body, &self.rule, fields, (part, increments));
            }
            _ => unreachable!("only an unstructured mesh has lists of nodes"),
        }
    }

    /// One step of the part of a region that lies in a piece of a body.
    pub fn step_cut(&mut self, body: &Body, fields: &mut StepFields, step: &CutStep) {
        let part = Part {
            columns: Columns::OfRows(&step.stepped),
            predicted: Columns::OfRows(&step.predicted),
            increments: &[],
        };
        self.sweep(body, fields, part);
    }

    /// One step of the same columns in all rows; the columns beside them are as the step before left them. The rest of the first cache line and of
    /// the last pack is stepped too.
    pub fn step_columns(&mut self, body: &Body, fields: &mut StepFields, [first, end]: [usize; 2]) {
        self.begin_damping(body, fields);
        let packs = [body.layout.unit_of(first), end.next_multiple_of(LANES)];
        let beside = [
            packs[0].saturating_sub(1),
            (packs[1] + 1).min(body.layout.stride),
        ];
        let part = Part {
            columns: Columns::Alike(packs),
            predicted: Columns::Alike(beside),
            increments: &[],
        };
        self.sweep(body, fields, part);
    }

    fn sweep(&mut self, body: &Body, fields: &mut StepFields, part: Part) {
        let (scratch, all) = (&mut self.scratch[..1], [0, body.layout.node_rows]);
        for mut strip in split(body, (&self.rule, self.law), fields, scratch, all) {
            strip.part = Some(part);
            strip.step();
        }
    }

    /// Makes room for the force of the stiffness damping before the first step with stiffness damping.
    fn begin_damping(&self, body: &Body, fields: &mut StepFields) {
        if self.rule.scheme.stiffness_damping > 0.0 {
            fields.state.damping_force.resize(body.layout.len());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::body::ElementKind;
    use crate::integrate::dissipation::{Dissipated, Mechanisms};
    use crate::integrate::state::NodalState;
    use crate::material::Elastic;
    use crate::material::j2::J2;
    use crate::mesh::{Edge, Mesh};

    const KINDS: [ElementKind; 3] = [
        ElementKind::Q4OnePoint,
        ElementKind::Q4Full,
        ElementKind::Q4MeanDilatation,
    ];

    /// A skewed body of 9 x 7 elements with E = density = 1, stepped under two forces.
    fn stepped(
        strips: usize,
        rows: [usize; 2],
        steps: usize,
    ) -> (NodalState, Dissipated<Vec<f64>>) {
        stepped_under(ElementKind::Q4OnePoint, None, strips, rows, steps)
    }

    /// The same for a kind of elements, with a yield stress (Pa) or without.
    fn stepped_under(
        kind: ElementKind,
        yield_pa: Option<f64>,
        strips: usize,
        rows: [usize; 2],
        steps: usize,
    ) -> (NodalState, Dissipated<Vec<f64>>) {
        let mesh = Mesh::structured(9, 7, |i, j| [i as f64 + 0.2 * j as f64, -(j as f64)]);
        let elastic = Elastic::plane_strain(1.0, 0.3, 1.0);
        let plastic = |yield_stress: f64| J2 {
            mu: elastic.c33,
            yield_stress,
            isotropic: 0.0,
            kinematic: 0.0,
            softens: false,
        };
        let law = yield_pa.map(plastic).map(NonlinearLaw::Plastic);
        let mut body = Body::new(&mesh, kind, &elastic, 1.0);
        let (layout, clamped) = (body.layout, mesh.edge(Edge::Bottom).into_iter());
        body.fix(clamped.flat_map(|node| [0, 1].map(|k| layout.index(node, k))));
        let scheme = NewmarkScheme {
            step: 0.3,
            damping: 0.75,
            mass_damping: 0.1,
            stiffness_damping: 0.05,
        };
        let mut integrator = Integrator::with_strips(&body, scheme, law, strips);
        let mechanisms = Mechanisms {
            numerical: true,
            mass_damping: true,
            stiffness_damping: true,
            plastic: law.is_some(),
        };
        let mut fields = StepFields::at_rest(&body, law.as_ref(), mechanisms);
        fields.load.add(body.layout.index([3, 0], 1), -1.0);
        fields.load.add(body.layout.index([7, 0], 0), 0.5);
        fields.accelerate(&body, scheme.mass_damping);
        for _ in 0..steps {
            integrator.step(&body, &mut fields, rows, None);
        }
        (fields.state, fields.dissipated)
    }

    #[test]
    fn strips_do_not_change_a_bit() {
        let one = stepped(1, [0, 8], 50);
        for strips in [2, 3, 5, 8, 20] {
            assert_eq!(stepped(strips, [0, 8], 50), one, "{strips} strips");
        }
    }

    #[test]
    fn strips_do_not_change_a_bit_where_some_elements_yield() {
        for kind in KINDS {
            let one = stepped_under(kind, Some(0.3), 1, [0, 8], 50);
            let flowed = one.0.history.iter().filter(|p| **p != 0.0).count();
            assert!(flowed > 0 && flowed < one.0.history.len() / 2, "{flowed}");
            for strips in [2, 3, 5, 8] {
                let many = stepped_under(kind, Some(0.3), strips, [0, 8], 50);
                assert_eq!(many, one, "{kind:?} {strips} strips");
            }
        }
    }

    #[test]
    fn a_body_that_never_yields_moves_like_the_elastic_one() {
        for kind in KINDS {
            let (elastic, _) = stepped_under(kind, None, 1, [0, 8], 50);
            let (plastic, dissipated) = stepped_under(kind, Some(1e3), 1, [0, 8], 50);
            assert_eq!(plastic.u, elastic.u, "{kind:?}");
            assert_eq!(plastic.force, elastic.force, "{kind:?}");
            assert!(
                plastic
                    .history
                    .iter()
                    .chain(&dissipated.plastic)
                    .all(|x| *x == 0.0)
            );
        }
    }

    #[test]
    fn rows_that_nothing_has_reached_can_be_left_out() {
        let (all, _) = stepped(1, [0, 8], 3);
        let (reached, _) = stepped(2, [0, 4], 3);
        assert_eq!(all.u, reached.u);
    }
}
