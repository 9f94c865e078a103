//! Loops that multipliers close start where the maps of these loops start, and loops in which nothing
//! can move rest by every scheme.

use crate::support::closures::*;
use crate::support::program::{number, run_of};

/// With A at −0.71 D cannot be at 2.771, where the tips of the cranks are further apart than the bars
/// reach.
fn too_far(closure: &str) -> String {
    let linkage = five_bar(["value = -0.71", "value = 2.771", closure]);
    [linkage, body("B"), body("D")].concat()
}

/// A boom that is driven far, and a loop with balls on it.
fn boom(closure: &str) -> String {
    let closed = format!("child = \"arm\"\n{closure}");
    [
        GROUND,
        RUN,
        &hinge("A", "ground", "prescribed = { constant = 2.5 }"),
        &arm("tip", "A", [1.0, 1.0, 0.0]),
        &joint("B", "revolute", "tip", "axis = [0.3, 0, 1]\nvalue = 0.3"),
        &arm("arm", "B", [0.5, 2.0, 0.0]),
        &arm("mid", "A", [0.0, 0.5, 0.0]),
        &hinge("K", "mid", ""),
        &arm("knee", "K", [-0.5, 1.0, 0.0]),
        &joint("S", "spherical", "knee", ""),
        &arm("strut", "S", [0.5, 2.0, 0.0]),
        &joint("c", "spherical", "strut", &closed),
        &["A", "B", "K", "S"].map(body).concat(),
    ]
    .concat()
}

#[test]
fn values_that_cannot_all_be_are_kept_as_by_the_map() {
    let (by_map, _) = start(&too_far(CLOSURES[0]));
    for closure in &CLOSURES[1..] {
        let (positions, notes) = start(&too_far(closure));
        assert!((positions["A angle"][0] + 0.71).abs() <= f64::EPSILON);
        for name in ["A angle", "B angle", "E angle", "D angle"] {
            let apart = (positions[name][0] - by_map[name][0]).abs();
            assert!(apart < 1e-9, "{closure}: {name} {apart:e}");
        }
        let told = notes.iter().any(|n| n.starts_with("D angle starts at "));
        assert!(told, "{notes:?}");
    }
}

#[test]
fn a_value_is_kept_far_from_where_the_loop_is_drawn() {
    for closure in CLOSURES {
        let (positions, notes) = start(&boom(closure));
        let off = (positions["B angle"][0] - 0.3).abs();
        assert!(off < 1e-14, "{closure}: {off:e}");
        assert!(!notes.iter().any(|n| n.contains("starts at")), "{notes:?}");
    }
}

#[test]
fn a_value_below_a_loop_leaves_the_loop_where_the_map_has_it() {
    // The strut spins freely between its balls, and starts as it is drawn, which smallest
    // corrections of the gap do not do.
    let turned = |closure: &str| {
        boom(closure)
            .replace("prescribed = { constant = 2.5 }", "value = 0.144")
            .replace("value = 0.3", "prescribed = { constant = 0.3 }")
    };
    let (by_map, _) = start(&turned(CLOSURES[0]));
    assert_eq!(by_map["A angle"][0], 0.144);
    for closure in &CLOSURES[1..] {
        let (positions, _) = start(&turned(closure));
        for name in ["A angle", "K angle", "S rotation", "c rotation"] {
            for (a, b) in positions[name].iter().zip(by_map[name]) {
                assert!((a - b).abs() < 1e-9, "{closure}: {name} {a} for {b}");
            }
        }
    }
}

#[test]
fn rates_that_follow_from_a_drive_are_no_rates_at_rest() {
    let driven = "prescribed = { proportional = 1 }";
    let linkage = five_bar([driven, driven, CLOSURES[1]]) + &body("B");
    let (said, _) = rows("closures-rates", &linkage);
    assert!(said.contains("complete"), "{said}");
    assert!(!said.contains("is attached to it by"), "{said}");
}

/// A triangle of bars with hinges: nothing moves, and it carries a weight.
#[test]
fn a_triangle_of_bars_carries_its_weight_by_every_scheme() {
    for scheme in ["\"radau\"", "\"bathe\"", "{ generalised-alpha = 0.8 }"] {
        let text = [
            GROUND,
            &hinge("A", "ground", ""),
            &arm("a", "A", [1.0, 1.0, 0.0]),
            &arm("foot", "ground", [0.1, 2.0, 0.0]),
            &hinge("D", "foot", ""),
            &arm("d", "D", [1.0, 1.0, 0.0]),
            &hinge("C", "a", &format!("child = \"d\"\n{}", CLOSURES[1])),
            &body("A").replace("mass", "center = [0.5, 0.4, 0]\nmass"),
            &body("D").replace("mass", "center = [0.5, 0, 0]\nmass"),
            &angle("A"),
            "[[loads]]\ngravity = [-9.81, 0, 0]\n",
            &format!("[analysis.dynamic]\nto = 0.1\nstep = 0.0025\nscheme = {scheme}\n"),
        ]
        .concat();
        let run = run_of("closures-triangle", &text);
        let moved = run.rows.iter().map(|r| number(r, "A").abs());
        assert!(moved.fold(0.0, f64::max) < 1e-14, "{scheme}");
        let warnings = run.result["warnings"].to_string();
        assert!(!warnings.contains("energy"), "{scheme}: {warnings}");
    }
}
