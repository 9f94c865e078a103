//! Modes of small systems, held to their polynomials.

use super::{X, Y, assert_near, slider};
use crate::support::*;
use nalgebra::SVector;
use num_complex::Complex64;
use pullback::check;
use pullback::elements::energy::EnergyElement;
use pullback::elements::joint::Prismatic;
use pullback::integrators::linearization::{ModeOptions, linearize, modes};
use pullback::manifold::scalar::Scalar;
use pullback::manifold::system::Point;
use pullback::prelude::*;
use std::f64::consts::TAU;

/// Eigenvalues λ of a model on the ground, about its state as drawn.
fn eigenvalues(name: &str, parts: &[String], count: usize) -> Vec<Complex64> {
    let analysis = format!("[analysis.modes]\ncount = {count}\n");
    let text = [GROUND, &parts.concat(), &analysis].concat();
    let rows = csv(ran(&directory(name), &text).join("modes.csv"));
    let value = |row: &Vec<f64>| Complex64::new(row[3], row[4]);
    rows.iter().map(value).collect()
}

/// Two bars of inertia 0.3 and 0.7 on springs, welded by multipliers: λ² + λ + 150 = 0, and nothing else.
#[test]
fn bars_welded_by_multipliers() {
    let on = |name: &str, spring: &str| hinge(name, "ground", &format!("spring = {spring}"));
    let parts = [
        on("A", "{ k = 100, c = 1 }"),
        on("B", "{ k = 50 }"),
        joint("C", "weld", "A", "child = \"B\"\nclosure = \"multipliers\""),
        body_of("A", 3.0, "inertia = [0.2, 0.2, 0.3]"),
        body_of("B", 3.0, "inertia = [0.6, 0.2, 0.7]"),
    ];
    let found = eigenvalues("welded bars", &parts, 4);
    assert_eq!(found.len(), 1, "{found:?}");
    let exact = Complex64::new(-0.5, 149.75_f64.sqrt());
    assert!((found[0] - exact).norm() < 1e-11, "{found:?}");
}

/// Two free bodies, one in coordinates relative to the other, on an isotropic spring half way between them, at the distance h of both
/// centres: shear turns the bodies against it. The rows of K of the first body are sums without a rest.
#[test]
fn modes_of_two_bodies_that_fly_freely() {
    let ([m, J, h], [k, kr]) = ([2.0, 0.3, 1.5], [1e5, 1e4]);
    let axis = [2.0, -6.0, 9.0].map(|x| x / 11.0);
    let at = |s: f64| {
        let [x, y, z] = [0, 1, 2].map(|i| [1.0, 2.0, 3.0][i] + s * axis[i]);
        format!("position = [{x}, {y}, {z}]")
    };
    let inertia = format!("inertia = [{J}, {J}, {J}]");
    let parts = [
        joint("A", "free", "ground", &at(-h)),
        joint("from", "offset", "A", &at(0.0)),
        joint("B", "free", "A", &at(h)),
        joint("to", "offset", "B", &at(0.0)),
        body_of("A", m, &inertia),
        body_of("B", m, &inertia),
        format!(
            "[[springs]]\nname = \"spring\"\nnodes = [\"from\", \"to\"]\n\
             bushing = {{ stiffness = [{k}, {k}, {k}, {kr}, {kr}, {kr}], damping = [0, 0, 0, 0, 0, 0] }}\n"
        ),
    ];
    let found = eigenvalues("two free bodies", &parts, 12);
    assert_eq!(found.len(), 12, "{found:?}");
    assert_eq!(found[..6], [Complex64::ZERO; 6]);
    let [bend, stretch, shear] = [kr / J, k / m, k / m + k * h * h / J];
    let exact = [bend, bend, bend, stretch, shear, shear].map(|x| (2.0 * x).sqrt());
    for (found, exact) in found[6..].iter().zip(exact) {
        assert!(
            (found.im - exact).abs() < 1e-7 * exact && found.re == 0.0,
            "{found} {exact}"
        );
    }
}

