//! Plausibility of the grains' results: checks of the values of a run against the bounds of its scenario.

use dem_kernel::bodies::Bodies;
use dem_kernel::step::state::GrainState;
use dem_kernel::step::stiffness::{StiffnessBounds, step_limit};
use protocol::{Finding, HeldLoad, larger};

use crate::config::DemPlausible;
use crate::measure::cycles::WheelCycles;
use crate::measure::flow::Flow;
use crate::measure::report::{RunStatistics, ejected_grains, inside_grains};
use kit::cycle_drift::CYCLE_DRIFT;
use kit::finding::{
    BELOW_ZERO, HEAT_BALANCE, HEAT_STEPS, NOT_CONVERGED, WHEEL_AT_REST, heat_coarseness,
};
use kit::judge;
use kit::wheel::WheelProgram;

kit::findings! {
    /// The wheel still sinks during the hold.
    ///
    /// - Why: the layer has not settled.
    /// - Do: hold longer, or load more slowly.
    /// - Judged: Height that the wheel loses or gains in the second half of the hold, by its trend,
    ///   over its approach (and 0.01 of the mean radius). A rail of 1e6 kg/m3 in `quick` is off by
    ///   0.5 %, one of 1e7 by 2.7 %.
    /// - Valid: 0.013 (100 N).
    /// - Wrong: 0.063 (rail of 1e6 kg/m3, approach 0.5 % off).
    WHEEL_DRIFT = "wheel_drift": wheel_drift_rel in dem = [0.03, 0.3];
    /// A fed flow of third body still changes from cycle to cycle: its mass per length, or the height of the wheel.
    ///
    /// - Why: feed and outflow do not balance yet, or balance only while the wheel sinks. Equal flows are no proof of a steady state.
    /// - Do: take more `wheel.cycles`, or feed another rate. The trends and their intervals are
    ///   results (`third_body_trend_kg_per_m`, `wheel_trend_m`).
    /// - Judged: Change of a fed flow per cycle of the wheel, over the last half of at least eight cycles and beyond the 95 % interval of its trend:
    ///   the third body per length, over its mean, or the wheel's height, over the mean diameter.
    /// - Valid: 0 (`third-body-steady`).
    /// - Wrong: 0.044 (a quarter of its feed, seed 2).
    NOT_STEADY = "not_steady": not_steady_rel in dem = [0.01, 0.5];
    /// A grain is hotter than solids with these properties are.
    ///
    /// - Why: heat does not leave through contacts, surroundings without a temperature keep it, or capacity, conductivity or a
    ///   speed has another unit.
    /// - Do: give `heat.held_k`, or look at the units.
    /// - Judged: Highest temperature of a grain (K); steel melts at 1 800 K.
    /// - Valid: 729 (`third-body-shear-heat`, seed 2).
    /// - Wrong: 4e5 (the same with its capacity in J/(g K), by the ratio of the rises).
    GRAIN_TEMPERATURE = "grain_temperature": grain_temperature_k in dem = [1500.0, 1e4];
    /// The force below the layer differs from the wheel's during the hold.
    ///
    /// - Why: the grains still move.
    /// - Do: hold longer, load more slowly, or lower `mass_scale`.
    /// - Judged: Difference of the mean forces on the glued disks and on the wheel in the second half of the hold, corrected for weight and fixed
    ///   bodies, over the load.
    /// - Valid: 5e-4.
    /// - Wrong: 0.034 (`mass_scale` 3e4).
    LAYER_AT_REST = "layer_at_rest": boundary_force_rel in dem = [0.02, 0.1];
    /// The mass added by `mass_scale` takes a good part of the force.
    ///
    /// - Why: the scale is large for this motion.
    /// - Do: lower `mass_scale`, or load more slowly.
    /// - Judged: Force that moves the mass added by `mass_scale`, over the force that goes through the grains, both summed over the last half of the
    ///   steps or a little more, without a wheel's ramp.
    /// - Valid: 0.02.
    /// - Wrong: 0.20 (`mass_scale` 1e5).
    ADDED_INERTIA = "added_inertia": added_inertia_rel in dem = [0.1, 0.4];
    /// Grains with springs overlapped by a good part of their radius.
    ///
    /// - Why: the load is high for the stiffness of the contacts.
    /// - Do: lower the load, or raise `law.contact_stiffness_pa`.
    /// - Judged: Largest overlap of compliant contacts over the mean radius.
    /// - Valid: 0.10.
    /// - Wrong: 0.55 (200 kN).
    OVERLAP = "overlap": overlap_rel in dem = [0.3, 1.0];
    /// Rigid grains overlapped.
    ///
    /// - Why: a long step, or a coarse tolerance.
    /// - Do: lower `time.step_s` or `solver.tolerance`, or write `law.penetration = "split"`.
    /// - Judged: Largest mean overlap of rigid contacts over the mean radius: their geometry assumes no overlap.
    /// - Valid: 1.2e-3.
    OVERLAP_RIGID = "overlap_rigid": overlap_rigid_rel in dem = [2e-3, 0.1];
    /// Grains left the layer.
    ///
    /// - Why: a load that rose too fast threw them out, or the ends let them through.
    /// - Do: load more slowly, or make the layer wider.
    /// - Judged: Number of grains that left the layer over the number of all grains.
    /// - Valid: 0.
    /// - Wrong: 0.03 (wheel dropped at 10 m/s).
    EJECTED = "ejected": ejected_rel in dem = [0.0, 0.1];
    /// Grains ended behind the face of a body that carries them.
    ///
    /// - Why: long steps or soft contacts let them pass through it, or they began there.
    /// - Do: lower `time.step_s` or `substeps`, or raise `law.contact_stiffness_pa`.
    /// - Judged: Number of grains whose centre ends behind the face of a body that carries them by more than 0.3 of their radius, over the number of
    ///   all grains.
    /// - Valid: 0.
    /// - Wrong: 1 (a disk that starts below the surface).
    INSIDE = "inside": inside_rel in dem = [0.0, 0.0];
    /// Detection found springs and bonds with another stretch than the step had left them.
    ///
    /// - Why: grains pass each other too far in a step, or a scheme that iterates ends windows before both sides agree.
    /// - Do: lower `time.step_s`, `substeps` or the interface's `tolerance_rel`.
    /// - Judged: Energy of springs and bonds that detection changes between two steps against the prediction from the velocities, absolute values
    ///   summed, over the energy that the grains have stored and dissipated. Causes are a wrong gap or normal, or a way past each other that is long
    ///   compared with the radii.
    /// - Valid: 9e-8 (`two-rails`), below 2e-6 (`wheel-rail-de-small`).
    /// - Wrong: including 1e-3 from turning contacts: 7.5e-3 (gaps 2 % wrong), 0.012 (normals turned by 3 mrad), 0.03 (by 10 mrad).
    DETECTION = "detection": detection_rel in dem = [5e-3, 3e-2];
    /// Friction or rebounds of rigid contacts created energy.
    ///
    /// - Why: Newton's `restitution` with friction gives energy to bodies that turn as they are hit (Kane and Levinson 1985), and `penetration =
    ///   "gap"` throws overlapping grains apart.
    /// - Do: give the contacts springs (`law.contact_stiffness_pa`, with `law.damping` for the
    ///   restitution), lower `law.restitution` or `law.friction`, or write `penetration = "iqs"`.
    /// - Judged: Energy that friction and rebounds of rigid contacts created, contact by contact, over the energy that the grains stored and lost;
    ///   only contacts with `law.restitution` that meet, or with `law.penetration = "gap"` that overlap.
    /// - Valid: 2e-7 (a heap that falls, e = 0.9, or `gap`).
    /// - Wrong: 0.05 to 0.5 (rods with e = 0.6 to 1 and friction).
    IMPACT_ENERGY = "impact_energy": impact_energy_rel in dem = [1e-4, 1e-3];
    /// A grain moved far in a step, compared with its radius.
    ///
    /// - Why: contacts are predicted along the normals at the start of a step, which stops grains that pass each other without touching. A fall with
    ///   `theta = 1` goes too far by half the way of its last step.
    /// - Do: lower `time.step_s` or `substeps`.
    /// - Judged: Way of a grain in a step over the smaller radius, past a disk or into a wall or
    ///   wheel that it presses on; also along its weight, times 2 theta - 1.
    /// - Valid: 0.23 (`isostatic-packing`), 0.16 (`plane-shear`).
    /// - Wrong: 2 (a fall 12 % too far), 5 (a disk stopped by another 1 mm beside its way).
    GRAIN_TRAVEL = "grain_travel": grain_travel_rel in dem = [0.3, 1.0];
    /// Grains overlapped a wall of points from behind, where nothing holds them.
    ///
    /// - Why: the grains are on the right of the wall's direction, or came round it, or were fed or
    ///   moved there.
    /// - Do: list `points_m` in the other order, or give the wall a second face by listing its
    ///   points there and back.
    /// - Judged: Largest number of grains that overlap a wall of points from behind at once, over the number of all grains.
    /// - Valid: 0.
    /// - Wrong: 1 (a box that moves towards its only grain from outside).
    BEHIND_WALL = "behind_wall": behind_wall_rel in dem = [0.0, 0.1];
    /// The wheel went into the bare surface, which holds grains and no wheel.
    ///
    /// - Why: too few grains are left between them, or they are far apart.
    /// - Do: fill the gap with grains, or load the wheel less.
    /// - Judged: Largest depth of a smooth wheel below a point of the bare surface, over the smallest radius.
    /// - Valid: 0.
    /// - Wrong: 2 (a wheel on two grains 4 mm apart).
    WHEEL_INSIDE = "wheel_inside": wheel_inside_rel in dem = [0.1, 1.0];
    /// Glued disks passed a wall, which holds grains and clusters only.
    ///
    /// - Why: the body that carries the disks moved through the wall, or the wall moved through them.
    /// - Do: stop the body by its own `boundary`, or the motion before they meet.
    /// - Judged: Largest depth of the centre of a glued disk behind a plane wall in front of which it began, over its radius.
    /// - Valid: 0.
    /// - Wrong: 0.5 (a body thrown at a wall).
    GLUED_BEHIND = "glued_behind_wall": glued_behind_wall_rel in dem = [0.1, 2.0];
    /// Bonds bore more than half their strength in steps above their bound, 1/(sqrt(3) omega).
    ///
    /// - Why: in a step this long a bond can withstand more than its fracture energy.
    /// - Do: lower `time.step_s` or `substeps`, or raise `mass_scale`.
    /// - Judged: Step or window over the bound of the bonds, 1/(sqrt(3) omega), where some bond bore more than half its strength. Above the bound a
    ///   bond may withstand more than its fracture energy.
    /// - Valid: 0.6.
    /// - Wrong: 2 (a bond stops a disk with twice its fracture energy).
    BOND_STEP = "bond_step": bond_step_rel in dem = [1.0, 4.0];
    /// Breaking bonds dissipated less than their surface energy.
    ///
    /// - Why: they opened far in a single step. The missing part grows with the step, to some 0.2 at the bound of the bonds.
    /// - Do: lower `time.step_s` or `substeps`.
    /// - Judged: Surface energy lost by bonds less the energy dissipated by decohesion, over the former, where this is more than a thousandth of the
    ///   energy given to the grains.
    /// - Valid: 0.009 (a twentieth of the bound), 0.03 (a fifth), 0.07 (`third-body-flow`, 0.6).
    /// - Wrong: 0.15 (0.8 of the bound), 0.27 (1.5).
    BOND_ENERGY = "bond_energy": bond_energy_rel in dem = [0.1, 0.5];
    /// The time step dissipated a good part of the energy given to moving grains.
    ///
    /// - Why: springs without dampers are damped by the step, which leaves `exp(-pi h omega / 2)` of each rebound.
    /// - Do: lower `time.step_s` or `substeps`, or give contacts `law.damping`.
    /// - Judged: Energy dissipated by the scheme and by turning contacts, over all energy given to the grains or, if larger, their largest kinetic
    ///   energy, where drives, walls, weight or their flight at the start gave more than a tenth of this energy. Elsewhere the energy lost by turning
    ///   contacts, over the energy that the grains stored and lost.
    /// - Valid: 0.04 (`third-body-flow`), 0.13 (`wheel-rail-de`, which opens it).
    /// - Wrong: 1 (a disk on a spring that does not rebound).
    NUMERICAL = "numerical": numerical_rel in dem = [0.1, 0.5];
    /// Clusters landed on several contacts at once, which damp them more or less than one contact.
    ///
    /// - Why: each damper of `law.damping` is set for its own contact, 1/m = 1/M + a^2/I; n dampers that share a landing have the damping ratio zeta
    ///   sum(sqrt(m)) / sqrt(n M).
    /// - Do: give `law.damping` the value in the warning, or let the cluster land on one disk.
    /// - Judged: Difference of the restitution of such landings from `law.damping`, weighted by the loss in their dampers, where this is more than a
    ///   tenth of the energy given to the grains.
    /// - Valid: 0.009 (a bar that lands flat on its two ends, `law.damping` 0.3).
    /// - Wrong: 0.12 (a block that lands flat on four disks, `law.damping` 0.3).
    SHARED_DAMPING = "shared_damping": shared_damping_diff in dem = [0.02, 1.0];
    /// The kinetic stress of the grains under the wheel is not small compared with its pressure.
    ///
    /// - Why: with scaled masses, inertia acts in the flow more than with real grains.
    /// - Do: lower `mass_scale`, and the step with its root.
    /// - Judged: Kinetic stress of the grains in the zone of a flow over the pressure of the wheel,
    ///   mean over the run.
    /// - Valid: 3e-5 (mass scale 1000), 3e-6 (10).
    /// - Wrong: 1.2e-3 (mass scale 1e6).
    FLOW_KINETIC = "flow_kinetic": flow_kinetic_rel in dem = [1e-3, 1e-2];
    /// Mass that was due to be fed in found no gap.
    ///
    /// - Why: the point is surrounded, or the feed too fast.
    /// - Do: lower `injection.rate_kg_per_s`, raise `injection.growth_s`, or move the point; with `detachment`, lower `detachment.growth_s`.
    /// - Judged: Mass that was due to be fed in and found no gap, over all mass that was due.
    /// - Valid: 0.
    /// - Wrong: 0.67 (walls closer than a grain).
    INJECTION = "injection": injection_rel in dem = [0.02, 0.5];
    /// Friction was due to take steel off a bare surface that may lose no more.
    ///
    /// - Why: the body below keeps its mesh, so that a surface loses at most a third of a segment of `sample.surface`.
    /// - Do: raise `detachment.energy_j_per_m2`, shorten the run, or make `spacing_m` larger.
    /// - Judged: Work of friction on bare surfaces that took nothing off because they may lose no more, over all their work of friction.
    /// - Valid: 0.
    /// - Wrong: 0.8 (a hundred layers a pass of a fiftieth of a radius).
    DETACHMENT = "detachment": detachment_rel in dem = [0.01, 0.5];
    /// The wheel's force reaches close to the ends of the layer.
    ///
    /// - Why: the layer is narrow for this load.
    /// - Do: make `half_width_m` larger, or give `half_width_load_n`.
    /// - Judged: Half-width of 98 % of the wheel's force over the half-width of a layer with free ends. Against the rail alone, two loads with
    ///   partial slip lost 6 % of their friction loop at 0.72 and 17 % at 0.83, and 1 to 4 % at 0.66.
    /// - Valid: 0.65.
    /// - Wrong: 0.83 (friction loop 17 % off).
    CONTACT_WIDTH = "contact_width": contact_width_rel in dem = [0.71, 0.95];
    /// Few segments of a bare surface carry the whole load on it.
    ///
    /// - Why: `sample.surface.spacing_m` is coarse compared with the width of the contact: the body below takes up the forces on a segment at its two
    ///   ends, and a crown has chords in place of arcs.
    /// - Do: lower `sample.surface.spacing_m` or list more `points_m`; without the key the spacing
    ///   is a mean diameter.
    /// - Judged: One over the number of segments that carry the force at the end, (sum F)^2 / sum F^2 over segments, where at least twice as many
    ///   contacts carry it; only surfaces of a coupled body without glued grains.
    /// - Valid: 0.2 (ten columns on a strip, 0.8 mm: approach 0.9 % off), 0.17 (`quick` on 2 mm).
    /// - Wrong: 0.5 (ten columns, 2 mm: 5 % off), 1 (4 mm: 66 % off).
    SURFACE_SEGMENTS = "surface_segments": surface_segment_share in dem = [0.35, 0.75];
    /// Fewer than five contacts carry 90 % of the wheel's force.
    ///
    /// - Why: rigid grains, or a rough wheel, under a load that brings only a few grains into contact. The results describe these grains, not the
    ///   layer.
    /// - Do: give the contacts springs, or make the load or the radius of the crown larger. If the scene is meant to be like this, open
    ///   `plausible.wheel_contact_share`.
    /// - Judged: One over the smallest number of contacts that carry 0.9 of the wheel's force, mean over the second half of the hold or, if smaller,
    ///   over the motion. It never exceeds 1: a load on few disks may be intended.
    /// - Valid: 0.11 (ten columns of disks, of which nine carry 90 %); layers and rails 0.03.
    /// - Wrong: 1 (one rigid grain bore a wheel of rigid disks).
    WHEEL_CONTACTS = "wheel_contacts": wheel_contact_share in dem = [0.2, 1.0];
    /// A contact solve ended with a large residual.
    ///
    /// - Why: a coarse tolerance.
    /// - Do: lower `solver.tolerance`.
    /// - Judged: Largest residual of a contact solve. In `quick` the mean friction is off by 0.2 %
    ///   at 1e-3, 1.8 % at 3e-3 and 4 % at 1e-2.
    /// - Valid: 1e-3.
    /// - Wrong: 3e-3 (friction 1.8 % off).
    CONTACT_RESIDUAL = "contact_residual": contact_residual in dem = [2e-3, 0.3];
}

