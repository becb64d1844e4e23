//! Runs whose results are not plausible: warnings with value and bound, and exit code 8 beyond the second bound.

use std::process::Output;

use harness::runs::{Scratch, parse_json, thirdbody};
use serde_json::{Value, json};

use crate::scene::folder;

/// Runs a shipped scene with these overrides and arguments: exit code, summary, output.
fn run(scene: &str, sets: &[&str], more: &[&str]) -> (Option<i32>, Value, Output) {
    let work = Scratch::new("plausible");
    let mut command = thirdbody(work.path());
    command
        .arg("run")
        .arg(folder(scene))
        .args(["--out", "out", "--json"]);
    for set in sets {
        command.args(["--set", set]);
    }
    let output = command.args(more).output().expect("the program starts");
    let summary = if output.stdout.is_empty() {
        Value::Null
    } else {
        parse_json(&output.stdout)
    };
    (output.status.code(), summary, output)
}

/// Ten windows of `quick`.
const SHORT: &str = "run.end_s=6e-6";

/// Codes of the warnings except `unreached`, which has its own tests below.
fn codes(summary: &Value) -> Vec<&str> {
    let warnings = summary["warnings"].as_array().expect("a list");
    let codes = warnings.iter().filter_map(|w| w["code"].as_str());
    codes.filter(|code| *code != "unreached").collect()
}

/// Keys whose effect the run ended before.
fn unreached(summary: &Value) -> Vec<&str> {
    let warnings = summary["warnings"].as_array().expect("a list").iter();
    let unreached = warnings.filter(|warning| warning["code"] == "unreached");
    unreached.filter_map(|w| w["where"].as_str()).collect()
}

#[test]
fn a_layer_of_another_shape_than_its_rail_is_suspect() {
    let crowned = |sets: &[&str], radius: &str, more: &[&str]| {
        let set = format!("participant.third-body.config.sample.crown_radius_m={radius}");
        run("quick", &[sets, &[&set]].concat(), more)
    };
    let crown = |radius: &str, more: &[&str]| crowned(&[SHORT], radius, more);
    let (code, summary, output) = crown("0.1", &[]);
    assert_eq!((code, &summary["status"]), (Some(8), &json!("suspect")));
    assert_eq!(codes(&summary), ["surface_offset"]);
    let warnings = summary["warnings"].as_array().expect("a list");
    let warning = warnings.last().expect("there is one");
    assert_eq!(warning["where"], "layer-base");
    assert!(
        warning["value"].as_f64() > warning["bound"].as_f64(),
        "{warning}"
    );
    let printed = String::from_utf8_lossy(&output.stderr);
    assert!(
        printed.contains("warning[surface_offset]: layer-base: the shape"),
        "{printed}"
    );

    let (code, summary, _) = crown("0.25", &[]);
    assert_eq!((code, codes(&summary)), (Some(0), vec!["surface_offset"]));
    let (code, summary, _) = crown("0.25", &["--strict"]);
    assert_eq!((code, &summary["status"]), (Some(8), &json!("suspect")));
    let bounds = "run.plausible.surface_offset_rel=[5.0, 9.0]";
    let (code, summary, _) = crowned(&[bounds], "0.1", &["--strict"]);
    assert_eq!((code, &summary["warnings"]), (Some(0), &json!([])));
}

/// Grains on a bare surface whose points lie 8 mm apart (20 elements) press on the rail with 713 MPa instead of 1 018.
#[test]
fn points_much_wider_apart_than_the_nodes_raise_a_warning() {
    let loose = "participant.third-body.config.sample.glued=false";
    let spacing = "participant.third-body.config.sample.surface.spacing_m";
    let found = |spacing_m: &str| {
        let set = format!("{spacing}={spacing_m}");
        let (_, summary, _) = run("quick", &[SHORT, loose, &set], &[]);
        codes(&summary).contains(&"point_spacing")
    };
    assert!(found("8e-3"));
    assert!(!found("1e-3"));
}

/// Grains on every second node press with 600 MPa where the load makes 500, if the mapping gives each of them one or two nodes.
#[test]
fn a_mapping_without_width_needs_a_point_for_each_node() {
    let found = |mapping: &str, fine: bool| {
        let mapping = format!("interface.feet.mapping={mapping}");
        let mut set = vec!["run.end_s=6e-6", &mapping];
        if fine {
            set.extend([
                "participant.strip.config.mesh.size_m=0.2e-3",
                "participant.strip.config.time.step_s=1.2e-8",
            ]);
        }
        let (_, summary, _) = run("verification/columns-on-a-strip", &set, &[]);
        codes(&summary).contains(&"point_spacing")
    };
    assert_eq!(
        ["mortar", "linear", "nearest"].map(|m| found(m, false)),
        [false, false, true]
    );
    assert_eq!(
        ["mortar", "linear", "nearest"].map(|m| found(m, true)),
        [false, true, true]
    );
}

