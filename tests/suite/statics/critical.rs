//! Limit points of beams found directly, and the path of a column beyond its bifurcation.

use crate::support::beams::{COLUMN, PINNED, line};
use crate::support::closures::{
    CLOSURES, angle, arm, beam_line, body_of, fixed, hinge, joint, probe,
};
use crate::support::laboratory::model;
use crate::support::prelude::*;
use crate::support::program::{
    Rows, assert_close, assert_says, changed, example, failed, number, run_of,
};
use pullback::input::job;
use std::collections::HashMap;

/// From the last step before it, in five iterations. Values by independent shooting: S11 and S12.
#[test]
fn limit_points_directly() {
    for (name, elements, exact, tolerance) in [
        ("lee_frame", 1, 18546.558 / 20000.0, 1e-5),
        ("deep_arch", 3, 897.2891 / 1000.0, 1e-6),
    ] {
        let mut file = model(&format!("{name}.toml"));
        for line in &mut file.lines {
            line.elements *= elements;
        }
        let mut job = job(name, &file, None).unwrap();
        let Plan::Path(options, _) = &mut job.plan else {
            unreachable!()
        };
        options.events.clear();
        let (mut before, mut q) = ((0.0, Vec::new()), Vec::new());
        trace_path(&mut job.context, &mut q, options, &mut |_, step| {
            if step.t < before.0 {
                return ControlFlow::Break(());
            }
            before = (step.t, step.q.to_vec());
            ControlFlow::Continue(())
        })
        .unwrap();
        let at = Point::statics(before.0, &before.1);
        let options = StaticNewtonOptions::default();
        let point = critical_point(&mut job.context, at, None, &options).unwrap();
        assert_eq!(point.kind, CriticalKind::Limit);
        let error = point.t / exact - 1.0;
        assert!(error.abs() < tolerance, "{name}: {} {error}", point.t);
        let corrections = &point.corrections;
        assert!(corrections.len() <= 5, "{name}: {corrections:?}");
        // Quadratic: with the change of the path's length over its own square.
        for pair in corrections.windows(2) {
            let most = 10.0 * pair[0] * pair[0] + 1e-7;
            assert!(pair[1] <= most, "{name}: {corrections:?}");
        }
    }
}

/// A pinned column with a force of 20 t; EI = 1 in the plane of its motion.
fn column() -> String {
    let planar = "\"y\", \"z\"] => \"y\", \"z\", \"rx\", \"ry\"]\n\
                  \"z\", \"rx\"] => \"z\", \"rx\", \"ry\"]\n[-1, => [-20,";
    let path = r#"
        [[probes]]
        name = "end"
        quantity = "displacement"
        node = "B"
        [analysis.arc_length]
        branch = "switch"
        stop = [{ load = 0.9 }]
        max_step = 0.05
    "#;
    line(COLUMN, 8, 3, &(changed(PINNED, planar) + path))
}

/// Complete elliptic integrals K and E, by the arithmetic-geometric mean (Abramowitz & Stegun 17.6).
fn elliptic(k: f64) -> [f64; 2] {
    let (mut a, mut b, mut c) = (1.0, (1.0 - k * k).sqrt(), k);
    let (mut sum, mut weight) = (0.5 * c * c, 0.5);
    for _ in 0..8 {
        (a, b, c) = (0.5 * (a + b), (a * b).sqrt(), 0.5 * (a - b));
        weight *= 2.0;
        sum += weight * c * c;
    }
    let K = FRAC_PI_2 / a;
    [K, K * (1.0 - sum)]
}

/// With EA = GA the column is Euler's elastica: P = 4 K²(k), with its end turned by 2 arcsin k and shortened by
/// 2 (1 − E/K) + P/EA: also where the first step passes several bifurcations, and the end of the path before all but one.
#[test]
fn a_column_follows_the_elastica() {
    for (steps, least) in [
        ("max_step = 0.05", 10),
        ("max_step = 0.05\nrecord = [\"turning_point\"]", 10),
        ("first_step = 5\nmax_step = 5", 1),
    ] {
        let text = column().replace("max_step = 0.05", steps);
        let text = text.replace("elements = 8", "elements = 10");
        let run = run_of("critical_elastica", &text);
        let (load, beyond) = branch(&run.rows);
        assert_close(20.0 * load / PI.powi(2), 1.0, 1e-6, steps);
        // The load of the elastica grows.
        assert!(beyond.iter().all(|row| row["event"] != "turning_point"));
        assert!(beyond.len() >= least, "{}", beyond.len());
        for row in beyond {
            let P = elastic_load(row);
            assert_close(20.0 * number(row, "t") / P, 1.0, 1e-5, P);
        }
        assert_eq!(run.result["warnings"], serde_json::json!([]), "{steps}");
    }
}

