//! Jumps of driven velocities: what is free takes the impulse. Inputs that change between steps.

use super::mass_on_rail;
use crate::support::closures::{
    CLOSURES, GROUND, PLAIN, arm, beam_line, body, body_of, five_bar, hinge, joint, motion,
    probe_of,
};
use crate::support::dynamics::{assert_order, motion_of, revolute};
use crate::support::prelude::*;
use crate::support::program::{assert_close, number, recorded};
use pullback::solve::begin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A unit mass on a rail, and the force on it.
fn pushed(force: impl FnOnce(&mut ModelBuilder) -> Box<dyn TimeFunction>) -> Context {
    let (mut b, node) = mass_on_rail();
    let force = NodalLoad::new(LoadKind::DeadForce, [1.0, 0.0, 0.0], force(&mut b));
    b.element("force", force, &[node]).unwrap();
    Context::new(b.build().unwrap())
}

/// Position and velocity after two seconds in steps of a tenth; `turn` is called after the first.
fn after(context: &mut Context, word: &str, turn: &mut dyn FnMut(&mut Context)) -> [f64; 2] {
    let options = DynamicOptions {
        scheme: word.parse().unwrap(),
        ..DynamicOptions::new(2.0, 0.1)
    };
    let mut progress = Progress::new(start(context, 0.0, &[], &[]).unwrap());
    integrate(context, &mut progress, &options, &mut |context, step| {
        if step.progress.summary.steps == 10 {
            turn(context);
        }
        ControlFlow::Continue(())
    })
    .unwrap();
    [progress.state.q[0], progress.state.v[0]]
}

#[test]
fn an_input_that_changes_is_a_kink() {
    // A force of 1 for a second, then of −2: v = 1 − 2, x = ½ + 1 − 1.
    let words = "newmark ga:0.5 bathe radau projected-newmark projected-newmark:0.5";
    for word in words.split(' ') {
        let mut handle = None;
        let mut model = pushed(|b| Box::new(*handle.insert(b.input(1.0))));
        let turn = &mut |context: &mut Context| context.set_input(handle.unwrap(), -2.0);
        let [x, v] = after(&mut model, word, turn);
        let off = (x - 0.5).abs().max((v + 1.0).abs());
        assert!(off < 1e-13, "{word}: {x}, {v}");
    }
}

/// A mass on a spring from rest under a force with these points at a step h: its position after a second is of order 2.
fn assert_second_order(name: &str, points: impl Fn(f64) -> Vec<[f64; 2]>, exact: f64) {
    for scheme in [
        "newmark = [0.25, 0.5]",
        "generalised-alpha = 0.9",
        "generalised-alpha = 0.5",
        "hht = -0.1",
        "wbz = 0.8",
    ] {
        let errors = [50.0, 100.0, 200.0, 400.0].map(|steps| {
            let h = 1.0 / steps;
            let points = points(h);
            let slider = format!(
                "axis = [1, 0, 0]\nspring = {{ k = 100 }}\nactuator = {{ table = {points:?} }}"
            );
            let text = [
                GROUND,
                &joint("slider", "prismatic", "ground", &slider),
                &body_of("slider", 1.0, ""),
                &probe_of("x", "joint_coordinate", "joint = \"slider\""),
                &motion(1.0, h),
                &format!("scheme = {{ {scheme} }}\n"),
                PLAIN,
            ];
            let rows = recorded(name, &text.concat());
            (number(&rows[rows.len() - 1], "x") - exact).abs()
        });
        assert_order(scheme, &errors, 2.0, 0.1);
    }
}

/// 100 sin 3t: all steps begin at a kink.
#[test]
fn a_force_sampled_at_every_step_keeps_the_order() {
    let exact = 100.0 / 91.0 * (3.0_f64.sin() - 0.3 * 10.0_f64.sin());
    let sampled = |h: f64| {
        let times = (0..=(1.0 / h).round() as usize).map(|k| k as f64 * h);
        times.map(|t| [t, 100.0 * (3.0 * t).sin()]).collect()
    };
    assert_second_order("kinks_sampled", sampled, exact);
}

/// From 0 to 100 at t = 0.1, within a millionth of a second: the same as a jump in the middle of that.
#[test]
fn a_steep_force_keeps_the_order() {
    let rise = 1e-6;
    let steep = |_| vec![[0.0, 0.0], [0.1, 0.0], [0.1 + rise, 100.0], [2.0, 100.0]];
    assert_second_order(
        "kinks_steep",
        steep,
        1.0 - (10.0 * (0.9 - 0.5 * rise)).cos(),
    );
}

