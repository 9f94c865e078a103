//! First-order form, with probes as outputs.

use super::linkages::{closed_by, sprung};
use super::{X, Y, slider};
use crate::support::*;
use nalgebra::{Complex, DMatrix};
use pullback::elements::model::Context;
use pullback::input::{Closure, ModelFile, Time, assemble_text, job};
use pullback::integrators::linearization::{linearize, output_derivatives};
use pullback::manifold::system::Point;

fn pendulum(acts: &str) -> String {
    [
        GROUND,
        &hinge("hinge", "ground", acts),
        &arm("tip", "hinge", [0.0, -2.0, 0.0]),
        &body_of("tip", 1.5, ""),
        "[[loads]]\ngravity = [0, -9.81, 0]\n[inputs]\ntorque = 0.0\n\
         [analysis.dynamic]\nto = 0.01\nstep = 0.01\n",
        &(probe("tip x", "acceleration", "tip") + "component = \"x\"\n"),
        "[[probes]]\nname = \"tension\"\nquantity = \"joint_force\"\njoint = \"hinge\"\ncomponent = \"y\"\n\
         [[probes]]\nname = \"energy\"\nquantity = \"kinetic_energy\"\n",
        &angle("hinge"),
    ]
    .concat()
}

/// m l² θ̈ = −m g l θ − c θ̇ + u; the tip is at x = l θ. About a state of a motion, and about an equilibrium.
#[test]
fn a_pendulum_with_a_motor() {
    let acts = "actuator = { input = \"torque\" }\nspring = { k = 0, c = 0.3 }";
    let moving = pendulum(acts);
    let at_rest = moving
        .replace("dynamic]\nto = 0.01\nstep = 0.01", "modes]")
        .replace("-9.81, 0]", "-9.81, 0]\ntime = { constant = 1 }");
    for (text, at) in [(moving, "--at 0.01"), (at_rest, "")] {
        let out = directory("state_space");
        write(&out, &text);
        printed(&out, &format!("linearize model.toml --first-order {at}"));
        let of = |name: &str| matrix(&out.join("model.linear").join(name));
        let (m, g, l, c) = (1.5, 9.81, 2.0, 0.3);
        let (k, c, b) = (g / l, c / (m * l * l), 1.0 / (m * l * l));
        let names = read(out.join("model.linear/outputs.txt"));
        assert_eq!(names, "tip x\ntension\nenergy\nhinge\n");
        assert_eq!(read(out.join("model.linear/inputs.txt")), "torque\n");
        let C = [-k * l, -c * l, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        for (name, rows, exact) in [
            ("state_A.mtx", 2, &[0.0, 1.0, -k, -c][..]),
            ("state_B.mtx", 2, &[0.0, b]),
            ("state_C.mtx", 4, &C),
            ("state_D.mtx", 4, &[b * l, 0.0, 0.0, 0.0]),
        ] {
            let (found, columns) = (of(name), exact.len() / rows);
            let exact = DMatrix::from_row_slice(rows, columns, exact);
            assert_eq!(found.shape(), exact.shape(), "{name}");
            assert!((&found - &exact).amax() < 1e-9, "{name}: {found} {exact}");
        }
    }
}

/// Two springs between two masses on a line, one stretched and one compressed, nearly in balance. A force that is an input,
/// and zero, does not change what counts as balance.
#[test]
fn inputs_leave_balance_as_it_is() {
    let parts = ["a", "b"].map(|name| {
        let rail = format!("[[supports]]\nnode = \"{name}\"\nfix = [\"y\", \"z\"]\n");
        body_of(name, 1.0, "") + &rail
    });
    let springs = [("pulls", 0.9), ("pushes", 1.1)].map(|(name, length)| {
        format!(
            "[[springs]]\nname = \"{name}\"\nnodes = [\"a\", \"b\"]\nstiffness = 1e6\nrest_length = {length}\n"
        )
    });
    let text = [
        "[nodes]\na = [0, 0, 0]\nb = [1, 0, 0]\n[inputs]\npush = 0.0\n",
        &parts.concat(),
        &springs.concat(),
        "[[loads]]\nnode = \"a\"\nforce = [1, 0, 0]\ntime = { input = \"push\" }\n[analysis.modes]\n",
    ];
    let mut context = assemble_text("model.toml", &text.concat()).unwrap().context;
    let lin = linearize(&mut context, Point::statics(0.0, &[1e-9, 0.0])).unwrap();
    assert!((lin.r_u[0][0] - 1.0).abs() < 1e-6, "{:?}", lin.r_u);
}

#[test]
fn times_that_a_motion_does_not_pass_are_refused() {
    let out = directory("state_at");
    write(&out, &pendulum("actuator = { input = \"torque\" }"));
    for (at, why) in [
        ("nan", "the load or time must be finite"),
        ("-1", "the motion begins later"),
    ] {
        let ran = program_in(&out, &format!("linearize model.toml --at {at}"));
        assert_says(&ended(&ran, 2), &["--at", why]);
    }
}

#[test]
fn inputs_that_prescribe_a_motion_are_warned_of() {
    for (acts, warned) in [
        ("actuator = { input = \"torque\" }", false),
        ("prescribed = { input = \"torque\" }", true),
    ] {
        let out = directory("state_prescribed");
        let text = pendulum(acts).replace("dynamic]\nto = 0.01\nstep = 0.01", "modes]");
        let free = [hinge("free", "ground", "spring = { k = 1 }"), body("free")];
        write(&out, &[text, free.concat()].concat());
        let said = succeeded(&program_in(&out, "linearize model.toml"));
        let warning = "input torque prescribes a motion";
        assert_eq!(said.contains(warning), warned, "{said}");
    }
}

#[test]
fn bad_inputs_and_missing_masses_are_refused() {
    let refused = |text: &str, code: i32, words: &[&str]| {
        let out = directory("state_refused");
        write(&out, text);
        let output = program_in(&out, "linearize model.toml --first-order");
        assert_says(&ended(&output, code), words);
    };
    let unknown = pendulum("actuator = { input = \"torqe\" }");
    refused(&unknown, 2, &["torqe", "torque"]);
    let massless = GROUND.replace("[[", "light = [1, 0, 0]\n[[")
        + "[[springs]]\nname = \"spring\"\nnodes = [\"ground\", \"light\"]\nstiffness = 1\n\
           [[supports]]\nnode = \"light\"\nfix = [\"y\", \"z\"]\n[analysis.modes]\n";
    let words = "node light, displacement along e1 moves without inertia";
    refused(&massless, 1, &[words]);
}

/// D + C (s − A)⁻¹ B of a motor in the first joint and the positions, velocities and accelerations of a node.
fn transfer(
    file: &ModelFile,
    closure: Option<Closure>,
    node: &str,
    s: Complex<f64>,
) -> Vec<Complex<f64>> {
    let mut file = closed_by(file, closure, None);
    file.inputs.insert("torque".to_owned(), 0.0);
    file.joints[0].actuator = Some(Time::Input("torque".to_owned()));
    let mut job = job("linkage", &file, None).unwrap();
    let q = job.context.initial().to_vec();
    let at = Point::statics(0.0, &q);
    let lin = linearize(&mut job.context, at).unwrap();
    let node = job.context.find(node).unwrap();
    let outputs = output_derivatives(&mut job.context, at, |context: &mut Context, _| {
        let state = context.node_state(node);
        let parts = [state.position, state.velocity, state.acceleration];
        Ok(parts.iter().flat_map(|x| [x.x, x.y]).collect())
    });
    // Derivatives of a position by multipliers and velocities are rounding errors alone.
    let position = output_derivatives(&mut job.context, at, |context: &mut Context, _| {
        Ok(vec![context.node_state(node).position.x])
    });
    lin.state_space(&position.unwrap()).unwrap();
    let space = lin.state_space(&outputs.unwrap()).unwrap();
    let n = space.A.nrows();
    let complex = |A: &DMatrix<f64>| A.map(|x| Complex::new(x, 0.0));
    let shifted = DMatrix::identity(n, n) * s - complex(&space.A);
    let x = shifted.lu().solve(&complex(&space.B)).unwrap();
    let y = complex(&space.C) * x + complex(&space.D);
    y.column(0).iter().copied().collect()
}

#[test]
fn transfer_functions_by_map_and_multipliers() {
    for (name, node) in [("four_bar", "tip"), ("slider_crank", "pin")] {
        let file = sprung(name);
        let nodes: Vec<_> = file.joints.iter().map(|j| j.name.clone()).collect();
        let node = nodes.iter().find(|n| *n == node).unwrap_or(&nodes[1]);
        let s = Complex::new(0.3, 2.1);
        let map = transfer(&file, None, node, s);
        let multipliers = transfer(&file, Some(Closure::Multipliers), node, s);
        let size = map.iter().fold(0.0_f64, |most, y| most.max(y.norm()));
        assert!(size > 0.0, "{name}: nothing moves");
        for (k, (a, b)) in map.iter().zip(&multipliers).enumerate() {
            assert!((a - b).norm() < 1e-8 * size, "{name} {k}: {a} {b}");
        }
        // Velocities are s times positions, accelerations s times velocities.
        for k in 0..4 {
            assert!((map[k + 2] - s * map[k]).norm() < 1e-8 * size, "{name} {k}");
        }
    }
}

/// Seen from a frame that rotates, a mass on equal springs has other poles, and a force along a fixed axis rotates.
#[test]
fn first_order_forms_of_what_does_not_rotate_are_refused() {
    let text = |more: &str| {
        [
            "[inputs]\nside = 0\n",
            GROUND,
            &hinge("hub", "ground", ""),
            &slider("rad", "hub", X, 400.0, 0.0),
            &slider("tan", "rad", Y, 400.0, 0.0),
            &body_of("tan", 1.0, ""),
            "[analysis.campbell]\njoint = \"hub\"\nto = 5\ncount = 2\n",
            more,
        ]
        .concat()
    };
    let force = "[[loads]]\nnode = \"tan\"\nforce = [1, 0, 0]\ntime = { input = \"side\" }\n";
    let of_node = &(probe("x", "displacement", "tan") + "component = \"x\"\n");
    let follower = changed(force, "time = => follower = true\\ntime =");
    let of_joint = &angle("rad");
    let out = directory("campbell_fixed");
    for (force, probe, fixed) in [
        (force, of_joint, true),
        (&follower, of_node, true),
        (&follower, of_joint, false),
    ] {
        write(&out, &text(&[force, probe].concat()));
        let ran = program_in(&out, "linearize model.toml --first-order");
        match fixed {
            true => assert_says(&ended(&ran, 2), &["inputs and outputs that rotate"]),
            false => drop(succeeded(&ran)),
        }
    }
}