/// Settling of the grains that counts as rest for any approach, over the mean radius.
const SETTLING: f64 = 0.01;

/// Part of the energy given to the grains above which the energy of motions counts.
const MOVING: f64 = 0.1;
/// Contacts per segment of a surface from which on grains share segments.
const SHARED: f64 = 2.0;
/// Part of the energy given to the grains above which the surface energy of broken bonds counts.
const SURFACE: f64 = 1e-3;

/// Reach of the free ends of a layer, in its thicknesses. With ends 8 and 11 thicknesses beyond 98 % of the force (0.15 mm, half-widths of 6 and 6.5
/// mm) the friction loop of `wheel-rail-coupled` is 0.7 and 0.2 % below the loop with 8 mm, with 6 (0.3 mm, 6.5 mm) 6 %.
const END_REACH: f64 = 8.0;

/// A run at its end.
pub struct FinishedRun<'a> {
    /// The bounds.
    pub bounds: &'a DemPlausible,
    /// The bodies.
    pub bodies: &'a Bodies,
    /// The last state.
    pub state: &'a GrainState,
    /// Energies stored since the start (J).
    pub stored: [f64; 5],
    /// Bounds on the step from bonds and contact springs.
    pub stiffness: StiffnessBounds,
    /// The flows of third body, where they are measured.
    pub flow: Option<&'a Flow>,
    /// Statistics over its steps.
    pub statistics: &'a RunStatistics,
    /// The full cycles of the wheel.
    pub cycles: &'a WheelCycles,
    /// The wheel, where there is one.
    pub program: Option<&'a WheelProgram>,
    /// True for a run without coupler.
    pub alone: bool,
    /// Half-width and thickness of a layer that does not repeat (m).
    pub ends: Option<[f64; 2]>,
}

