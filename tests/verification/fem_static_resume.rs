//! Problem: the rail under a wheel in equilibrium: 8 000 N in 20 increments with friction, then a quarter of a cycle. Another node
//! resumes it from a checkpoint.
//! Exact: the same bits as in the uninterrupted run. The node reports after five increments at most.

use fem_node::FemConfig;
use fem_node::StaticNode;
use kit::read_config;
use protocol::{FaultCode, Node};
use serde_json::{Value, json};

use crate::fem_bodies::{setting, small, window, with};
use crate::fem_static_contact::loaded;

/// 20 increments of load and 60 of motion.
fn cycled() -> Value {
    let moving = json!({"statics": {"increment_n": 400.0},
                        "wheel": {"amplitude_m": 0.05e-3, "frequency_hz": 300.0, "cycles": 0.25}});
    with(loaded(small(), 8000.0, 0.3), moving)
}

fn node(config: &Value) -> StaticNode {
    let config: FemConfig = read_config(config).expect("the keys are valid");
    StaticNode::new(&config, &setting(1)).expect("the body is valid")
}

/// Reports of these windows of five increments.
fn advanced(node: &mut StaticNode, windows: std::ops::Range<u64>) -> Vec<Vec<f64>> {
    windows
        .map(|index| node.advance_alone(&window(index, 5)).expect("it converges"))
        .collect()
}

#[test]
fn an_equilibrium_resumes_from_a_checkpoint_bit_for_bit() {
    // During the loading, right after it, and during the motion.
    for cut in [2, 4, 9] {
        let mut whole = node(&cycled());
        assert_eq!(whole.describe().end_s, Some(80.0));
        assert_eq!(whole.describe().steps_at_once, Some(5));
        advanced(&mut whole, 0..cut);
        let state = whole.checkpoint().expect("it is a state");
        let mut resumed = node(&cycled());
        resumed.restore(&state).expect("of the same body");
        assert_eq!(
            advanced(&mut whole, cut..16),
            advanced(&mut resumed, cut..16)
        );
        let [whole, resumed] = [whole, resumed].map(|mut node| node.finish().expect("it ends"));
        assert_eq!(whole.state_hash, resumed.state_hash);
        assert_eq!(whole.results, resumed.results);
        assert_eq!(whole.steps, resumed.steps);
        assert!(whole.results.contains_key("p0_pa"));
    }
}

#[test]
fn a_checkpoint_of_another_body_is_refused() {
    let mut rail = node(&cycled());
    advanced(&mut rail, 0..1);
    let state = rail.checkpoint().expect("it is a state");
    let mut damaged = state.clone();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    let coarse = with(cycled(), json!({"mesh": {"size_m": 4e-4}}));
    for (mut other, state) in [(node(&coarse), &state), (node(&cycled()), &damaged)] {
        let error = other.restore(state).expect_err("it does not fit");
        assert_eq!(error.code, FaultCode::Configuration);
        assert!(error.message.contains("checkpoint"), "{error}");
    }
}

/// Without friction the path has no effect: 20 increments end where one does.
#[test]
fn increments_without_friction_end_where_one_does() {
    let smooth = |increment: f64| {
        let change = json!({"statics": {"increment_n": increment}});
        let mut node = node(&with(loaded(small(), 8000.0, 0.0), change));
        let end = node.describe().end_s.expect("it ends") as u64;
        advanced(&mut node, 0..end.div_ceil(5));
        (end, node.finish().expect("it ends").results)
    };
    let ((many, ours), (one, exact)) = (smooth(10.0), smooth(8000.0));
    assert_eq!((many, one), (20, 1));
    for name in [
        "p0_pa",
        "approach_m",
        "p_max_gauss_pa",
        "contact_half_width_m",
    ] {
        let error = ours[name] / exact[name] - 1.0;
        assert!(error.abs() < 1e-9, "{name}: {error:e}");
    }
}
