//! Critical loads by linear extrapolation against exact solutions.

use super::assert_near;
use crate::support::beams::{COLUMN, PINNED, line};
use crate::support::closures::fixed;
use crate::support::*;
use pullback::input::{Plan, assemble_text};
use pullback::integrators::linearization::{
    BucklingError, BucklingMode, ModesError, buckling, buckling_while,
};
use pullback::integrators::statics::{
    CriticalKind, StaticNewtonOptions, critical_point, equilibrium,
};
use pullback::manifold::system::Point;
use std::f64::consts::PI;
use std::ops::ControlFlow;

/// Critical loads of a model file from its state at load parameter `from`.
fn critical(text: &str, from: f64, count: usize) -> Result<Vec<BucklingMode>, BucklingError> {
    let mut job = assemble_text("model.toml", text).unwrap();
    let mut q = vec![0.0; job.context.initial().len()];
    if let (Plan::Static(options), true) = (&mut job.plan, from > 0.0) {
        options.to = from;
        q = equilibrium(&mut job.context, options).unwrap();
    }
    buckling(&mut job.context, Point::statics(from, &q), count)
}

/// Finds the critical point of a mode directly, from nine tenths of its load: the same where the path is straight.
fn assert_direct(text: &str, mode: &BucklingMode, tolerance: f64) {
    let mut job = assemble_text("model.toml", text).unwrap();
    let Plan::Static(options) = &mut job.plan else {
        unreachable!()
    };
    options.to = 0.9 * mode.load;
    let q = equilibrium(&mut job.context, options).unwrap();
    let at = Point::statics(options.to, &q);
    let newton = StaticNewtonOptions::default();
    let point = critical_point(&mut job.context, at, Some(&mode.shape), &newton).unwrap();
    assert_eq!(point.kind, CriticalKind::Bifurcation);
    assert_near(point.t, mode.load, tolerance);
    let corrections = &point.corrections;
    // Below, rounding errors of stiffnesses that differ by eight powers of ten.
    let large = corrections.iter().take_while(|c| **c > 1e-6).count();
    assert!(large <= 4, "{corrections:?}");
    assert!(corrections[2] < corrections[1].powf(1.5), "{corrections:?}");
}

/// Two bars of 0.05 with a lateral spring between them, P = k l/2, on the scale of a mast that is longer by three orders.
#[test]
fn a_small_part_of_a_large_model_buckles() {
    let text = r#"
[sections.mast]
stiffness = { EA = 1e9, GA = [1e9, 1e9], GJ = 1e9, EI = [1e9, 1e9] }
[nodes]
foot = [0, 0, 0]
head = [0, 0, 60]
a = [1, 0, 0]
m = [1.05, 0, 0]
e = [1.1, 0, 0]
w = [1.05, 0.1, 0]
[[lines]]
name = "mast"
from = "foot"
to = "head"
elements = 2
section = "mast"
[[supports]]
node = "m"
fix = ["z", "rx", "ry", "rz"]
[[supports]]
node = "e"
fix = ["y", "z", "rx", "ry", "rz"]
[[springs]]
name = "b1"
nodes = ["a", "m"]
stiffness = 1e6
[[springs]]
name = "b2"
nodes = ["m", "e"]
stiffness = 1e6
[[springs]]
name = "lateral"
nodes = ["m", "w"]
stiffness = 10
[[loads]]
node = "e"
force = [-1, 0, 0]
[analysis.buckling]
count = 1
"#;
    let text = fixed("foot") + &fixed("a") + &fixed("w") + text;
    let modes = critical(&text, 0.0, 1).unwrap();
    assert_near(modes[0].load, 0.25, 1e-8);
}

/// A load that grows at its first rate where it is critical by that rate, but is another one then: 1 at t = 1, −5 at t = 2.
#[test]
fn a_load_that_has_not_grown_steadily_has_an_error() {
    let loaded = "[[loads]]\nnode = \"B\"\nforce = [-1, 0, 0]\ntime = { table = [[0, 0], [1, 1], [2, -5], [20, 13]] }\n";
    let text = line(
        COLUMN,
        8,
        3,
        &(fixed("A") + loaded + "[analysis.buckling]\n"),
    );
    let modes = critical(&text, 0.0, 1).unwrap();
    assert!(modes[0].error > 0.5, "{:?}", modes[0].error);
}

#[test]
fn an_observer_ends_the_search() {
    let mut job = assemble_text("model.toml", &line(COLUMN, 16, 1, PINNED)).unwrap();
    let q = vec![0.0; job.context.initial().len()];
    let mut stop = |_| ControlFlow::Break(());
    let ended = buckling_while(&mut job.context, Point::statics(0.0, &q), 1, &mut stop);
    let interrupted = matches!(ended, Err(BucklingError::Search(ModesError::Interrupted)));
    assert!(interrupted, "{ended:?}");
}

