//! What the program says about motions that are not what they seem.
#![allow(clippy::unwrap_used)]

use crate::support::program::{refusal, told};
use nalgebra::Vector3;
use pullback::input::assemble_text;
use pullback::manifold::system::Point;

/// Notes and warnings of a short run of a model on a held ground.
fn said(name: &str, rest: &str) -> [Vec<String>; 2] {
    let text = format!(
        "[nodes]\nground = [0, 0, 0]\ntip = [1, 0, 0]\n{rest}\n[analysis.dynamic]\nto = 0.02\n\
         step = 0.01\n\n[output]\nfigures = false\nparaview_every = 0\n"
    );
    told(&format!("hints_{name}"), &text)
}

/// Whether a line begins so.
fn any(lines: &[String], start: &str) -> bool {
    lines.iter().any(|line| line.starts_with(start))
}

const HELD: &str = "[[supports]]\nnode = \"ground\"\nfix = \"all\"\n";

fn joint(kind: &str, more: &str) -> String {
    format!(
        "[[joints]]\nname = \"J\"\ntype = \"{kind}\"\nparent = \"ground\"\naxis = [0, 0, 1]\n{more}\n"
    )
}

const BODY: &str =
    "[[bodies]]\nname = \"b\"\nnode = \"J\"\nmass = 1\ncenter = [1, 0, 0]\ninertia = [1, 1, 1]\n";

const LINE: &str = "[sections.s]\nstiffness = { EA = 1e3, GA = [1e3, 1e3], GJ = 1, EI = [1, 1] }\n\
    mass = { A_rho = 1, J = [0.1, 0.1, 0.1] }\n[[lines]]\nname = \"L\"\nfrom = \"J\"\n\
    to = \"tip\"\nelements = 2\nsection = \"s\"\n";

#[test]
fn what_hangs_on_a_base_that_is_driven_from_the_start_moves_along() {
    let base = "[[supports]]\nnode = \"ground\"\nfix = [\"x\", \"y\", \"rx\", \"ry\", \"rz\"]\n\
                prescribed = { z = { sine = { amplitude = 0.1, omega = 2 } } }\n";
    let sprung = joint("prismatic", "spring = { k = 4 }");
    let lost = "[[bodies]]\nname = \"t\"\nnode = \"tip\"\nmass = 1\ninertia = [1, 1, 1]\n";
    let [notes, _] = said("carried", &[base, &sprung, BODY, lost].concat());
    let note = "support of ground is prescribed with a velocity just before t = 0: what is attached to it by J";
    assert!(any(&notes, note), "{notes:?}");
    // What the note advises is done: nothing hangs about.
    let rest = "[[initial]]\nvelocity = [0, 0, 0]\n";
    let [notes, _] = said("at_rest", &[base, &sprung, BODY, lost, rest].concat());
    assert!(!any(&notes, note), "{notes:?}");
}

#[test]
fn a_line_does_not_start_with_the_rate_of_its_joint() {
    let whole = |more: &str| [HELD, &joint("revolute", "rate = 3"), LINE, more].concat();
    let warning = "joint J starts with a rate, and the rest of line L at rest";
    let [_, warnings] = said("left", &whole(""));
    assert!(any(&warnings, warning), "{warnings:?}");
    let all = "[[initial]]\nline = \"L\"\nangular_velocity = [0, 0, 3]\n";
    let [_, warnings] = said("taken", &whole(all));
    assert!(!any(&warnings, warning), "{warnings:?}");
}

