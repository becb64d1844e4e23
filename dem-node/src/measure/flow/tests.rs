//! A scene by hand: two grains under the wheel, one that is detached, one of the initial stock, one far away.
//!
//! Masses are powers of two, so that sums are exact.

use dem_kernel::bodies::geometry::Period;
use dem_kernel::contact::bond::Bond;
use dem_kernel::contact::detect::Slot;

use super::*;
use crate::config::flow::LateralConfig;
use dem_kernel::bodies::cluster::{Cluster, ClusterMembers, Clusters};
use dem_kernel::bodies::drive::Drive;

/// Diameter (m).
const D: f64 = 1.0;
const MASSES: [f64; 5] = [1.0, 2.0, 4.0, 8.0, 16.0];
const WEAR: f64 = 2.0;

/// Grains 0 and 1 carry the wheel at -2 and 2; 2 is bonded to 0, 3 is loose, 4 stands far away. Body 5 is glued, 6 the wheel.
struct Trial {
    bodies: Bodies,
    state: GrainState,
    scene: FlowScene,
    flow: Flow,
    time: f64,
}

impl Trial {
    fn new() -> Trial {
        let bodies = Bodies {
            free: 5,
            radii: vec![0.5 * D; 6],
            masses: MASSES.map(|m| 100.0 * m).to_vec(),
            reference: vec![[0.0; 2]],
            base: 1,
            wheel_mass: Some(1.0),
            ..Bodies::default()
        };
        let x = [-2.0, 2.0, 0.5, -1.0, 10.0, 0.0];
        let mut state = GrainState {
            centres: x.iter().map(|x| [*x, 0.0]).collect(),
            velocities: vec![[3.0, 4.0, 0.0]; x.len()],
            ..GrainState::default()
        };
        let bond = |(a, b): (u32, u32)| Bond {
            a,
            b,
            adhesion: 1.0,
            ..Bond::default()
        };
        state.bonds = [(0, 2), (0, 5), (1, 5), (4, 5)].map(bond).to_vec();
        state.list.slots = [(0, 100.0), (1, 100.0)]
            .map(|(a, force)| Slot {
                a,
                b: 6,
                force: [force, 0.0],
                ..Slot::default()
            })
            .to_vec();
        let config = FlowConfig {
            zone_share: 0.99,
            margin_diameters: 1.0,
            hysteresis_diameters: 1.0,
            zone_mean_s: Some(0.0),
            wear_s: WEAR,
            lateral: None,
        };
        Trial {
            scene: FlowScene::new(config, &bodies, 100.0, (0.0, 1)),
            flow: Flow::new(&config, &bodies, &state),
            bodies,
            state,
            time: 0.0,
        }
    }

    /// A step of one second, to the end of which these grains move; the balance must be exact.
    fn step(&mut self, moves: &[(usize, f64)]) -> MassLedger {
        for (grain, x) in moves {
            self.state.centres[*grain][0] = *x;
        }
        self.time += 1.0;
        let now = (&self.bodies, &self.state);
        self.flow.record(&self.scene, now, self.time, 1.0);
        assert_eq!(
            self.flow.held,
            self.flow.ledger.zone(),
            "at {} s",
            self.time
        );
        assert_eq!(self.flow.defect, 0.0);
        self.flow.ledger
    }

    fn set_adhesion(&mut self, pair: (u32, u32), adhesion: f64) {
        let bond = self.state.bonds.iter_mut().find(|b| b.pair() == pair);
        bond.expect("it is there").adhesion = adhesion;
    }

    /// Breaks the bond of grain 2.
    fn detach(&mut self) {
        self.set_adhesion((0, 2), 0.01);
    }

    fn ends(&self) -> [f64; 2] {
        self.flow.zone.expect("the wheel is loaded").ends
    }

    fn body(&self, grain: usize) -> FlowBody {
        self.flow.grains[grain].body
    }
}

