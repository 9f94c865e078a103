//! What a run in time tells of its energy, and small forces beside large ones, against closed forms.
#![allow(clippy::unwrap_used)]

use crate::support::program::{
    directory, ended, history, number, program, results, succeeded, write,
};
use std::path::{Path, PathBuf};

/// A point mass on an arm of length 1 that turns about e₂ and starts along e₁.
fn arm(name: &str, turns: &str, more: &str, analysis: &str) -> (Vec<[f64; 2]>, String) {
    let text = format!(
        "[nodes]\nground = [0, 0, 0]\n\n\
         [[joints]]\nname = \"arm\"\ntype = \"revolute\"\naxis = [0, 1, 0]\n{turns}\n\n\
         [[joints]]\nname = \"end\"\ntype = \"offset\"\nparent = \"arm\"\nposition = [1, 0, 0]\n\n\
         [[bodies]]\nname = \"mass\"\nnode = \"end\"\nmass = 1\n\n\
         [[supports]]\nnode = \"ground\"\nfix = \"all\"\n\n{more}\n\n\
         [analysis.dynamic]\n{analysis}\n\n[output]\nfigures = false\nparaview_every = 0\n\n\
         [[probes]]\nname = \"rate\"\nquantity = \"joint_rate\"\njoint = \"arm\"\n"
    );
    let directory = directory(&format!("program_balance_{name}"));
    let output = program(&[&write(&directory, &text)]);
    let said = [output.stdout, output.stderr].map(|s| String::from_utf8_lossy(&s).into_owned());
    let said = said.concat();
    assert!(output.status.success(), "{said}");
    // What the terminal warns of stands in result.json.
    let told = results(&directory.join("model.out"))["warnings"].to_string();
    let doubt = "much compared";
    assert_eq!(told.contains(doubt), said.contains(doubt), "{told}\n{said}");
    let rows = history(&directory.join("model.out"));
    let numbers = |row| ["rate", "energy_defect"].map(|column| number(row, column));
    (rows.iter().map(numbers).collect(), said)
}

const GRAVITY: &str = "[[loads]]\ngravity = [0, 0, -9.81]";

#[test]
fn the_work_of_gravity_is_what_it_has_lost_of_its_potential() {
    // A scheme that keeps the energy has no defect at steps of a twentieth of the period.
    let parent = "parent = \"ground\"";
    let (rows, said) = arm(
        "kept",
        parent,
        GRAVITY,
        "to = 20\nstep = 0.1\nscheme = \"projected-newmark\"",
    );
    let worst = rows.iter().map(|r| r[1].abs()).fold(0.0, f64::max);
    assert!(worst < 1e-12, "{worst:e}");
    assert!(!said.contains("much compared"), "{said}");
    // Steps far beyond the limit of an explicit one: more energy than gravity has.
    let wild = "to = 100\nstep = 1\nscheme = \"central-difference\"";
    let (_, said) = arm("wild", parent, GRAVITY, wild);
    assert!(said.contains("much compared"), "{said}");
}

#[test]
fn a_model_that_is_unstable_itself_is_told_so() {
    // x = 0.01 cosh(√1000 t) is beyond the largest number before t = 23, and its energy before 12.
    let text = "[nodes]\nground = [0, 0, 0]\n\n[[joints]]\nname = \"slide\"\ntype = \"prismatic\"\n\
                parent = \"ground\"\naxis = [1, 0, 0]\nspring = { k = -1000 }\nvalue = 0.01\n\n\
                [[bodies]]\nname = \"mass\"\nnode = \"slide\"\nmass = 1\n\n\
                [[supports]]\nnode = \"ground\"\nfix = \"all\"\n\n\
                [analysis.dynamic]\nto = 100\nstep = 0.01\n\n[output]\nfigures = false\nparaview_every = 0\n";
    let output = program(&[&write(&directory("program_balance_pushed"), text)]);
    let said = ended(&output, 1);
    let told = "its energy is beyond all numbers";
    assert!(said.contains(told) && said.contains("stiffness"), "{said}");
    assert!(!said.contains("NaN") && !said.contains("inf "), "{said}");
}

#[test]
fn a_small_motor_drives_a_fast_rotor() {
    // One radian per second more after one second, beside a centrifugal force of 1e10.
    let turns = "parent = \"ground\"\nrate = 1e5\nactuator = { constant = 1 }";
    let (rows, _) = arm("rotor", turns, "", "to = 1\nstep = 0.01");
    let [rate, _] = rows[rows.len() - 1];
    assert!((rate - 100_001.0).abs() < 1e-6, "{rate}");
}

#[test]
fn a_motion_with_hardly_any_energy_is_not_unstable() {
    // A slider pushes the pivot across the arm: this turns about its mass, which hardly moves at first.
    let slider = "[[joints]]\nname = \"slider\"\ntype = \"prismatic\"\nparent = \"ground\"\n\
                  axis = [0, 0, 1]\nprescribed = { spin_up = { rate = 1, duration = 0.5 } }";
    let (rows, said) = arm("push", "parent = \"slider\"", slider, "to = 1\nstep = 0.01");
    assert_eq!(rows.len(), 101, "{said}");
}

/// The defect of the balance of energy over the work done, what the run said, and its results.
fn defect(name: &str, text: &str) -> (f64, String, PathBuf) {
    let directory = directory(&format!("program_balance_{name}"));
    let output = program(&[&write(&directory, text)]);
    let said = succeeded(&output);
    let out = directory.join("model.out");
    let energy = &results(&out)["statistics"]["energy"];
    let [defect, gross] = ["largest_defect", "gross"].map(|key| energy[key].as_f64().unwrap());
    assert!(gross > 0.0, "{energy}");
    (defect / gross, said, out)
}

