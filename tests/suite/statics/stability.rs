//! Stability of equilibria by the signs of pivots: columns against Euler's loads, arches at their
//! limit points.

use super::solved;
use crate::support::beams::{COLUMN, PINNED, line};
use crate::support::closures::{CLOSURES, GROUND, arm, beam_line, fixed, hinge, joint};
use crate::support::prelude::*;
use crate::support::program::{assert_says, changed, example, run_of};

/// Elements of a column.
const ELEMENTS: usize = 16;

fn column(analysis: &str) -> String {
    line(COLUMN, ELEMENTS, 1, &format!("{PINNED}{analysis}"))
}

/// Critical loads up to `most` of half waves in bending with the stiffness EI.
///
/// With EA = GA the equation of the beam is EI φ″ + P φ = 0 exactly: the compression P/EA takes from
/// the lever arm what the shear P/GA gives to it. Elements with linear interpolation and one
/// integration point make it EI (φ₊ − 2φ + φ₋)/h² + P (φ₊ + 2φ + φ₋)/4 = 0 with the
/// solutions cos(kπx/L), P = 4 EI/h² tan²(kπh/2L).
fn euler_loads(EI: f64, most: f64) -> Vec<f64> {
    let n = ELEMENTS as f64;
    (1..)
        .map(|k| 4.0 * EI * n * n * (f64::from(k) * PI / (2.0 * n)).tan().powi(2))
        .take_while(|P| *P < most)
        .collect()
}

/// Load and unstable directions of each row.
fn counts(text: &str) -> Vec<(f64, Option<usize>)> {
    let mut found = Vec::new();
    solved(text, &mut |step| found.push((step.t, step.unstable))).unwrap();
    found
}

#[test]
fn each_eulers_load_of_a_straight_column_is_one_more_direction() {
    let most = 110.0;
    let mut critical = euler_loads(1.0, most);
    critical.extend(euler_loads(3.0, most));
    assert_eq!(critical.len(), 4);
    let check = |rows: Vec<(f64, Option<usize>)>| {
        for (t, unstable) in rows {
            let passed = critical.iter().filter(|P| **P < t).count();
            assert_eq!(unstable, Some(passed), "P = {t}");
        }
    };
    // To 1e-6 of the critical loads, by load steps that end there.
    for P in &critical {
        for to in [P * (1.0 - 1e-6), P * (1.0 + 1e-6)] {
            let steps = format!("[analysis.static]\nto = {to:?}\nsteps = 3");
            let rows = counts(&column(&steps));
            assert_eq!(rows.len(), 4);
            check(rows);
        }
    }
    // Along the path.
    let path = "[analysis.arc_length]\nload_scale = 30\nstop = [{ load = 110 }]\n\
                record = [{ load = 9.8 }, { load = 9.95 }]";
    let rows = counts(&column(path));
    assert!(rows.len() > 20);
    check(rows);
}

#[test]
fn multipliers_do_not_count() {
    // The hinge at A as a joint that is closed by multipliers, one of six equations redundant or not.
    let closed = format!("child = \"A\"\n{}", CLOSURES[1]);
    let hinged = (fixed("G") + &hinge("hinge", "G", &closed)).replace('\n', "\\n");
    let pinned = "[[supports]]\\nnode = \"A\"\\nfix = [\"x\", \"y\", \"z\"]\\n";
    let changes = format!("A = [0, 0, 0] => &\\nG = [0, 0, 0]\n{pinned} => {hinged}");
    let first = euler_loads(1.0, 20.0)[0];
    for (load, expected) in [(0.99 * first, 0), (1.01 * first, 1)] {
        let steps = format!("[analysis.static]\nto = {load:?}\nsteps = 2");
        let rows = counts(&changed(&column(&steps), &changes));
        let counted: Vec<_> = rows.iter().map(|row| row.1).collect();
        assert_eq!(counted, [Some(0), Some(0), Some(expected)], "{load}");
    }
}