/// Two pairs of glued disks far apart: `mortar` spreads half of the load over the hole between them.
#[test]
fn a_hole_in_a_glued_row_raises_a_warning() {
    let disks = [-8.8e-3, -8.4e-3, 8.4e-3, 8.8e-3].map(|x| {
        format!("{{x_m={x:e},y_m=0.0,radius_m=0.2e-3,glued=true}},{{x_m={x:e},y_m=0.4e-3,radius_m=0.2e-3}}")
    });
    let sample = format!(
        "participant.third-body.config.sample={{kind=\"disks\",disks=[{}]}}",
        disks.join(",")
    );
    let found = |mapping: &str| {
        let mapping = format!("interface.layer-base.mapping={mapping}");
        let end = "run.end_s=1e-5";
        let (_, summary, _) = run("quick", &[end, &sample, &mapping], &[]);
        codes(&summary).contains(&"point_hole")
    };
    assert!(found("mortar"));
    assert!(!found("linear"));
}

#[test]
fn bounds_out_of_order_are_refused_by_their_key() {
    for (set, key) in [
        ("run.plausible.gap_rel=[1.0, 0.5]", "run.plausible.gap_rel"),
        (
            "participant.third-body.config.plausible.overlap_rel=[1.0, 0.5]",
            "participant.third-body.config.plausible.overlap_rel",
        ),
        (
            "participant.third-body.config.plausible.detection_rel=[0.03, 0.003]",
            "participant.third-body.config.plausible.detection_rel",
        ),
        (
            "participant.rail.config.plausible.strain=[-1.0, 0.5]",
            "participant.rail.config.plausible.strain",
        ),
    ] {
        let (code, _, output) = run("quick", &[SHORT, set], &[]);
        let printed = String::from_utf8_lossy(&output.stderr);
        assert_eq!(code, Some(2), "{printed}");
        assert!(
            printed.contains(key) && printed.contains("ascending order"),
            "{printed}"
        );
    }
}

#[test]
fn interfaces_inside_out_are_refused() {
    let (code, _, output) = run(
        "two-rails",
        &[
            "interface.below.between=[\"lower.top\", \"third-body.lid\"]",
            "interface.above.between=[\"upper.bottom\", \"third-body.base\"]",
        ],
        &[],
    );
    let printed = String::from_utf8_lossy(&output.stderr);
    assert_eq!(code, Some(2), "{printed}");
    for part in ["below", "lower.top", "third-body.lid", "face the same way"] {
        assert!(printed.contains(part), "{part}: {printed}");
    }
}

#[test]
fn windows_accepted_without_convergence_make_the_run_suspect() {
    let (code, summary, _) = run(
        "quick",
        &[
            SHORT,
            "interface.layer-base.on_not_converged=\"accept\"",
            "participant.third-body.config.solver.max_iterations=2",
        ],
        &[],
    );
    assert_eq!(code, Some(8));
    assert!(codes(&summary).contains(&"not_converged"), "{summary}");
}

#[test]
fn a_wheel_that_moves_at_once_under_its_load_is_suspect() {
    let key = "participant.third-body.config.wheel";
    let set = |name: &str| format!("{key}.{name}");
    let (code, summary, _) = run(
        "layer-alone",
        &["run.end_s=1e-5", &set("ramp_s=0.0"), &set("hold_s=0.0")],
        &[],
    );
    assert_eq!(code, Some(8), "{summary}");
    assert!(codes(&summary).contains(&"wheel_at_rest"), "{summary}");
    let short_ramp = [&set("ramp_s=2e-5")[..], &set("hold_s=0.0")];
    let (_, summary, _) = run(
        "layer-alone",
        &[&["run.end_s=3e-5"], &short_ramp[..]].concat(),
        &[],
    );
    let rest = |w: &&Value| w["code"] == "wheel_at_rest";
    let warnings = summary["warnings"].as_array().expect("a list");
    let value = warnings.iter().find(rest).map(|w| &w["value"]);
    assert!(
        value.is_some_and(|value| value.as_f64() > Some(0.05)),
        "the last force of a ramp of 0.02 ms is far off: {summary}"
    );
    let (_, summary, _) = run(
        "layer-alone",
        &[&["run.end_s=1e-5"], &short_ramp[..]].concat(),
        &[],
    );
    assert!(
        !codes(&summary).contains(&"wheel_at_rest"),
        "it is still being loaded: {summary}"
    );
}