#[test]
fn what_ball_joints_hold_starts_with_the_value_above_them() {
    let offset = |name: &str, parent: &str, position: [f64; 3]| {
        format!(
            "[[joints]]\nname = \"{name}\"\ntype = \"offset\"\nparent = \"{parent}\"\nposition = {position:?}\n"
        )
    };
    let ball = |name: &str, parent: &str| {
        format!("[[joints]]\nname = \"{name}\"\ntype = \"spherical\"\nparent = \"{parent}\"\n")
    };
    let drawn = [[2.0, 0.0, 0.0], [3.0, 1.0, 0.5]];
    let chain = |value: f64, scheme: &str, more: &str| {
        let run = format!("[analysis.dynamic]\nto = 0.01\nstep = 0.01\nscheme = \"{scheme}\"\n");
        [
            "[nodes]\nground = [0, 0, 0]\ntip = [4, 0, 0]\n",
            HELD,
            &joint("revolute", &format!("value = {value}")),
            &offset("a", "J", [1.0, 0.0, 0.0]),
            &ball("S", "a"),
            &offset("e", "S", drawn[0]),
            &ball("T", "e"),
            &offset("f", "T", drawn[1]),
            &BODY.replace("\"J\"", "\"f\""),
            more,
            &run,
        ]
        .concat()
    };
    let ends = |text: &str| {
        let mut job = assemble_text("model.toml", text).unwrap();
        let (t, q, v, a) = (
            0.0,
            &job.start.q,
            &job.start.v,
            vec![0.0; job.start.q.len()],
        );
        job.context.configure(Point { t, q, v, a: &a }).unwrap();
        ["e", "f"].map(|n| {
            job.context
                .node_state(job.context.find(n).unwrap())
                .position
        })
    };
    for (value, scheme) in [
        (0.5_f64, "newmark"),
        (4.0, "newmark"),
        (0.5, "lie-newmark"),
        (4.0, "ul-newmark"),
    ] {
        let (sin, cos) = value.sin_cos();
        for (found, [x, y, z]) in ends(&chain(value, scheme, LINE_ELSEWHERE))
            .iter()
            .zip(drawn)
        {
            let exact = Vector3::new(cos * x - sin * y, sin * x + cos * y, z);
            assert!((found - exact).norm() < 1e-14, "{value} {scheme}: {found}");
        }
    }
    // A rotation that is given is one in space, and carries what hangs below.
    let given = "[[initial]]\nnode = \"S\"\nrotation = [0, 0, 1.5707963267948966]\n";
    let [e, f] = ends(&chain(0.5, "newmark", &[LINE_ELSEWHERE, given].concat()));
    let a = Vector3::new(0.5_f64.cos(), 0.5_f64.sin(), 0.0);
    assert!((e - a - Vector3::new(0.0, 1.0, 0.0)).norm() < 1e-14, "{e}");
    assert!((f - e - Vector3::new(-1.0, 1.0, 0.5)).norm() < 1e-14, "{f}");
    // A line from there ends where it is drawn.
    let line = LINE.replace("\"J\"", "\"f\"");
    let said = refusal(&chain(0.5, "newmark", &line)).to_string();
    assert!(
        said.contains("line \"L\" is drawn from node \"f\""),
        "{said}"
    );
    let straight = chain(0.0, "newmark", &line);
    assert!(assemble_text("model.toml", &straight).is_ok());
}

#[test]
fn a_mass_without_inertia_about_the_line_to_it_is_named() {
    let pendulum = |inertia: &str| {
        let ball = joint("spherical", "").replace("axis = [0, 0, 1]\n", "");
        let body = BODY.replace("center = [1, 0, 0]", "center = [0.6, 0.1, -0.8]");
        [
            HELD,
            &ball,
            &body.replace("inertia = [1, 1, 1]\n", inertia),
            LINE_ELSEWHERE,
            WEIGHT,
        ]
        .concat()
    };
    let about = |warnings: &[String]| warnings.iter().any(|w| w.contains("others of its node"));
    let [_, warnings] = said("point", &pendulum(""));
    assert!(about(&warnings), "{warnings:?}");
    let [_, warnings] = said("rod", &pendulum("inertia = [1e-6, 1e-6, 1e-6]\n"));
    assert!(!about(&warnings), "{warnings:?}");
}

const WEIGHT: &str = "[[loads]]\ngravity = [0, 0, -9.81]\n";

/// A body that has nothing to do with the rest, at the other node.
const LINE_ELSEWHERE: &str =
    "[[bodies]]\nname = \"t\"\nnode = \"tip\"\nmass = 1\ninertia = [1, 1, 1]\n";

