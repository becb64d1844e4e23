//! Problem: mesh files that are damaged, of another kind, or without a valid body.
//! Exact: each is refused with a message that names the error; no file causes a panic.
//! Source: Gmsh reference manual, MSH file format.
//! Tolerance: none.

use fem_node::mesh::gmsh::parse;
use kit::ConfigError;
use protocol::Setting;
use serde_json::{Value, json};

use crate::fem_bodies::setting;
use crate::fem_msh::{Drawing, MshFile, fan};

fn refused(text: &str) -> ConfigError {
    parse(text, 1.0).expect_err("it must be refused")
}

/// The refusal of the 2.2 file of three elements around a node, with `from` replaced once.
fn changed(from: &str, to: &str) -> ConfigError {
    let text = fan(3).msh2();
    assert!(text.contains(from), "{text}");
    refused(&text.replacen(from, to, 1))
}

fn says(error: ConfigError, words: &str) {
    assert!(error.problem.contains(words), "{error}");
}

#[test]
fn files_of_another_format_or_version_are_refused() {
    says(refused(""), "$MeshFormat");
    says(refused("solid cube\n"), "solid cube");
    says(changed("2.2 0 8", "4.0 0 8"), "version 4.0");
    says(changed("2.2 0 8", "2.2 1 8"), "no 1 of 4 bytes");
    says(changed("2.2 0 8", "2.2 2 8"), "file type is \"2\"");
    let broken = parse([&b"$MeshFormat\n2.2 0 8\n"[..], &[0xff]].concat(), 1.0);
    says(broken.expect_err("not text"), "not text");
    says(changed("$EndElements", ""), "truncated");
    says(
        changed("$EndNodes\n$Elements", "$EndNodes\n$Elephants"),
        "truncated",
    );
    says(changed("$Nodes", "$Notes"), "truncated");
    says(refused("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"), "$Nodes");
}

#[test]
fn errors_in_a_file_are_named_with_their_line() {
    let at = |from: &str, to: &str| changed(from, to).to_string();
    assert!(at("\n1 0e0 0e0 0\n", "\n1 nan 0e0 0\n").contains("line 11: a finite number"));
    assert!(at("\n1 0e0 0e0 0\n", "\n1 1e999 0e0 0\n").contains("a finite number"));
    assert!(at("\n2 1e0 0e0 0\n", "\n1 1e0 0e0 0\n").contains("node 1 is defined a second time"));
    assert!(at("3 2 1 1 1 2 3 4", "3 2 1 1 1 2 3 99").contains("names node 99"));
    assert!(at("3 2 1 1 1 2 3 4", "2 2 1 1 1 2 3").contains("a 3-node triangle"));
    // The reader takes the next element's number for the missing corner.
    assert!(at("3 2 1 1 1 2 3 4", "3 2 1 1 1 2 3").contains("names node 8"));
    assert!(at("$Nodes\n7", "$Nodes\n6").contains("$Nodes goes on where 6"));
    assert!(at("$Nodes\n7", "$Nodes\n18446744073709551615").contains("$Nodes ends there"));
    assert!(at("$Nodes\n7", "$Nodes\n-7").contains("the number of nodes"));
}

#[test]
fn invalid_bodies_are_refused_with_the_place() {
    let help = changed("3 2 1 1 1 2 3 4", "2 2 1 1 1 2 3").help;
    assert!(help.expect("advice").contains("ecombine"));
    // Node 3 moves beyond the opposite corner, then onto a neighbour's side.
    let third = |to: [f64; 2]| {
        let mut drawing = fan(3);
        drawing.points[2] = to;
        refused(&drawing.msh2())
    };
    says(third([-2.0, -2.0]), "folded, or not convex, at node");
    says(
        third([0.25, 0.433_012_701_892_219_3]),
        "straight angle, at node",
    );
    let beside = third([1.0, 0.0]).problem;
    let named = ["folded, or not convex, at node", "straight angle, at node"];
    assert!(named.iter().any(|how| beside.contains(how)), "{beside}");
    let mut raised = fan(3).msh2();
    raised = raised.replacen("\n2 1e0 0e0 0\n", "\n2 1e0 0e0 0.1\n", 1);
    says(refused(&raised), "z goes from 0.0 to 0.1");

    let mut cracked = fan(4);
    let hub = cracked.points.len();
    cracked.points.push([1e-12, 0.0]);
    cracked.quads[2][0] = hub;
    says(refused(&cracked.msh4()), "lie in one place");
    let mut twice = fan(4);
    twice.points.push([0.1, 0.0]);
    twice.quads.push([9, 1, 2, 3]);
    says(refused(&twice.msh4()), "overlap");
    let mut loose = fan(4);
    loose.lines[0].1.push([2, 6]);
    says(refused(&loose.msh4()), "is not a side of any quadrilateral");
    let mut branching = fan(4);
    branching.lines[0].1.push([0, 1]);
    says(refused(&branching.msh2()), "branches at node");
    let mut same_name = fan(4);
    same_name.lines.push(("rim", vec![[0, 1]]));
    says(refused(&same_name.msh4()), "two physical groups");
    let large = parse(fan(4).msh2(), 1e9).expect_err("it is too large");
    says(large, "m large");
    says(
        refused(&Drawing::default().msh2()),
        "it holds no quadrilaterals",
    );
}