#[test]
fn a_rail_too_heavy_to_come_to_rest_raises_a_warning() {
    let heavy = "participant.rail.config.material.density_kg_per_m3=1e7";
    let alone = "participant.third-body.config.wheel.cycles=0.0";
    let (code, summary, _) = run("quick", &[heavy, alone], &[]);
    // The approach is 2.7 % below a steel rail's.
    let expected = vec!["unusual_value", "wheel_drift"];
    assert_eq!((code, codes(&summary)), (Some(0), expected));
}

#[test]
fn a_rough_tolerance_and_a_layer_under_stress_raise_warnings() {
    let rough = "participant.third-body.config.solver.tolerance=0.05";
    let (_, summary, _) = run("quick", &["run.end_s=6e-5", rough], &[]);
    assert_eq!(codes(&summary), ["contact_residual"]);
    let advised = |pressures: &str| {
        let work = Scratch::new("prestress");
        let mut check = thirdbody(work.path());
        let set = format!("participant.third-body.config.sample.press_pa={pressures}");
        check
            .arg("check")
            .arg(folder("quick"))
            .args(["--set", &set]);
        let printed = check.output().expect("the program starts");
        let printed = [printed.stdout, printed.stderr].concat();
        let printed = String::from_utf8_lossy(&printed).into_owned();
        let flat: Vec<&str> = printed.split_whitespace().collect();
        flat.join(" ").contains("sample.press_pa: the layer")
    };
    assert!(advised("[1e10]"));
    assert!(!advised("[1e9, 5e7]"), "the last pressure counts");
}

/// The exit code and the output of `check` for a scene with this override.
fn checked(scene: &str, set: &str) -> (Option<i32>, String) {
    let work = Scratch::new("checked");
    let mut check = thirdbody(work.path());
    check.arg("check").arg(folder(scene)).args(["--set", set]);
    let output = check.output().expect("the program starts");
    let printed = [output.stdout, output.stderr].concat();
    (
        output.status.code(),
        String::from_utf8_lossy(&printed).into_owned(),
    )
}

/// Geometry, masses and keys are known before the first window: `check` warns of them with the codes and the exit code of the run.
#[test]
fn check_gives_the_warnings_and_the_exit_code_of_the_run() {
    let crown = "participant.third-body.config.sample.crown_radius_m=0.15";
    let (code, printed) = checked("quick", crown);
    assert_eq!(code, Some(8), "{printed}");
    assert!(printed.contains("warning[surface_offset]"), "{printed}");
    let (code, summary, _) = run("quick", &[SHORT, crown], &[]);
    assert_eq!((code, codes(&summary)), (Some(8), vec!["surface_offset"]));
    let (code, printed) = checked("quick", "run.seed=2");
    assert_eq!(
        (code, printed.contains("warning[")),
        (Some(0), false),
        "{printed}"
    );
}

/// 102.5 for 102.5 GPa, and 7.8 for 7.8 g/cm3.
#[test]
fn a_mistaken_unit_is_guessed() {
    for (set, meant) in [
        (
            "participant.rail.config.material.young_pa=102.5",
            "was 102.5 GPa meant, 1.025e11 Pa?",
        ),
        (
            "participant.third-body.config.density_kg_per_m3=7.8",
            "was 7.8 g/cm3 meant, 7.8e3 kg/m3?",
        ),
    ] {
        let (_, printed) = checked("quick", set);
        assert!(
            printed.contains("warning[unusual_value]") && printed.contains(meant),
            "{printed}"
        );
        let (_, summary, _) = run("quick", &[SHORT, set], &[]);
        assert!(codes(&summary).contains(&"unusual_value"), "{summary}");
    }
}

/// A component of a velocity, and the keys of bonds.
#[test]
fn numbers_in_lists_and_of_bonds_are_judged() {
    for (scene, set) in [
        (
            "verification/bar-thrown",
            "participant.bar.config.initial.body.velocity_m_per_s=[0.0, 1e5]",
        ),
        (
            "verification/pull-off",
            "participant.bond.config.law.cn_pa_per_m=1e25",
        ),
        (
            "verification/pull-off",
            "participant.bond.config.law.w_j_per_m2=1e9",
        ),
    ] {
        let (_, printed) = checked(scene, set);
        assert!(printed.contains("warning[unusual_value]"), "{printed}");
    }
}

