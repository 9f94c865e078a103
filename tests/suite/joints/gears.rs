//! Gears and racks against closed forms.

use crate::support::closures::{
    GROUND, SECOND, angle, body_of, fixed, hinge, joint, probe, probe_of,
};
use crate::support::dynamics::{grounded, observed, point, revolute};
use crate::support::prelude::*;
use crate::support::program::{assert_says, check, number, recorded};

/// Two rotors on the ground with a motor on the first, and a spring and damper where `acts` says so.
fn rotors(acts: [&str; 2], gear: &str) -> String {
    let nodes = GROUND.replace("[[", "beside = [0.5, 0, 0]\n[[");
    [
        &nodes,
        &fixed("beside"),
        &hinge("pinion", "ground", acts[0]),
        &hinge("wheel", "beside", acts[1]),
        gear,
        &body_of("pinion", 1.0, "inertia = [1, 1, 0.02]"),
        &body_of("wheel", 1.0, "inertia = [1, 1, 0.9]"),
        SECOND,
        &angle("pinion"),
        &angle("wheel"),
        &probe("on first", "joint_moment", "pinion"),
        &probe("on second", "joint_moment", "wheel"),
        &probe("ground", "reaction_moment", "ground"),
        &probe("beside", "reaction_moment", "beside"),
    ]
    .concat()
}

const GEAR: &str = "[[gears]]\njoints = [\"pinion\", \"wheel\"]\nratio = -0.25\n";

#[test]
fn two_rotors_have_the_reduced_inertia() {
    let (ratio, first, second, motor) = (-0.25, 0.02, 0.9, 0.5);
    // (J₁ + i² J₂) θ̈₁ = M; each rotor takes J θ̈ from its joint.
    let reduced = first + ratio * ratio * second;
    let text = rotors(["actuator = { constant = 0.5 }", ""], GEAR);
    let rows = recorded("gear_motor", &text);
    for row in &rows {
        let t = number(row, "t");
        let acceleration = motor / reduced;
        let angle = 0.5 * acceleration * t * t;
        assert!((number(row, "pinion") - angle).abs() < 1e-9);
        assert!((number(row, "wheel") - ratio * angle).abs() < 1e-9);
        assert!((number(row, "on first.z") - first * acceleration).abs() < 1e-9);
        assert!((number(row, "on second.z") - second * ratio * acceleration).abs() < 1e-9);
        // Supports give what changes the angular momentum of both.
        let supports = number(row, "ground.z") + number(row, "beside.z");
        let change = (first + ratio * second) * acceleration;
        assert!((supports - change).abs() < 1e-9);
    }
    assert_eq!(rows.len(), 101);
    // A prescribed pinion, θ = sin 2t, takes (J₁ + i² J₂) θ̈ along its coordinate, and J₁ θ̈ through its hinge.
    let effort = probe_of("effort", "joint_effort", "joint = \"pinion\"");
    let swings = "prescribed = { sine = { amplitude = 1, omega = 2 } }";
    for row in recorded("gear_prescribed", &(rotors([swings, ""], GEAR) + &effort)) {
        let acceleration = -4.0 * (2.0 * number(&row, "t")).sin();
        assert!((number(&row, "effort") - reduced * acceleration).abs() < 1e-12);
        assert!((number(&row, "on first.z") - first * acceleration).abs() < 1e-12);
    }
}

#[test]
fn a_rack_falls_and_spins_its_pinion() {
    let gear = GEAR.replace("-0.25", "0.3") + "[[loads]]\ngravity = [0, -9.81, 0]\n";
    let rack = joint("wheel", "prismatic", "beside", "axis = [0, 1, 0]");
    let text = rotors(["", ""], &gear).replace(&hinge("wheel", "beside", ""), &rack);
    // (m + J/r²) ü = −m g.
    let acceleration = -9.81 / (1.0 + 0.02 / 0.09);
    for row in recorded("gear_rack", &text) {
        let t = number(&row, "t");
        let way = 0.5 * acceleration * t * t;
        assert!((number(&row, "wheel") - way).abs() < 1e-9);
        assert!((number(&row, "pinion") - way / 0.3).abs() < 1e-9);
        assert!((number(&row, "on first.z") - 0.02 * acceleration / 0.3).abs() < 1e-9);
    }
}