/// With EA = GA the equation of a pinned column is EI φ″ + P φ = 0; elements of order one make its critical loads
/// 4 EI/h² tan²(kπh/2L).
#[test]
fn a_pinned_column_in_both_planes() {
    let n = 16.0;
    let load = |EI: f64, k: f64| 4.0 * EI * n * n * (k * PI / (2.0 * n)).tan().powi(2);
    let exact = [load(1.0, 1.0), load(3.0, 1.0), load(1.0, 2.0)];
    let text = line(COLUMN, 16, 1, PINNED);
    for from in [0.0, 5.0] {
        for (mode, exact) in critical(&text, from, 3).unwrap().iter().zip(exact) {
            assert_near(mode.load, exact, 1e-6);
            if from == 0.0 {
                assert_direct(&text, mode, 1e-9);
            }
        }
    }
    let beyond = critical(&text, 12.0, 1);
    assert_eq!(beyond, Err(BucklingError::Unstable));
}

/// A line of elements of an order that is clamped at A, with a load.
fn clamped(stiffness: &str, (elements, order): (usize, usize), load: &str) -> String {
    let rest = format!("{}[[loads]]\n{load}\n", fixed("A"));
    line(stiffness, elements, order, &rest)
}

/// P L²/√(EI GJ) of a narrow cantilever with a force at its tip, across the plane of its large stiffness.
#[test]
fn lateral_buckling_of_a_cantilever() {
    let stiffness = "EA = 1e8, GA = [1e8, 1e8], GJ = 0.25, EI = [1e7, 1.0]";
    let text = clamped(stiffness, (12, 3), "node = \"B\"\nforce = [0, 0, -1]");
    for mode in critical(&text, 0.0, 2).unwrap() {
        assert_near(mode.load.abs(), 4.012599343578901 * 0.5, 1e-5);
        assert_direct(&text, &mode, 1e-6);
    }
}

/// q L³/EI of a column under its own weight.
#[test]
fn a_column_under_its_own_weight() {
    let stiffness = "EA = 1e7, GA = [1e7, 1e7], GJ = 1.0, EI = [1.0, 2.0]";
    let weight = "line = \"line\"\nforce_per_length = [-1, 0, 0]";
    let text = clamped(stiffness, (12, 3), weight);
    for (mode, EI) in critical(&text, 0.0, 2).unwrap().iter().zip([1.0, 2.0]) {
        assert_near(mode.load, EI * 7.837347438943484, 1e-5);
        assert_direct(&text, mode, 1e-6);
    }
}

#[test]
fn follower_loads_are_refused() {
    let follower = "node = \"B\"\nforce = [0, 0, -1]\nfollower = true";
    // Without a load as well, where the tangent is still symmetric.
    for from in [0.0, 0.5] {
        let refused = critical(&clamped(COLUMN, (4, 1), follower), from, 1);
        assert_eq!(refused, Err(BucklingError::Asymmetric));
    }
}

#[test]
fn loads_that_do_not_grow_are_refused() {
    let constant = "node = \"B\"\nforce = [0, 0, -1]\ntime = { constant = 1 }";
    let none = line(COLUMN, 4, 1, &fixed("A"));
    for (text, from) in [(none, 0.0), (clamped(COLUMN, (4, 1), constant), 0.5)] {
        assert_eq!(critical(&text, from, 1), Err(BucklingError::NoLoad));
    }
}

/// A straight column keeps its shape until it buckles; Lee's frame bends from the start, and snaps at 18546.558 of 20000
/// (independent shooting).
#[test]
fn the_error_tells_a_poor_estimate() {
    let stiffness = "EA = 1e5, GA = [1e5, 1e5], GJ = 1.0, EI = [1.0, 2.0]";
    let column = clamped(stiffness, (8, 1), "node = \"B\"\nforce = [-1, 0, 0]");
    let column = critical(&column, 0.0, 1).unwrap();
    assert!(column[0].error < 1e-3, "{column:?}");
    let frame = critical(&example("lee_frame"), 0.0, 1).unwrap();
    let off = (frame[0].load / (18546.558 / 20000.0) - 1.0).abs();
    assert!(off > 0.1 && frame[0].error > 0.1, "{frame:?}");
}