/// No shipped scene has this name, so there is nothing to compare with.
#[test]
fn an_origin_that_is_not_shipped_is_a_key_without_effect() {
    let (code, printed) = checked("quick", "run.derived_from=quik");
    assert_eq!(code, Some(0), "{printed}");
    assert!(
        printed.contains("warning[unused_key]: run.derived_from")
            && printed.contains("did you mean `quick`?"),
        "{printed}"
    );
}

#[test]
fn a_tolerance_below_rounding_is_refused() {
    let set = "participant.third-body.config.solver.tolerance=1e-100";
    let (code, _, output) = run("quick", &[SHORT, set], &[]);
    let printed = String::from_utf8_lossy(&output.stderr);
    assert_eq!(code, Some(2), "{printed}");
    assert!(
        printed.contains("solver.tolerance") && printed.contains("1e-100"),
        "{printed}"
    );
}

#[test]
fn a_key_without_meaning_is_a_warning_of_the_summary() {
    let set = "interface.layer-base.relaxation=0.5";
    let (code, summary, _) = run("quick", &[SHORT, set], &[]);
    assert_eq!((code, codes(&summary)), (Some(0), vec!["unused_key"]));
    assert_eq!(
        summary["warnings"][0]["where"],
        "interface.layer-base.relaxation"
    );
}

/// Keys of a run alone, of a log that is not written, and of the network.
#[test]
fn keys_of_another_kind_of_run_have_no_effect() {
    let sets = [
        "run.output.exchange=false",
        "run.output.flush_every_windows=3",
        "run.output.alone_steps=7",
        "run.remote.listen=tcp/127.0.0.1:0",
        "run.checkpoints_kept=3",
        "run.deadlines.link_s=9.0",
        "participant.third-body.config.solver.on_not_converged=accept",
    ];
    let (code, summary, _) = run("quick", &[&[SHORT][..], &sets].concat(), &[]);
    assert_eq!((code, codes(&summary)), (Some(0), vec!["unused_key"; 6]));
    let warned = summary["warnings"].as_array().expect("a list").iter();
    let warned = warned.filter(|one| one["code"] == "unused_key");
    let about: Vec<&str> = warned.filter_map(|one| one["where"].as_str()).collect();
    let expected = [
        "run.output.flush_every_windows",
        "run.output.alone_steps",
        "run.checkpoints_kept",
        "run.remote",
        "run.deadlines.link_s",
        "participant.third-body.config.solver.on_not_converged",
    ];
    assert_eq!(about, expected);
}

/// The last window is cut at the end of the run, and its step says nothing about the others.
#[test]
fn the_step_over_the_inertial_time_does_not_depend_on_the_end() {
    let of = |end: &str| run("quick", &[end], &[]).1["results"]["step_over_inertial_time"].as_f64();
    let [one, other] = ["run.end_s=6e-5", "run.end_s=6.1e-5"].map(of);
    assert!(one > Some(0.0) && one == other, "{one:?} {other:?}");
}

#[test]
fn energies_that_no_participant_reports_are_marked_as_missing() {
    let (code, summary, _) = run("verification/block-under-wheel", &[], &[]);
    assert_eq!(code, Some(0));
    let block = &summary["participants"]["block"];
    assert_eq!(block["ledger"], false);
    assert_eq!(block["energy_balance_rel"], Value::Null);
    assert_eq!(summary["results"]["energy_balance_rel"], Value::Null);
    let (_, summary, _) = run("quick", &[SHORT], &[]);
    assert_eq!(summary["participants"]["rail"].get("ledger"), None);
}