impl FinishedRun<'_> {
    /// All checks for which the scene has a value.
    pub fn findings(&self) -> Vec<Finding> {
        let all = [
            self.overlap(),
            self.ejected(),
            self.inside(),
            self.wheel_at_rest(),
            self.layer_at_rest(),
            self.wheel_drift(),
            self.cycle_drift(),
            self.added_inertia(),
            self.detection(),
            self.impact_energy(),
            self.grain_travel(),
            self.behind_wall(),
            self.wheel_inside(),
            self.glued_behind(),
            self.bond_step(),
            self.bond_energy(),
            self.numerical(),
            self.shared_damping(),
            self.flow_kinetic(),
            self.not_steady(),
            self.injection(),
            self.detachment(),
            self.contact_width(),
            self.surface_segments(),
            self.wheel_contacts(),
            self.contact_residual(),
            self.not_converged(),
        ];
        all.into_iter().chain(self.heat()).flatten().collect()
    }

    /// The load that the boundary must carry in the second half of the hold: the wheel's, and the weight of the grains.
    pub fn held_load(&self) -> Option<HeldLoad> {
        let wanted = self.program?.load_n;
        let mean = self.statistics.hold.force.value()?;
        let masses = self.bodies.masses.iter().sum::<f64>();
        let weight = -masses * self.bodies.gravity[1];
        Some(HeldLoad {
            wanted_n: wanted + weight,
            mean_n: mean + weight,
        })
    }

    fn overlap(&self) -> Option<Finding> {
        let radius = self.bodies.mean_radius();
        if self.bodies.law.springs.is_some() {
            let value = self.statistics.largest.overlap / radius;
            return judge!(self.bounds => OVERLAP, value;
                "two bodies overlapped by {value:.3} of the mean radius, where a contact law between disks means nothing: lower the load, or raise law.contact_stiffness_pa");
        }
        let value = self.statistics.largest.overlap_mean / radius;
        judge!(self.bounds => OVERLAP_RIGID, value;
            "the mean overlap of rigid contacts reached {value:.2e} of the mean radius: lower time.step_s or solver.tolerance, or write law.penetration = \"split\"")
    }

    fn ejected(&self) -> Option<Finding> {
        let lost = ejected_grains(self.bodies, self.state);
        let grains = self.state.present(self.bodies);
        let value = lost as f64 / grains as f64;
        judge!(self.bounds => EJECTED, value;
            "{lost} of {grains} grains have left the layer, which is no longer the layer of the scenario: lower the load, the amplitude or the step, or make sample.half_width_m larger")
    }

    fn inside(&self) -> Option<Finding> {
        let count = inside_grains(self.bodies, self.state);
        let value = count as f64 / self.state.present(self.bodies) as f64;
        judge!(self.bounds => INSIDE, value;
            "{count} grains ended behind the face of the body that carries them: they went through it, and are missing above it; lower time.step_s or, where there are windows, substeps, or raise law.contact_stiffness_pa")
    }

    /// The wheel must be at rest when its results are taken.
    fn wheel_at_rest(&self) -> Option<Finding> {
        let program = self.program.filter(|program| program.load_n > 0.0)?;
        let [low, high] = self.statistics.held_range()?;
        let load = program.load_n;
        let value = larger(high - load, load - low) / load;
        judge!(self.bounds => WHEEL_AT_REST, value;
            "the wheel is not at rest before its motion: it moves at {:.2e} m/s, and over the second half of the hold (without a hold, before the motion) the grains carried {low:.0} to {high:.0} N of its {load} N: make wheel.hold_s or wheel.ramp_s longer, or bring wheel.vy_m_per_s closer to 0",
            self.statistics.hold.velocity)
    }

    /// A wheel that bears its load may still sink with the bodies below.
    fn wheel_drift(&self) -> Option<Finding> {
        self.program.filter(|program| program.load_n > 0.0)?;
        let [lost, approach] = self.statistics.held_drift()?;
        let value = lost.abs() / (approach.abs() + SETTLING * self.bodies.mean_radius());
        judge!(self.bounds => WHEEL_DRIFT, value;
            "over the second half of the hold the wheel sank by {lost:.2e} m, of {approach:.2e} m in all: the bodies that carry it are not at rest; make wheel.hold_s or wheel.ramp_s longer, or lower densities and masses")
    }

    /// Under a held load a motion that repeats must find the wheel at the same height in each cycle. A third body that flows out lets it sink; a run
    /// with flows measures this.
    fn cycle_drift(&self) -> Option<Finding> {
        let program = self.program.filter(|_| self.flow.is_none())?;
        let drift = self.statistics.drift;
        drift.judge(program, self.bounds.of(&CYCLE_DRIFT))
    }

    /// During the hold nothing must move between wheel and boundary.
    fn layer_at_rest(&self) -> Option<Finding> {
        let load = self.held_load().filter(|load| load.wanted_n > 0.0)?;
        let borne = self.statistics.hold.boundary.value()?;
        let value = (borne - load.mean_n).abs() / load.wanted_n;
        let judged = judge!(self.bounds => LAYER_AT_REST, value;
            "over the second half of the hold the wheel pressed with {:.5e} N and {borne:.5e} N came out below: the grains were not at rest; lower mass_scale, or make wheel.hold_s or wheel.ramp_s longer",
            load.mean_n);
        // Rigid walls bear a part of the force, and without glued disks there is no boundary to compare.
        judged.filter(|_| self.bodies.walls.is_empty() && self.bodies.glued() > 0)
    }

    fn added_inertia(&self) -> Option<Finding> {
        let value = self.statistics.added_inertia.value()?;
        judge!(self.bounds => ADDED_INERTIA, value;
            "moving the mass that mass_scale adds to the grains took {value:.3} of the force through them: lower mass_scale, or load more slowly")
    }

    fn contact_residual(&self) -> Option<Finding> {
        let value = self.statistics.largest.residual;
        judge!(self.bounds => CONTACT_RESIDUAL, value;
            "the contact solve of a step ended with a residual of {value:.1e}, and friction is off by several per cent: lower solver.tolerance")
    }

    /// Steps of a run alone that were accepted without having converged; the coupler judges the steps of a coupled run.
    fn not_converged(&self) -> Option<Finding> {
        let steps = self.statistics.steps;
        let accepted = self.statistics.accepted_steps * u64::from(self.alone);
        let value = accepted as f64 / steps.max(1) as f64;
        judge!(self.bounds => NOT_CONVERGED, value;
            "{accepted} of {steps} steps were accepted without having converged, as solver.on_not_converged = \"accept\" asks")
    }

    /// See [`Bodies::noise`] and [`GrainState::rounding`].
    fn noise(&self) -> f64 {
        let load = self.program.map_or(0.0, |program| program.load_n);
        let kinetic = larger(0.0, self.kinetic_at_start());
        let rounding = self.statistics.steps as f64 * self.state.rounding(self.bodies);
        self.bodies.noise(load, kinetic) + rounding
    }

    /// An energy (J) over what the grains have stored and lost; 0 where it is noise.
    fn of_kept(&self, energy: f64) -> f64 {
        let ledger = &self.state.ledger;
        let lost = kit::named!(ledger; impact, numerical, friction, cohesion).map(|(_, lost)| lost);
        let kept = self.stored.iter().chain(&lost);
        let kept: f64 = kept.map(|energy| energy.abs()).sum();
        if energy <= self.noise() {
            0.0
        } else {
            energy / kept
        }
    }

    /// Detection must find springs as the step left them.
    fn detection(&self) -> Option<Finding> {
        let value = self.of_kept(self.state.ledger.unforeseen);
        judge!(self.bounds => DETECTION, value;
            "detection found the springs between the grains with another energy than their velocities predict, by {value:.3e} of the energy that the grains stored and lost: they pass each other too far in a step, or windows ended before both sides agreed; lower time.step_s or, where there are windows, substeps or the interface's tolerance_rel")
    }

    /// Rigid contacts must not create energy.
    fn impact_energy(&self) -> Option<Finding> {
        let made = self.state.ledger.made;
        let value = self.of_kept(made);
        judge!(self.bounds => IMPACT_ENERGY, value;
            "friction and rebounds of rigid contacts created {made:.3e} J, {value:.3e} of the energy that the grains stored and lost: Newton's restitution with friction does that where bodies turn as they are hit, and law.penetration = \"gap\" where it repairs overlaps; give the contacts springs (law.contact_stiffness_pa), or lower law.restitution or law.friction")
    }

    /// Contacts are predicted along the normals at the start of a step, and falls are off by half the way of the last step.
    fn grain_travel(&self) -> Option<Finding> {
        let value = self.statistics.largest.travel;
        judge!(self.bounds => GRAIN_TRAVEL, value;
            "in a step a grain moved by {} of its radius, past or into a body that it pressed on, or as it fell: grains that pass each other may have been stopped without touching, and falls are off by half of that; lower time.step_s or, where there are windows, substeps",
            in_short(value))
    }

    /// A wall of points does not hold grains that come from behind.
    fn behind_wall(&self) -> Option<Finding> {
        let count = self.statistics.largest.behind;
        let value = count as f64 / self.state.present(self.bodies) as f64;
        judge!(self.bounds => BEHIND_WALL, value;
            "{count} grains at once overlapped a wall of points from behind, where nothing holds them: list the points of that wall (points_m) so that the grains are on the left of its direction, or lower the step")
    }

    fn wheel_inside(&self) -> Option<Finding> {
        let depth = self.statistics.largest.wheel_depth;
        let radii = self.bodies.radii[..self.bodies.free].iter().copied();
        let value = depth / radii.fold(f64::INFINITY, f64::min);
        judge!(self.bounds => WHEEL_INSIDE, value;
            "the wheel went {depth:.2e} m, {value:.2} of the smallest radius, into the bare surface, with which it has no contact: put grains between them, or lower wheel.load_n")
    }

    fn glued_behind(&self) -> Option<Finding> {
        let value = self.statistics.largest.glued_depth;
        judge!(self.bounds => GLUED_BEHIND, value;
            "a glued disk went {value:.2} of its radius behind a wall, with which it has no contact: walls hold grains and clusters; stop the body that carries the disk by its own boundary, or move wall and disk apart")
    }

    /// Judges the step where bonds came close to breaking.
    fn bond_step(&self) -> Option<Finding> {
        // Where pairs heal that did not touch at the start, only the bonds of the end have a bound.
        let healed = step_limit(self.bodies, self.state, &self.state.bonds);
        let limits = [self.stiffness.bonds_s, healed].into_iter().flatten();
        let limit = limits.reduce(f64::min)?;
        let largest = &self.statistics.largest;
        let (load, step) = (largest.bond_load, largest.bond_step);
        let value = step / limit;
        judge!(self.bounds => BOND_STEP, value;
            "bonds bore up to {load:.2} of their strength in steps of {step:.3e} s, {value:.2} of the {limit:.3e} s above which a bond can withstand more than its fracture energy: lower time.step_s (where there are windows, substeps), or raise mass_scale")
    }

    /// Judges the energy that breaking bonds dissipated, where it matters in the energy balance.
    fn bond_energy(&self) -> Option<Finding> {
        let ledger = &self.state.ledger;
        let share = ledger.decohesion_share()?;
        let counts = ledger.surface > SURFACE * self.energy_in();
        let value = if counts { 1.0 - share } else { 0.0 };
        judge!(self.bounds => BOND_ENERGY, value;
            "bonds lost a surface energy of {:.3e} J and dissipated {share:.3} times as much: the steps are too long for the speed at which they open; lower time.step_s or, where there are windows, substeps",
            ledger.surface)
    }

    /// Work done on the grains plus the kinetic energy that they have lost, or their largest kinetic energy, if this is more (J): a flight that goes
    /// on after a rebound at the same speed has lost next to nothing.
    fn energy_in(&self) -> f64 {
        let lost = (-self.stored[0]).max(0.0);
        let moved = self.statistics.largest.kinetic - self.drifting();
        let largest = larger(moved, self.flight());
        larger(self.state.ledger.worked() + lost, largest)
    }

    /// Kinetic energy at the start beyond the common motion (J).
    fn flight(&self) -> f64 {
        larger(0.0, self.kinetic_at_start() - self.drifting())
    }

    fn kinetic_at_start(&self) -> f64 {
        self.state.kinetic(self.bodies) - self.stored[0]
    }

    /// The kinetic energy of the common motion (J), which grains keep that meet nothing but each other.
    fn drifting(&self) -> f64 {
        let alone = self.bodies.count() == self.bodies.free;
        let [x, y] = self.state.momentum(self.bodies);
        let mass = self.bodies.masses.iter().sum::<f64>();
        f64::from(u8::from(alone)) * 0.5 * (x * x + y * y) / mass
    }

    /// Judges the energy that the scheme dissipates where drives, walls, weight or flight gave a part of the grains' energy: rebounds and flows
    /// depend on it. The loss of turning contacts is included, and is judged alone where nothing moves the grains. Grains that only ring under a load
    /// come to rest by any dissipation.
    fn numerical(&self) -> Option<Finding> {
        let (ledger, given) = (&self.state.ledger, self.energy_in());
        let moved = ledger.moved() + self.flight();
        let taken = ledger.numerical + ledger.detection.abs();
        let counts = taken > self.noise() && moved > MOVING * given;
        let turned = self.of_kept(ledger.detection.abs());
        let value = if counts { taken / given } else { turned };
        let kept = self.stiffness.restitution(self.statistics.largest.step);
        let rebound = kept.map_or(String::new(), |[low, high]| {
            format!(
                " (two of the lightest grains rebound with {low:.2} to {high:.2} of their speed)"
            )
        });
        judge!(self.bounds => NUMERICAL, value;
            "the time scheme dissipated {value:.3} of the energy given to the grains{rebound}: rebounds and rest depend on the step; lower time.step_s (where there are windows, substeps), and damp contacts with law.damping and bonds with law.bond_damping_ratio")
    }

    /// Judges landings of clusters on several dampers.
    fn shared_damping(&self) -> Option<Finding> {
        let [lost, sums @ ..] = self.statistics.shared_damping;
        let [asked, left, needed] = sums.map(|sum| sum / lost);
        let counts = lost > MOVING * self.energy_in();
        let value = if counts { (left - asked).abs() } else { 0.0 };
        judge!(self.bounds => SHARED_DAMPING, value;
            "clusters landed on several contacts at once, whose dampers together leave them {left:.3} of their speed, where law.damping is {asked:.3}: it is exact for a single contact; law.damping = {needed:.3} gives such landings {asked:.3}")
    }

    fn flow_kinetic(&self) -> Option<Finding> {
        let value = self.flow?.kinetic_share();
        // During the ramp of its wheel a zone bears next to nothing.
        self.statistics.added_inertia.value()?;
        judge!(self.bounds => FLOW_KINETIC, value;
            "the kinetic stress of the grains in the contact zone was {value:.2e} of the pressure of the wheel or the lid: inertia acts in the flow, with heavy grains (mass_scale) more than with real ones; lower mass_scale, and the step with its root")
    }

    /// Judges whether a fed flow has come to a balance: equal flows are no proof while the wheel sinks.
    fn not_steady(&self) -> Option<Finding> {
        let ([third, height], mean) = self.cycles.trends()?;
        let diameter = 2.0 * self.bodies.mean_radius();
        let beyond = |[slope, half]: [f64; 2]| larger(0.0, slope.abs() - half);
        let of_mass = if mean > 0.0 {
            beyond(third) / mean
        } else {
            0.0
        };
        let value = larger(of_mass, beyond(height) / diameter);
        let found = judge!(self.bounds => NOT_STEADY, value;
            "over the last half of its cycles the third body per length changed by {:.2e} +- {:.2e} of its mean a cycle, and the height of the wheel by {:.2e} +- {:.2e} m: the flow is not steady, and its means hold for these cycles only; take more wheel.cycles, or feed another rate",
            third[0] / mean, third[1] / mean, height[0], height[1]);
        found.filter(|_| self.bodies.injection.is_some())
    }

    fn heat(&self) -> [Option<Finding>; 4] {
        let Some(law) = &self.bodies.heat else {
            return Default::default();
        };
        let heat = &self.state.heat;
        let balance = heat.balance_rel(self.bodies, &self.state.ledger);
        let few = heat_coarseness(u64::from(law.every), heat.conductions);
        let highest = law.capacity_factor.rise(heat.peak);
        let extreme = larger(larger(highest, -heat.lowest), f64::MIN_POSITIVE);
        let steps = larger(few, heat.bent / extreme);
        let lowest = law.start + heat.lowest;
        let (peak, [x, y, t]) = (law.kelvins(heat.peak), heat.peak_at);
        [
            judge!(self.bounds => HEAT_BALANCE, balance;
                "{balance:.1e} of the heat was lost, or made without a loss of the contacts: an error of the program, please report it"),
            judge!(self.bounds => HEAT_STEPS, steps;
                "heat passed in few conductions, or a factor on the capacity changed much within one, and each mixes what happens within: lower heat.every_steps"),
            judge!(self.bounds => BELOW_ZERO, larger(0.0, -lowest);
                "a grain had {lowest:.0} K: look at heat.capacity_factor and heat.every_steps"),
            judge!(self.bounds => GRAIN_TEMPERATURE, peak;
                "a grain at x = {x:.3e}, y = {y:.3e} m had {peak:.0} K at t = {t:.3e} s, far beyond solids with one capacity and conductivity: give heat.held_k, or look at the units of heat"),
        ]
    }

    /// Judges the mass that was due to be fed in and found no gap.
    fn injection(&self) -> Option<Finding> {
        let bodies = self.bodies;
        let injection = bodies.injection.as_ref()?;
        let next = bodies.masses.get(self.state.present(bodies));
        let value = self.state.feed.missed(next.copied().unwrap_or(0.0));
        let (of, cure) = match injection.point() {
            Some(source) => {
                let [x, y] = source.point;
                (
                    format!("was to be fed in found no gap to begin in around ({x:e}, {y:e}) m"),
                    "lower injection.rate_kg_per_s, raise injection.growth_s, or move the point",
                )
            }
            None => (
                "came off the surface found no gap to begin in as grains".into(),
                "lower detachment.growth_s, or raise detachment.energy_j_per_m2",
            ),
        };
        judge!(self.bounds => INJECTION, value; "{value:.3} of the mass that {of}: {cure}")
    }

    /// Judges the work of friction that would have taken steel off surfaces that may lose no more.
    fn detachment(&self) -> Option<Finding> {
        let [done, beyond] = self.state.worn.done;
        let value = if beyond > 0.0 { beyond / done } else { 0.0 };
        judge!(self.bounds => DETACHMENT, value;
            "{value:.3} of the work of friction on bare surfaces was due to take steel off where a third of a segment is gone already, and took none: too little comes off from then on; raise detachment.energy_j_per_m2, shorten the run, or give the surface and its body longer segments")
    }

    /// Friction and pressure below a wheel on a few contacts describe single grains, not the layer.
    fn wheel_contacts(&self) -> Option<Finding> {
        self.program.filter(|program| program.load_n > 0.0)?;
        let carrying = self.statistics.carrying_contacts();
        let fewest = carrying.into_iter().flatten().reduce(f64::min)?;
        judge!(self.bounds => WHEEL_CONTACTS, 1.0 / fewest;
            "{fewest:.1} contacts, a mean over the hold or the motion, carry 90 % of the wheel's force: friction and pressure describe single grains, and change with the seed; give the contacts springs (law.contact_stiffness_pa), make the load or the radius of the crown larger, or open plausible.wheel_contact_share if the scene is meant to be like this")
    }

    /// Judges the number of segments of a bare surface that carry the load: the body below takes it up at their points.
    fn surface_segments(&self) -> Option<Finding> {
        let bodies = self.bodies;
        let on_surface = |body: u32| bodies.segment_index(body as usize);
        let mut forces = vec![0.0; bodies.surface.segments()];
        let mut contacts = Vec::new();
        for slot in self.state.list.pressing() {
            if let Some(segment) = on_surface(slot.b) {
                forces[segment] += slot.force[0];
                contacts.push(slot.force[0]);
            }
        }
        let number = |forces: &[f64]| {
            let [sum, squares] = [1, 2].map(|n| forces.iter().map(|f| f.powi(n)).sum::<f64>());
            sum * sum / squares
        };
        let (segments, contacts) = (number(&forces), number(&contacts));
        let counts = !self.alone && bodies.glued() == 0 && contacts >= SHARED * segments;
        let found = judge!(self.bounds => SURFACE_SEGMENTS, 1.0 / segments;
            "{contacts:.1} contacts press on {segments:.1} segments of the bare surface, and the body below takes up their forces at the ends: pressure and approach are off by several per cent, with fewer than two segments by tens of per cent; lower sample.surface.spacing_m (or list more points_m), or remove it for a mean diameter");
        found.filter(|_| counts)
    }

    fn contact_width(&self) -> Option<Finding> {
        let [half_width, thickness] = self.ends?;
        let pressed = pressed_half_width(self.bodies, self.state)?;
        let found = judge!(self.bounds => CONTACT_WIDTH, pressed / half_width;
            "98 % of the wheel's force lies within {:.2} mm of the middle and the layer ends at {:.2} mm, where it yields sideways: results of slip are off by several per cent; make sample.half_width_m at least {:.2e}",
            1e3 * pressed, 1e3 * half_width, pressed / self.bounds.of(&CONTACT_WIDTH).warn);
        found.filter(|_| half_width - pressed < END_REACH * thickness)
    }
}