/// A chain of masses and springs, by extensions, whose frequencies reach over seven decades: the sum of ω² is the trace of M⁻¹ K,
/// of mass by mass the stiffness on both sides.
#[test]
fn highest_modes_of_a_chain_have_no_part_in_lower_ones() {
    let masses = [1.15e-4, 5.5e-4, 8.7e-4, 1.5e-2, 4.1];
    let springs = [1.2e7, 7.1e8, 0.12, 0.29, 0.038];
    let mut parts = Vec::new();
    let (mut before, mut sum) = ("ground".to_owned(), 0.0);
    for (i, (m, k)) in masses.into_iter().zip(springs).enumerate() {
        let name = format!("slider {i}");
        parts.push(slider(&name, &before, [1, 0, 0], k, 0.0));
        parts.push(body_of(&name, m, "inertia = [1, 1, 1]"));
        sum += (k + springs.get(i + 1).unwrap_or(&0.0)) / m;
        before = name;
    }
    let found = eigenvalues("masses on springs", &parts, 5);
    assert_eq!(found.len(), 5, "{found:?}");
    let trace: f64 = found.iter().map(Complex64::norm_sqr).sum();
    assert!((trace - sum).abs() < 1e-12 * sum, "{trace} {sum}");
}

/// A four-bar linkage without loads: nothing but rounding errors of its gap is out of balance.
#[test]
fn an_unloaded_linkage_closed_by_multipliers_is_at_rest() {
    let (crank, tip) = ([0.3, 0.4, 0.0], [0.9, 0.8, 0.0]);
    let parts = [
        hinge("A", "ground", ""),
        arm("tip of A", "A", crank),
        hinge("B", "tip of A", ""),
        arm("tip of B", "B", tip),
        arm("right", "ground", [0.9, 0.0, 0.0]),
        hinge("C", "right", ""),
        arm("tip of C", "C", tip),
        hinge(
            "D",
            "tip of B",
            "child = \"tip of C\"\nclosure = \"multipliers\"",
        ),
    ];
    let parts = [parts.concat(), ["A", "B", "C"].map(body).concat()];
    let found = eigenvalues("unloaded linkage", &parts, 1);
    assert_eq!(found, [Complex64::ZERO]);
}

/// A five-bar linkage whose loop leaves two bars on springs free: det(k − ω² M) = 0. Rounding errors of its gap make the only forces.
#[test]
fn an_unloaded_linkage_on_springs_has_the_modes_of_its_bars() {
    let (feet, l) = ([[0.7, 1.6, 0.0], [0.1, 0.7, 0.0]], 1.3_f64);
    let [a, b, c] = [[-0.5, 1.1, 0.0], [0.2, 0.8, 0.0], [-1.7, -0.9, 0.0]];
    let parts = [
        arm("left", "ground", feet[0]),
        arm("right", "ground", feet[1]),
        hinge("A", "left", "spring = { k = 1.0 }"),
        arm("tip of A", "A", a),
        hinge("B", "tip of A", "spring = { k = 1.0 }"),
        arm("tip of B", "B", b),
        hinge("C", "tip of B", ""),
        arm("tip of C", "C", c),
        hinge("D", "tip of C", ""),
        arm("tip of D", "D", feet[1]),
        hinge(
            "E",
            "right",
            "child = \"tip of D\"\nclosure = \"multipliers\"",
        ),
    ];
    let parts = [parts.concat(), ["A", "B"].map(body).concat()];
    let found = eigenvalues("unloaded linkage on springs", &parts, 2);
    let J = 0.1;
    let (sum, det) = (l * l + 3.0 * J, J * (l * l + J));
    let squares =
        [-1.0, 1.0].map(|sign| (sum + sign * (sum * sum - 4.0 * det).sqrt()) / (2.0 * det));
    assert_eq!(found.len(), 2, "{found:?}");
    for (found, square) in found.iter().zip(squares) {
        assert!(
            (found.im - square.sqrt()).abs() < 1e-9 && found.re == 0.0,
            "{found} {square}"
        );
    }
}

