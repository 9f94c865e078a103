//! Probes against closed forms: what an arm turning about an axis does, and a bar's strains and forces.

use crate::support::beams::line;
use crate::support::*;
use nalgebra::Vector3;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

type Row = HashMap<String, String>;

fn vector(row: &Row, probe: &str, ends: [&str; 3]) -> Vector3<f64> {
    Vector3::from(ends.map(|end| number(row, &format!("{probe}.{end}"))))
}

#[track_caller]
fn near(found: Vector3<f64>, expected: Vector3<f64>, what: &str) {
    let gap = (found - expected).norm();
    let close = gap < 1e-11 * (1.0 + expected.norm());
    assert!(close, "{what}: {found:?} {expected:?}");
}

/// An arm that is swung about an axis, with its probes.
fn swung() -> String {
    let text = r#"
probes = [
    { name = "p", quantity = "position", node = "arm" },
    { name = "v", quantity = "velocity", node = "arm" },
    { name = "a", quantity = "acceleration", node = "arm" },
    { name = "omega", quantity = "angular_velocity", node = "arm" },
    { name = "alpha", quantity = "angular_acceleration", node = "arm" },
    { name = "bend", quantity = "joint_acceleration", joint = "hinge" },
    { name = "turned", quantity = "rotation", node = "arm" },
    { name = "chart", quantity = "chart_rotation", node = "arm" },
    { name = "speed", quantity = "velocity", node = "arm", component = "norm" },
    { name = "up", quantity = "acceleration", node = "arm", component = "z" },
]
nodes = { ground = [0, 0, 0], elsewhere = [5, 0, 0] }
"#;
    let swung = "axis = [0, 0.6, 0.8]\nprescribed = { sine = { amplitude = 4, omega = 3 } }";
    [
        text,
        &joint("hinge", "revolute", "ground", swung),
        &arm("arm", "hinge", [0.5, -0.3, 0.7]),
        &body_of("arm", 1.0, ""),
        // Something has to be free.
        &body_of("elsewhere", 1.0, ""),
        &fixed("ground"),
        &motion(2.0, 0.02),
    ]
    .concat()
}

#[test]
fn an_arm_that_is_swung_about_an_axis() {
    let rows = recorded("program_probes_arm", &swung());
    assert_eq!(rows.len(), 101);
    let e = Vector3::new(0.0, 0.6, 0.8);
    let r = Vector3::new(0.5, -0.3, 0.7);
    let mut turns = Vec::new();
    for row in &rows {
        let t = number(row, "t");
        let (sin, cos) = (3.0 * t).sin_cos();
        let [theta, rate, slope] = [4.0 * sin, 12.0 * cos, -36.0 * sin];
        let of = |probe| vector(row, probe, ["x", "y", "z"]);
        let along = e * e.dot(&r);
        let p = along + (r - along) * theta.cos() + e.cross(&r) * theta.sin();
        let v = e.cross(&p) * rate;
        let a = e.cross(&p) * slope + e.cross(&v) * rate;
        near(of("p"), p, "position");
        near(of("v"), v, "velocity");
        near(of("a"), a, "acceleration");
        near(of("omega"), e * rate, "angular velocity");
        near(of("alpha"), e * slope, "angular acceleration");
        near(of("turned"), e * theta, "rotation");
        for (name, exact, size) in [
            ("bend", slope, slope.abs()),
            ("speed", v.norm(), v.norm()),
            ("up", a.z, a.norm()),
        ] {
            assert_close(number(row, name), exact, 1e-11 * (1.0 + size), name);
        }
        // The same rotation, whole turns away, and within its chart but for the last step.
        let psi = e.dot(&of("chart"));
        let turn = ((theta - psi) / TAU).round();
        near(of("chart"), e * (theta - TAU * turn), "chart");
        assert!(psi.abs() <= PI + 0.02 * 12.0, "{psi} at {t}");
        turns.push(turn as i32);
    }
    turns.sort_unstable();
    turns.dedup();
    assert_eq!(turns, [-1, 0, 1], "the chart changes on both sides");
}

/// A straight bar along (0.6, 0.8, 0), clamped, with a load at its other end, and what its second
/// element says: N, Γ, M, K.
fn loaded(name: &str, load: &str) -> [Vector3<f64>; 4] {
    let quantities = ["N", "Gamma", "M", "K"];
    let probes = quantities.map(|q| probe_of(q, q, "element = \"line:2\""));
    let rest = [
        &fixed("A"),
        &format!("[[loads]]\nnode = \"B\"\n{load}\n"),
        "[analysis.static]\nsteps = 2\n",
        &probes.concat(),
    ];
    let stiffness = "EA = 50, GA = [20, 30], GJ = 2, EI = [3, 4]";
    let text = line(stiffness, 4, 1, &rest.concat());
    let rows = recorded(name, &changed(&text, "B = [1, 0, 0] => B = [1.2, 1.6, 0]"));
    quantities.map(|probe| vector(&rows[rows.len() - 1], probe, ["1", "2", "3"]))
}

