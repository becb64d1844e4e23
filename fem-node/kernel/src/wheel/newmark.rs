//! The time scheme for one component.

/// The scheme of [`crate::integrate`] for one component: from the end of a step to the end of the next.
#[derive(Clone, Copy)]
pub(crate) struct Newmark {
    h: f64,
    b: f64,
    c: f64,
}

impl Newmark {
    pub(super) fn new(h: f64, b: f64, c: f64) -> Newmark {
        Newmark { h, b, c }
    }

    /// v' and a' of v and a, `push` being force over mass at the end of the step.
    pub(super) fn rates(self, [v, a]: [f64; 2], push: f64) -> [f64; 2] {
        let Newmark { h, b, c } = self;
        let undamped = v + h * ((1.0 - b) * a + b * push);
        let a_new = push - c / (1.0 + b * h * c) * undamped;
        [v + h * ((1.0 - b) * a + b * a_new), a_new]
    }

    /// Displacement after the next step, u' + h v' + h^2/2 a', while the force stays as it is.
    pub(crate) fn next(self, u: f64, rates: [f64; 2], push: f64) -> f64 {
        let [v, a] = self.rates(rates, push);
        u + (self.h * v + 0.5 * self.h * self.h * a)
    }

    /// Displacement after the next step for each unit of `push` added: h^2 (b + 1/2) / (1 + b h c).
    pub(crate) fn weight(self) -> f64 {
        let Newmark { h, b, c } = self;
        h * h * (b + 0.5) / (1.0 + b * h * c)
    }
}