#[test]
fn what_a_gear_cannot_do_is_refused() {
    let gear =
        |joints: &str, ratio: &str| format!("[[gears]]\njoints = {joints}\nratio = {ratio}\n");
    let text = rotors(["", ""], &gear("[\"pinion\", \"weel\"]", "2"));
    let message = "no joint with a released coordinate";
    check(&text, "\"weel\"", message, "`wheel`");
    let text = rotors(["", ""], &gear("[\"pinion\", \"wheel\"]", "0"));
    check(&text, "[[gears]]", "ratio 0 must be", "");
    let twice = GEAR.to_owned() + &gear("[\"wheel\", \"pinion\"]", "-3");
    check(&rotors(["", ""], &twice), "[[gears]]", "the ratio -4", "");
    let text = rotors(["", "rate = 2"], GEAR);
    check(&text, "2", "follows another one", "other end");
}

/// A carrier, a planet on it, and a pinion on the ground after them.
fn train() -> (ModelBuilder, [NodeId; 3]) {
    let (mut b, ground) = grounded();
    let axis = [0.0, 0.0, 1.0];
    let carrier = revolute(&mut b, "carrier", ground, axis);
    let seat = b.offset("seat", carrier.frame, [0.7, 0.0, 0.0]).unwrap();
    let inertia = Matrix3::identity() * 0.05;
    let body = RigidBody::new(2.0, inertia, Vector3::zeros()).unwrap();
    let [planet, pinion] = [("planet", seat), ("pinion", ground)].map(|(name, on)| {
        let made = revolute(&mut b, name, on, axis);
        b.element(name, body, &[made.frame]).unwrap();
        made.coordinates[0]
    });
    (b, [carrier.coordinates[0], planet, pinion])
}

#[test]
fn a_planet_rolls_around_a_fixed_sun_and_drives_a_train() {
    // Sun 0.4, planet 0.3: the planet turns by 4/3 of the carrier's angle in the carrier, 7/3 in
    // all. The pinion, driven by the planet's angle in the carrier, makes twice that: 8/3.
    for reversed in [false, true] {
        let (mut b, [carrier, planet, pinion]) = train();
        if reversed {
            b.gear([pinion, planet], 0.5).unwrap();
            b.gear([planet, carrier], 0.75).unwrap();
        } else {
            b.gear([carrier, planet], 0.4 / 0.3).unwrap();
            b.gear([planet, pinion], 2.0).unwrap();
        }
        // Said before, in other words.
        b.gear([carrier, pinion], 8.0 / 3.0).unwrap();
        let error = b.gear([pinion, carrier], 1.0).unwrap_err();
        let wrong = "gear between pinion angle and carrier angle: other gears between them";
        assert!(error.to_string().starts_with(wrong), "{error}");
        let motor = CoordinateForce::new(Constant(0.3));
        b.element("motor", motor, &[planet]).unwrap();
        let mut context = Context::new(b.build().unwrap());
        assert_eq!(context.pattern().dim(), 1);
        // m a² + J (7/3)² + J (8/3)² and the motor's 4/3 of its moment.
        let squares = (7.0_f64 / 3.0).powi(2) + (8.0_f64 / 3.0).powi(2);
        let acceleration = 0.3 * (4.0 / 3.0) / (2.0 * 0.49 + 0.05 * squares);
        let options = DynamicOptions::new(2.0, 0.01);
        let progress = observed(&mut context, [&[0.0], &[0.0]], &options, &mut |_, _| ());
        let angle = 0.5 * acceleration * 4.0;
        assert!((progress.state.q[0] - angle).abs() < 1e-9);
        let at = point(&progress.state);
        context.configure(at).unwrap();
        let [found, rate, _] = context.coordinate(pinion, 0).unwrap();
        assert!((found - angle * 8.0 / 3.0).abs() < 1e-9);
        assert!((rate - acceleration * 2.0 * 8.0 / 3.0).abs() < 1e-9);
    }
}

#[test]
fn nodes_that_are_no_coordinates_have_no_gears() {
    let (mut b, [carrier, ..]) = train();
    let ground = b.find("ground").unwrap();
    let seat = b.find("seat").unwrap();
    for (node, ratio) in [(ground, 1.0), (seat, 1.0), (carrier, f64::NAN)] {
        let error = b.gear([carrier, node], ratio).unwrap_err();
        assert!(matches!(error, ModelError::Gear { .. }), "{error}");
    }
    let ModelError::Gear { source, .. } = b.gear([carrier, carrier], 2.0).unwrap_err() else {
        panic!("another error");
    };
    let (found, given) = (1.0, 2.0);
    assert_eq!(
        source,
        GearError::Contradiction {
            found,
            requested: given
        }
    );
}

#[test]
fn a_driven_follower_is_told_to_drive_its_leader() {
    let (mut b, [carrier, planet, _]) = train();
    b.gear([carrier, planet], 2.0).unwrap();
    b.prescribe_coordinate(planet, 0, Proportional(1.0));
    let said = b.build().err().unwrap().to_string();
    assert_says(&said, &["planet angle", "carrier angle"]);
}