/// Grains 0 to 3 are in the zone: 0.5 x 100 x 15 kg x 25 m2/s2 over 200 N x 7.5 m.
#[test]
fn the_kinetic_stress_of_the_zone_is_measured_against_the_pressure() {
    let mut trial = Trial::new();
    trial.state.wheel.position[1] = 7.5;
    trial.step(&[]);
    assert_eq!(trial.flow.kinetic_share(), 12.5);
}

#[test]
fn a_grain_that_is_detached_ejected_brought_back_and_worn_is_counted_exactly() {
    let mut trial = Trial::new();
    let bodies: Vec<FlowBody> = trial.flow.bodies().collect();
    use FlowBody::{First, Stock, Third};
    assert_eq!(bodies, [First, First, First, Stock, First]);
    // 1 s: the zone appears over the initial stock, which is no source.
    let stock = MassLedger {
        covered: 8.0,
        ..MassLedger::default()
    };
    assert_eq!(trial.step(&[]), stock);
    assert_eq!(trial.ends(), [-3.0, 3.0]);
    // 2 s: grain 2 comes off in the zone, grain 4 outside.
    trial.detach();
    trial.set_adhesion((4, 5), 0.005);
    let detached = MassLedger {
        source: 4.0,
        detached: 20.0,
        ..stock
    };
    assert_eq!(trial.step(&[]), detached);
    assert_eq!([trial.body(2), trial.body(4)], [Third; 2]);
    let times: Vec<f64> = trial.flow.detached().collect();
    assert_eq!(times, [-1.0, -1.0, 2.0, -1.0, 2.0]);
    // 3 and 4 s: out and in again before it is worn.
    let out = MassLedger {
        ejected: 4.0,
        ..detached
    };
    assert_eq!(trial.step(&[(2, 3.5)]), out);
    let back = MassLedger {
        recirculated: 4.0,
        ..out
    };
    assert_eq!(trial.step(&[(2, 2.0)]), back);
    // 5 s: out on the other side, through x = 0.
    let through = MassLedger {
        ejected: 8.0,
        internal_net: -4.0,
        internal_abs: 4.0,
        ..back
    };
    assert_eq!(trial.step(&[(2, -3.5)]), through);
    // 6, 7 and 8 s: worn 2 s after it left, once.
    assert_eq!(trial.step(&[]), through);
    let worn = MassLedger {
        wear: 4.0,
        ..through
    };
    assert_eq!(trial.step(&[]), worn);
    assert_eq!(trial.step(&[]), worn);
    // 9 s: it comes back all the same, and 10 s: holds on to grain 1.
    let returned = MassLedger {
        recirculated: 8.0,
        wear_returned: 4.0,
        ..worn
    };
    assert_eq!(
        trial.step(&[(2, 1.5)]),
        MassLedger {
            internal_net: 0.0,
            internal_abs: 8.0,
            ..returned
        }
    );
    trial.state.bonds.push(Bond {
        a: 1,
        b: 2,
        adhesion: 1.0,
        ..Bond::default()
    });
    trial.state.bonds.sort_by_key(Bond::pair);
    let held = trial.step(&[]);
    assert_eq!((held.reattached, trial.flow.held), (4.0, 8.0));
    assert_eq!(trial.body(2), First);
    // 11 s: grain 4 walks in for the first time; it does not come back, and it was no source.
    let walked = trial.step(&[(4, 2.5)]);
    assert_eq!(
        [walked.entered, walked.recirculated, walked.source],
        [16.0, 8.0, 4.0]
    );
    let results: Vec<_> = trial.flow.results().collect();
    assert!(
        results.contains(&("flow_balance_rel", 0.0))
            && results.contains(&("third_body_zone_kg", 24.0))
    );
}