/// The load parameter of the first bifurcation of a path, and the rows beyond it.
#[track_caller]
fn branch(rows: &Rows) -> (f64, &[HashMap<String, String>]) {
    let mut events = rows.iter().map(|row| &row["event"]);
    let found = events.position(|event| event == "bifurcation").unwrap();
    (number(&rows[found], "t"), &rows[found + 1..])
}

/// The load of the elastica with the rotation of a row, whose shortening is that of the row.
#[track_caller]
fn elastic_load(row: &HashMap<String, String>) -> f64 {
    let angle = number(row, "largest_rotation");
    let [K, E] = elliptic((0.5 * angle).sin());
    let P = 4.0 * K * K;
    let shortening = 2.0 * (1.0 - E / K) + P / 1e4;
    assert_close(number(row, "end.x"), -shortening, 1e-5, angle);
    assert_eq!(row["unstable"], "0", "{angle}");
    P
}

/// An end that is moved: the first step along the branch is too long, and is halved.
#[test]
fn a_shortened_column_follows_the_elastica() {
    let load = "[[loads]]\nnode = \"B\"\nforce = [-20, 0, 0]";
    let moved = "prescribed = { x = { proportional = -7.6e-4 } }";
    let text = column()
        .replace(load, moved)
        .replace("load = 0.9", "load = 2.2")
        .replace("max_step = 0.05", "");
    let rows = run_of("critical_shortened", &text).rows;
    let (_, beyond) = branch(&rows);
    assert!(beyond.len() >= 10, "{}", beyond.len());
    for row in beyond {
        elastic_load(row);
    }
    assert!(number(&rows[rows.len() - 1], "largest_rotation") > 0.05);
}

/// Euler's loads, n² π², in one step.
#[test]
fn all_bifurcations_of_a_step_are_found() {
    let text = column()
        .replace("branch = \"switch\"", "record = [\"bifurcation\"]")
        .replace("{ load = 0.9 }", "{ load = 5 }")
        .replace("max_step = 0.05", "first_step = 5\nmax_step = 5");
    let rows = run_of("critical_all", &text).rows;
    let found = rows.iter().filter(|row| row["event"] == "bifurcation");
    let loads: Vec<f64> = found.map(|row| 20.0 * number(row, "t")).collect();
    assert_eq!(loads.len(), 3, "{loads:?}");
    for (load, n) in loads.iter().zip(1..) {
        let exact = (f64::from(n) * PI).powi(2);
        assert_close(*load / exact, 1.0, 1e-4, n);
    }
}

/// Both ends rotate by the same angle: the side does not depend on rounding errors.
#[test]
fn a_column_buckles_to_the_same_side_in_any_unit() {
    let middle = "load_scale = 0.5\n[[probes]]\nname = \"middle\"\nquantity = \"displacement\"\nnode = \"line/15\"";
    let [m, mm] = [1.0, 1e3].map(|length: f64| {
        let [GJ, soft, stiff] = [1e3, 1.0, 1e3].map(|k| k * length * length);
        let stiffness = format!("EA = 1e7, GA = [1e7, 1e7], GJ = {GJ}, EI = [{stiff}, {soft}]");
        let column = column()
            .replace(COLUMN, &stiffness)
            .replace("elements = 8", "elements = 10");
        let column = column.replace("B = [1,", &format!("B = [{length},"));
        let column = column.replace("[\"y\", \"z\", \"rx\", \"ry\"]", "[\"y\", \"z\"]");
        let rows = run_of("critical_units", &(column + middle)).rows;
        number(&rows[rows.len() - 1], "middle.y") / length
    });
    assert!(m.abs() > 0.3);
    assert_close(mm, m, 1e-9, "length");
}