/// Three rigid links of length 1 with springs of 1 between them, between a pin and a slide: critical loads 1 and 3 (joints
/// displaced by equal or opposite amounts), also where multipliers close the loop.
#[test]
fn links_between_a_pin_and_a_slide() {
    for closure in ["map", "multipliers"] {
        let mut text = GROUND.to_owned()
            + &joint("top", "offset", "ground", "position = [0, 0, 3]")
            + &joint("slide", "prismatic", "top", "axis = [0, 0, 1]");
        let (mut end, axis) = ("ground".to_owned(), "axis = [0, 1, 0]\n");
        for k in 1..=3 {
            let (hinged, next) = (format!("h{k}"), format!("p{k}"));
            let spring = if k > 1 { "spring = { k = 1 }" } else { "" };
            text += &joint(&hinged, "revolute", &end, &(axis.to_owned() + spring));
            text += &arm(&next, &hinged, [0.0, 0.0, f64::from(k)]);
            text += &body_of(&next, 1.0, "");
            end = next;
        }
        let closing = format!("{axis}child = \"slide\"\nclosure = \"{closure}\"");
        text += &joint("C", "revolute", &end, &closing);
        text += "[[loads]]\nnode = \"slide\"\nforce = [0, 0, -1]\n[analysis.static]\n";
        let found = critical(&text, 0.01, 2).unwrap();
        for (mode, exact) in found.iter().zip([1.0, 3.0]) {
            assert_near(mode.load, exact, 1e-10);
        }
    }
}

/// A load that does not grow beyond t = 1 does not reach a critical load beyond it.
#[test]
fn the_error_sees_loads_that_stop_growing() {
    let load = "node = \"B\"\nforce = [-1, 0, 0]\ntime = { ramp = { end = 1 } }";
    let stiffness = "EA = 1e4, GA = [4e3, 4e3], GJ = 1.5, EI = [1.0, 2.0]";
    let found = critical(&clamped(stiffness, (4, 2), load), 0.0, 1).unwrap();
    assert!(found[0].load > 1.0 && found[0].error >= 1.0, "{found:?}");
}

/// Two rods of one on hinges with springs of one, under a force P at the end of the second, and its function of the load parameter:
/// 1 − 3P + P² = 0.
fn two_rods(time: &str) -> String {
    let rod = |name: &str, parent: &str| hinge(name, parent, "spring = { k = 1 }");
    [
        GROUND,
        &rod("a", "ground"),
        &joint("middle", "offset", "a", "position = [1, 0, 0]"),
        &rod("b", "middle"),
        &joint("end", "offset", "b", "position = [2, 0, 0]"),
        &body_of("end", 1.0, ""),
        &format!("[[loads]]\nnode = \"end\"\nforce = [-1, 0, 0]\ntime = {{ {time} }}\n"),
    ]
    .concat()
}

#[test]
fn loads_with_kinks_are_extrapolated_as_they_grow() {
    let root = f64::sqrt(5.0);
    let exact = [3.0 - root, 3.0 + root].map(|x| x / 8.0);
    for time in [
        "proportional = 4",
        "ramp = { end = 0.5, value = 2 }",
        "triangle = { peak = 0.5, end = 1, value = 2 }",
        "table = [[0, 0], [0.05, 0.2], [0.5, 2]]",
    ] {
        // At a kink, between two, and just behind one.
        for from in [0.0, 0.02, 0.05, 0.050001] {
            let modes = critical(&two_rods(time), from, 2).unwrap();
            for (mode, exact) in modes.iter().zip(exact) {
                assert_near(mode.load, exact, 1e-9);
            }
        }
    }
    let later = two_rods("ramp = { start = 0.5, end = 1, value = 2 }");
    assert_eq!(critical(&later, 0.02, 2), Err(BucklingError::NoLoad));
}

/// A pinned column that is shortened by u: π² EI/(EA L) = u/L.
#[test]
fn a_prescribed_shortening_with_kinks() {
    let column = |time: &str| {
        let stiffness = "EA = 1e4, GA = [1e4, 1e4], GJ = 10, EI = [1, 50]";
        let pinned = "[[supports]]\nnode = \"A\"\nfix = [\"x\", \"y\", \"z\", \"rx\", \"rz\"]\n\
                      [[supports]]\nnode = \"B\"\nfix = [\"y\", \"z\", \"rx\", \"rz\"]\n";
        let shortened = format!("{pinned}prescribed = {{ x = {{ {time} }} }}\n");
        line(stiffness, 6, 3, &shortened)
    };
    for (time, from) in [
        ("proportional = -1e-3", 0.0),
        ("ramp = { end = 1, value = -1e-3 }", 0.0),
        ("ramp = { end = 1, value = -1e-3 }", 0.4),
        ("ramp = { end = 1, value = -1e-3 }", 0.9),
    ] {
        let modes = critical(&column(time), from, 1).unwrap();
        assert_near(modes[0].load, 0.1 * PI * PI, 1e-6);
    }
}
