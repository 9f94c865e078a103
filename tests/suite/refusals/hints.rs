//! What the program says about motions that are not what they seem.

use crate::support::*;
use nalgebra::Vector3;
use pullback::input::assemble_text;

/// Notes and warnings of a short run of a model with a ground and a tip.
fn said(name: &str, parts: &[&str]) -> [Vec<String>; 2] {
    let nodes = "[nodes]\nground = [0, 0, 0]\ntip = [1, 0, 0]\n";
    let text = [nodes, &parts.concat(), &motion(0.02, 0.01), PLAIN];
    told(&format!("hints_{name}"), &text.concat())
}

/// Whether a line is told that begins so, or not.
#[track_caller]
fn assert_told(lines: &[String], start: &str, told: bool) {
    let any = lines.iter().any(|line| line.starts_with(start));
    assert_eq!(any, told, "{start:?}: {lines:?}");
}

fn held() -> String {
    fixed("ground")
}

/// The joint J on the ground with a body whose centre of mass is beside it.
fn swing(joint: &str) -> String {
    joint.to_owned() + &body_of("J", 1.0, CENTER)
}

const CENTER: &str = "center = [1, 0, 0]\ninertia = [1, 1, 1]";

fn slider(more: &str) -> String {
    let axis = format!("axis = [0, 0, 1]\n{more}");
    joint("J", "prismatic", "ground", &axis)
}

/// A line from a node to the tip.
fn line(from: &str) -> String {
    let section = "[sections.s]\nstiffness = { EA = 1e3, GA = [1e3, 1e3], GJ = 1, EI = [1, 1] }\n\
                   mass = { A_rho = 1, J = [0.1, 0.1, 0.1] }\n";
    section.to_owned() + &beam_line("L", [from, "tip"], 2, "s")
}

#[test]
fn what_hangs_on_a_base_that_is_driven_from_the_start_moves_along() {
    let base = "[[supports]]\nnode = \"ground\"\nfix = [\"x\", \"y\", \"rx\", \"ry\", \"rz\"]\n\
                prescribed = { z = { sine = { amplitude = 0.1, omega = 2 } } }\n";
    let sprung = swing(&slider("spring = { k = 4 }"));
    let note = "support of ground is prescribed with a velocity just before t = 0: what is attached to it by J";
    // What the note advises is done: nothing hangs about.
    for (rest, told) in [("", true), ("[[initial]]\nvelocity = [0, 0, 0]\n", false)] {
        let [notes, _] = said("carried", &[base, &sprung, &body("tip"), rest]);
        assert_told(&notes, note, told);
    }
}

#[test]
fn a_line_does_not_start_with_the_rate_of_its_joint() {
    let all = "[[initial]]\nline = \"L\"\nangular_velocity = [0, 0, 3]\n";
    let turning = hinge("J", "ground", "rate = 3");
    // The joint that turns may be further inside.
    let outer = [arm("a", "J", [0.5, 0.0, 0.0]), hinge("H", "a", "")].concat();
    let inner = [&*turning, &outer, &line("H")].concat();
    let own = [&*turning, &line("J")].concat();
    for (name, joints, more, told) in [
        ("left", &own, "", Some("J")),
        ("taken", &own, all, None),
        ("inner", &inner, "", Some("H")),
    ] {
        let [_, warnings] = said(name, &[&held(), joints, more]);
        let warning = format!(
            "line L starts at rest but for its end at {}",
            told.unwrap_or("")
        );
        assert_told(&warnings, &warning, told.is_some());
    }
}

#[test]
fn what_ball_joints_hold_starts_with_the_value_above_them() {
    let drawn = [[2.0, 0.0, 0.0], [3.0, 1.0, 0.5]];
    let chain = |value: f64, scheme: &str, more: &[&str]| {
        [
            "[nodes]\nground = [0, 0, 0]\ntip = [4, 0, 0]\n",
            &held(),
            &hinge("J", "ground", &format!("value = {value}")),
            &arm("a", "J", [1.0, 0.0, 0.0]),
            &joint("S", "spherical", "a", ""),
            &arm("e", "S", drawn[0]),
            &joint("T", "spherical", "e", ""),
            &arm("f", "T", drawn[1]),
            &body_of("f", 1.0, CENTER),
            &more.concat(),
            &motion(0.01, 0.01),
            &format!("scheme = \"{scheme}\"\n"),
        ]
        .concat()
    };
    let ends = |text: &str| {
        let context = started(text).context;
        ["e", "f"].map(|n| context.node_state(context.find(n).unwrap()).position)
    };
    for (value, scheme) in [
        (0.5_f64, "newmark"),
        (4.0, "newmark"),
        (0.5, "lie-newmark"),
        (4.0, "ul-newmark"),
    ] {
        let (sin, cos) = value.sin_cos();
        let found = ends(&chain(value, scheme, &[&body("tip")]));
        for (found, [x, y, z]) in found.iter().zip(drawn) {
            let exact = Vector3::new(cos * x - sin * y, sin * x + cos * y, z);
            assert!((found - exact).norm() < 1e-14, "{value} {scheme}: {found}");
        }
    }
    // A rotation that is given is one in space, and carries what hangs below.
    let given = "[[initial]]\nnode = \"S\"\nrotation = [0, 0, 1.5707963267948966]\n";
    let [e, f] = ends(&chain(0.5, "newmark", &[&body("tip"), given]));
    let a = Vector3::new(0.5_f64.cos(), 0.5_f64.sin(), 0.0);
    assert!((e - a - Vector3::new(0.0, 1.0, 0.0)).norm() < 1e-14, "{e}");
    assert!((f - e - Vector3::new(-1.0, 1.0, 0.5)).norm() < 1e-14, "{f}");
    // A line from there ends where it is drawn.
    let said = refusal(&chain(0.5, "newmark", &[&line("f")])).to_string();
    assert_says(&said, &["line \"L\" is drawn from node \"f\""]);
    let straight = chain(0.0, "newmark", &[&line("f")]);
    assert!(assemble_text("model.toml", &straight).is_ok());
}

