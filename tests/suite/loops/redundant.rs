//! Redundant equations: some that always are, and a loop in which others are as it moves, so that they are chosen
//! anew on the way.

use crate::support::closures::{CLOSURES, GROUND, RUN, angle, arm, body, hinge, joint, rows};
use crate::support::dynamics::{grounded, integrate_ode};
use crate::support::loops::{G, bar, gap, pick, run};
use crate::support::prelude::*;
use crate::support::program::number;

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
        "[[probes]]\nname = \"pin\"\nquantity = \"joint_force\"\nnode = \"pin\"\n",
    ]
    .concat()
}

/// Forces at rest are those of the state that was reached, wherever equations are looked at again.
#[test]
fn the_ground_bears_a_linkage_in_every_row() {
    let sprung = |name: &str, parent: &str, more: &str| {
        hinge(name, parent, &format!("spring = {{ k = 3 }}\n{more}"))
    };
    let linkage = [
        GROUND,
        "[analysis.static]\nsteps = 4\n",
        &sprung("A", "ground", ""),
        &arm("a", "A", [0.0, 1.0, 0.0]),
        &sprung("B", "a", ""),
        &arm("b", "B", [1.2, 1.9, 0.0]),
        &arm("foot", "ground", [1.6, 0.0, 0.0]),
        &sprung("D", "foot", ""),
        &arm("d", "D", [1.2, 1.9, 0.0]),
        &hinge("C", "b", "child = \"d\"\nclosure = \"multipliers\""),
        &body("a"),
        &body("b"),
        "[[loads]]\ngravity = [0, -9.81, 0]\n",
        &angle("A"),
        "[[probes]]\nname = \"ground\"\nquantity = \"reaction_force\"\nnode = \"ground\"\n",
    ]
    .concat();
    let (_, rows) = rows("loops_redundant_rest", &linkage);
    assert!(rows.len() >= 5);
    let mut turned = 0.0_f64;
    for row in &rows {
        let number = |column: &str| number(row, column);
        turned = turned.max(number("A").abs());
        // Two bodies of unit mass.
        let weight = 2.0 * 9.81 * number("t");
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
            let (_, rows) = rows(&name, &circles(carrier, closure));
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
            let (_, rows) = rows(name, &arm_with(axis, tip, close));
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

/// A plate on three parallel cranks of the same length: the third one only fits. `length` is that
/// of the third crank.
#[derive(Clone, Copy, Debug)]
struct Parallelogram {
    length: f64,
}

impl Implicit<4, 4> for Parallelogram {
    /// x: angles of the three cranks and of the plate.
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, 4>) -> SVector<S, 4> {
        let pin = |k: usize, l: f64, at: f64| {
            [
                x[0].cos() + x[3].cos() * at - x[k].cos() * l - at,
                x[0].sin() + x[3].sin() * at - x[k].sin() * l,
            ]
        };
        let ([a, b], [c, d]) = (pin(1, 1.0, 2.0), pin(2, self.length, 1.0));
        SVector::<S, 4>::new(a, b, c, d)
    }

    fn equation(&self, i: usize) -> String {
        [
            "second pin, e1",
            "second pin, e2",
            "third pin, e1",
            "third pin, e2",
        ][i]
            .to_owned()
    }
}

/// The plate on its cranks, under their weights.
fn carried(map: ImplicitMap) -> (ModelBuilder, NodeId) {
    let (mut b, ground) = grounded();
    let q = b.coordinates("q", &[Quantity::Angle]).unwrap();
    let x = b
        .mapped_coordinates("x", &[Quantity::Angle; 4], Box::new(map), &[q])
        .unwrap();
    let cranks = [0, 1, 2].map(|k| pick::<4>(&mut b, x, k, Quantity::Angle));
    let first = bar(&mut b, ground, [0.0; 3], cranks[0], 1.0, 1.0);
    bar(&mut b, ground, [2.0, 0.0, 0.0], cranks[1], 1.0, 2.0);
    bar(&mut b, ground, [1.0, 0.0, 0.0], cranks[2], 1.0, 3.0);
    let turn = Linear::sum([-1.0, 0.0, 0.0, 1.0], 0.0).boxed();
    let turn = b
        .mapped_coordinates("turn", &[Quantity::Angle], turn, &[x])
        .unwrap();
    bar(&mut b, first, [1.0, 0.0, 0.0], turn, 2.0, 4.0);
    (b, x)
}

/// Angle and rate of the cranks at a time: as the plate only translates, a pendulum,
/// (Σ m/3 + m_p) θ̈ = −g (Σ m/2 + m_p) cos θ.
fn pendulum(start: Vector2<f64>, to: f64) -> Vector2<f64> {
    let ode = |_: f64, z: &Vector2<f64>| Vector2::new(z[1], -G * z[0].cos() * 7.0 / 6.0);
    integrate_ode(&ode, start, to, 4000)
}

#[test]
fn a_redundant_crank_is_named_and_carried_along() {
    let start = -1.0_f64;
    let guess = [start, start, start, 0.0];
    let plate = |length| {
        let cranks = Parallelogram { length };
        ImplicitMap::of(cranks, 1, 0.0, guess, Choice::Split)
    };
    let map = plate(1.0).unwrap();
    assert_eq!(map.redundant().len(), 1, "{:?}", map.redundant());
    let error = plate(0.95).err().unwrap();
    assert!(error.to_string().contains("pin"), "{error}");
    let (b, x) = carried(map);
    let to = 1.0;
    let z = pendulum(Vector2::new(start, 0.0), to);
    let exact = [z[0], z[0], z[0], 0.0, z[1], z[1], z[1], 0.0];
    let h = |x: &SVector<f64, 4>| Parallelogram { length: 1.0 }.h(0.0, x).amax();
    let run = run(Context::new(b.build().unwrap()), x, &[0.0], &h, [to, 1e-3]);
    assert!(gap(&run.end, &exact) < 1e-4, "{:?}", run.end);
    assert!(run.residual < 1e-14);
    assert!(run.notes[0].1.contains("redundant: "), "{:?}", run.notes);
}
