//! What a run in time tells of its energy, and small forces beside large ones, against closed forms.

use crate::support::*;

/// Whether a run tells that its energy is not balanced.
fn doubted(run: &Ran) -> bool {
    run.said.contains("much compared")
}

/// A point mass on an arm of length 1 that turns about e₂ and starts along e₁: rates and defects, and the run.
fn turning(name: &str, turns: &str, more: &str, analysis: &str) -> (Vec<[f64; 2]>, Ran) {
    let text = [
        GROUND,
        "[[joints]]\nname = \"arm\"\ntype = \"revolute\"\naxis = [0, 1, 0]\n",
        turns,
        "\n",
        &arm("end", "arm", [1.0, 0.0, 0.0]),
        &body_of("end", 1.0, ""),
        more,
        &format!("[analysis.dynamic]\n{analysis}\n"),
        PLAIN,
        &probe_of("rate", "joint_rate", "joint = \"arm\""),
    ];
    let run = run_of(&format!("program_balance_{name}"), &text.concat());
    // What the terminal warns of stands in result.json.
    let told = run.result["warnings"].to_string().contains("much compared");
    assert_eq!(told, doubted(&run), "{}", run.said);
    let numbers = |row| ["rate", "energy_defect"].map(|column| number(row, column));
    (run.rows.iter().map(numbers).collect(), run)
}

const PARENT: &str = "parent = \"ground\"";

#[test]
fn the_work_of_gravity_is_what_it_has_lost_of_its_potential() {
    // A scheme that keeps the energy has no defect at steps of a twentieth of the period.
    let kept = "to = 20\nstep = 0.1\nscheme = \"projected-newmark\"";
    let (rows, run) = turning("kept", PARENT, GRAVITY, kept);
    let worst = rows.iter().map(|r| r[1].abs()).fold(0.0, f64::max);
    assert!(worst < 1e-12 && !doubted(&run), "{worst:e}");
    // Steps far beyond the limit of an explicit one: more energy than gravity has.
    let wild = "to = 100\nstep = 1\nscheme = \"central-difference\"";
    assert!(doubted(&turning("wild", PARENT, GRAVITY, wild).1));
}

#[test]
fn a_model_that_is_unstable_itself_is_told_so() {
    // x = 0.01 cosh(√1000 t) is beyond the largest number before t = 23, and its energy before 12.
    let pushed = "axis = [1, 0, 0]\nspring = { k = -1000 }\nvalue = 0.01";
    let text = [
        GROUND,
        &joint("slide", "prismatic", "ground", pushed),
        &body_of("slide", 1.0, ""),
        &motion(100.0, 0.01),
        PLAIN,
    ];
    let said = failed("program_balance_pushed", &text.concat());
    assert_says(&said, &["its energy is beyond all numbers", "stiffness"]);
    assert!(!said.contains("NaN") && !said.contains("inf "), "{said}");
}

#[test]
fn a_small_motor_drives_a_fast_rotor() {
    // One radian per second more after one second, beside a centrifugal force of 1e10.
    let turns = format!("{PARENT}\nrate = 1e5\nactuator = {{ constant = 1 }}");
    let (rows, _) = turning("rotor", &turns, "", "to = 1\nstep = 0.01");
    assert_close(rows[rows.len() - 1][0], 100_001.0, 1e-6, "rate");
}

#[test]
fn a_motion_with_hardly_any_energy_is_not_unstable() {
    // A slider pushes the pivot across the arm: this turns about its mass, which hardly moves at first.
    let pushed = "axis = [0, 0, 1]\nprescribed = { spin_up = { rate = 1, duration = 0.5 } }";
    let slider = joint("slider", "prismatic", "ground", pushed);
    let turns = "parent = \"slider\"";
    let (rows, _) = turning("push", turns, &slider, "to = 1\nstep = 0.01");
    assert_eq!(rows.len(), 101);
}