/// A stiff column of many elements, which a weld by multipliers joins in the middle.
#[test]
fn multipliers_of_large_models_do_not_count() {
    let half = |name: &str, ends: [&str; 2]| beam_line(name, ends, 64, "s");
    let text = [
        "[sections.s]\nstiffness = { EA = 1e7, GA = [1e7, 1e7], GJ = 10.0, EI = [3.0, 1.0] }\n\
         [nodes]\nA = [0, 0, 0]\nm = [0.5, 0, 0]\nw = [0.5, 0, 0]\nB = [1, 0, 0]\n",
        &half("first", ["A", "m"]),
        &half("second", ["w", "B"]),
        &joint(
            "weld",
            "weld",
            "m",
            &format!("child = \"w\"\n{}", CLOSURES[1]),
        ),
        PINNED,
        "[analysis.static]\nfrom = 0.0\nto = 120.0\nsteps = 15\n",
    ]
    .concat();
    let n = 128.0_f64;
    let load = |EI: f64, k: f64| 4.0 * EI * n * n * (k * PI / (2.0 * n)).tan().powi(2);
    let critical = [
        load(1.0, 1.0),
        load(3.0, 1.0),
        load(1.0, 2.0),
        load(1.0, 3.0),
        load(3.0, 2.0),
    ];
    let rows = counts(&text);
    assert_eq!(rows.len(), 16);
    for (t, unstable) in rows {
        let passed = critical.iter().filter(|P| **P < t).count();
        assert_eq!(unstable, Some(passed), "P = {t}");
    }
}

#[test]
fn a_column_beyond_its_load_is_warned_of() {
    let first = euler_loads(1.0, 20.0)[0];
    let steps = format!("[analysis.static]\nto = {}\nsteps = 2", 1.5 * first);
    let run = run_of("stability_column", &column(&steps));
    let warnings = run.result["warnings"].as_array().unwrap();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    let before = (0.75 * first * 1e4).floor() / 1e4;
    let span = format!("between load parameter {before:.4}");
    let told = [&span, "bifurcation", "unstable in 1 direction"];
    let words = warnings[0].as_str().unwrap();
    assert_says(words, &told);
    assert_says(words, &["imperfection", "max_step"]);
    assert_eq!(run.result["last"]["unstable"], 1);
    let column: Vec<&str> = run.rows.iter().map(|r| &r["unstable"][..]).collect();
    assert_eq!(column, ["0", "0", "1"]);
}

#[test]
fn a_deep_arch_is_unstable_from_its_limit_point_on() {
    let run = run_of("stability_arch", &example("deep_arch"));
    let mut events = run.rows.iter().map(|row| &row["event"]);
    let turning = events.position(|event| event == "turning_point").unwrap();
    for (k, row) in run.rows.iter().enumerate().skip(1) {
        let load = format!("load {}", row["t"]);
        match &row["unstable"][..] {
            // Where the tangent is singular nothing can be said.
            "" => assert!(k >= turning, "{load}"),
            unstable => {
                assert_ne!(k, turning, "{load}");
                assert_eq!(unstable, if k < turning { "0" } else { "1" }, "{load}");
            }
        }
    }
    assert_says(&run.result["warnings"].to_string(), &["limit point"]);
}

/// A bent cantilever of an isotropic section, spun about its axis at the root, keeps its shape: charts that change on the way
/// are no reason for short steps or bifurcations.
#[test]
fn a_path_passes_changes_of_chart() {
    let model = |spin: f64| {
        [
            "[sections.s]\nstiffness = { EA = 1e8, GA = [1e8, 1e8], GJ = 1.0, EI = [1.0, 1.0] }\n\
             [nodes]\na = [0, 0, 0]\nb = [1.0, 0, 0]\n",
            &(beam_line("l", ["a", "b"], 10, "s") + "order = 2\n"),
            "[[supports]]\nnode = \"a\"\nfix = [\"x\", \"y\", \"z\", \"ry\", \"rz\"]\n",
            &format!("prescribed = {{ rx = {{ proportional = {spin:?} }} }}\n"),
            "[[loads]]\nnode = \"b\"\nforce = [0, 0, 3.0]\ntime = { ramp = { start = 0.0, end = 0.2 } }\n",
            "[analysis.arc_length]\nmax_step = 0.05\nrecord = [\"bifurcation\"]\n",
        ]
        .concat()
    };
    let [still, spun] = [0.0, 8.0].map(|spin| {
        let mut unstable = 0;
        let context = solved(&model(spin), &mut |step| unstable += step.unstable.unwrap()).unwrap();
        assert_eq!(unstable, 0, "{spin}");
        context.node_state(context.find("b").unwrap()).d
    });
    assert!((spun - still).norm() < 1e-3, "{still} {spun}");
}

