//! What a run in time tells of its energy, and small forces beside large ones, against closed forms.
#![allow(clippy::unwrap_used)]

use crate::support::program::{directory, history, number, program, results, write};

/// A point mass on an arm of length 1 that turns about e₂ and starts along e₁.
fn arm(name: &str, turns: &str, more: &str, analysis: &str) -> (Vec<[f64; 2]>, String) {
    let text = format!(
        "[nodes]\nground = [0, 0, 0]\n\n\
         [[joints]]\nname = \"arm\"\ntype = \"revolute\"\naxis = [0, 1, 0]\n{turns}\n\n\
         [[joints]]\nname = \"end\"\ntype = \"offset\"\nmaster = \"arm\"\nplace = [1, 0, 0]\n\n\
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
    let master = "master = \"ground\"";
    let (rows, said) = arm(
        "kept",
        master,
        GRAVITY,
        "to = 20\nstep = 0.1\nscheme = \"em\"",
    );
    let worst = rows.iter().map(|r| r[1].abs()).fold(0.0, f64::max);
    assert!(worst < 1e-12, "{worst:e}");
    assert!(!said.contains("much compared"), "{said}");
    // Steps far beyond the limit of an explicit one: more energy than gravity has.
    let wild = "to = 100\nstep = 1\nscheme = \"central-difference\"";
    let (_, said) = arm("wild", master, GRAVITY, wild);
    assert!(said.contains("much compared"), "{said}");
}

#[test]
fn a_model_that_is_unstable_itself_is_told_so() {
    // x = 0.01 cosh(√1000 t) is beyond the largest number before t = 23, and its energy before 12.
    let text = "[nodes]\nground = [0, 0, 0]\n\n[[joints]]\nname = \"slide\"\ntype = \"prismatic\"\n\
                master = \"ground\"\naxis = [1, 0, 0]\nspring = { k = -1000 }\nvalue = 0.01\n\n\
                [[bodies]]\nname = \"mass\"\nnode = \"slide\"\nmass = 1\n\n\
                [[supports]]\nnode = \"ground\"\nfix = \"all\"\n\n\
                [analysis.dynamic]\nto = 100\nstep = 0.01\n\n[output]\nfigures = false\nparaview_every = 0\n";
    let output = program(&[&write(&directory("program_balance_pushed"), text)]);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stderr);
    let told = "its energy is beyond all numbers";
    assert!(said.contains(told) && said.contains("stiffness"), "{said}");
    assert!(!said.contains("NaN") && !said.contains("inf "), "{said}");
}

#[test]
fn a_small_motor_drives_a_fast_rotor() {
    // One radian per second more after one second, beside a centrifugal force of 1e10.
    let turns = "master = \"ground\"\nrate = 1e5\nmotor = { constant = 1 }";
    let (rows, _) = arm("rotor", turns, "", "to = 1\nstep = 0.01");
    let [rate, _] = rows[rows.len() - 1];
    assert!((rate - 100_001.0).abs() < 1e-6, "{rate}");
}

#[test]
fn a_motion_with_hardly_any_energy_is_not_unstable() {
    // A slider pushes the pivot across the arm: this turns about its mass, which hardly moves at first.
    let slider = "[[joints]]\nname = \"slider\"\ntype = \"prismatic\"\nmaster = \"ground\"\n\
                  axis = [0, 0, 1]\ndriven = { run-up = { rate = 1, duration = 0.5 } }";
    let (rows, said) = arm("push", "master = \"slider\"", slider, "to = 1\nstep = 0.01");
    assert_eq!(rows.len(), 101, "{said}");
}
