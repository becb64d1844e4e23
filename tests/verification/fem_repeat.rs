//! Problem: a repeated window, a run on several threads, and a run in shorter windows.
//! Exact: the same bits in the first two. The same motion in the third: each window computes the acceleration anew, and
//! under an unchanged force it is the same to rounding.
//! Source: requirement; every thread computes a row of nodes in the same way.
//! Tolerance: none for bits; 1e-12 for shorter windows.

use fem_node::FemNode;
use protocol::Node;
use serde_json::json;

use crate::fem_bodies::{block, node, node_on, paper, rail, window, with};

fn hash(node: &mut FemNode) -> String {
    node.finish().expect("it ends").state_hash
}

fn force(points: usize, seed: usize) -> Vec<f64> {
    (0..2 * points)
        .map(|k| ((seed + 7 * k) as f64).sin())
        .collect()
}

#[test]
fn repeats_leave_no_trace() {
    let config = with(
        block(),
        json!({"time": {"mass_damping_per_s": 1e5},
               "boundary": {"top": {"traction_pa": [0.0, -1e6], "ramp_s": 1e-6}}}),
    );
    let (mut plain, mut repeated) = (node(&config), node(&config));
    let points = plain.couple("top").expect("a set").len();
    repeated.couple("top").expect("a set");
    for index in 0..20 {
        let seed = index as usize;
        repeated
            .advance(&window(index, 3), &force(points, seed + 100))
            .expect("stable");
        repeated.columns(&window(0, 4)).expect("stable");
        let again = repeated
            .advance(&window(index, 9), &force(points, seed))
            .expect("stable");
        let once = plain
            .advance(&window(index, 9), &force(points, seed))
            .expect("stable");
        assert_eq!(once, again);
        let reports = [&mut plain, &mut repeated]
            .map(|node| node.commit(&window(index, 9), &[]).expect("advanced"));
        assert_eq!(reports[0], reports[1]);
    }
    assert_eq!(hash(&mut plain), hash(&mut repeated));
}

#[test]
fn threads_do_not_change_a_bit() {
    let config = with(rail(paper()), json!({"time": {"mass_damping_per_s": 3e4}}));
    let run = |threads: usize| {
        let mut node = node_on(&config, threads);
        node.couple("top").expect("a set");
        let points: Vec<usize> = (180..210).collect();
        node.select(&points).expect("points of the set");
        for index in 0..3 {
            node.advance(&window(index, 10), &force(30, index as usize))
                .expect("stable");
            node.commit(&window(index, 10), &[]).expect("advanced");
        }
        let columns = node.columns(&window(0, 3)).expect("stable");
        (hash(&mut node), columns)
    };
    let one = run(1);
    for threads in [2, 3, 5] {
        assert_eq!(run(threads), one, "{threads} threads");
    }
}

#[test]
fn shorter_windows_do_not_change_the_motion() {
    let config = with(
        block(),
        json!({"time": {"mass_damping_per_s": 3e5}, "boundary": {"top": {"traction_pa": [1e6, -1e6]}}}),
    );
    let (mut whole, mut cut) = (node(&config), node(&config));
    whole.advance_alone(&window(0, 300)).expect("stable");
    for index in 0..100 {
        cut.advance_alone(&window(index, 3)).expect("stable");
    }
    let pairs = || whole.state().u.iter().zip(&cut.state().u);
    let largest = pairs().fold(0.0, |far: f64, (u, _)| far.max(u.abs()));
    let apart = pairs().fold(0.0, |far: f64, (a, b)| far.max((a - b).abs()));
    assert!(apart <= 1e-12 * largest, "{apart:e} of {largest:e}");
}

#[test]
fn a_window_that_was_not_advanced_cannot_be_committed() {
    let mut node = node(&block());
    assert!(node.commit(&window(0, 5), &[]).is_err());
    node.advance(&window(0, 5), &[])
        .expect("nothing is coupled");
    assert!(
        node.commit(&window(1, 5), &[]).is_err(),
        "another window was advanced"
    );
    node.advance(&window(0, 5), &[])
        .expect("nothing is coupled");
    assert!(
        node.commit(&window(0, 5), &[0.0]).is_err(),
        "no set has a prescribed displacement"
    );
}