/// A portal frame on hinges sways at P = EI x²/L² with x tan x = 6 (Timoshenko & Gere 1961, section 2.4): by multipliers and
/// stiff members as by a map, in a plane that belongs to no axis.
#[test]
fn a_stiff_portal_sways_at_its_load_with_multipliers() {
    let (sin, cos) = 0.3_f64.sin_cos();
    let up = format!("{:?}, {:?}", -sin, cos);
    let line = |name: &str, ends: [&str; 2], axis: &str| {
        beam_line(name, ends, 4, "s") + &format!("order = 3\nsecond_axis = [{axis}]\n")
    };
    let hinge = |name: &str, parent: &str, more: &str| {
        joint(
            name,
            "revolute",
            parent,
            &format!("axis = [0, {cos}, {sin}]\n{more}"),
        )
    };
    let load = |node: &str| {
        format!(
            "[[loads]]\nnode = \"{node}\"\nforce = [0, {sin}, {:?}]\n",
            -cos
        )
    };
    let text = [
        "[sections.s]\nstiffness = { EA = 1e7, GA = [1e7, 1e7], GJ = 2.0, EI = [2.0, 1.0] }\n",
        &format!(
            "[nodes]\na = [0, 0, 0]\nb = [0, {up}]\nc = [1, {up}]\nd = [1, 0, 0]\ne = [1, 0, 0]\n"
        ),
        &line("left", ["hinge a", "b"], "1, 0, 0"),
        &line("beam", ["b", "c"], &format!("0, {up}")),
        &line("right", ["c", "e"], "1, 0, 0"),
        &fixed("a"),
        &fixed("d"),
        &load("b"),
        &load("c"),
        &hinge("hinge a", "a", ""),
        &hinge("hinge d", "d", "child = \"e\"\nclosure = \"multipliers\"\n"),
        "[analysis.static]\nto = 2.0\nsteps = 20\n",
    ]
    .concat();
    let mut x = 1.3_f64;
    for _ in 0..20 {
        x -= (x * x.tan() - 6.0) / (x.tan() + x / x.cos().powi(2));
    }
    solved(&text, &mut |step| {
        let unstable = usize::from(step.t > x * x);
        assert_eq!(step.unstable, Some(unstable), "{}", step.t);
    })
    .unwrap();
}

/// Two links of length 1/2 with springs of 0.7 and 2 at their hinges, in a line with the force on the slider that closes the
/// loop: they turn by θ and −θ, and buckle at 0.7 + 4·2.
#[test]
fn multipliers_leave_the_count_next_to_a_critical_load() {
    let text = [
        GROUND,
        &hinge("first", "ground", "spring = { k = 0.7 }"),
        &arm("middle", "first", [0.5, 0.0, 0.0]),
        &hinge("second", "middle", "spring = { k = 2 }"),
        &arm("end", "second", [1.0, 0.0, 0.0]),
        &joint("slider", "prismatic", "ground", "axis = [1, 0, 0]"),
        &arm("tip", "slider", [1.0, 0.0, 0.0]),
        &hinge("pin", "tip", "child = \"end\"\nclosure = \"multipliers\""),
        "[[loads]]\nnode = \"tip\"\nforce = [-8.7, 0, 0]\n[analysis.static]\n",
    ]
    .concat();
    for below in [1e-2, 1e-3, 2e-4, 2e-5, 2e-6] {
        for (to, expected) in [(1.0 - below, 0), (1.0 + below, 1)] {
            let (_, found) = counts(&format!("{text}to = {to:?}\n")).pop().unwrap();
            assert_eq!(found, Some(expected), "{to}");
        }
    }
}
