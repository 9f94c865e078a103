//! The joints of the library in motion, from model files, against closed forms.

use crate::support::closures::{
    GROUND, PLAIN, angle, arm, beam_line, body_of, joint, motion, on_joint, probe,
};
use crate::support::prelude::*;
use crate::support::program::{Rows, assert_close, check_table, number, recorded, refusal};

#[track_caller]
fn ran(name: &str, text: &str) -> Rows {
    let rows = recorded(name, text);
    assert_eq!(rows.len(), 101);
    rows
}

const G: f64 = 9.81;

#[test]
fn a_nut_runs_down_its_screw() {
    let pitch = 0.4;
    let screw = format!("type = \"helical\"\naxis = [0, 0, 1]\npitch = {pitch}");
    let text = on_joint(&screw, "inertia = [0.06, 0.06, 0.05]", &angle("joint"));
    // (J + m p²/4π²) φ̈ = −m g p/2π.
    let lead = pitch / TAU;
    let rate = -2.0 * G * lead / (0.05 + 2.0 * lead * lead);
    for row in ran("joint_helical", &text) {
        let t = number(&row, "t");
        assert!((number(&row, "joint") - 0.5 * rate * t * t).abs() < 1e-8);
        assert!((number(&row, "position.z") - 0.5 * rate * lead * t * t).abs() < 1e-9);
    }
    assert!(0.5 * rate < -1.5 * TAU, "it makes turns: {rate}");
}

#[test]
fn a_cylindrical_joint_falls_and_spins_by_itself() {
    let joint = "type = \"cylindrical\"\naxis = [0, 0, 1]\ncoordinates = { displacement = { spring = { k = 50 } }, \
                 angle = { actuator = { constant = 0.3 }, rate = 2.0 } }";
    let probes = ["joint displacement", "joint angle"].map(angle).concat();
    let text = on_joint(joint, "inertia = [1, 1, 0.6]", &probes);
    for row in ran("joint_cylindrical", &text) {
        let t = number(&row, "t");
        assert!((number(&row, "joint angle") - (2.0 * t + 0.25 * t * t)).abs() < 1e-9);
        // u = −m g/k (1 − cos ω t), ω² = 25.
        let way = -2.0 * G / 50.0 * (1.0 - (5.0 * t).cos());
        assert!((number(&row, "joint displacement") - way).abs() < 1e-5);
    }
}

#[test]
fn a_puck_on_a_slope_flies_like_a_stone() {
    // The plane with the normal (0, −1, 1)/√2: half of gravity's square along the slope.
    let joint = "type = \"planar\"\naxis = [0, -1, 1]\nsecond_axis = [1, 0, 0]\n\
                 coordinates = { \"displacement 1\" = { rate = 3.0 }, angle = { rate = 4.0 } }";
    let names = [
        "joint displacement 1",
        "joint displacement 2",
        "joint angle",
    ];
    let text = on_joint(joint, "inertia = [1, 2, 2]", &names.map(angle).concat());
    let down = -G / 2.0_f64.sqrt();
    for row in ran("joint_planar", &text) {
        let t = number(&row, "t");
        assert!((number(&row, "joint displacement 1") - 3.0 * t).abs() < 1e-9);
        assert!((number(&row, "joint displacement 2") - 0.5 * down * t * t).abs() < 1e-9);
        assert!((number(&row, "joint angle") - 4.0 * t).abs() < 1e-9);
        assert!((number(&row, "position.x") - 3.0 * t).abs() < 1e-9);
        let below = 0.5 * down * t * t / 2.0_f64.sqrt();
        assert!((number(&row, "position.z") - below).abs() < 1e-9);
    }
}