/// A run whose defect of the balance of energy is below a part of the work done, and which has no doubts.
#[track_caller]
fn assert_balanced(name: &str, text: &str, most: f64) -> Ran {
    let run = run_of(&format!("program_balance_{name}"), text);
    let energy = &run.result["statistics"]["energy"];
    let [defect, gross] = ["largest_defect", "gross"].map(|key| energy[key].as_f64().unwrap());
    assert!(gross > 0.0 && defect < most * gross, "{name}: {energy}");
    assert!(!doubted(&run), "{name}: {}", run.said);
    run
}

/// A linear system: the work of the trapezoidal rule is that of mean forces on displacements, whatever its steps
/// leave unresolved.
#[test]
fn work_is_exact_of_waves_that_steps_do_not_resolve() {
    // Waves pass an element in a tenth of a step.
    let text = [
        "[sections.bar]\nstiffness = { EA = 1e8, GA = [1e8, 1e8], GJ = 1, EI = [1, 1] }\n\
         mass = { A_rho = 1, J = [1, 1, 1] }\n\
         [nodes]\nleft = [0, 0, 0]\nright = [1, 0, 0]\n",
        &beam_line("bar", ["left", "right"], 10, "bar"),
        &moved("left", "proportional = 1"),
        &motion(0.05, 1e-4),
        "scheme = \"newmark\"\n",
        PLAIN,
    ];
    assert_balanced("bar", &text.concat(), 1e-9);
}

/// A node whose x is a function of time, and which is held otherwise.
fn moved(node: &str, x: &str) -> String {
    let fixed = "fix = [\"y\", \"z\", \"rx\", \"ry\", \"rz\"]";
    format!("[[supports]]\nnode = \"{node}\"\n{fixed}\nprescribed = {{ x = {{ {x} }} }}\n")
}

/// It relaxes in 1e-5, in steps of a hundredth, and its base is jerked three times.
#[test]
fn a_dashpot_that_steps_do_not_resolve_moves_along_with_a_jerk() {
    let spring = "axis = [1, 0, 0]\nspring = { k = 100, c = 1e5 }\nvalue = 0.1";
    let dashpot = [
        "[nodes]\nbase = [0, 0, 0]\n",
        &moved("base", "table = [[0, 0], [1, 1], [2, 1]]"),
        &joint("slide", "prismatic", "base", spring),
        &body_of("slide", 1.0, ""),
        &angle("slide"),
        PLAIN,
        &motion(3.0, 0.01),
    ]
    .concat();
    for scheme in "newmark ga:0.5 ga:0.9 hht:-0.1 bathe radau projected-newmark".split(' ') {
        let text = format!("{dashpot}scheme = \"{scheme}\"\n");
        for row in assert_balanced("dashpot", &text, 0.03).rows {
            // s = 0.1 exp(-t k/c) but for 1e-5 in a jerk.
            let exact = 0.1 * (-1e-3 * number(&row, "t")).exp();
            let what = format!("{scheme} at {}", row["t"]);
            assert_close(number(&row, "slide"), exact, 1e-4, what);
        }
    }
}

#[test]
fn a_motion_that_begins_and_ends_at_rest_is_no_false_alarm() {
    // What the load does, the damper takes.
    let damped = "axis = [0, 0, 1]\nspring = { c = 8 }";
    let text = [
        GROUND,
        &joint("j", "prismatic", "ground", damped),
        &body_of("j", 1.5, ""),
        "[[loads]]\nnode = \"j\"\nforce = [0, 0, -15]\ntime = { table = [[0, 1], [2, 1], [2.5, 0]] }\n",
        &motion(8.0, 0.01),
        PLAIN,
    ];
    assert_balanced("rest", &text.concat(), 1e-4);
}