/// ∫ f(s) sin ω(t − s)/ω ds of a force with these points: Simpson's rule is exact to rounding in pieces this short.
fn convolved(points: &[[f64; 2]], omega: f64, t: f64) -> f64 {
    let pieces = points.windows(2).map(|ends| {
        let [[a, f], [b, g]] = [ends[0], ends[1]];
        let part = |s: f64, force: f64| force * (omega * (t - s)).sin() / omega;
        let middle = part(0.5 * (a + b), 0.5 * (f + g));
        (b - a) / 6.0 * (part(a, f) + 4.0 * middle + part(b, g))
    });
    pieces.sum()
}

/// A triangle of 1e-5 s in adaptive steps, which double behind it; and a blast whose points lie ever further apart. The
/// position is right to a hundredth of the amplitude that the impulse gives.
#[test]
fn short_forces_leave_nothing_but_their_impulse() {
    let triangle = vec![[0.5, 0.0], [0.500005, 2e5], [0.50001, 0.0]];
    let blast = vec![
        [0.4999, 0.0],
        [0.5, 2000.0],
        [0.50019, 1365.0],
        [0.50055, 660.0],
        [0.50124, 167.0],
        [0.50255, 12.0],
        [0.505, 0.0],
    ];
    for (name, points, steps) in [
        (
            "kinks_triangle",
            triangle,
            "adaptive = { tolerance = 1e-7 }\n",
        ),
        ("kinks_blast", blast, ""),
    ] {
        let slider =
            format!("axis = [1, 0, 0]\nspring = {{ k = 4 }}\nactuator = {{ table = {points:?} }}");
        let text = [
            GROUND,
            &joint("slider", "prismatic", "ground", &slider),
            &body_of("slider", 1.0, ""),
            &probe_of("x", "joint_coordinate", "joint = \"slider\""),
            &motion(2.0, 0.01),
            steps,
            PLAIN,
        ];
        let rows = recorded(name, &text.concat());
        let impulse: f64 = (points.windows(2))
            .map(|ends| 0.5 * (ends[1][0] - ends[0][0]) * (ends[0][1] + ends[1][1]))
            .sum();
        let exact = convolved(&points, 2.0, 2.0);
        assert_close(
            number(&rows[rows.len() - 1], "x"),
            exact,
            0.01 * impulse / 2.0,
            name,
        );
    }
}

/// A speed that an input holds since the time of another one, and the angle there.
#[derive(Debug)]
struct Held([Input; 3]);

impl TimeFunction for Held {
    fn at(&self, t: f64, inputs: &[f64]) -> [f64; 3] {
        let [angle, speed, since] = self.0.map(|u| inputs[usize::from(u)]);
        [angle + speed * (t - since), speed, 0.0]
    }
}

/// A disc turns freely on a shaft, whose speed of 1 becomes 3: the disc keeps its own, however the input is set.
#[test]
fn a_prescribed_speed_by_an_input_jumps_as_at_a_kink() {
    for word in ["newmark", "ga:0.5", "radau", "projected-newmark"] {
        for by_event in [false, true] {
            let mut b = ModelBuilder::new();
            let shaft = b.node("shaft", [0.0; 3]).unwrap();
            b.support(shaft, &Dof::ALL[..5]);
            let inputs = [0.0, 1.0, 0.0].map(|value| b.input(value));
            b.prescribe(shaft, Dof::RZ, Held(inputs));
            let disc = revolute(&mut b, "disc", shaft, [0.0, 0.0, 1.0]).frame;
            let body = RigidBody::new(1.0, Matrix3::identity(), Vector3::zeros()).unwrap();
            b.element("body", body, &[disc]).unwrap();
            let mut context = Context::new(b.build().unwrap());
            let options = DynamicOptions {
                scheme: word.parse().unwrap(),
                ..DynamicOptions::new(1.0, 0.1)
            };
            let first = start(&context, 0.0, &[0.0], &[0.0]).unwrap();
            let mut run = Simulation::new(&mut context, first, &options).unwrap();
            let now = inputs.into_iter().zip([0.5, 3.0, 0.5]);
            if by_event {
                run.add_event(
                    |_, state| state.t - 0.5,
                    move |context: &mut Context, _| {
                        now.clone()
                            .for_each(|(u, value)| context.set_input(u, value));
                        ControlFlow::Continue(())
                    },
                );
            } else {
                (0..5).for_each(|_| assert!(run.step().unwrap().is_some()));
                now.for_each(|(u, value)| run.set_input(u, value));
            }
            run.finish().unwrap();
            let omega = [shaft, disc].map(|node| run.system().node_state(node).omega.z);
            let off = (omega[0] - 3.0).abs().max((omega[1] - 1.0).abs());
            assert!(off < 1e-12, "{word}: {omega:?}");
        }
    }
}