/// Translations of a free beam are combinations of its six modes at rest: their effective masses sum to its mass, with damping
/// as without.
#[test]
fn effective_masses_of_a_damped_free_beam() {
    let text = [
        "[sections.s]\nstiffness = { EA = 1e5, GA = [4e4, 4e4], GJ = 8, EI = [10, 14] }\n\
         mass = { A_rho = 0.5, J = [2e-4, 1e-4, 1e-4], center = [0.01, 0.02] }\n\
         damping = { stiffness = 1e-4 }\n[nodes]\na = [0, 0, 0]\nb = [1.0, 0.4, 0.2]\n",
        &beam_line("beam", ["a", "b"], 6, "s"),
        "order = 2\n[analysis.modes]\ncount = 8\n",
    ];
    let rows = csv(ran(&directory("free damped"), &text.concat()).join("modes.csv"));
    for axis in 9..12 {
        let sum: f64 = rows[..6].iter().map(|row| row[axis]).sum();
        assert_near(sum, 0.5 * 1.2_f64.sqrt(), 1e-9);
    }
}

/// A loop of two arms in space, loaded by gravity: its tangent is not symmetric, and it has one degree of freedom.
#[test]
fn a_loop_has_as_many_modes_as_degrees_of_freedom() {
    let sprung = |names: [&str; 2]| {
        let [a, b] = names.map(|name| format!("{name:?} = {{ spring = {{ k = 20 }} }}"));
        format!("coordinates = {{ {a}, {b} }}")
    };
    let universal = "axis = [-0.4, -0.7, -0.6]\nsecond_axis = [0.9, -0.4, -0.1]\n".to_owned()
        + &sprung(["angle 1", "angle 2"]);
    let cylindrical = "axis = [-0.8, -0.2, 0.6]\n".to_owned() + &sprung(["displacement", "angle"]);
    let [first, second] = [
        "axis = [-0.2, -0.4, 0.9]\nspring = { k = 25 }",
        "axis = [-0.9, 0.4, -0.1]\nspring = { k = 26 }",
    ];
    let body = |node: &str, mass: f64, center: [f64; 3]| {
        let more = format!("inertia = [1, 1, 1]\ncenter = {center:?}");
        body_of(node, mass, &more)
    };
    let loaded = |closure: &str| {
        let close = format!("child = \"D end\"\naxis = [-0.6, 0.6, 0.6]\nclosure = {closure:?}");
        let parts = [
            arm("left", "ground", [-0.1, 0.6, -0.1]),
            joint("A", "universal", "left", &universal),
            arm("A end", "A", [0.5, -0.9, 0.5]),
            joint("B", "prismatic", "A end", first),
            arm("B end", "B", [1.1, 0.5, 0.5]),
            arm("right", "ground", [0.0, 0.0, -0.4]),
            joint("C", "cylindrical", "right", &cylindrical),
            arm("C end", "C", [0.3, 0.8, -0.6]),
            joint("D", "prismatic", "C end", second),
            arm("D end", "D", [1.1, 0.5, 0.5]),
            joint("E", "revolute", "B end", &close),
            body("A", 0.9, [0.3, -0.1, 0.4]),
            body("B", 1.5, [-0.4, -0.5, 0.1]),
            body("C", 0.5, [-0.2, 0.3, 0.0]),
            body("D", 1.8, [0.1, 0.0, -0.5]),
            "[[loads]]\ngravity = [0.3, 0.1, 0.6]\n".to_owned(),
        ];
        eigenvalues("loaded loop", &parts, 10)
    };
    let [by_map, by_multipliers] = ["map", "multipliers"].map(loaded);
    let counts = [by_map.len(), by_multipliers.len()];
    assert_eq!(counts, [1, 1], "{by_multipliers:?}");
    let gap = (by_map[0] - by_multipliers[0]).norm();
    assert!(gap < 1e-8, "{by_map:?} {by_multipliers:?}");
}