#[test]
fn a_damped_strip_that_is_jerked_is_no_false_alarm() {
    let jerked = "prescribed = { x = { table = [[0, 0], [0.2, 0.001]] } }\n";
    let text = [
        "[sections.strip]\nrectangle = { width = 0.02, height = 0.001 }\n\
         material = { E = 210e9, nu = 0.3, rho = 7850 }\ndamping = { mass = 5, stiffness = 1e-5 }\n\
         [nodes]\nL = [-0.25, 0, 0]\nR = [0.25, 0, 0]\n",
        &beam_line("strip", ["L", "R"], 20, "strip"),
        "second_axis = [0, 1, 0]\n",
        "[[supports]]\nnode = \"L\"\nfix = [\"x\", \"y\", \"z\", \"rx\", \"rz\"]\n\
         [[supports]]\nnode = \"R\"\nfix = [\"y\", \"z\", \"rx\", \"rz\"]\n",
        jerked,
        "[[loads]]\nnode = \"strip/9\"\nforce = [0, 0, 0.05]\n",
        &motion(0.3, 0.0005),
        "scheme = { generalised-alpha = 0.5 }\n",
        PLAIN,
    ];
    assert_balanced("strip", &text.concat(), 1e-3);
}

#[test]
fn a_damped_blade_that_turns_from_the_start_keeps_its_balance() {
    // Its first element is sheared at once, and stiffness-proportional damping resists in a thousandth of a step.
    let changes = "spin_up = { rate = 6, duration = 15 } => proportional = 1\n\
                   [nodes] => damping = { stiffness = 1e-3 }\\n\\n&\nto = 20 => to = 2";
    assert_balanced("blade", &changed(&example("spin_up"), changes), 0.02);
}

/// Two masses on a stiff spring and damper turn steadily about their center, beside an oscillator with a damper of its own and
/// a small load with kinks: λh = 10, and nothing relaxes.
#[test]
fn accelerations_are_those_of_the_equations_where_nothing_jumps() {
    let spring = |name: &str, nodes: [&str; 2], rest: &str| {
        format!("[[springs]]\nname = \"{name}\"\nnodes = {nodes:?}\n{rest}\n")
    };
    let text = [
        "[nodes]\na = [1, 0, 0]\nb = [-1, 0, 0]\nheld = [0, 5, 0]\nswinging = [0, 6, 0]\n",
        &fixed("held"),
        &["a", "b", "swinging"].map(|node| body_of(node, 1.0, "")).concat(),
        &spring("stiff", ["a", "b"], "stiffness = 1e4\ndamping = 1e3\nrest_length = 1.9996"),
        &spring("other", ["held", "swinging"], "stiffness = 1\ndamping = 0.1"),
        "[[initial]]\nangular_velocity = [0, 0, 2]\n",
        "[[initial]]\nnode = \"swinging\"\nvelocity = [0, 1, 0]\n",
        "[[loads]]\nnode = \"a\"\nforce = [0, 0, 1e-9]\ntime = { table = [[0, 0], [0.5, 1], [5, 0]] }\n",
        PLAIN,
        &probe("a", "acceleration", "a"),
        "component = \"norm\"\n",
        &motion(1.0, 0.01),
    ]
    .concat();
    for scheme in ["radau", "ga:0.9", "newmark"] {
        let text = format!("{text}scheme = \"{scheme}\"\n");
        let rows = recorded("program_balance_pair", &text);
        // ω² r.
        for row in &rows {
            let what = format!("{scheme} at {}", row["t"]);
            assert_close(number(row, "a"), 4.0, 1e-2, what);
        }
        assert_close(number(&rows[0], "a"), 4.0, 1e-9, scheme);
    }
    // A damper that is worked: a = −c v/m, and the state is consistent for a linearisation.
    let damped = "axis = [1, 0, 0]\nrate = 1\nspring = { c = 5 }";
    let slider = [
        GROUND,
        &joint("slide", "prismatic", "ground", damped),
        &body_of("slide", 1.0, ""),
        &motion(1.0, 0.1),
        PLAIN,
        &probe("a", "acceleration", "slide"),
    ];
    let rows = recorded("program_balance_slider", &slider.concat());
    assert_close(number(&rows[0], "a.x"), -5.0, 1e-12, "slider");
}