#[test]
fn a_grain_that_crosses_and_changes_in_one_step_counts_once() {
    // It is detached at its position at the end of the step: outside, and it did not leave as third body.
    let mut trial = Trial::new();
    trial.step(&[]);
    trial.detach();
    let out = trial.step(&[(2, 3.5)]);
    assert_eq!([out.source, out.detached, out.ejected], [0.0, 4.0, 0.0]);
    // It comes in for the first time and is held in the same step.
    trial.set_adhesion((0, 2), 1.0);
    let held = trial.step(&[(2, 0.5)]);
    assert_eq!(
        [held.entered, held.recirculated, held.reattached],
        [4.0, 0.0, 4.0]
    );
    // A new life: its past makes neither recirculation nor wear.
    trial.detach();
    assert_eq!(trial.step(&[]).source, 4.0);
    trial.step(&[(2, 4.0)]);
    trial.set_adhesion((0, 2), 1.0);
    for _ in 0..4 {
        assert_eq!(trial.step(&[]).wear, 0.0);
    }
}

#[test]
fn a_grain_that_is_back_when_it_would_be_worn_is_not() {
    let mut trial = Trial::new();
    trial.step(&[]);
    trial.step(&[(3, -3.5)]);
    trial.step(&[]);
    let back = trial.step(&[(3, -1.0)]);
    assert_eq!(
        [back.ejected, back.wear, back.recirculated],
        [8.0, 0.0, 8.0]
    );
    // Its time starts again when it leaves again, 5 s, and is over at 7 s.
    let waits = [-3.5, -3.6, -3.7].map(|x| trial.step(&[(3, x)]).wear);
    assert_eq!(waits, [0.0, 0.0, 8.0]);
}

#[test]
fn the_zone_moves_when_an_end_is_off_by_more_than_the_hysteresis() {
    let mut trial = Trial::new();
    trial.step(&[]);
    trial.step(&[(0, -2.9), (1, 2.9)]);
    assert_eq!(trial.ends(), [-3.0, 3.0]);
    // One end at a time: the loose grain at -1 is left behind, and taken in again.
    let gone = trial.step(&[(0, 0.5)]);
    assert_eq!(trial.ends(), [-0.5, 3.0]);
    assert_eq!([gone.uncovered, gone.ejected, gone.wear], [8.0, 0.0, 0.0]);
    trial.step(&[]);
    assert_eq!(trial.step(&[]).wear, 8.0);
    let taken = trial.step(&[(0, -2.0)]);
    assert_eq!(
        [taken.covered, taken.recirculated, taken.wear_returned],
        [16.0, 0.0, 8.0]
    );
    // A wheel without a load leaves the zone unchanged.
    trial.state.list.slots.clear();
    trial.step(&[]);
    assert_eq!(trial.ends(), [-3.0, 3.0]);
}

#[test]
fn the_zone_leaves_out_grains_that_carry_less_than_its_share() {
    let mut trial = Trial::new();
    let wheel = |a: u32, force: f64| Slot {
        a,
        b: 6,
        force: [force, 0.0],
        ..Slot::default()
    };
    // Half a per cent of 201 N is 1.005 N: grain 4 at 10 bears less, then more.
    trial.state.list.slots.push(wheel(4, 1.0));
    trial.step(&[]);
    assert_eq!(trial.ends(), [-3.0, 3.0]);
    trial.state.list.slots[2] = wheel(4, 1.1);
    trial.step(&[]);
    assert_eq!(trial.ends(), [-3.0, 11.0]);
}

/// The disks of the face belong to the wheel.
#[test]
fn a_wheel_of_disks_has_a_zone_as_a_flat_one() {
    let mut trial = Trial::new();
    trial.bodies.face.push([0.0, 0.0]);
    trial.bodies.radii.push(0.5);
    assert_eq!(trial.bodies.wheel(), Some(7));
    trial.step(&[]);
    assert_eq!(trial.ends(), [-3.0, 3.0]);
}

/// Over ten seconds a step of one second has the share 1 - exp(-1/10) of the mean: a grain that has long carried half of the wheel counts until its
/// remaining share is below half a per cent, exp(-t/10)/2 < 0.005.
#[test]
fn the_zone_follows_the_mean_force_over_its_time() {
    let mut trial = Trial::new();
    trial.scene.config.zone_mean_s = Some(10.0);
    (0..1000).for_each(|_| {
        trial.step(&[]);
    });
    trial.state.list.slots[0].a = 5;
    let last = 10.0 * f64::ln(100.0);
    for after in 1..60 {
        trial.step(&[]);
        let left = if f64::from(after) < last { -3.0 } else { -1.0 };
        assert_eq!(trial.ends(), [left, 3.0], "{after} s");
    }
}

