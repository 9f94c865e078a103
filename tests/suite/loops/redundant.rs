//! Redundant equations: some that always are, and a loop in which others are as it moves, so that they are chosen
//! anew on the way.

use crate::support::closures::{
    CLOSURES, GROUND, RUN, STATIC, angle, arm, body, four_bar, hinge, joint, probe,
};
use crate::support::program::{number, recorded};
use std::f64::consts::FRAC_PI_2;

/// Cardan's circles: a point on the rim of a wheel that rolls in a ring twice its size runs on a diameter,
/// where a slider guides it. The wheel sees the gap in its own axes: what the slider asks for is the gap along
/// its first axis at the start and along its second one a quarter turn later; the other one says nothing.
fn circles(carrier: &str, closure: &str) -> String {
    [
        GROUND,
        "[analysis.dynamic]\nto = 3\nstep = 0.01\nscheme = { generalised-alpha = 0.8 }\n",
        &hinge("carrier", "ground", carrier),
        &arm("hub", "carrier", [0.5, 0.0, 0.0]),
        &hinge("wheel", "hub", ""),
        "[[gears]]\njoints = [\"carrier\", \"wheel\"]\nratio = -2\n",
        &arm("rim", "wheel", [1.0, 0.0, 0.0]),
        &arm("guide", "ground", [1.0, 0.0, 0.0]),
        &joint("slider", "prismatic", "guide", "axis = [1, 0, 0]"),
        &hinge("pin", "slider", &format!("child = \"rim\"\n{closure}")),
        &body("wheel"),
        &body("slider"),
        &angle("carrier"),
        &angle("slider"),
        &probe("pin", "joint_force", "pin"),
    ]
    .concat()
}

/// Forces at rest are those of the state that was reached, wherever equations are looked at again.
#[test]
fn the_ground_bears_a_linkage_in_every_row() {
    let linkage = [
        GROUND,
        STATIC,
        &four_bar(["spring = { k = 3 }"; 3], CLOSURES[1]),
        &body("coupler tip"),
        "[[loads]]\ngravity = [0, -9.81, 0]\n",
        &probe("ground", "reaction_force", "ground"),
    ]
    .concat();
    let rows = recorded("loops_redundant_rest", &linkage);
    assert!(rows.len() >= 5);
    let mut turned = 0.0_f64;
    for row in &rows {
        let number = |column: &str| number(row, column);
        turned = turned.max(number("A").abs());
        // Four bodies of unit mass.
        let weight = 4.0 * 9.81 * number("t");
        assert!((number("ground.y") - weight).abs() < 1e-8, "{row:?}");
        assert!(number("ground.x").abs() < 1e-8, "{row:?}");
    }
    assert!(turned > 0.2, "{turned}");
}

#[test]
fn a_point_of_a_rolling_wheel_stays_on_its_diameter() {
    let driven = format!("prescribed = {{ proportional = {} }}", -FRAC_PI_2);
    for (closure, close) in CLOSURES.into_iter().zip([1e-12, 1e-9, 1e-5]) {
        for (name, carrier) in [
            ("driven", driven.as_str()),
            ("free", "rate = -1.5707963267948966"),
        ] {
            let name = format!("loops_redundant_{name}");
            let rows = recorded(&name, &circles(carrier, closure));
            let mut turned = 0.0_f64;
            for row in &rows {
                let number = |column: &str| number(row, column);
                let theta = number("carrier");
                let exact = theta.cos() - 1.0;
                let off = (number("slider") - exact).abs();
                assert!(off < close, "{name}, {closure} at {theta}: {off:e}");
                turned = turned.max(theta.abs());
                // The slider is a harmonic oscillator of unit mass, and asks for nothing across its way. What
                // multipliers of the equations in use do there the wheel bears.
                let [along, across] = ["pin.x", "pin.y"].map(|c| number(c).abs());
                // A penalty makes forces of rounding errors of gaps.
                let most = match closure {
                    c if c.contains("multipliers") => 10.0,
                    c if c.contains("penalty") => 1e-7,
                    _ => 1e-9,
                };
                assert!(across < most, "{name}, {closure} at {theta}: {across}");
                assert!(along < 2.6, "{name}, {closure} at {theta}: {along}");
            }
            assert!(turned > 3.0, "{turned}");
        }
    }
}

/// Both ends of a loop on one body: its six equations say nothing, and the gradients of their gaps are rounding
/// errors of the positions.
#[test]
fn a_loop_within_a_body_holds_nothing() {
    let arm_with = |axis: [f64; 3], tip: [f64; 3], close: &str| {
        let turning = |values: &str| format!("axis = {axis:?}\n{values}");
        [
            GROUND,
            RUN,
            &hinge("carrier", "ground", "value = 0.7\nrate = 0.5"),
            &arm("seat", "carrier", axis),
            &joint("A", "revolute", "seat", &turning("value = 0.4\nrate = 1.0")),
            &arm("elbow", "A", [0.9, 1.7, -0.4]),
            &joint("plate", "weld", "elbow", ""),
            &arm("tip", "plate", tip),
            &arm("end", "A", tip),
            &body("A"),
            &body("plate"),
            close,
            &angle("A"),
        ]
        .concat()
    };
    for (axis, tip) in [
        ([-0.3, -0.4, -2.0], [1.2, -0.2, 1.7]),
        ([0.7, 0.4, 0.1], [0.3, 1.1, -0.6]),
        ([1.3, -0.8, 0.5], [-1.9, 0.7, 0.2]),
    ] {
        let last = |name: &str, close: &str| {
            let rows = recorded(name, &arm_with(axis, tip, close));
            number(rows.last().unwrap(), "A")
        };
        let open = last("loops_redundant_open", "");
        for closure in CLOSURES {
            let close = joint(
                "weld",
                "weld",
                "tip",
                &format!("child = \"end\"\n{closure}"),
            );
            let off = last("loops_redundant_closed", &close) - open;
            assert!(off.abs() < 1e-9, "{axis:?} {closure}: {off:e}");
        }
    }
}