/// Two modes at rest, of masses 2000 and 0.1, and three others.
#[test]
fn modes_at_rest_with_dampers() {
    let parts = [
        slider("A", "ground", X, 0.0, 1.0),
        body_of("A", 1000.0, ""),
        slider("B", "A", X, 1.0, 0.0),
        body_of("B", 1000.0, ""),
        slider("C", "A", Y, 0.0, 0.1),
        body_of("C", 0.1, ""),
    ];
    let found = eigenvalues("modes at rest", &parts, 10);
    let at_rest = found.iter().filter(|lambda| lambda.norm() == 0.0);
    assert_eq!([at_rest.count(), found.len()], [2, 5], "{found:?}");
    // Without mass, too: λ · 2λ · 3λ (λ² + 1) = 0.
    let massless = [
        slider("A", "ground", X, 1.0, 0.0),
        body_of("A", 1.0, ""),
        slider("B", "ground", Y, 0.0, 1.0),
        slider("C", "ground", X, 0.0, 2.0),
        slider("D", "C", Y, 0.0, 3.0),
    ];
    let found = eigenvalues("massless at rest", &massless, 10);
    let at_rest = found.iter().filter(|lambda| lambda.norm() == 0.0);
    assert_eq!([at_rest.count(), found.len()], [3, 4], "{found:?}");
}

/// Three equal cantilevers that are almost round: three copies of each of two near frequencies. With damping by stiffness
/// |λ| is that without, where modes are counted.
#[test]
fn copies_of_modes_with_others_near() {
    let line = |k: u32| {
        let [from, to] = ["a", "b"].map(|end| format!("{end}{k}"));
        beam_line(&format!("l{k}"), [&from, &to], 8, "s") + "order = 2\n" + &fixed(&from)
    };
    let lines: String = (0..3).map(line).collect();
    let nodes: String = (0..3)
        .map(|k| format!("a{k} = [0, {k}, 0]\nb{k} = [1, {k}, 0]\n"))
        .collect();
    let text = |damping: &str, count: usize| {
        format!(
            "[nodes]\n{nodes}[sections.s]\nmass = {{ A_rho = 1, J = [2e-3, 1e-3, 1e-3] }}\n{damping}\
             stiffness = {{ EA = 1e4, GA = [1e4, 1e4], GJ = 1, EI = [1, 1.0002] }}\n{lines}\
             [analysis.modes]\ncount = {count}\n"
        )
    };
    for count in [2, 9, 10, 19] {
        let [damped, exact] = ["damping = { stiffness = 1e-5 }\n", ""].map(|damping| {
            let rows = csv(ran(&directory("near copies"), &text(damping, count)).join("modes.csv"));
            let size = |row: &Vec<f64>| row[3].hypot(row[4]);
            rows.iter().map(size).collect::<Vec<_>>()
        });
        assert_eq!([damped.len(), exact.len()], [count; 2]);
        for (damped, exact) in damped.iter().zip(exact) {
            assert!(
                (damped / exact - 1.0).abs() < 1e-7,
                "{count}: {damped} {exact}"
            );
        }
    }
}

/// More copies of a frequency than modes are requested, with and without damping: λ² + c λ + 5 = 0.
#[test]
fn many_copies_of_a_mode() {
    for (copies, c) in [(61, 0.1), (130, 0.0)] {
        let pendulums: Vec<String> = (0..copies)
            .flat_map(|k| {
                let (joint, spring) = (format!("j{k}"), format!("spring = {{ k = 5, c = {c:?} }}"));
                let bar = body_of(&joint, 1.0, "inertia = [1, 1, 1]");
                [hinge(&joint, "ground", &spring), bar]
            })
            .collect();
        let found = eigenvalues("many copies", &pendulums, 10);
        assert_eq!(found.len(), 10, "{copies} copies");
        let exact = Complex64::new(-0.5 * c, (5.0 - 0.25 * c * c).sqrt());
        for lambda in found {
            assert!((lambda - exact).norm() < 1e-12, "{copies} copies: {lambda}");
        }
    }
}