#[test]
fn a_cluster_that_loses_its_last_anchor_is_third_body_as_a_whole() {
    let mut trial = Trial::new();
    trial.step(&[]);
    trial.set_adhesion((0, 5), 0.0);
    let gone = trial.step(&[]);
    assert_eq!([gone.source, gone.detached], [5.0, 5.0]);
    assert_eq!([trial.body(0), trial.body(2)], [FlowBody::Third; 2]);
}

/// Grain 3 is fed into the zone, grain 4 outside: in store they are nowhere, and neither is a source or comes back.
#[test]
fn fed_grains_are_external_in_the_zone_and_enter_it_from_outside() {
    let mut trial = Trial::new();
    trial.state.bonds.retain(|bond| bond.a != 4);
    trial.state.feed.waiting = 2;
    trial.flow = Flow::new(&trial.scene.config, &trial.bodies, &trial.state);
    assert_eq!(trial.step(&[]), MassLedger::default());
    trial.state.feed.waiting = 1;
    let inside = MassLedger {
        external: 8.0,
        injected: 8.0,
        ..MassLedger::default()
    };
    assert_eq!(trial.step(&[]), inside);
    assert_eq!(trial.step(&[]), inside);
    trial.state.feed.waiting = 0;
    let outside = MassLedger {
        injected: 24.0,
        ..inside
    };
    assert_eq!(trial.step(&[]), outside);
    assert_eq!([trial.body(3), trial.body(4)], [FlowBody::Fed; 2]);
    // Both cross an end of the zone by their own motion; grain 4 does for the first time.
    let crossed = MassLedger {
        ejected: 8.0,
        entered: 16.0,
        ..outside
    };
    assert_eq!(trial.step(&[(3, -3.5), (4, 2.5)]), crossed);
    let back = trial.step(&[(3, -1.0)]);
    assert_eq!([back.recirculated, trial.flow.held], [8.0, 24.0]);
}

/// The zone is [-3, 3] when the motion begins: its middle half is [-1.5, 1.5], 3 m long, and stays there when the zone moves.
#[test]
fn third_body_per_length_is_taken_in_a_middle_that_stays() {
    let name = "third_body_per_length_kg_per_m";
    let mut trial = Trial::new();
    trial.scene.middle_from = 2.0;
    trial.step(&[]);
    let result = |flow: &Flow| flow.results().find(|(known, _)| *known == name);
    assert_eq!(result(&trial.flow), None);
    assert!(trial.flow.signals().any(|signal| signal == (name, 0.0)));
    trial.step(&[]);
    assert_eq!(result(&trial.flow), Some((name, 8.0 / 3.0)));
    trial.detach();
    trial.step(&[]);
    assert_eq!(trial.flow.per_length(), 4.0);
    // Out of the middle, and still in the zone.
    trial.step(&[(3, -1.6)]);
    assert_eq!(
        (trial.flow.per_length(), trial.flow.held),
        (4.0 / 3.0, 12.0)
    );
    // The zone leaves grain 3 behind, then holds it again: the middle does not change.
    trial.step(&[(3, -1.0), (0, 0.5)]);
    assert_eq!(trial.ends(), [-0.5, 3.0]);
    assert_eq!((trial.flow.per_length(), trial.flow.held), (4.0, 4.0));
    trial.step(&[(0, -2.9)]);
    assert_eq!((trial.flow.per_length(), trial.flow.held), (4.0, 12.0));
    assert!(trial.flow.signals().any(|signal| signal == (name, 4.0)));
}