/// Links of length 1 in line between a hinge at A = (0, y, 0) and a slider from B, with a spring of 1 at the knee: the angle a there
/// has the potential a²/2 + 2 P cos(a/2): P = a/sin(a/2), from 2 on. The slider has no stiffness.
fn links(of: &str, y: f64, closure: &str) -> String {
    let [first, middle, knee, end, slider] =
        ["first", "middle", "knee", "end", "slider"].map(|part| format!("{part}{of}"));
    let [left, right] = ["A", "B"].map(|node| format!("{node}{of}"));
    let close = format!("child = \"{end}\"\n{closure}");
    [
        fixed(&left) + &fixed(&right),
        hinge(&first, &left, "") + &arm(&middle, &first, [1.0, y, 0.0]),
        hinge(&knee, &middle, "spring = { k = 1 }") + &arm(&end, &knee, [2.0, y, 0.0]),
        joint(&slider, "prismatic", &right, "axis = [1, 0, 0]") + &body_of(&middle, 1.0, ""),
        format!("[[loads]]\nnode = \"{slider}\"\nforce = [-1, 0, 0]\n"),
        hinge(&format!("close{of}"), &slider, &close),
    ]
    .concat()
}

const LINKED: &str =
    "[analysis.arc_length]\nmax_step = 0.05\nload_scale = 1\nstop = [{ load = 2.2 }]\n";

#[test]
fn links_that_multipliers_close_follow_their_branch() {
    for closure in &CLOSURES[..2] {
        let nodes = "[nodes]\nA = [0, 0, 0]\nB = [2, 0, 0]\n".to_owned();
        let links = nodes + &links("", 0.0, closure) + &angle("knee");
        let rows = run_of(
            "critical_links",
            &(links + LINKED + "branch = \"switch\"\n"),
        )
        .rows;
        let (load, beyond) = branch(&rows);
        assert_close(load, 2.0, 1e-9, "load");
        assert!(beyond.len() >= 10, "{}", beyond.len());
        for row in beyond {
            let a = number(row, "knee");
            assert_close(number(row, "t"), a / (0.5 * a).sin(), 1e-6, a);
            assert_eq!(row["unstable"], "0", "{closure}: {a}");
        }
    }
}

/// The penalty makes the tangent singular to rounding near the load of both: the end of a part of the step that ends
/// there is all that is known.
#[test]
fn equal_links_that_stiff_penalties_close_buckle_at_once() {
    let stiff = "closure = \"penalty\"\npenalty = 1e9";
    let nodes =
        "[nodes]\nA1 = [0, 0, 0]\nB1 = [2, 0, 0]\nA2 = [0, 1, 0]\nB2 = [2, 1, 0]\n".to_owned();
    let links = nodes + &links("1", 0.0, stiff) + &links("2", 1.0, stiff);
    let (loads, told) = bifurcations(
        "critical_equal_links",
        &(links + LINKED + "record = [\"bifurcation\"]\n"),
    );
    assert_eq!(loads.len(), 1);
    assert!((2.0..2.02).contains(&loads[0]), "{}", loads[0]);
    assert_says(&told, &["unstable in 2 directions"]);
}

/// A hinged arch of radius 10 that spans twice the angle, with a force at its top, where a weld may join its halves.
fn arch(angle: f64, weld: &str, [GJ, EI]: [f64; 2], force: [f64; 3], path: &str) -> String {
    let (sin, cos) = angle.to_radians().sin_cos();
    let (x, z) = (10.0 * sin, 10.0 * cos);
    let half = |name: &str, ends: [&str; 2]| {
        beam_line(name, ends, 10, "s")
            + &format!(
                "second_axis = [0, 1, 0]\n\
                 arc = {{ center = [0, 0, 0], axis = [0, 1, 0], angle_deg = {angle:?} }}\n"
            )
    };
    let hinge = |node: &str| {
        format!("[[supports]]\nnode = \"{node}\"\nfix = [\"x\", \"y\", \"z\", \"rx\", \"rz\"]\n")
    };
    let (top, welded) = match weld {
        "" => ("m", String::new()),
        closure => {
            let weld = joint("weld", "weld", "m", &format!("child = \"top\"\n{closure}"));
            ("top", format!("top = [0, 0, 10]\n{weld}"))
        }
    };
    [
        &format!(
            "[sections.s]\nstiffness = {{ EA = 1e5, GA = [5e4, 5e4], GJ = {GJ:?}, EI = [1.0, {EI:?}] }}\n\
             [nodes]\na = [{:?}, 0, {z:?}]\nm = [0, 0, 10]\nb = [{x:?}, 0, {z:?}]\n{welded}",
            -x
        ),
        &half("first", ["a", "m"]),
        &half("second", [top, "b"]),
        &hinge("a"),
        &hinge("b"),
        &format!("[[loads]]\nnode = \"m\"\nforce = {force:?}\n"),
        &probe("top", "displacement", "m"),
        "[analysis.arc_length]\nmax_step = 0.05\nfirst_step = 0.02\n",
        path,
    ]
    .concat()
}