/// A force that breaks the rules: it is no function of time alone, and does not say so.
#[derive(Debug)]
struct Outside(Arc<AtomicBool>);

impl TimeFunction for Outside {
    fn at(&self, _: f64, _: &[f64]) -> [f64; 3] {
        let forward = self.0.load(Ordering::Relaxed);
        [if forward { 1.0 } else { -2.0 }, 0.0, 0.0]
    }
}

#[test]
fn em_takes_no_force_for_steady_that_does_not_say_so() {
    let [newmark, em] = ["newmark", "projected-newmark"].map(|word| {
        let forward = Arc::new(AtomicBool::new(true));
        let mut model = pushed(|_| Box::new(Outside(forward.clone())));
        after(&mut model, word, &mut |_| {
            forward.store(false, Ordering::Relaxed)
        })
    });
    assert_eq!(em, newmark);
}

/// A mass on a stiff spring that starts 0.1 off, on a base that is jerked, with or without a hinge
/// beside it that has no mass.
fn jerked(idle: &str) -> Vec<[f64; 3]> {
    let rail = "axis = [1, 0, 0]\nspring = { k = 1e4, x0 = 0.1 }";
    let text = [
        "[nodes]\nbase = [0, 0, 0]\n\
         [[supports]]\nnode = \"base\"\nfix = [\"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n\
         prescribed = { x = { table = [[0.03, 0], [0.1, 0.07]] } }\n",
        &joint("way", "prismatic", "base", rail),
        idle,
        &body_of("way", 1.0, ""),
        "[analysis.dynamic]\nto = 0.06\nstep = 0.01\n",
    ];
    let (mut model, first, options) = motion_of(&text.concat());
    let node = model.find("way").unwrap();
    let mut progress = Progress::new(first);
    begin(&mut model, &options, &mut progress).unwrap();
    let row = |model: &Context| {
        let state = model.node_state(node);
        [state.position.x, state.velocity.x, state.acceleration.x]
    };
    let mut rows = vec![row(&model)];
    integrate(&mut model, &mut progress, &options, &mut |model, _| {
        rows.push(row(model));
        ControlFlow::Continue(())
    })
    .unwrap();
    rows
}

#[test]
fn what_has_no_mass_leaves_alone_what_it_has_nothing_to_do_with() {
    let words = "axis = [0, 1, 0]\nspring = { k = 1 }";
    let hinge = joint("idle", "revolute", "base", words);
    let (alone, beside) = (jerked(""), jerked(&hinge));
    // k x0/m.
    assert!((alone[0][2] - 1e3).abs() < 1e-9, "{:?}", alone[0]);
    assert_eq!(alone.len(), 7);
    for (a, b) in alone.iter().flatten().zip(beside.iter().flatten()) {
        assert_close(*a, *b, 1e-9 * (1.0 + a.abs()), "beside");
    }
}

/// Velocity and acceleration at the start of a disc that a damper couples to a shaft, beside a cart on a rail, where both begin
/// with a jerk; lengths are measured in another unit, and masses in its reciprocal.
fn jerked_with_damper(unit: f64) -> [f64; 2] {
    let begins = |rate: f64| format!("prescribed = {{ ramp = {{ end = 1, value = {rate:?} }} }}\n");
    let damper = format!("spring = {{ c = {:?} }}", 0.03 * unit);
    let inertia = format!("inertia = {:?}", [1e-3 * unit; 3]);
    let rail = format!("axis = [1, 0, 0]\n{}", begins(unit));
    let text = [
        GROUND,
        &hinge("shaft", "ground", &begins(1.0)),
        &hinge("disc", "shaft", &damper),
        &body_of("disc", 1.0 / unit, &inertia),
        &joint("rail", "prismatic", "ground", &rail),
        &joint("cart", "prismatic", "rail", "axis = [1, 0, 0]"),
        &body_of("cart", 1.0 / unit, ""),
        "[analysis.dynamic]\nto = 1\nstep = 0.1\n",
    ];
    let (mut model, first, options) = motion_of(&text.concat());
    let mut progress = Progress::new(first);
    begin(&mut model, &options, &mut progress).unwrap();
    let disc = model.find("disc").unwrap();
    let state = model.node_state(disc);
    [state.omega.z, state.omega_dot.z]
}