const PLAIN: &str = "\n[output]\nfigures = false\nparaview_every = 0\n";

/// A linear system: the work of the trapezoidal rule is that of mean forces on displacements, whatever its steps
/// leave unresolved.
#[test]
fn work_is_exact_of_waves_that_steps_do_not_resolve() {
    // Waves pass an element in a tenth of a step.
    let bar = "[sections.bar]\nstiffness = { EA = 1e8, GA = [1e8, 1e8], GJ = 1, EI = [1, 1] }\n\
        mass = { A_rho = 1, J = [1, 1, 1] }\n\n[nodes]\nleft = [0, 0, 0]\nright = [1, 0, 0]\n\n\
        [[lines]]\nname = \"bar\"\nfrom = \"left\"\nto = \"right\"\nelements = 10\nsection = \"bar\"\n\n\
        [[supports]]\nnode = \"left\"\nfix = [\"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n\
        prescribed = { x = { proportional = 1 } }\n\n\
        [analysis.dynamic]\nto = 0.05\nstep = 1e-4\nscheme = \"newmark\"\n";
    let (defect, said, _) = defect("bar", &[bar, PLAIN].concat());
    assert!(defect < 1e-9, "{defect:e}");
    assert!(!said.contains("much compared"), "{said}");
}

/// It relaxes in 1e-5, in steps of a hundredth, and its base is jerked three times.
#[test]
fn a_dashpot_that_steps_do_not_resolve_moves_along_with_a_jerk() {
    let dashpot = "[nodes]\nbase = [0, 0, 0]\n\n[[supports]]\nnode = \"base\"\n\
        fix = [\"y\", \"z\", \"rx\", \"ry\", \"rz\"]\nprescribed = { x = { table = [[0, 0], [1, 1], [2, 1]] } }\n\n\
        [[joints]]\nname = \"slide\"\ntype = \"prismatic\"\nparent = \"base\"\naxis = [1, 0, 0]\n\
        spring = { k = 100, c = 1e5 }\nvalue = 0.1\n\n[[bodies]]\nname = \"mass\"\nnode = \"slide\"\nmass = 1\n\n\
        [[probes]]\nname = \"s\"\nquantity = \"joint_coordinate\"\njoint = \"slide\"\n\n\
        [analysis.dynamic]\nto = 3\nstep = 0.01\n";
    for scheme in [
        "newmark",
        "ga:0.5",
        "ga:0.9",
        "hht:-0.1",
        "bathe",
        "radau",
        "projected-newmark",
    ] {
        let text = format!("{dashpot}scheme = \"{scheme}\"\n{PLAIN}");
        let (defect, said, out) = defect("dashpot", &text);
        assert!(defect < 0.03, "{scheme}: {defect:e}");
        assert!(!said.contains("much compared"), "{scheme}: {said}");
        for row in history(&out) {
            // s = 0.1 exp(-t k/c) but for 1e-5 in a jerk.
            let exact = 0.1 * (-1e-3 * number(&row, "t")).exp();
            assert!(
                (number(&row, "s") - exact).abs() < 1e-4,
                "{scheme}: {row:?}"
            );
        }
    }
}

#[test]
fn a_damped_strip_that_is_jerked_is_no_false_alarm() {
    let strip = "[sections.strip]\nrectangle = { width = 0.02, height = 0.001 }\n\
        material = { E = 210e9, nu = 0.3, rho = 7850 }\ndamping = { mass = 5, stiffness = 1e-5 }\n\n\
        [nodes]\nL = [-0.25, 0, 0]\nR = [0.25, 0, 0]\n\n\
        [[lines]]\nname = \"strip\"\nfrom = \"L\"\nto = \"R\"\nelements = 20\nsection = \"strip\"\nsecond_axis = [0, 1, 0]\n\n\
        [[supports]]\nnode = \"L\"\nfix = [\"x\", \"y\", \"z\", \"rx\", \"rz\"]\n\n\
        [[supports]]\nnode = \"R\"\nfix = [\"y\", \"z\", \"rx\", \"rz\"]\nprescribed = { x = { table = [[0, 0], [0.2, 0.001]] } }\n\n\
        [[loads]]\nnode = \"strip/9\"\nforce = [0, 0, 0.05]\n\n\
        [analysis.dynamic]\nto = 0.3\nstep = 0.0005\nscheme = { generalised-alpha = 0.5 }\n\n\
        [output]\nfigures = false\nparaview_every = 0\n";
    let (defect, said, _) = defect("strip", strip);
    assert!(defect < 1e-3, "{defect:e}");
    assert!(!said.contains("much compared"), "{said}");
}

#[test]
fn a_damped_blade_that_turns_from_the_start_keeps_its_balance() {
    // Its first element is sheared at once, and stiffness-proportional damping resists in a thousandth of a step.
    let model = pullback::studies::gallery::model(Path::new("spin_up")).unwrap();
    let text = model
        .replace("spin_up = { rate = 6, duration = 15 }", "proportional = 1")
        .replace("[nodes]", "damping = { stiffness = 1e-3 }\n\n[nodes]")
        .replace("to = 20", "to = 2");
    assert!(text.contains("proportional = 1") && text.contains("to = 2\n"));
    let (defect, said, _) = defect("blade", &text);
    assert!(defect < 0.02, "{defect:e}");
    assert!(!said.contains("much compared"), "{said}");
}