/// A pendulum on a ball joint hangs along skew gravity, in balance but for rounding errors. It may spin.
#[test]
fn a_pendulum_in_skew_gravity() {
    let parts = [
        joint("ball", "spherical", "ground", ""),
        arm("bob", "ball", [0.3, -0.5, -0.8]),
        body_of("bob", 1.0, "inertia = [0.1, 0.1, 0.1]"),
        "[[loads]]\ngravity = [3, -5, -8]\n".to_owned(),
    ];
    let found = eigenvalues("skew pendulum", &parts, 3);
    let (square, gravity) = (0.98_f64, 98.0_f64.sqrt());
    let exact = (gravity * square.sqrt() / (0.1 + square)).sqrt();
    assert_eq!(found[0], Complex64::ZERO);
    for lambda in &found[1..] {
        assert_near(lambda.im, exact, 1e-12);
    }
}

/// An upright top on a universal joint that spins fast enough to be stable: I λ² − i J Ω λ − m g l = 0. Its forces of inertia
/// cancel but for rounding errors. Over the speed, two real eigenvalues at rest become one pair, and others begin a line.
#[test]
fn a_sleeping_top() {
    let (I, J, weight, spin) = (0.34, 0.03, 2.0 * 9.81 * 0.4, 130.0);
    let top = |rate: &str| {
        let cross = "axis = [1, 0, 0]\nsecond_axis = [0, 1, 0]";
        let body = "center = [0, 0, 0.4]\ninertia = [0.02, 0.02, 0.03]";
        let spin = format!("axis = [0, 0, 1]\n{rate}");
        [
            joint("tilt", "universal", "ground", cross),
            joint("spin", "revolute", "tilt", &spin),
            body_of("spin", 2.0, body),
            GRAVITY.to_owned(),
        ]
        .concat()
    };
    let root = f64::sqrt(J * spin * J * spin - 4.0 * I * weight);
    let exact = [J * spin - root, J * spin + root].map(|x| x / (2.0 * I));
    let after = "[analysis.modes.after.dynamic]\nto = 0.01\nstep = 0.001\n";
    let found = eigenvalues("top", &[top("rate = 130"), after.to_owned()], 3);
    assert_eq!(found[0], Complex64::ZERO);
    assert_near(found[1].im, exact[0], 1e-9);
    assert_near(found[2].im, exact[1], 1e-9);

    let analysis = "[analysis.campbell]\njoint = \"spin\"\nto = 130\nsteps = 10\ncount = 2\n";
    let text = [GROUND, &top(""), analysis].concat();
    let csv = ran(&directory("campbell_top"), &text).join("campbell.csv");
    let csv = std::fs::read_to_string(csv).unwrap();
    let last = csv.lines().next_back().unwrap().split(',');
    let cells = last.skip(1).step_by(2).filter_map(|cell| cell.parse().ok());
    let mut found: Vec<f64> = cells.map(|x: f64| TAU * x).collect();
    found.sort_by(f64::total_cmp);
    assert_eq!(found.len(), 2);
    assert_near(found[0], exact[0], 1e-9);
    assert_near(found[1], exact[1], 1e-9);
}

/// A four-bar linkage with a damper has one mode, however many are requested. Angles of its joints are massless unknowns beside
/// the multipliers, which equations hold.
#[test]
fn a_damped_four_bar() {
    let spring = "spring = { k = 40, c = 0.5 }";
    let found = ["map", "multipliers"].map(|closure| {
        let linkage = four_bar([spring, "", ""], &format!("closure = \"{closure}\""));
        eigenvalues(&format!("four-bar by {closure}"), &[linkage], 20)
    });
    for found in &found {
        assert_eq!(found.len(), 1, "{found:?}");
    }
    assert_near(found[1][0].re, found[0][0].re, 1e-11);
    assert_near(found[1][0].im, found[0][0].im, 1e-11);
}