/// The steps that locate a bifurcation with multipliers are halved many times.
#[test]
fn a_branch_begins_with_a_first_step() {
    let path = "branch = \"switch\"\nstop = [{ load = 0.11 }]\n";
    let [whole, welded] = ["", CLOSURES[1]].map(|weld| {
        let text = arch(107.5, weld, [2.0, 0.5], [0.0, 0.0, -0.12], path);
        let rows = run_of("critical_weld", &text).rows;
        let last = &rows[rows.len() - 1];
        assert!(number(last, "largest_rotation") > 0.4);
        ["top.x", "top.y", "top.z"].map(|name| number(last, name))
    });
    for (welded, whole) in welded.iter().zip(whole) {
        assert_close(*welded, whole, 1e-9, whole);
    }
}

/// Newton's method for a critical point has not converged where its corrections grow.
#[test]
fn bifurcations_do_not_depend_on_the_steps_to_them() {
    let [fine, coarse] = ["max_step = 0.02", "max_step = 0.05"].map(|step| {
        let path = "record = [\"bifurcation\"]\nstop = [{ load = -0.3 }]\n";
        let text = arch(90.0, "", [0.2, 0.1], [2.4e-3, 0.0, -0.12], path);
        bifurcations("critical_steps", &text.replace("max_step = 0.05", step)).0
    });
    assert_eq!([fine.len(), coarse.len()], [11; 2]);
    for (fine, coarse) in fine.iter().zip(coarse) {
        assert_close(coarse, *fine, 1e-7, fine);
    }
}

/// A round cantilever buckles in all planes at Euler's load π²/4.
#[test]
fn a_round_column_has_no_single_branch() {
    let rest = "[[loads]]\nnode = \"B\"\nforce = [-5, 0, 0]\n[analysis.arc_length]\nbranch = \"switch\"\n\
                max_step = 0.05\nstop = [{ load = 1 }]\n";
    let stiffness = "EA = 1e4, GA = [1e4, 1e4], GJ = 1.0, EI = [1.0, 1.0]";
    let text = line(stiffness, 4, 2, &(fixed("A") + rest));
    let words = ["2 directions become unstable", "load parameter 0.493"];
    assert_says(&failed("critical_round", &text), &words);
}

#[test]
fn followers_have_no_count_of_unstable_directions() {
    let text = column().replace("[-20, 0, 0]", "[-20, 0, 0]\nfollower = true");
    let said = failed("critical_follower", &text);
    assert_says(&said, &["follower loads have no potential"]);
}

/// A cantilever that two forces bend, of which the second one has a function of the load parameter with kinks.
fn bent_twice(function: &str, analysis: &str) -> String {
    let force = |force: &str, time: &str| {
        format!("[[loads]]\nnode = \"B\"\nforce = {force}\ntime = {time}\n")
    };
    let rest = [
        &fixed("A"),
        &force("[0, 0.1, 0]", "{ ramp = { end = 0.5 } }"),
        &force("[0, 0, 0.05]", function),
        analysis,
        &probe("d", "displacement", "B"),
    ];
    let stiffness = "EA = 1e6, GA = [1e6, 1e6], GJ = 100, EI = [1, 10]";
    line(stiffness, 8, 2, &rest.concat())
}

/// Forces are applied in sequence, taken away again and turned round. The equilibria at the end of a path, and where it
/// is known those of a linear beam, are those of load steps.
#[test]
fn a_path_goes_through_the_kinks_of_its_loads() {
    let path = "[analysis.arc_length]\n";
    for (function, linear) in [
        ("{ ramp = { start = 0.5, end = 1 } }", 0.05 / 3.0),
        ("{ ramp = { start = 0.3, end = 0.6 } }", 0.05 / 3.0),
        ("{ triangle = { peak = 0.5, end = 0.8, value = -5 } }", 0.0),
        ("{ table = [[0, 0], [0.4, 1], [0.6, -1]] }", -0.05 / 3.0),
    ] {
        let [steps, path] = ["[analysis.static]\nsteps = 10\n", path].map(|analysis| {
            let rows = run_of("critical_kinks", &bent_twice(function, analysis)).rows;
            let last = rows.last().unwrap();
            assert_eq!(number(last, "t"), 1.0);
            ["d.x", "d.y", "d.z"].map(|column| number(last, column))
        });
        for (a, b) in steps.iter().zip(path) {
            assert_close(b, *a, 1e-9, function);
        }
        assert_close(path[2], linear, 1e-5, function);
    }
    // Backward from the end of a ramp, over the beginning of another one: the first force alone, by 0.4, bends B by
    // P/3EI.
    let back =
        "[analysis.arc_length]\nfrom = 1\ndirection = \"backward\"\nstop = [{ load = 0.2 }]\n";
    let text = bent_twice("{ ramp = { start = 0.5, end = 1 } }", back);
    let rows = run_of("critical_kinks", &text).rows;
    let last = rows.last().unwrap();
    for (column, linear) in [("d.y", 0.04 / 30.0), ("d.z", 0.0)] {
        assert_close(number(last, column), linear, 1e-7, column);
    }
    // The structure jumps with a load, and no path leads there.
    let pulse = "{ pulse = { start = 0.5, end = 2 } }";
    for path in [path, back] {
        let told = failed("critical_jump", &bent_twice(pulse, path));
        assert_says(&told, &["a jump or kink at 0.5, within this step"]);
    }
}