#[test]
fn a_joint_is_let_go_with_its_spring_tight_without_a_warning() {
    let let_go = joint("revolute", "value = 0.5\nspring = { k = 100, x0 = 0.1 }");
    let [_, warnings] = said("let_go", &[HELD, &let_go, BODY, LINE_ELSEWHERE].concat());
    assert!(warnings.is_empty(), "{warnings:?}");
    // A line that is strained at the start is another matter.
    let held = "[[supports]]\nnode = \"tip\"\nfix = \"all\"\n";
    let [_, warnings] = said("strained", &[HELD, &let_go, LINE, held].concat());
    let about = "joint J is not where the model is drawn";
    assert!(any(&warnings, about), "{warnings:?}");
}

#[test]
fn a_motion_in_which_nothing_moves_is_said_to_be_one() {
    let [_, warnings] = said(
        "idle",
        &[HELD, &joint("revolute", ""), BODY, LINE_ELSEWHERE].concat(),
    );
    assert!(warnings[0].starts_with("nothing moves"), "{warnings:?}");
    let push = "[[loads]]\nnode = \"J\"\nforce = [0, 1, 0]\n";
    let [_, warnings] = said(
        "moving",
        &[
            HELD,
            &joint("prismatic", ""),
            BODY,
            LINE_ELSEWHERE,
            &push.replace("0, 1, 0", "0, 0, 1"),
        ]
        .concat(),
    );
    assert!(warnings.is_empty(), "{warnings:?}");
}

/// A point mass that passes the right angle of a universal joint, near and not so near.
#[test]
fn an_angle_that_steps_do_not_resolve_is_named() {
    let passing = |rate: f64, step: f64| {
        format!(
            "[nodes]\nground = [0, 0, 0]\n{HELD}[[joints]]\nname = \"cross\"\ntype = \"universal\"\n\
             parent = \"ground\"\naxis = [1, 0, 0]\nsecond_axis = [0, 1, 0]\ncoordinates = {{ \
             \"angle 1\" = {{ rate = {rate} }}, \"angle 2\" = {{ value = 1.2, rate = 2 }} }}\n\
             [[bodies]]\nname = \"bob\"\nnode = \"cross\"\nmass = 1\ncenter = [0, 0, -1]\n\
             [analysis.dynamic]\nto = 0.4\nstep = {step}\n[output]\nfigures = false\n\
             paraview_every = 0\n"
        )
    };
    let said = |rate: f64, step: f64| {
        let [_, warnings] = told("hints_turn", &passing(rate, step));
        warnings.into_iter().find(|w| w.contains("steps do not"))
    };
    // It passes at t = (π/2 − 1.2)/2.
    for (rate, step) in [(0.003, 1e-3), (0.03, 2e-3)] {
        let warning = said(rate, step).unwrap();
        let name = "the rate of cross angle 1 changes by ";
        assert!(warning.starts_with(name), "{warning}");
        assert!(warning.contains("(that to t = 0.18"), "{warning}");
    }
    // Where the steps are small enough there is nothing to say.
    assert_eq!(said(1.0, 1e-3), None);
}

#[test]
fn words_of_other_programs_are_understood_in_refusals() {
    let text = |joint_more: &str, scheme: &str, quantity: &str| {
        format!(
            "[nodes]\nground = [0, 0, 0]\n{HELD}{}{BODY}[analysis.dynamic]\nto = 1\nstep = 0.01\n\
             scheme = {scheme}\n[[probes]]\nname = \"p\"\nquantity = \"{quantity}\"\njoint = \"J\"\n",
            joint("revolute", joint_more)
        )
    };
    let fine = ("\"ga:0.9\"", "joint_coordinate");
    for (more, scheme, quantity, advice) in [
        ("value_deg = 30", fine.0, fine.1, "give `value`, in radians"),
        (
            "",
            "{ generalised-alpha = { rho = 0.8 } }",
            fine.1,
            "{ generalised-alpha = 0.9 }",
        ),
        (
            "",
            fine.0,
            "joint_angle",
            "did you mean `joint_coordinate`?",
        ),
    ] {
        let error = refusal(&text(more, scheme, quantity));
        let help = error.problem.advice();
        let said = format!("{error} {}", help.unwrap_or_default());
        assert!(said.contains(advice), "{said}");
    }
}