#[test]
fn a_mass_without_inertia_about_the_line_to_it_is_named() {
    let ball = joint("J", "spherical", "ground", "");
    for (inertia, told) in [("", true), ("inertia = [1e-6, 1e-6, 1e-6]", false)] {
        let mass = body_of("J", 1.0, &format!("center = [0.6, 0.1, -0.8]\n{inertia}"));
        let [_, warnings] = said("point", &[&held(), &ball, &mass, &body("tip"), GRAVITY]);
        let found = warnings.iter().any(|w| w.contains("others of its node"));
        assert_eq!(found, told, "{warnings:?}");
    }
}

#[test]
fn a_joint_is_let_go_with_its_spring_tight_without_a_warning() {
    let let_go = hinge("J", "ground", "value = 0.5\nspring = { k = 100, x0 = 0.1 }");
    let [_, warnings] = said("let_go", &[&held(), &swing(&let_go), &body("tip")]);
    assert!(warnings.is_empty(), "{warnings:?}");
    // A line that is strained at the start is another matter.
    let about = "joint J is not where the model is drawn";
    let driven = hinge("J", "ground", "prescribed = { constant = 0.1 }");
    let keys = "axis = [0, 0, 1]\nsecond_axis = [0, 1, 0]\ncoordinates = { \"angle 1\" = { value = 0.1 } }";
    let one_of_two = joint("J", "universal", "ground", keys);
    for joint in [let_go, driven, one_of_two] {
        let [_, warnings] = said("strained", &[&held(), &joint, &line("J"), &fixed("tip")]);
        assert_told(&warnings, about, true);
    }
    // A motion that begins there, and a spring that is tight as drawn.
    let swings = hinge("J", "ground", "prescribed = { sine = { omega = 2 } }");
    let tight =
        "[[springs]]\nname = \"s\"\nnodes = [\"J\", \"tip\"]\nstiffness = 10\nrest_length = 0.5\n";
    let [_, warnings] = said(
        "tight",
        &[&held(), &swings, tight, &body("J"), &body("tip")],
    );
    assert_told(&warnings, about, false);
}

#[test]
fn a_motion_in_which_nothing_moves_is_said_to_be_one() {
    let idle = swing(&hinge("J", "ground", ""));
    let [_, warnings] = said("idle", &[&held(), &idle, &body("tip")]);
    assert!(
        warnings[0].starts_with("nothing with mass or stiffness moves"),
        "{warnings:?}"
    );
    let push = "[[loads]]\nnode = \"J\"\nforce = [0, 0, 1]\n";
    let moving = swing(&slider(""));
    let [_, warnings] = said("moving", &[&held(), &moving, &body("tip"), push]);
    assert!(warnings.is_empty(), "{warnings:?}");
}

/// A point mass that passes the right angle of a universal joint, near and not so near.
#[test]
fn an_angle_that_steps_do_not_resolve_is_named() {
    let said = |rate: f64, step: f64| {
        let coordinates = format!(
            "axis = [1, 0, 0]\nsecond_axis = [0, 1, 0]\ncoordinates = {{ \
             \"angle 1\" = {{ rate = {rate} }}, \"angle 2\" = {{ value = 1.2, rate = 2 }} }}"
        );
        let text = [
            GROUND,
            &joint("cross", "universal", "ground", &coordinates),
            &body_of("cross", 1.0, "center = [0, 0, -1]"),
            &motion(0.4, step),
            PLAIN,
        ];
        let [_, warnings] = told("hints_turn", &text.concat());
        warnings.into_iter().find(|w| w.contains("steps do not"))
    };
    // It passes at t = (π/2 − 1.2)/2.
    for (rate, step) in [(0.003, 1e-3), (0.03, 2e-3)] {
        let warning = said(rate, step).unwrap();
        let named = warning.starts_with("the rate of cross angle 1 changes by ");
        assert!(named, "{warning}");
        assert_says(&warning, &["(that to t = 0.18"]);
    }
    // Where the steps are small enough there is nothing to say.
    assert_eq!(said(1.0, 1e-3), None);
}

#[test]
fn an_angle_may_jump_with_what_is_prescribed() {
    // What hangs on the base stays where it is, and its angle goes back as fast as the base turns.
    let turn = "prescribed = { table = [[0, 0], [0.01, 0], [1, 25]] }";
    let joints = [hinge("J", "ground", turn), hinge("H", "J", ""), body("H")].concat();
    let [_, warnings] = told(
        "hints_jump",
        &[GROUND, &joints, &motion(0.02, 0.01), PLAIN].concat(),
    );
    assert_told(&warnings, "the rate of H", false);
}

#[test]
fn words_of_other_programs_are_understood_in_refusals() {
    let model = [
        GROUND,
        &hinge("J", "ground", "rate = 1"),
        &body_of("J", 1.0, CENTER),
        &motion(1.0, 0.01),
        "scheme = \"ga:0.9\"\n",
        &angle("J"),
    ]
    .concat();
    check_table(
        &model,
        refusal,
        r#"
rate = 1 => value_deg = 30 | value_deg | | give `value`, in radians
"ga:0.9" => { generalised-alpha = { rho = 0.8 } } | | { generalised-alpha = 0.9 }
joint_coordinate => joint_angle | | | did you mean `joint_coordinate`?
"#,
    );
}