/// A rigid bar of length 1 upright on a hinge with springs of 10 and `second`, and a force of t: critical loads are the
/// stiffnesses.
fn upright(second: f64, analysis: &str) -> String {
    let springs = format!(
        "axis = [0, 1, 0]\nsecond_axis = [1, 0, 0]\n\
         coordinates = {{ \"angle 1\" = {{ spring = {{ k = 10 }} }}, \"angle 2\" = {{ spring = {{ k = {second} }} }} }}"
    );
    [
        "[nodes]\nground = [0, 0, 0]\n",
        &fixed("ground"),
        &joint("foot", "universal", "ground", &springs),
        &joint("tip", "offset", "foot", "position = [0, 0, 1]"),
        "[[loads]]\nnode = \"tip\"\nforce = [0, 0, -1]\n",
        "[analysis.arc_length]\nload_scale = 10\nrecord = [\"bifurcation\"]\n",
        analysis,
    ]
    .concat()
}

/// The load parameters of the bifurcations found, and the first warning.
fn bifurcations(name: &str, text: &str) -> (Vec<f64>, String) {
    let run = run_of(name, text);
    let events = run.rows.iter().filter(|row| row["event"] == "bifurcation");
    let loads = events.map(|row| number(row, "t")).collect();
    let warning = run.result["warnings"][0].as_str().unwrap();
    (loads, warning.to_owned())
}

#[test]
fn bifurcations_of_one_load_and_of_one_step_are_located() {
    let (loads, told) = bifurcations(
        "critical_upright",
        &upright(10.0, "first_step = 3\nstop = [{ load = 14 }]\n"),
    );
    assert_eq!(loads.len(), 1);
    assert_close(loads[0], 10.0, 1e-9, "two directions at once");
    assert_says(&told, &["unstable in 2 directions"]);
    let switched = upright(10.0, "branch = \"switch\"\nstop = [{ load = 14 }]\n");
    let words = ["2 directions become unstable", "load parameter 10"];
    assert_says(&failed("critical_upright_switch", &switched), &words);
    let steps = "first_step = 5\nmax_step = 5\nstop = [{ load = 30 }]\n";
    let (loads, told) = bifurcations("critical_upright", &upright(12.0, steps));
    assert_eq!(loads.len(), 2);
    assert_close(loads[0], 10.0, 1e-9, "the first one");
    assert_close(loads[1], 12.0, 1e-9, "the second one");
    assert_says(&told, &["bifurcation between load parameter 10 and 30"]);
}

/// Back from a load beyond the first bifurcation, the bar is unstable from the start.
#[test]
fn a_start_without_stability_is_told_of() {
    let back = "from = 12\ndirection = \"backward\"\nstop = [{ load = 3 }]\n";
    let run = run_of("critical_unstable", &upright(20.0, back));
    assert_eq!(run.rows[0]["unstable"], "1");
    let told = run.result["warnings"][0].as_str().unwrap();
    let between = "between load parameter 10 and";
    let words = ["at or before load parameter 12", between, "stable again"];
    assert_says(told, &words);
}

/// Corrections after a change of charts are as free as the first ones of a step: damped, they fail, and steps are halved.
#[test]
fn elements_that_change_their_charts_halve_hardly_any_steps() {
    let rows = run_of("critical_charts", &example("bending_torsion.toml")).rows;
    assert_eq!(number(rows.last().unwrap(), "t"), 1.0);
    assert!(rows.len() <= 30, "{} rows", rows.len());
}