#[test]
fn a_body_on_a_coupling_goes_round_without_turning_about_its_shaft() {
    // Its bob is a metre below the joint and is thrown into a cone of 30°.
    // As the joint transmits any turn about its shaft from the ground, which does not turn, the angular
    // velocity is ω (e3 − c) with the body's axis c. Its spin −ω (1 − cos θ) has a momentum of its own:
    // ω² (I cos θ + J (1 − cos θ)) = m g l, I and J across and along the shaft, at the joint. The moment of
    // the joint, along e3 + c, has no part in that.
    let (m, across, along, cone) = (2.0, 0.5, 0.8, PI / 6.0);
    let (sine, cosine) = cone.sin_cos();
    let omega: f64 = (m * G / ((m + across) * cosine + along * (1.0 - cosine))).sqrt();
    // The first tilt is about e2, the second about −e1; the bob is at (sin θ, 0, −cos θ).
    let coupling = format!(
        "type = \"constant_velocity\"\naxis = [0, 0, 1]\nsecond_axis = [0, 0, 1]\ncoordinates = {{ \
         \"tilt 1\" = {{ value = {} }}, \"tilt 2\" = {{ rate = {} }} }}",
        -cone,
        -cone * omega
    );
    let body = format!("inertia = [{across}, {across}, {along}]");
    let rotation = probe("turn", "rotation", "bob");
    let offset = arm("bob", "joint", [0.0, 0.0, -1.0]);
    let text = on_joint(&coupling, &body, &rotation)
        .replace("to = 1.0\nstep = 0.001", "to = 2.2\nstep = 0.0005")
        .replace("record_every = 10", "record_every = 44")
        .replace("\nnode = \"joint\"", "\nnode = \"bob\"")
        .replace("[[bodies]]", &(offset + "[[bodies]]"));
    let mut turned = 0.0;
    for row in ran("joint_cone", &text) {
        turned = omega * number(&row, "t");
        let (s, c) = turned.sin_cos();
        // One rotation about an axis across the shaft that goes round with the bob.
        for (name, exact, most) in [
            ("position", [sine * c, sine * s, -cosine], 2e-6),
            ("turn", [cone * s, -cone * c, 0.0], 4e-6),
        ] {
            for (axis, exact) in ["x", "y", "z"].into_iter().zip(exact) {
                let found = number(&row, &format!("{name}.{axis}"));
                let off = (found - exact).abs();
                assert!(off < most, "{name} turned by {turned}: {found} {exact}");
            }
        }
    }
    assert!(turned > TAU, "a whole turn");
    assert!(sine * along > 0.1, "a spin that matters");
}

#[test]
fn a_coupling_of_constant_velocity_turns_its_shafts_equally() {
    // Two shafts at 40°, the far end of the second in a bearing: statics of a driven angle.
    let (s, c) = 40_f64.to_radians().sin_cos();
    let axes = format!("axis = [1, 0, 0]\nsecond_axis = [{c}, {s}, 0]");
    let ends = ["A", "B"].map(|end| probe(end, "rotation", end) + "component = \"norm\"\n");
    let text = [
        "[sections.shaft]\nstiffness = { EA = 1e4, GA = [1e4, 1e4], GJ = 1e3, EI = [1e3, 1e3] }\n",
        &format!("[nodes]\nA = [-1, 0, 0]\nB = [{c}, {s}, 0]\nmiddle = [0, 0, 0]\n"),
        &beam_line("first", ["A", "middle"], 1, "shaft"),
        &joint("coupling", "constant_velocity", "middle", &axes),
        &beam_line("second", ["coupling", "B"], 1, "shaft"),
        "[[supports]]\nnode = \"A\"\nfix = [\"x\", \"y\", \"z\", \"ry\", \"rz\"]\n\
         prescribed = { rx = { proportional = 5.0 } }\n\
         [[supports]]\nnode = \"B\"\nfix = \"position\"\n\
         [analysis.static]\nsteps = 50\n",
        PLAIN,
        &ends.concat(),
    ]
    .concat();
    let rows = recorded("joint_coupling", &text);
    for row in &rows {
        assert_close(number(row, "A"), number(row, "B"), 1e-8, "ends");
    }
    assert!((number(rows.last().unwrap(), "B") - 5.0).abs() < 1e-8);
}