#[test]
fn what_dampers_absorb_does_not_depend_on_units() {
    let in_metres = jerked_with_damper(1.0);
    for unit in [1024.0, 1.0 / 1024.0] {
        let other = jerked_with_damper(unit);
        for (a, b) in in_metres.iter().zip(other) {
            assert_close(*a, b, 1e-9 * (1.0 + a.abs()), unit);
        }
    }
}

/// A five-bar linkage whose crank is jerked at the end of every step, so also where the coordinates of the loop change.
#[test]
fn a_loop_that_changes_its_coordinates_at_a_kink_keeps_its_velocities() {
    let points = (0..=100).map(|k| [k, k + k % 2].map(|k| f64::from(k) * 0.005));
    let points: Vec<[f64; 2]> = points.map(|[t, next]| [t, -0.8 * t - 0.2 * next]).collect();
    let crank = format!("prescribed = {{ table = {points:?} }}");
    let joints = ["B", "C", "D", "E"];
    let [rows, others] = [0, 1].map(|k| {
        let text = [
            five_bar([&crank, "", CLOSURES[k]]),
            "[[loads]]\ngravity = [0, 9.81, 0]\n".to_owned(),
            ["A", "B", "D", "E"].map(body).concat(),
            joints.map(rate).concat(),
            PLAIN.to_owned(),
        ];
        recorded("kinks_five_bar", &text.concat())
    });
    assert!(rows.iter().any(|row| number(row, "chart_changes") > 0.0));
    for (row, other) in rows.iter().zip(&others) {
        for joint in joints {
            let [rate, exact] = [row, other].map(|row| number(row, joint));
            assert_close(rate, exact, 0.01, format_args!("{joint} at {}", row["t"]));
        }
    }
}

/// The probe of the rate of a joint, of its name.
fn rate(joint: &str) -> String {
    probe_of(joint, "joint_rate", &format!("joint = \"{joint}\""))
}

/// A trolley of mass 2 with a bent wire, along which a cart of mass 3 is moved: its momentum stays zero.
#[test]
fn a_cart_that_is_at_a_corner_at_a_kink_moves_the_trolley_as_elsewhere() {
    let cases = [
        (1.0, "[0.1, 0], [0.3, 0.2]", -0.6),
        (1.0, "[0.1, 0], [0.3, -0.2]", 0.36),
        (0.8, "[0, 0], [0.1, 0.2], [0.3, 0.4]", -0.6),
        (0.8, "[0, 0], [0.1, 0.2], [0.3, 0]", 0.36),
    ];
    for (from, table, exact) in cases {
        let cart = format!(
            "[[joints]]\nname = \"cart\"\ntype = \"slide\"\nlines = [\"down\", \"flat\"]\nstart = {from}\n\
             prescribed = {{ table = [{table}] }}\n"
        );
        let text = [
            GROUND,
            "[sections.wire]\nstiffness = { EA = 1, GA = [1, 1], GJ = 1, EI = [1, 1] }\n",
            &joint("trolley", "prismatic", "ground", "axis = [1, 0, 0]"),
            &arm("left", "trolley", [0.0, 0.8, 0.0]),
            &arm("corner", "trolley", [0.6, 0.0, 0.0]),
            &arm("right", "trolley", [1.6, 0.0, 0.0]),
            &beam_line("down", ["left", "corner"], 1, "wire"),
            &beam_line("flat", ["corner", "right"], 1, "wire"),
            &cart,
            &body_of("trolley", 2.0, ""),
            &body_of("cart", 3.0, "inertia = [1, 1, 1]"),
            &rate("trolley"),
            &motion(0.2, 0.01),
            PLAIN,
        ];
        let rows = recorded("kinks_corner", &text.concat());
        let found = number(&rows[rows.len() - 1], "trolley");
        assert_close(found, exact, 1e-9, format_args!("{from} {table}"));
    }
}
