//! A wheel that rolls along the body: what it needs, and how far the box around the contact changes its creepage.

use std::f64::consts::PI;

use fem_kernel::material::Elastic;
use fem_kernel::mesh::{Edge, Mesh};
use kit::ConfigError;
use kit::rolling::Rolling;

use crate::config::choice::{Analysis, Base};
use crate::config::keys::FemConfig;

kit::results! {
    /// # Rolling
    /// - `creepage_box_shift`: Estimate of the change of a rolling wheel's creepage by the clamped base
    ///   and by the period of the body; a half-space has none.
}

/// Share of the speed of shear waves above which a wheel is not slow.
const FAST: f64 = 0.1;

/// Speed of Rayleigh waves over shear waves, at most.
const RAYLEIGH: f64 = 0.96;

/// Least number of nodes in a contact whose stick and slip are resolved.
const NODES_MIN: f64 = 10.0;

/// Largest ratio of distances of nodes below the way.
const COARSER: f64 = 1.5;

/// Least period in half-widths of the contact.
const PERIOD_MIN: f64 = 12.0;

/// Fall of zeta R/(mu a) by a base at the depth H, over a/(mu H), and by a period L, over a/(mu L) (boundary elements, nu = 0.3).
const BASE: f64 = 0.32;
const REPEATED: f64 = 0.45;

/// Share of mu a/R that the box may change.
const SHIFT_MAX: f64 = 0.1;

/// A rolling wheel and the contact of Hertz that it has on a half-space.
#[derive(Clone, Debug)]
pub(crate) struct Roll {
    pub(crate) rolling: Rolling,
    /// Least and largest distance of neighbouring nodes below the way (m).
    pub(crate) spacing: [f64; 2],
    radius: f64,
    friction: f64,
    /// Half-width of the contact (m).
    half_width: f64,
    /// Depth of a clamped base (m).
    depth: Option<f64>,
    /// Speed of the wheel over the speed of shear waves, where it moves in time.
    speed_rel: f64,
}

impl Roll {
    /// Refuses a wheel that leaves the body, or cannot have its force.
    pub(crate) fn new(
        config: &FemConfig,
        mesh: &Mesh,
        elastic: &Elastic,
        thickness: f64,
        rolling: &Rolling,
    ) -> Result<Roll, ConfigError> {
        let wheel = config.wheel.as_ref();
        let (load, radius) = wheel.map_or((0.0, 0.0), |wheel| (wheel.load_n, wheel.radius_m));
        let friction = config.contact.map_or(0.0, |contact| contact.friction);
        let points = mesh.surface_points(Edge::Top);
        let ends = [points.first(), points.last()].map(|p| p.map_or(0.0, |p| p[0]));
        let in_time = config.analysis == Analysis::Dynamic;
        rolling.check_on(ends, friction * load, in_time)?;
        // (1 - nu^2)/E of plane strain, and 1/E of plane stress.
        let modulus = elastic.c11 - elastic.c12 * elastic.c12 / elastic.c11;
        let shear_speed = (elastic.c33 / elastic.density).sqrt();
        let speed_rel = rolling.speed.abs() / shear_speed;
        if in_time && speed_rel >= RAYLEIGH {
            let problem = format!(
                "{:e} m/s is not below the speed of surface waves, {:.0} m/s",
                rolling.speed,
                RAYLEIGH * shear_speed
            );
            return Err(ConfigError::new("wheel.rolling.speed_m_per_s", problem)
                .help("check the unit (m/s), or lower it"));
        }
        let [_, height] = mesh.extents();
        Ok(Roll {
            spacing: spacing(&points, rolling),
            radius,
            friction,
            half_width: (4.0 * load / thickness * radius / (PI * modulus)).sqrt(),
            depth: (config.base != Base::Free).then_some(height),
            speed_rel: if in_time { speed_rel } else { 0.0 },
            rolling: rolling.clone(),
        })
    }

    /// Estimate of the change of the creepage by the base and the period.
    pub(crate) fn box_shift(&self) -> f64 {
        let a = self.half_width;
        let by = |factor: f64, length: Option<f64>| length.map_or(0.0, |l| factor * a / l);
        // A period that is longer than the depth does nothing beside the base.
        let base = by(BASE, self.depth);
        let period = by(REPEATED, self.rolling.period);
        -a / self.radius * base.max(period)
    }

    /// Advice before a long run.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let [least, most] = self.spacing;
        let a = self.half_width;
        let nodes = 2.0 * a / most;
        let unit = self.friction * a / self.radius;
        let period = self.rolling.period;
        let period = period.filter(|period| *period < PERIOD_MIN * a);
        let shift = -self.box_shift();
        let mut warnings = Vec::new();
        if self.speed_rel > FAST {
            warnings.push(format!(
                "wheel.rolling.speed_m_per_s: {:.2} of the speed of shear waves: inertia changes the contact; below {FAST} it rolls as if in equilibrium",
                self.speed_rel
            ));
        }
        if nodes < NODES_MIN {
            warnings.push(format!(
                "mesh.size_m: a contact of {:.3e} m holds {nodes:.1} nodes below the way, and needs {NODES_MIN} to resolve stick and slip: lower it to {:.1e} m, or raise wheel.load_n or wheel.radius_m",
                2.0 * a,
                2.0 * a / NODES_MIN
            ));
        }
        if most > COARSER * least {
            warnings.push(format!(
                "mesh.fine_width_m: the wheel rolls over nodes {least:.3e} to {most:.3e} m apart: make the fine zone at least {:.3e} m wide, or roll a shorter way",
                2.0 * (self.rolling.start.abs().max(self.rolling.centre(self.rolling.distance).abs()) + a)
            ));
        }
        if let Some(period) = period {
            warnings.push(format!(
                "mesh.width_m: the wheel meets the contact of its neighbour, {period:.3e} m away: make it at least {:.3e} m, {PERIOD_MIN} half-widths of the contact",
                PERIOD_MIN * a
            ));
        }
        if shift > SHIFT_MAX * unit {
            warnings.push(format!(
                "mesh.height_m: base and ends of the body lower the creepage by about {shift:.1e}, {:.2} of mu a/R: a body of {:.3e} m changes it by a tenth",
                shift / unit,
                BASE * a * a / (self.radius * SHIFT_MAX * unit)
            ));
        }
        warnings
    }
}

/// Least and largest distance of neighbouring nodes below the way (m).
fn spacing(points: &[[f64; 2]], rolling: &Rolling) -> [f64; 2] {
    let ends = [0.0, rolling.distance].map(|rolled| rolling.centre(rolled));
    let (from, to) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
    let all = rolling.period.is_some_and(|period| to - from >= period);
    let shifts = match rolling.period {
        None => vec![0.0],
        Some(period) => vec![-period, 0.0, period],
    };
    let below = |pair: &&[[f64; 2]]| {
        let crossed = |shift: &f64| pair[1][0] + shift >= from && pair[0][0] + shift <= to;
        all || shifts.iter().any(crossed)
    };
    let length = |pair: &[[f64; 2]]| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
    let lengths = points.windows(2).filter(below).map(length);
    lengths.fold([f64::INFINITY, 0.0], |[least, most], length| {
        [least.min(length), most.max(length)]
    })
}