/// A strip of 12 m, from -4 to 8: grain 4 at 10 lies in it at -2. All of it is zone from the first step on, and nothing leaves it.
#[test]
fn a_grain_that_leaves_a_strip_on_one_side_enters_it_on_the_other() {
    let mut trial = Trial::new();
    trial.bodies.period = Some(Period::between([-4.0, 8.0]));
    trial.flow = Flow::new(&trial.scene.config, &trial.bodies, &trial.state);
    trial.detach();
    let start = MassLedger {
        covered: 8.0,
        source: 4.0,
        detached: 4.0,
        ..MassLedger::default()
    };
    assert_eq!(trial.step(&[]), start);
    assert_eq!(trial.ends(), [-4.0, 8.0]);
    // Over the seam at 8, which does not count.
    assert_eq!(trial.step(&[(2, 9.0), (3, -4.5)]), start);
    // The image of x = 0 at 12 to the right, the image at -12 to the left.
    let passed = MassLedger {
        internal_net: -4.0,
        internal_abs: 12.0,
        ..start
    };
    assert_eq!(trial.step(&[(2, 13.0), (3, -12.5)]), passed);
    // Two of them at once, back to where it was.
    let back = MassLedger {
        internal_net: -8.0,
        internal_abs: 16.0,
        ..start
    };
    assert_eq!(trial.step(&[(2, 11.0)]), back);
    for _ in 0..4 {
        assert_eq!(trial.step(&[]), back);
    }
    assert_eq!((trial.flow.held, trial.flow.per_length()), (12.0, 1.0));
    trial.bodies.wheel_mass = None;
    assert_eq!(trial.step(&[(2, 35.5)]).internal_net, 0.0);
    assert_eq!(trial.ends(), [-4.0, 8.0]);
}

/// Two disks of a lid from -4 to 4, then from -2 to 6; 100 N press the first one from 2 m below, 1.5 m above the base.
#[test]
fn the_zone_below_a_lid_goes_from_its_first_disk_to_its_last() {
    let mut trial = Trial::new();
    trial.bodies.wheel_mass = None;
    trial.bodies.radii.extend([0.5; 2]);
    trial.bodies.reference.extend([[0.0; 2]; 2]);
    trial.state.centres.extend([[-3.5, 2.0], [3.5, 2.0]]);
    trial.state.centres[0][0] = -3.5;
    trial.state.list.slots.truncate(1);
    trial.scene.base = 0.5;
    let stock = trial.step(&[]);
    assert_eq!((stock.covered, trial.ends()), (8.0, [-4.0, 4.0]));
    // Grains 0 to 3 are below it: 0.5 x 100 x 15 kg x 25 m2/s2 over 100 N x 1.5 m.
    assert_eq!(trial.flow.kinetic_share(), 125.0);
    // The lid moves, and leaves grain 3 behind.
    let gone = trial.step(&[(3, -2.5), (6, -1.5), (7, 5.5)]);
    assert_eq!((gone.uncovered, gone.ejected), (8.0, 0.0));
    assert_eq!(trial.ends(), [-2.0, 6.0]);
    trial.step(&[]);
    let worn = trial.step(&[]);
    assert_eq!((worn.wear, trial.flow.held), (8.0, 0.0));
    let back = trial.step(&[(3, -1.0)]);
    assert_eq!([back.recirculated, back.wear_returned], [8.0; 2]);
}

/// The time that third body stays, a step, and the steps of a run (s).
const STAYS: f64 = 40.0;
const STEP: f64 = 0.1;
const STEPS: u32 = 3000;