#[test]
fn parts_of_a_file_without_a_role_are_skipped() {
    let mut drawing = fan(4);
    drawing.points.insert(0, [17.0, 4.0]);
    drawing
        .quads
        .iter_mut()
        .flatten()
        .for_each(|node| *node += 1);
    let rim = &mut drawing.lines[0].1;
    rim.iter_mut().flatten().for_each(|node| *node += 1);
    let text = drawing.msh2();
    // A point element, a repeated element, a group without a name, another program's section.
    let text = text.replacen(
        "$Elements\n12\n",
        "$Elements\n15\n90 15 2 7 7 1\n91 3 2 9 9 2 3 4 5\n92 1 2 8 8 3 4\n",
        1,
    );
    let text = text + "$Other\nanything 1 2 3\n$EndOther\n";
    let mesh = parse(&text, 1e-3).expect("it is still a body");
    assert_eq!((mesh.elements(), mesh.points.len()), (4, 9));
    assert!((mesh.size() - 2e-3).abs() < 1e-15);
    assert_eq!(mesh.sets(), ["rim", "whole body"]);
}

/// The error of `check` for a body with these keys and a mesh of four elements, with groups of these names; empty without one.
fn judged(groups: &[(&'static str, [usize; 2])], change: Value) -> String {
    let mut drawing = fan(4);
    drawing.lines = groups
        .iter()
        .map(|(name, line)| (*name, vec![*line]))
        .collect();
    let file = MshFile::new(&drawing.msh4());
    let mut config = json!({
        "base": "free", "mesh": {"gmsh": file.0},
        "material": {"young_pa": 1e9, "poisson": 0.3, "density_kg_per_m3": 1000.0},
        "time": {"step_s": "auto", "damping": 0.75},
    });
    crate::fem_bodies::merge(&mut config, change);
    let setting: Setting = setting(1);
    match fem_node::check(&config, &setting) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    }
}

#[test]
fn groups_that_other_keys_need_are_named() {
    fn says(groups: &[(&'static str, [usize; 2])], change: Value, words: &[&str]) {
        let message = judged(groups, change);
        let all = words.iter().all(|word| message.contains(word));
        assert!(all, "{message}");
    }
    assert_eq!(judged(&[], json!({})), "");
    let side = ("side", [1, 2]);
    says(
        &[side],
        json!({"base": "clamped"}),
        &["base", "`bottom`", "side", "whole body"],
    );
    says(
        &[side],
        json!({"sides": "fixed_x"}),
        &["sides", "`left`", "side"],
    );
    let wheel = json!({
        "wheel": {"load_n": 1.0, "mass_kg": 1.0, "ramp_s": 1.0, "hold_s": 0.0}, "contact": {"friction": 0.0},
    });
    says(&[side], wheel.clone(), &["wheel", "`top`", "side"]);
    says(&[("top", [0, 1])], wheel, &["wheel", "outline"]);
    let on = |set: &str, load: Value| json!({"boundary": {set: load}});
    says(
        &[side],
        on("rim", json!({"pressure_pa": 1.0})),
        &["boundary.rim", "side"],
    );
    says(
        &[("cut", [0, 1])],
        on("cut", json!({"pressure_pa": 1.0})),
        &["boundary.cut", "inside"],
    );
    says(
        &[side],
        on("whole body", json!({"pressure_pa": 1.0})),
        &["whole body", "surface"],
    );
    let moved = on("whole body", json!({"velocity_m_per_s": [1.0, 0.0]}));
    assert_eq!(judged(&[side], moved), "");
    says(
        &[],
        json!({"mesh": {"size_m": 1.0}}),
        &["mesh", "`size_m`", "gmsh"],
    );
    says(
        &[],
        json!({"mesh": {"gmsh": "none.msh"}}),
        &["mesh.gmsh", "none.msh"],
    );
}

#[test]
fn damage_never_causes_a_panic() {
    let (mut random, mut accepted) = (0x2545_f491_4f6c_dd1d_u64, 0);
    let mut next = |below: usize| {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random % below as u64) as usize
    };
    for text in [fan(3).msh2(), fan(5).msh4()] {
        for _ in 0..6_000 {
            let mut bytes = text.clone().into_bytes();
            for _ in 0..=next(3) {
                let at = next(bytes.len());
                if bytes.len() < 2 {
                    break;
                }
                match next(4) {
                    0 => bytes[at] = b"0123456789.-e $\n\"n"[next(18)],
                    1 => bytes[at] = next(128) as u8,
                    2 => drop(bytes.remove(at)),
                    _ => bytes.truncate(at.max(1)),
                }
            }
            let damaged = String::from_utf8(bytes).expect("only ASCII was written");
            match parse(&damaged, 1.0) {
                Ok(mesh) => accepted += usize::from(mesh.elements() > 0),
                Err(error) => assert!(!error.problem.is_empty() && error.help.is_some()),
            }
        }
    }
    // Often the damage only moves a node a little, or changes a name.
    assert!((100..6_000).contains(&accepted), "{accepted}");
}