#[test]
fn a_bar_under_an_end_force_and_a_cantilever_under_an_end_moment() {
    let none = Vector3::zeros();
    // Along the bar: N = F, Γ₁ = F/EA, in tension and in compression (well below its critical load).
    for force in [5.0, -0.2] {
        let load = format!("force = [{}, {}, 0]", 0.6 * force, 0.8 * force);
        let [N, Gamma, M, K] = loaded("program_probes_force", &load);
        near(N, Vector3::x() * force, "N");
        near(Gamma, Vector3::x() * (force / 50.0), "Gamma");
        near(M, none, "M");
        near(K, none, "K");
    }
    // A moment about E₁, E₂ = (−0.8, 0.6, 0) or E₃ = e₃: K = M/(GJ, EI₂, EI₃) everywhere.
    for (moment, axis, stiffness) in [
        ("[0.9, 1.2, 0]", Vector3::x(), 2.0),
        ("[-1.2, 0.9, 0]", Vector3::y(), 3.0),
        ("[0, 0, 1.5]", Vector3::z(), 4.0),
    ] {
        let load = format!("moment = {moment}");
        let [N, Gamma, M, K] = loaded("program_probes_moment", &load);
        near(N, none, "N");
        near(Gamma, none, "Gamma");
        near(M, axis * 1.5, "M");
        near(K, axis * 1.5 / stiffness, "K");
    }
}

/// A rod is stretched and twisted at the rate 0.1, without inertia: N = EA (0.03 + β 0.1), M = GJ (0.03 + β 0.1), with β = 0.5.
#[test]
fn the_forces_of_a_rod_are_those_of_its_dampers_too() {
    let rate = "{ spin_up = { rate = 0.1, duration = 0.2 } }";
    let probes = ["N", "M"].map(|q| probe_of(q, q, "element = \"line:2\""));
    for interpolation in ["total", "geodesic"] {
        let rest = [
            &format!("interpolation = \"{interpolation}\"\n"),
            &fixed("A"),
            "[[supports]]\nnode = \"B\"\nfix = [\"y\", \"z\", \"ry\", \"rz\"]\n",
            &format!("prescribed = {{ x = {rate}, rx = {rate} }}\n"),
            "[sections.main.damping]\nstiffness = 0.5\n",
            "[sections.main.mass]\nA_rho = 1e-6\nJ = [1e-8, 1e-8, 1e-8]\n",
            &motion(0.4, 0.01),
            "scheme = \"radau\"\n",
            &probes.concat(),
        ];
        let stiffness = "EA = 1000, GA = [1000, 1000], GJ = 10, EI = [10, 10]";
        let text = line(stiffness, 2, 1, &rest.concat());
        let rows = recorded(&format!("program_probes_damped_{interpolation}"), &text);
        let last = rows.last().unwrap();
        for (probe, exact) in [("N", 80.0), ("M", 0.8)] {
            let found = vector(last, probe, ["1", "2", "3"]);
            near(found, Vector3::x() * exact, probe);
        }
    }
}

/// A body that is held at its center, and about x as far as its rotation vector has no such component: the moment of the
/// support is the rate of its angular momentum, also where the vector is complemented.
#[test]
fn the_moment_of_a_support_is_the_rate_of_momentum() {
    let h = 0.001;
    let text = [
        "[nodes]\nbody = [0, 0, 0]\n",
        "[[supports]]\nnode = \"body\"\nfix = [\"x\", \"y\", \"z\", \"rx\"]\n",
        &body_of("body", 1.0, "inertia = [1, 2, 3]"),
        "[[initial]]\nnode = \"body\"\nangular_velocity = [0, 1, 4]\n",
        &motion(1.2, h),
        PLAIN,
        &probe("M", "reaction_moment", "body"),
        &probe("chart", "chart_rotation", "body"),
        "[[probes]]\nname = \"L\"\nquantity = \"angular_momentum\"\n",
    ];
    let rows = recorded("program_probes_held", &text.concat());
    let of = |row: &Row, probe: &str| vector(row, probe, ["x", "y", "z"]);
    let mut changes = 0;
    for three in rows.windows(3) {
        let [before, now, after] = [0, 1, 2].map(|k| &three[k]);
        let rate = (of(after, "L") - of(before, "L")) / (2.0 * h);
        let gap = (of(now, "M") - rate).norm() / (1.0 + rate.norm());
        assert!(gap < 1e-3, "at {}: {gap:e} {rate}", now["t"]);
        changes += usize::from((of(now, "chart") - of(before, "chart")).norm() > 1.0);
    }
    assert_eq!(changes, 1);
}