/// Half-width of 98 % of the force on the wheel (m), `None` where nothing touches it.
fn pressed_half_width(bodies: &Bodies, state: &GrainState) -> Option<f64> {
    let on_wheel = state.on_wheel(bodies);
    let mut forces: Vec<(f64, f64)> = on_wheel.map(|[x, force]| (x.abs(), force)).collect();
    forces.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = forces.iter().map(|(_, force)| force).sum();
    let mut sum = 0.0;
    let within = forces.iter().find(|(_, force)| {
        sum += force;
        sum >= 0.98 * total
    });
    within.map(|(x, _)| *x)
}

/// A ratio for readers; a run that has gone wrong has ratios of 300 digits.
fn in_short(value: f64) -> String {
    if value.abs() < 1e4 {
        format!("{value:.3}")
    } else {
        format!("{value:.3e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dem_kernel::bodies::faces::{Face, RigidWall};
    use dem_kernel::bodies::feed::{Injection, PointSource, Source};
    use dem_kernel::bodies::surface::BareSurface;
    use dem_kernel::contact::detect::Slot;
    use dem_kernel::law::Springs;
    use dem_kernel::solver::residual::Convergence;
    use dem_kernel::step::StepSummary;
    use dem_kernel::step::state::WheelState;
    use kit::wheel::WheelProgram;

    const LOAD: f64 = 1000.0;
    const WEIGHT: f64 = 100.0;
    const RADIUS: f64 = 0.5;
    const GRAINS: usize = 2000;
    const STEPS: usize = 24;
    const STEP: f64 = 0.125;
    /// First step of the second half of the hold.
    const REST: usize = 20;

    /// A run of 24 steps: a ramp of 2 s and a hold of 1 s, in which the wheel has come down by 1 m.
    struct Scene {
        bodies: Bodies,
        state: GrainState,
        stored: [f64; 5],
        program: WheelProgram,
        ends: Option<[f64; 2]>,
        steps: Vec<StepSummary>,
        heights: Vec<f64>,
        first_height: f64,
        /// Contacts that share the wheel's force in each step.
        carriers: Vec<u32>,
        cycles: WheelCycles,
        alone: bool,
    }

    /// A run without findings, with a value for every check.
    fn sound() -> Scene {
        let step = StepSummary {
            on_wheel: [0.0, LOAD],
            on_boundary: [0.0, -LOAD - WEIGHT],
            transmitted: LOAD,
            convergence: Convergence {
                converged: true,
                ..Convergence::default()
            },
            ..StepSummary::default()
        };
        let mut state = GrainState {
            centres: vec![[0.0, 1.0]; GRAINS],
            ..GrainState::default()
        };
        let ledger = &mut state.ledger;
        [ledger.impact, ledger.friction, ledger.cohesion] = [1.0, 5.0, -1.0];
        Scene {
            bodies: Bodies {
                free: GRAINS,
                radii: vec![RADIUS; GRAINS],
                masses: vec![WEIGHT / 10.0 / GRAINS as f64; GRAINS],
                gravity: [0.0, -10.0],
                reference: vec![[-10.0, 0.0], [10.0, 0.0]],
                base: 2,
                wheel_mass: Some(1.0),
                ..Bodies::default()
            },
            state,
            stored: [1.0, -1.0, 0.5, -0.5, 0.0],
            program: WheelProgram {
                load_n: LOAD,
                load_table: None,
                amplitude_m: 0.0,
                frequency_hz: 1.0,
                ramp_s: 2.0,
                hold_s: 1.0,
                cycles: 0.0,
                rolling: None,
            },
            ends: Some([4.0, 1.0]),
            steps: vec![step; STEPS],
            heights: vec![0.0; STEPS],
            first_height: 1.0,
            carriers: vec![10; STEPS],
            cycles: WheelCycles::default(),
            alone: true,
        }
    }

    fn slot(a: u32, b: usize, force: f64) -> Slot {
        Slot {
            a,
            b: b as u32,
            force: [force, 0.0],
            ..Slot::default()
        }
    }

    impl Scene {
        fn statistics(&self) -> RunStatistics {
            let mut statistics = RunStatistics::new(self.first_height);
            let program = self.program.clone();
            let steps = self.steps.iter().zip(&self.heights);
            for (index, (step, height)) in steps.enumerate() {
                let start = index as f64 * STEP;
                let mut state = GrainState {
                    centres: vec![[0.0; 2]; GRAINS],
                    wheel: WheelState {
                        position: [0.0, *height],
                        velocity: [0.0; 2],
                        turn: 0.0,
                    },
                    ..GrainState::default()
                };
                let carriers = 0..self.carriers[index];
                state.list.slots = carriers.map(|a| slot(a, GRAINS, LOAD)).collect();
                let span = [start, start + STEP];
                statistics.record(Some(&program), (&self.bodies, &state), step, span);
            }
            statistics
        }

        /// Codes of the findings, and whether each makes the run suspect.
        fn found(&self) -> Vec<(String, bool)> {
            let program = self.program.clone();
            let judged = FinishedRun {
                bounds: &DemPlausible::default(),
                bodies: &self.bodies,
                state: &self.state,
                stored: self.stored,
                stiffness: StiffnessBounds::default(),
                flow: None,
                statistics: &self.statistics(),
                cycles: &self.cycles,
                program: Some(&program),
                alone: self.alone,
                ends: self.ends,
            };
            let findings = judged.findings().into_iter();
            findings.map(|f| (f.code, f.suspect)).collect()
        }
    }

    /// Expects no finding for the first value, a warning for the next two and a suspect run for the last.
    fn judges_values(code: &str, values: [f64; 4], scene: impl Fn(f64) -> Scene) {
        let expected = [None, Some(false), Some(false), Some(true)];
        for (value, expected) in values.into_iter().zip(expected) {
            let expected: Vec<_> = expected
                .map(|s| (code.to_string(), s))
                .into_iter()
                .collect();
            assert_eq!(scene(value).found(), expected, "{code} of {value}");
        }
        let found = scene(f64::NAN).found();
        assert!(
            found.contains(&(code.into(), true)),
            "{code} of NaN: {found:?}"
        );
    }

    /// The same with values just inside and just outside both bounds.
    fn judges(code: &str, [warn, suspect]: [f64; 2], scene: impl Fn(f64) -> Scene) {
        let [below, above] = [0.999, 1.001];
        let values = [below * warn, above * warn, below * suspect, above * suspect];
        judges_values(code, values, scene);
    }

    /// A sound scene with this step changed.
    fn with_step(index: usize, change: impl Fn(&mut StepSummary)) -> Scene {
        let mut scene = sound();
        change(&mut scene.steps[index]);
        scene
    }

    #[test]
    fn a_sound_run_has_no_findings() {
        assert_eq!(sound().found(), []);
    }

    #[test]
    fn overlaps_of_any_step_are_judged_by_the_law_of_the_contacts() {
        judges("overlap", [0.3, 1.0], |value| {
            let mut scene = with_step(0, |step| step.overlap = [0.0, value * RADIUS]);
            scene.bodies.law.springs = Some(Springs {
                normal: 1.0,
                tangential: 1.0,
                damping: 0.0,
            });
            scene
        });
        judges("overlap_rigid", [2e-3, 0.1], |value| {
            with_step(0, |step| step.overlap = [value * RADIUS, RADIUS])
        });
    }

    /// A wheel that sinks by a part of a diameter, 1 m, in each of ten cycles of a second.
    #[test]
    fn a_fed_flow_below_a_wheel_that_sinks_is_not_steady() {
        let sinking = |value: f64, fed: bool| {
            let mut scene = sound();
            let program = WheelProgram {
                amplitude_m: 1.0,
                cycles: 10.0,
                ..scene.program.clone()
            };
            scene.bodies.injection = fed.then_some(Injection {
                grains: 0,
                growth: 1.0,
                source: Source::Point(PointSource {
                    point: [0.0; 2],
                    rate: 1.0,
                    start: 0.0,
                    end: 1.0,
                }),
            });
            scene.cycles = WheelCycles::new(0.0, 1.0);
            for step in 0..104 {
                let [start, end] = [step, step + 1].map(|n| 0.125 * f64::from(n));
                let mut state = GrainState::default();
                state.wheel.position[1] = -value * (end - program.motion_start());
                let moved = (&scene.bodies, &state, &StepSummary::default());
                (scene.cycles).record(&program, [start, end], moved, &[], None);
            }
            scene
        };
        judges("not_steady", [0.01, 0.5], |value| sinking(value, true));
        assert_eq!(sinking(0.1, false).found(), [], "nothing is fed");
    }

    #[test]
    fn each_grain_that_left_is_counted() {
        let scene = |lost: f64| {
            let mut scene = sound();
            let lost = if lost.is_nan() { GRAINS } else { lost as usize };
            scene.state.centres[..lost].fill([11.0, 1.0]);
            scene
        };
        judges_values("ejected", [0.0, 1.0, 200.0, 201.0], scene);
    }

    #[test]
    fn the_wheel_is_judged_above_and_below_its_load() {
        for side in [1.0, -1.0] {
            judges("wheel_at_rest", [0.05, 0.2], |value| {
                let mut scene = with_step(REST, |step| step.on_wheel[1] += side * value * LOAD);
                // The force below is the wheel's.
                scene.steps[REST].on_boundary[1] -= side * value * LOAD;
                scene
            });
        }
    }

    #[test]
    fn without_a_hold_the_last_force_before_the_motion_counts() {
        let mut scene = sound();
        (scene.program.ramp_s, scene.program.hold_s) = (3.0, 0.0);
        assert_eq!(scene.found(), []);
        scene.steps[STEPS - 1].on_wheel[1] = 0.9 * LOAD;
        assert_eq!(scene.found(), [("wheel_at_rest".to_string(), false)]);
        scene.program.ramp_s = 0.0;
        assert_eq!(scene.found(), [("wheel_at_rest".to_string(), true)]);
    }

    #[test]
    fn the_drift_is_judged_over_the_approach_and_the_settling() {
        let drifting = |lost: f64, first_height: f64| {
            let mut scene = sound();
            scene.first_height = first_height;
            for (index, height) in scene.heights[REST..].iter_mut().enumerate() {
                *height = lost * (0.5 - index as f64 / 3.0);
            }
            scene
        };
        let settling = SETTLING * RADIUS;
        for side in [1.0, -1.0] {
            judges("wheel_drift", [0.03, 0.3], |value| {
                drifting(side * value * (1.0 + settling), 1.0)
            });
        }
        assert_eq!(drifting(0.029 * settling, 0.0).found(), []);
    }

    #[test]
    fn the_wheel_s_force_must_arrive_below() {
        for side in [1.0, -1.0] {
            let scene = |value: f64| {
                let mut scene = sound();
                for step in &mut scene.steps {
                    step.on_boundary[1] *= 1.0 + side * value;
                }
                scene
            };
            judges("layer_at_rest", [0.02, 0.1], scene);
            let mut loose = scene(1.0);
            loose.bodies.reference.clear();
            loose.bodies.base = 0;
            assert_eq!(loose.found(), [], "nothing is glued");
            let mut walled = scene(1.0);
            walled.bodies.walls = vec![RigidWall {
                face: Face::HalfPlane {
                    point: [0.0; 2],
                    normal: [1.0, 0.0],
                },
                velocity: [0.0; 2],
            }];
            assert_eq!(walled.found(), [], "a wall bears a part");
        }
    }

    #[test]
    fn added_inertia_is_judged_after_the_ramp() {
        judges("added_inertia", [0.1, 0.4], |value| {
            let mut scene = sound();
            for (index, step) in scene.steps.iter_mut().enumerate() {
                step.added_inertia = if index < 16 { LOAD } else { value * LOAD };
            }
            scene
        });
    }

    #[test]
    fn jumps_of_detection_are_judged_over_all_energies() {
        judges("detection", [5e-3, 3e-2], |value| {
            let mut scene = sound();
            scene.state.ledger.unforeseen = 10.0 * value;
            scene
        });
        let mut rigid = sound();
        rigid.state.ledger = Default::default();
        rigid.stored = [0.0; 5];
        assert_eq!(rigid.found(), [], "no springs, no jumps");
    }

    #[test]
    fn nearly_all_of_the_force_must_lie_within_the_layer() {
        let scene = |value: f64| {
            let mut scene = sound();
            let centres = &mut scene.state.centres;
            (centres[1][0], centres[2][0]) = (-4.0 * value, 8.0);
            let forces = [(0, 97.0), (1, 1.5), (2, 1.5)];
            let on_wheel = forces.map(|(grain, force)| slot(grain, GRAINS, force));
            scene.state.list.slots = on_wheel.to_vec();
            scene.state.list.slots.push(slot(2, 3, 1e6));
            scene
        };
        judges("contact_width", [0.71, 0.95], scene);
        let thin = |thickness: f64| Scene {
            ends: Some([4.0, thickness]),
            ..scene(0.8)
        };
        assert_eq!(thin(0.09).found(), [], "its ends are 8.9 thicknesses away");
        assert_eq!(thin(0.11).found().len(), 1);
    }

    /// Of five equal contacts 5 are the fewest that carry 0.9, of four 4.
    #[test]
    fn a_wheel_on_few_contacts_gets_a_warning_in_the_hold_and_in_the_motion() {
        let warned = [("wheel_contacts".to_string(), false)];
        let mut scene = sound();
        scene.carriers = vec![1; REST];
        scene.carriers.extend([5; STEPS - REST]);
        assert_eq!(scene.found(), [], "few only before the hold");
        scene.carriers[REST] = 4;
        assert_eq!(scene.found(), warned, "4.75 in the mean");
        scene.carriers.fill(1);
        assert_eq!(scene.found(), warned, "a single one");
        scene.carriers.fill(10);
        (scene.program.ramp_s, scene.program.hold_s) = (1.0, 1.0);
        scene.carriers[REST..].fill(0);
        assert_eq!(scene.found(), [], "a wheel in the air");
        scene.carriers[16..].fill(4);
        assert_eq!(scene.found(), warned, "in its motion");
        scene.carriers.fill(0);
        assert_eq!(scene.found(), [], "nothing ever touched it");
    }

    /// A thousand disks on a number of the ten segments of a surface.
    #[test]
    fn few_segments_below_many_contacts_get_a_warning() {
        let found = |carrying: usize, contacts: usize, alone: bool| {
            let mut scene = sound();
            let points = (0..11).map(|k| [f64::from(k), 0.0]).collect();
            (scene.bodies.reference, scene.bodies.base) = (Vec::new(), 0);
            scene.bodies.surface = BareSurface::new([&[points], &[]], None);
            let first = scene.bodies.first_segment();
            let slots = (0..contacts).map(|i| slot(i as u32, first + i % carrying, 1.0));
            scene.state.list.slots = slots.collect();
            scene.alone = alone;
            scene.found()
        };
        let one = |suspect: bool| [("surface_segments".to_string(), suspect)];
        assert_eq!(found(3, 1000, false), [], "three carry");
        assert_eq!(found(2, 1000, false), one(false));
        assert_eq!(found(1, 1000, false), one(true));
        assert_eq!(found(1, 1, false), [], "a grain has one place");
        assert_eq!(
            found(2, 3, false),
            [],
            "two grains of three have a segment of their own"
        );
        assert_eq!(found(1, 1000, true), [], "a rigid surface");
    }

    #[test]
    fn steps_that_are_accepted_without_having_converged_are_counted() {
        let mut scene = sound();
        scene.steps[3].convergence.converged = false;
        assert_eq!(scene.found(), [("not_converged".to_string(), true)]);
    }

    #[test]
    fn the_residual_of_any_step_is_judged() {
        judges("contact_residual", [2e-3, 0.3], |value| {
            with_step(0, |step| step.convergence.residual = value)
        });
    }
}