/// The peak of 957 MPa at 0.5 ms is not the hold's, 1 053 MPa. At 0.8 ms the hold is over, and only the motion is to come.
#[test]
fn results_of_the_hold_are_left_out_of_a_run_that_ends_before_it() {
    let keys = |names: &[&str]| {
        let keys = names.iter();
        let keys = keys.map(|name| format!("participant.rail.config.wheel.{name}"));
        keys.collect::<Vec<_>>()
    };
    let of_hold = [
        "p0_pa",
        "approach_m",
        "contact_half_width_m",
        "p_max_gauss_pa",
    ];
    for (end, coming, there) in [
        ("5e-4", &["cycles", "hold_s", "ramp_s"][..], false),
        ("7.9e-4", &["cycles", "hold_s"], false),
        ("8e-4", &["cycles"], true),
    ] {
        let set = format!("run.end_s={end}");
        let (code, summary, _) = run("wheel-rail-fe-small", &[&set], &[]);
        assert_eq!(
            (code, unreached(&summary)),
            (Some(0), keys(coming).iter().map(|k| &**k).collect())
        );
        for name in of_hold {
            let result = &summary["results"][name];
            assert_eq!(result.is_number(), there, "{name} at {end}: {result}");
        }
        assert_eq!(
            summary["results"]["load_n"], 8000.0,
            "the load that is asked for"
        );
    }
    let check = |sets: &[&str]| {
        let work = Scratch::new("predicted");
        let mut check = thirdbody(work.path());
        check
            .arg("check")
            .arg(folder("wheel-rail-fe-small"))
            .args(sets);
        let printed = check.output().expect("the program starts").stdout;
        String::from_utf8_lossy(&printed)
            .matches("warning[unreached]")
            .count()
    };
    assert_eq!(check(&["--set", "run.end_s=5e-4"]), 3);
    assert_eq!(check(&[]), 0);
}

/// The grains report the wheel, the rail reports the pressures, and the force is the interface's.
#[test]
fn results_of_a_hold_are_left_out_whichever_participant_reports_them() {
    let of_hold = ["approach_m", "p_max_gauss_pa", "interface_force_n"];
    let (_, summary, _) = run("quick", &["run.end_s=2e-4"], &[]);
    let wheel = ["cycles", "hold_s", "ramp_s"];
    let wheel = wheel.map(|key| format!("participant.third-body.config.wheel.{key}"));
    assert_eq!(unreached(&summary), wheel);
    let mut gone = of_hold.iter().map(|name| &summary["results"][*name]);
    assert!(gone.all(Value::is_null), "{summary}");
}

/// A load that changes after the end, a ramp and fields that come after it; a table that stays constant beyond it raises no warning.
#[test]
fn tables_ramps_and_fields_after_the_end_are_reported_by_key() {
    let loaded = |table: &str| {
        let set = format!(
            "participant.bar.config.boundary.top={{ {table}, load_direction = [0.0, -1.0] }}"
        );
        let (code, summary, _) = run("verification/bar-driven", &[&set, "run.end_s=2e-6"], &[]);
        assert_eq!(code, Some(0), "{summary}");
        unreached(&summary).join(" ")
    };
    let key = "participant.bar.config.boundary.top";
    let late = "load_table = [[0.0, 1.0], [1e-6, 2.0], [4e-6, -1.0]]";
    assert_eq!(loaded(late), format!("{key}.load_table"));
    let settled = "load_table = [[0.0, 1.0], [1e-6, 2.0], [4e-6, 2.0]]";
    assert_eq!(loaded(settled), "");
    let slow = "participant.bar.config.boundary.top={ traction_pa = [0.0, -1e6], ramp_s = 3e-6 }";
    let fields = ["run.end_s=2e-6", "run.output.fields_every_s=1.0"];
    let (_, summary, _) = run(
        "verification/bar-driven",
        &[&[slow], &fields[..]].concat(),
        &[],
    );
    let both = ["run.output.fields_every_s", &format!("{key}.ramp_s")];
    assert_eq!(unreached(&summary), both);
}

/// The time of a static analysis counts increments.
#[test]
fn increments_that_never_came_are_reported_by_key() {
    let (code, summary, _) = run("verification/block-under-wheel", &["run.end_s=3.0"], &[]);
    let keys = ["cycles", "load_n"].map(|key| format!("participant.block.config.wheel.{key}"));
    assert_eq!(
        (code, unreached(&summary)),
        (Some(0), keys.iter().map(|k| &**k).collect())
    );
    assert_eq!(summary["results"]["p0_pa"], Value::Null);
}

/// The only cycle, of 3 kHz, ends at 1.133 ms; half a cycle has no area.
#[test]
fn a_loop_that_is_not_closed_has_no_area() {
    let wheel = ["frequency_hz=3000.0", "cycles=1.0"];
    let wheel = wheel.map(|set| format!("participant.rail.config.wheel.{set}"));
    let area = |end: &[&str]| {
        let sets = [&[&*wheel[0], &*wheel[1]], end].concat();
        let (_, summary, _) = run("wheel-rail-fe-small", &sets, &[]);
        summary["results"]["loop_area_j"].clone()
    };
    assert!(area(&[]).is_number());
    assert_eq!(area(&["run.end_s=9.7e-4"]), Value::Null);
}