#[test]
fn nothing_vibrates_where_all_is_prescribed() {
    let text = [
        GROUND,
        &hinge("A", "ground", "prescribed = { proportional = 1 }"),
        &body("A"),
        "[analysis.modes]\n",
    ]
    .concat();
    let said = failed("all prescribed", &text);
    assert_says(&said, &["nothing in the model is free to move"]);
}

/// An arm that is turned by the load parameter carries a pendulum with a slider, at rest: √(40/0.75) and √(4000/1), without a
/// damper or a gyroscopic force.
#[test]
fn what_the_load_parameter_moves_does_not_rotate() {
    for turned in [
        "constant = 10",
        "proportional = 10",
        "ramp = { end = 2, value = 20 }",
        "sine = { amplitude = 1, omega = 10 }",
    ] {
        let keys = "axis = [0, 0, 1]\nspring = { k = 40 }";
        let parts = [
            hinge("base", "ground", &format!("prescribed = {{ {turned} }}")),
            joint("arm", "offset", "base", "position = [1, 0, 0]"),
            joint("lag", "revolute", "arm", keys),
            slider("ext", "lag", X, 4000.0, 0.0),
            body_of("lag", 2.0, "center = [0.5, 0, 0]"),
            body_of("ext", 1.0, "center = [0.5, 0, 0]"),
        ];
        let found = eigenvalues("turned by the load", &parts, 2);
        assert_eq!(found.len(), 2, "{turned}: {found:?}");
        for (lambda, stiffness) in found.iter().zip([40.0 / 0.75, 4000.0]) {
            let exact = Complex64::new(0.0, f64::sqrt(stiffness));
            assert!(
                (lambda - exact).norm() < 1e-10 * exact.norm(),
                "{turned}: {found:?}"
            );
        }
    }
}

/// A spring beside a Maxwell element, by its elongation x and that of its damper.
struct Maxwell {
    k: [f64; 2],
    tau: f64,
}

impl EnergyElement<2> for Maxwell {
    const KINETIC: bool = false;

    fn potential<S: Scalar>(&self, _t: S, x: &SVector<S, 2>) -> S {
        let e = x[0] - x[1];
        (x[0] * x[0] * self.k[0] + e * e * self.k[1]) * 0.5
    }

    fn dissipation<S: Scalar>(&self, _x: &SVector<S, 2>, v: &SVector<S, 2>) -> S {
        v[1] * v[1] * (0.5 * self.k[1] * self.tau)
    }
}

/// A coordinate with an equation of first order: (m λ² + k₀)(1 + τ λ) + k₁ τ λ = 0, as ṡ = k₁ ẋ − s/τ.
#[test]
fn a_mass_on_a_maxwell_element() {
    let (k, tau, m) = ([9.0, 5.0], 0.7, 2.0);
    let maxwell = || Maxwell { k, tau }.into_element();
    check::element(&maxwell()).assert();
    let mut b = ModelBuilder::new();
    let ground = b.node("ground", [0.0; 3]).unwrap();
    b.support(ground, &Dof::ALL);
    let slide = Prismatic::new([1.0, 0.0, 0.0]).unwrap();
    let slide = b.attach("slide", ground, slide).unwrap();
    b.element("mass", PointMass::new(m).unwrap(), &[slide.frame])
        .unwrap();
    let z = b.coordinates("z", &[Quantity::Length]).unwrap();
    b.element("maxwell", maxwell(), &[slide.coordinates[0], z])
        .unwrap();
    let mut context = Context::new(b.build().unwrap());
    let linear = linearize(&mut context, Point::statics(0.0, &[0.0; 2])).unwrap();
    let found = modes(&linear, &ModeOptions::lowest(3)).unwrap().modes;
    // One relaxation, and one vibration.
    assert_eq!(found.len(), 2);
    for mode in found {
        let at = mode.eigenvalue;
        let left = (at * at * m + k[0]) * (at * tau + 1.0) + at * (k[1] * tau);
        assert!(left.norm() < 1e-12 * k[0], "{at}: {left}");
    }
}