/// Grains of 1 kg in a strip that repeats, which come at a rate that depends on the third body there (kg/s), by `come`, and leave sideways. Third
/// body must be within two grains of `expected` at each time, as coming and leaving are each off by one at most.
fn drained(
    mut state: GrainState,
    rate: impl Fn(f64) -> f64,
    come: impl Fn(&mut GrainState),
    expected: impl Fn(f64) -> f64,
) -> MassLedger {
    let count = state.velocities.len();
    let bodies = Bodies {
        free: count,
        radii: vec![0.5; count],
        masses: vec![1.0; count],
        reference: vec![[0.0; 2]],
        base: 1,
        wheel_mass: Some(1.0),
        period: Some(Period::between([-1.0, 1.0])),
        ..Bodies::default()
    };
    let config = FlowConfig {
        zone_share: 0.99,
        margin_diameters: 1.0,
        hysteresis_diameters: 1.0,
        zone_mean_s: None,
        wear_s: WEAR,
        lateral: Some(LateralConfig { time_s: STAYS }),
    };
    let scene = FlowScene::new(config, &bodies, 1.0, (0.0, 7));
    let mut flow = Flow::new(&config, &bodies, &state);
    let mut due = 0.0;
    for number in 1..=STEPS {
        due += rate(flow.held) * STEP;
        while due >= 0.5 {
            due -= 1.0;
            come(&mut state);
        }
        let t = STEP * f64::from(number);
        flow.record(&scene, (&bodies, &state), t, STEP);
        for grain in flow.leave_sideways(&scene, (&bodies, &state), STEP) {
            state.take(&bodies, grain);
        }
        let expected = expected(t);
        assert!((flow.held - expected).abs() < 2.0, "{} at {t} s", flow.held);
        let all = flow.held + state.taken.len() as f64;
        assert_eq!(all, flow.ledger.source + flow.ledger.external);
        assert_eq!(flow.defect, 0.0);
    }
    let signals = Vec::from_iter(flow.signals());
    assert!(signals.contains(&("q_lateral_kg", flow.ledger.lateral)));
    assert!(flow.ledger.lateral > 700.0);
    flow.ledger
}

fn at_rest(count: usize) -> GrainState {
    GrainState {
        centres: vec![[0.0; 2]; count + 1],
        velocities: vec![[0.0; 3]; count],
        ..GrainState::default()
    }
}

/// m = Q T (1 - exp(-t/T)).
#[test]
fn a_constant_feed_and_a_sink_come_to_the_feed_times_the_time_that_grains_stay() {
    let (feed, count) = (3.0, 1000);
    let mut state = at_rest(count);
    state.feed.waiting = count as u32;
    let ledger = drained(
        state,
        |_| feed,
        |state| state.feed.waiting -= 1,
        |t| feed * STAYS * (1.0 - (-t / STAYS).exp()),
    );
    assert_eq!([ledger.source, ledger.external], [0.0, 900.0]);
}

/// A source Qs = alpha (m* - m): m = m_e (1 - exp(-(alpha + 1/T) t)) with m_e = alpha m*/(alpha + 1/T).
#[test]
fn a_source_that_third_body_slows_and_a_sink_come_to_their_balance() {
    let (alpha, wanted, count) = (0.02, 300.0, 1500);
    let mut state = at_rest(count);
    let anchored = (0..count as u32).map(|a| Bond {
        a,
        b: count as u32,
        adhesion: 1.0,
        ..Bond::default()
    });
    state.bonds = anchored.collect();
    let rate = alpha + 1.0 / STAYS;
    let ledger = drained(
        state,
        |held| alpha * (wanted - held),
        |state| state.bonds.truncate(state.bonds.len() - 1),
        |t| alpha * wanted / rate * (1.0 - (-rate * t).exp()),
    );
    assert_eq!(ledger.external, 0.0);
}

/// Disks 1 and 3 are one body; body 5 is glued.
#[test]
fn a_cluster_is_first_body_by_any_of_its_disks_and_a_driven_one_always() {
    let with = |drive: Option<Drive>| {
        let members = ClusterMembers {
            disks: vec![1, 3],
            drive,
            ..ClusterMembers::default()
        };
        let cluster = Cluster::new(&members, |i| ([i as f64, 0.0], 0.5, 1.0), 1.0);
        Bodies {
            free: 5,
            clusters: Clusters::new(vec![cluster], 5),
            ..Bodies::default()
        }
    };
    let held = [false, true, false, true, false];
    for bonded in [1, 3] {
        assert_eq!(first_grains(&with(None), &[(bonded, 5)]), held);
    }
    assert_eq!(first_grains(&with(None), &[(0, 2)]), [false; 5]);
    assert_eq!(first_grains(&with(Some(Drive::default())), &[]), held);
}