/// Nothing acts on a body whose coordinates are relative to the ground, or to a hub that swings: it turns by several whole
/// turns, beside the pole of its rotation vector, and keeps its momentum.
#[test]
fn a_free_body_keeps_its_momentum_on_any_parent() {
    let swung = "axis = [0.3, -0.2, 1]\nprescribed = { sine = { amplitude = 2, omega = 3 } }";
    let inertia = "inertia = [1, 2, 3]\ncenter = [0.1, -0.2, 0.1]";
    let columns = ["momentum", "angular_momentum"]
        .map(|quantity| format!("[[probes]]\nname = \"{quantity}\"\nquantity = \"{quantity}\"\n"));
    let cases = [
        ("hub", "ga:0.8"),
        ("ground", "ga:0.8"),
        ("ground", "lie-ga:0.8"),
        ("ground", "ul-newmark"),
        ("ground", "spin-newmark"),
    ];
    for (parent, scheme) in cases {
        let end = |h: f64| {
            let text = [
                GROUND,
                &joint("hub", "revolute", "ground", swung),
                &joint("body", "free", parent, "position = [0.4, 0.1, 0]"),
                &body_of("body", 2.0, inertia),
                "[[initial]]\nangular_velocity = [0.3, 0.2, 5.0]\n",
                &motion(4.0, h),
                &format!("scheme = \"{scheme}\"\n"),
                PLAIN,
                &columns.concat(),
            ];
            let rows = recorded(&format!("joint_free_{parent}"), &text.concat());
            let last = rows.last().unwrap();
            let [found_p, found_L] = ["momentum", "angular_momentum"].map(|of| {
                Vector3::from(["x", "y", "z"].map(|axis| number(last, &format!("{of}.{axis}"))))
            });
            // J ω and m v of the rigid motion about the origin.
            let omega = Vector3::new(0.3, 0.2, 5.0);
            let center = Vector3::new(0.5, -0.1, 0.1);
            let p = omega.cross(&center) * 2.0;
            let spin = Vector3::new(1.0, 2.0, 3.0).component_mul(&omega);
            let L = center.cross(&p) + spin;
            (found_p - p).amax().max((found_L - L).amax())
        };
        let errors = [0.002, 0.001].map(end);
        let second = errors[0] < 0.02 && errors[1] < 0.3 * errors[0];
        assert!(second, "{parent}, {scheme}: {errors:?}");
    }
}

#[test]
fn coordinates_of_joints_are_refused_by_name() {
    let crossed = "type = \"universal\"\naxis = [1, 0, 0]\nsecond_axis = [0, 1, 0]";
    check_table(
        &on_joint(crossed, "inertia = [1, 1, 1]", ""),
        refusal,
        r#"
second_axis = [0, 1, 0] => &\nrate = 1 | rate | universal
 => &\ncoordinates = { angle = { rate = 1 } } | angle | no coordinate of the joint named "angle" | angle 1
 => second_axis = [-2, 0, 0] | [1, 0, 0] | parallel
 => | [[joints]] | needs second_axis
type = "universal"\naxis = [1, 0, 0]\nsecond_axis = [0, 1, 0] => type = "weld"\naxis = [1, 0, 0] | axis | weld
 => type = "spherical"\nspring = { k = 1 } | spring | no use for spring | penalty_damping
 => type = "spherical"\ncoordinates = { rx = { rate = 1 } } | coordinates | no use for coordinates | penalty_damping
"#,
    );
    // What is offered is accepted.
    let ball = joint("ball", "spherical", "ground", "rate = 1");
    let advice = refusal(&[GROUND, &ball, &motion(1.0, 0.1)].concat()).to_string();
    assert!(
        !advice.contains("actuator") && !advice.contains("coordinates"),
        "{advice}"
    );
}
