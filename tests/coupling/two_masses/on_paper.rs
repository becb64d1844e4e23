//! The equations of each scheme for the two masses, with plain numbers.

/// m (kg) and k (N/m) of the one element of the bench's bar.
pub const MASS_KG: f64 = 0.5;
pub const STIFFNESS_N_PER_M: f64 = 1.0;

/// A set-up.
#[derive(Clone, Copy)]
pub struct Case {
    pub step_s: f64,
    pub substeps: u32,
    /// M (kg).
    pub mass_kg: f64,
    /// Mass of the glued point (kg), which only schemes with `dirichlet = "continuum"` use.
    pub point_kg: f64,
}

pub const CASES: [Case; 3] = [
    Case {
        step_s: 0.3,
        substeps: 1,
        mass_kg: 0.2,
        point_kg: 0.01,
    },
    Case {
        step_s: 0.05,
        substeps: 9,
        mass_kg: 3.0,
        point_kg: 0.5,
    },
    Case {
        step_s: 0.6,
        substeps: 40,
        mass_kg: 20.0,
        point_kg: 2.0,
    },
];

/// The two masses on paper.
#[derive(Clone, Copy)]
pub struct Two {
    case: Case,
    pub u: f64,
    pub v: f64,
    /// Velocity of M at the end of the window before.
    pub v_m: f64,
    /// Force on m in the window before.
    pub lambda: f64,
    /// Motion of m in the window before.
    pub du: f64,
    /// Velocity of m's line, where the scheme prescribes it.
    pub line: f64,
    pub books: Books,
}

/// The interface's ledger on paper, F being the force of M on m.
#[derive(Clone, Copy, Debug, Default)]
pub struct Books {
    /// Sum of |W - F H v_M| (J).
    pub defect_j: f64,
    /// Sum of |W| (J), W being the work of the force that m carried.
    pub energy_j: f64,
    /// Largest |force that m carried - F| (N).
    pub residual_n: f64,
    /// Largest |F| (N).
    pub force_n: f64,
}

impl Books {
    fn add(&mut self, [borne, force]: [f64; 2], work: f64, wall_motion: f64) {
        self.defect_j += (work - force * wall_motion).abs();
        self.energy_j += work.abs();
        self.residual_n = self.residual_n.max((borne - force).abs());
        self.force_n = self.force_n.max(force.abs());
    }
}

impl Two {
    pub fn new(case: Case) -> Two {
        Two {
            case,
            u: 0.0,
            v: 0.0,
            v_m: 1.0,
            lambda: 0.0,
            du: 0.0,
            line: 0.0,
            books: Books::default(),
        }
    }

    pub fn h(&self) -> f64 {
        self.case.step_s * f64::from(self.case.substeps)
    }

    /// m under a constant force: (u, v) at the end of the window.
    fn verlet(&self, u: f64, v: f64, force: f64) -> (f64, f64) {
        let (h, a) = (self.case.step_s, |u: f64| {
            (force - STIFFNESS_N_PER_M * u) / MASS_KG
        });
        (0..self.case.substeps).fold((u, v), |(u, v), _| {
            let moved = u + h * v + 0.5 * h * h * a(u);
            (moved, v + 0.5 * h * (a(u) + a(moved)))
        })
    }

    /// C: displacement at the end of a window from rest under 1 N.
    pub fn compliance(&self) -> f64 {
        self.verlet(0.0, 0.0, 1.0).0
    }

    /// F = -M (v - v_0) / H.
    fn force_of(&self, v: f64) -> f64 {
        -self.case.mass_kg * (v - self.v_m) / self.h()
    }

    fn end(&mut self, lambda: f64, acting: f64, v_m: f64) {
        let (u, v) = self.verlet(self.u, self.v, acting);
        (self.du, self.u, self.v) = (u - self.u, u, v);
        (self.lambda, self.v_m) = (lambda, v_m);
        let work = acting * self.du;
        self.books.add([acting, lambda], work, self.h() * v_m);
    }

    /// Both end in the same place: H v_M = du_free + C lambda, lambda = F(v_M). If the mass M uses a compliance of `factor` times C, it
    /// starts from the increment under the force of the window before.
    pub fn dual_schur(&mut self, factor: f64) {
        let (h, c) = (self.h(), factor * self.compliance());
        let before = self.verlet(self.u, self.v, self.lambda).0 - self.u;
        let free = (before - c * self.lambda) / h;
        let v_m = (free + c / (h * h) * self.case.mass_kg * self.v_m)
            / (1.0 + c / (h * h) * self.case.mass_kg);
        let lambda = self.force_of(v_m);
        self.end(lambda, lambda, v_m);
    }

    /// m follows a straight line of velocities to v: (u, force at the end), m a + k u.
    fn led(&self, v: f64) -> (f64, f64) {
        let (h, a) = (self.h(), (v - self.v) / self.h());
        let u = self.u + h * self.v + 0.5 * h * h * a;
        (u, MASS_KG * a + STIFFNESS_N_PER_M * u)
    }

    /// Equal velocities at the end, with M' = M + `added`: lambda(v) = -M' (v - v_0) / H, linear in v.
    pub fn velocity(&mut self, added: f64, v_0: f64) {
        let (h, mass) = (self.h(), self.case.mass_kg + added);
        let at = |v: f64| self.led(v).1 + mass * (v - v_0) / h;
        let v = -at(0.0) / (at(1.0) - at(0.0));
        let (u, lambda) = self.led(v);
        let work = work_along_line(self.case, [self.u, self.v], v);
        self.books.add([lambda, lambda], work, h * v);
        (self.u, self.v, self.v_m, self.line, self.lambda) = (u, v, v, v, lambda);
    }

    pub fn staggered(&mut self, parallel: bool) {
        let du = self.verlet(self.u, self.v, self.lambda).0 - self.u;
        let v_m = if parallel { self.du } else { du } / self.h();
        let lambda = self.force_of(v_m);
        self.end(lambda, self.lambda, v_m);
    }

    /// m follows the line of the window before; M with its point takes the force of that line.
    pub fn staggered_continuum(&mut self, parallel: bool) {
        let (h, line) = (self.h(), self.line);
        let (u, lambda) = self.led(line);
        let borne = if parallel { self.lambda } else { lambda };
        // M and its point move as one, except at the start, when only M moves.
        let (mass, point) = (self.case.mass_kg, self.case.point_kg);
        let v = (mass * self.v_m + point * self.line - h * borne) / (mass + point);
        let work = work_along_line(self.case, [self.u, self.v], line);
        self.books.add([lambda, borne], work, h * v);
        (self.u, self.v) = (u, line);
        (self.v_m, self.line, self.lambda) = (v, v, lambda);
    }
}

/// Work (J) on m whose velocity changes linearly to this one (m/s): sum over its steps of the mean of both forces m a + k u
/// times the displacement, from (u, v).
pub fn work_along_line(case: Case, [mut u, mut v]: [f64; 2], end: f64) -> f64 {
    let h = case.step_s;
    let a = (end - v) / (h * f64::from(case.substeps));
    let mut work = 0.0;
    for _ in 0..case.substeps {
        let way = h * v + 0.5 * h * h * a;
        work += (MASS_KG * a + STIFFNESS_N_PER_M * (u + 0.5 * way)) * way;
        (u, v) = (u + way, v + h * a);
    }
    work
}
