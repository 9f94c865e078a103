//! What a run in statics records and warns of.

use super::corrections::truss;
use crate::support::beams::line;
use crate::support::closures::{
    CLOSURES, GROUND, PLAIN, arm, body, body_of, fixed, hinge, joint, probe_of,
};
use crate::support::drawings::tagged;
use crate::support::prelude::*;
use crate::support::program::*;
use pullback::integrators::significant;
use roxmltree::Document;

/// The example of Lee's frame with another analysis.
fn lee(analysis: &str) -> String {
    let text = example("lee_frame");
    let (model, rest) = text.split_once("[analysis").unwrap();
    let (_, probes) = rest.split_once("[[probes]]").unwrap();
    [model, analysis, "\n[[probes]]", probes, "\n", PLAIN].concat()
}

#[test]
fn located_rows_are_where_they_say_whatever_the_step() {
    let analysis = |step: f64| {
        format!(
            "[analysis.arc_length]\nfirst_step = {step}\nmax_step = {step}\n\
             record = [{{ load = 0.25 }}, {{ load = 0.9 }}, \"turning_point\"]\n\
             stop = [{{ load = 1 }}]"
        )
    };
    let reference = run_of("statics_lee", &lee(&analysis(0.05))).rows;
    let position = |rows: &Rows, event: &str| -> Vec<f64> {
        let row = rows.iter().find(|r| r["event"] == event).unwrap();
        let columns = row.keys().filter(|k| k.starts_with("load point."));
        let mut columns: Vec<&String> = columns.collect();
        columns.sort();
        assert_eq!(columns.len(), 3, "{:?}", row.keys());
        columns.into_iter().map(|c| number(row, c)).collect()
    };
    for step in [0.5, 1.0, 10.0, 12.0] {
        let Ran { rows, result, .. } =
            run_of(&format!("statics_lee_{step}"), &lee(&analysis(step)));
        for row in &rows {
            let event = &row["event"];
            let context = format!("first step {step}, {event} at load {}", row["t"]);
            if let Some(load) = event.strip_prefix("load = ") {
                let load: f64 = load.parse().unwrap();
                assert_close(number(row, "t"), load, 2e-9, &context);
                let expected = position(&reference, event);
                for (x, y) in position(&rows, event).into_iter().zip(expected) {
                    // Of a frame of 120.
                    assert_close(x, y, 1e-5, &context);
                }
            }
            if !event.is_empty() {
                // The corrections of a trial that failed are of the size of the frame.
                assert!(number(row, "last_correction") < 1e-2, "{context}");
                assert!(number(row, "iterations") > 0.0, "{context}");
            }
        }
        let told: f64 = rows.iter().map(|r| number(r, "iterations")).sum();
        assert_eq!(result["statistics"]["iterations"], told as u64, "{step}");
    }
}

#[test]
fn a_path_plays_in_the_order_of_its_rows() {
    let analysis = "[analysis.arc_length]\nstop = [\"turning_point\"]\nmax_step = 0.3\n";
    let drawn = changed(&lee(analysis), "paraview_every = 0 => paraview_every = 1");
    let Ran { rows, out, .. } = run_of("statics_pvd", &drawn);
    let text = read(out.join("steps.pvd"));
    let document = Document::parse(&text).unwrap();
    let mut count = 0;
    for (k, set) in tagged(&document, "DataSet").enumerate() {
        assert_eq!(set.attribute("timestep").unwrap().parse(), Ok(k as f64));
        let grid = read(out.join(set.attribute("file").unwrap()));
        let grid = Document::parse(&grid).unwrap();
        let data = tagged(&grid, "FieldData").next();
        let array = data.unwrap().first_element_child().unwrap();
        assert_eq!(array.attribute("Name"), Some("load_parameter"));
        let load = grid_array(&grid, "load_parameter")[0];
        assert_eq!(load, number(&rows[k], "t"));
        count += 1;
    }
    assert_eq!(count, rows.len());
}

#[test]
fn a_spring_that_parts_hold_at_the_start_is_in_balance() {
    // Without a load the reactions are rounding errors of nothing, and measure no residual.
    let k = "spring = { k = 60 }";
    let closed = format!("axis = [0.3, 1, 0]\nchild = \"b\"\n{}\n{k}", CLOSURES[1]);
    let file = [
        GROUND,
        &hinge("A", "ground", k),
        &arm("a", "A", [0.31, 1.04, 0.0]),
        &hinge("B", "a", k),
        &arm("b", "B", [1.26, 1.37, 0.0]),
        &hinge("D", "ground", k),
        &arm("d", "D", [1.26, 1.37, 0.0]),
        &joint("C", "prismatic", "d", &closed),
        "[[springs]]\nname = \"stay\"\nnodes = [\"d\", \"a\"]\nstiffness = 18\nrest_length = 1.1\n",
        "[[loads]]\nnode = \"a\"\nforce = [0.3, -1, 0]\n",
        "[analysis.static]\nsteps = 2\n",
    ];
    let Ran { rows, result, .. } = run_of("statics_strained", &file.concat());
    assert_eq!(result["warnings"].to_string(), "[]");
    let strain = 0.95_f64.hypot(0.33) - 1.1;
    let energy = number(&rows[0], "strain_energy");
    assert_close(energy, 9.0 * strain * strain, 1e-14, "energy");
}

#[test]
fn why_stability_is_not_known_is_told() {
    let Ran { rows, result, .. } = run_of("statics_unstable_unknown", MODEL);
    let notes = result["notes"].to_string();
    assert_says(&notes, &["`unstable` stays empty", "(load 1)"]);
    assert!(rows.iter().all(|row| row["unstable"].is_empty()));

    // A dead force has a potential, and so has a penalty, with dampers too.
    let penalty = format!("{}\npenalty_damping = 0.1", CLOSURES[2]);
    let k = "spring = { k = 60 }";
    let file = [
        GROUND,
        &hinge("A", "ground", k),
        &arm("a", "A", [0.31, 1.04, 0.0]),
        &hinge("B", "ground", k),
        &arm("b", "B", [0.31, 1.04, 0.0]),
        &joint("C", "weld", "a", &format!("child = \"b\"\n{penalty}")),
        "[[springs]]\nname = \"stay\"\nnodes = [\"b\", \"ground\"]\nstiffness = 18\n",
        "[[loads]]\nnode = \"a\"\nforce = [0.3, -1, 0]\n",
        "[analysis.static]\nsteps = 2\n",
    ];
    let Ran { rows, result, .. } = run_of("statics_unstable_penalty", &file.concat());
    let notes = result["notes"].to_string();
    assert!(!notes.contains("unstable"), "{notes}");
    assert!(rows[1..].iter().all(|row| row["unstable"] == "0"));
}

#[test]
fn a_balance_that_ends_at_rounding_errors_is_warned_of() {
    // A soft hinge turns a stiff beam: nodes far from where they were drawn, whose rounding errors times EA
    // are no small forces beside the load.
    let rest = [
        &fixed("A"),
        &hinge("hinge", "A", "spring = { k = 1e-3 }"),
        "[[loads]]\nnode = \"B\"\nforce = [0, 1e-4, 0]\n[analysis.static]\nsteps = 2\n",
    ]
    .concat();
    let changes = "from = \"A\" => from = \"hinge\"\nB = [1, => B = [5,";
    for (EA, told) in [("1e2", false), ("1e8", true)] {
        let stiffness = format!("EA = {EA}, GA = [{EA}, {EA}], GJ = 1e6, EI = [1e6, 1e6]");
        let text = changed(&line(&stiffness, 4, 1, &rest), changes);
        let Ran { rows, result, .. } = run_of("statics_rounding", &text);
        let ratios = rows.iter().map(|r| number(r, "residual_over_tolerance"));
        let ratio = ratios.fold(0.0, f64::max);
        let warnings = result["warnings"].to_string();
        let found = warnings.contains("balance of forces ends");
        assert_eq!(found, told, "{ratio}: {warnings}");
        // 1e-5 of the forces is 10,000 times the tolerance.
        assert_eq!(ratio > 1e4, told, "{ratio}");
    }
}

#[test]
fn what_does_nothing_or_too_much_is_warned_of() {
    let warnings = |text: &str| {
        let result = run_of("statics_warned", text).result;
        serde_json::from_value::<Vec<String>>(result["warnings"].clone()).unwrap()
    };
    assert_eq!(warnings(MODEL), [""; 0]);
    // Unloaded, nothing but rounding errors is left.
    let unloaded = "time = { triangle = { peak = 0.5, end = 1 } }\n[analysis.static]";
    let unloaded = with("[analysis.static]", unloaded);
    assert_eq!(warnings(&unloaded), [""; 0]);
    let moment = "moment = [0, 0, 3.141592653589793]";
    let at_b = format!("node = \"B\"\n{moment}");
    for (old, new, told) in [
        (
            moment,
            "moment = [0, 0, 0]",
            &["no load acts and nothing is prescribed"][..],
        ),
        (
            &at_b,
            &at_b.replace('B', "A"),
            &["supports and joints bear all loads"],
        ),
        // EA = 1e6: rounding errors of forces are of the order of 1e-9.
        (
            moment,
            "force = [1e-12, 0, 0]",
            &["balance of forces ends at rounding errors"],
        ),
        // 30 % of elongation.
        (moment, "force = [3e5, 0, 0]", &["element beam:", "%"]),
    ] {
        let warnings = warnings(&with(old, new));
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert_says(&warnings[0], told);
    }
    // A bar pressed to -10 % of its length.
    let guide = "[[supports]]\nnode = \"B\"\nfix = [\"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n";
    let pressed = with(moment, "force = [-1.1e6, 0, 0]") + guide;
    let warnings = warnings(&pressed).concat();
    let told = ["inside out", "element beam:1", "load parameter 1 "];
    assert_says(&warnings, &told);
}

#[test]
fn the_equilibrium_at_the_start_is_the_first_row() {
    // Half of the moment is there at the start, the other half grows: both turn the tip by M L/EI.
    let half = format!("moment = [0, 0, {}]", PI / 2.0);
    let growing = format!("\n[[loads]]\nnode = \"B\"\n{half}\n");
    let constant = format!("{half}\ntime = {{ constant = 1 }}");
    let text = with("moment = [0, 0, 3.141592653589793]", &constant) + &growing;
    let along = "[analysis.static]\\nsteps = 4 => [analysis.arc_length]";
    let path = changed(&text, along);
    for (name, text) in [("statics_start", text), ("statics_start_path", path)] {
        let Ran { rows, result, .. } = run_of(name, &text);
        assert_eq!(rows[0]["step"], "0");
        assert_eq!(number(&rows[0], "t"), 0.0);
        assert!(number(&rows[0], "iterations") > 1.0);
        for row in &rows {
            let expected = (1.0 + number(row, "t")) * PI / 4.0;
            assert_close(number(row, "turn"), expected, 1e-8, name);
        }
        let told: f64 = rows.iter().map(|r| number(r, "iterations")).sum();
        assert_eq!(result["statistics"]["iterations"], told as u64);
        let last = &rows[rows.len() - 1]["step"];
        assert_eq!(&result["statistics"]["steps"].to_string(), last);
    }
}

#[test]
fn figures_tell_exaggeration_and_incompleteness() {
    let scaled = format!("{MODEL}\n[output]\ndeformation_scale = 25\nparaview_every = 0\n");
    let Ran { result, out, .. } = run_of("statics_scaled", &scaled);
    let shape = read(out.join("deformed.svg"));
    assert!(shape.contains("Quarter circle, displacements × 25"));
    assert!(!read(out.join("history.svg")).contains('×'));
    // Whatever the defaults depend on, the results tell them.
    assert_eq!(result["settings"]["analysis"]["static"]["min_step"], 1e-6);
    let Ran { result, out, .. } = run_of("statics_plain", &MODEL.replace("steps = 4", ""));
    assert!(!read(out.join("deformed.svg")).contains('×'));
    let settings = &result["settings"]["analysis"]["static"];
    assert_eq!(settings["first_step"], 0.1);
    assert_eq!(settings["max_step"], 0.25);

    let directory = directory("statics_incomplete");
    let few = "first_step = 0.25\nmax_step = 0.25\nmin_step = 0.2\nnewton = { max_iterations = 1 }";
    let model = write(&directory, &with("steps = 4", few));
    ended(&program(&[&model]), 1);
    for name in ["deformed.svg", "history.svg"] {
        let figure = read(directory.join("model.out").join(name));
        assert!(figure.contains("Quarter circle, incomplete"), "{name}");
    }
}

/// A steep truss gives way sideways, and its load falls.
#[test]
fn an_unstable_branch_is_told_from_a_limit_point() {
    let aside =
        |x: f64| format!("{{ coordinate = {{ node = \"T\", dof = \"x\", value = {x:?} }} }}");
    let stop = [0.5, -0.5].map(aside).join(", ");
    let analysis =
        "[analysis.arc_length]\nbranch = \"switch\"\nload_scale = 100\nmax_step = 0.1\nstop = [";
    let text = truss(1.0, 4.0, 0.01) + analysis + &stop + "]\n";
    let Ran { rows, result, .. } = run_of("statics_steep", &text);
    // The stiffness across is 2 k (1 + (1 − l₀/l) y²)/l².
    let across = |y: f64| 1.0 + (1.0 - (17.0 / (1.0 + y * y)).sqrt()) * y * y;
    let [mut low, mut high] = [1.0, 4.0];
    for _ in 0..60 {
        let y = 0.5 * (low + high);
        if across(y) < 0.0 { low = y } else { high = y }
    }
    let exact = 2.0 * low * ((17.0 / (1.0 + low * low)).sqrt() - 1.0);
    let found = rows.iter().find(|r| r["event"] == "bifurcation").unwrap();
    assert_close(0.01 * number(found, "t") / exact, 1.0, 1e-9, "load");
    assert_eq!(rows[rows.len() - 1]["unstable"], "1");
    let warnings = result["warnings"].to_string();
    let at = significant(exact / 0.01);
    let between = format!("bifurcation between load parameter {at} and");
    assert_says(&warnings, &[&between, "unstable in 1 direction after it"]);
    assert!(!warnings.contains("limit point"), "{warnings}");
}

#[test]
fn a_truss_of_springs_snaps_through_and_is_drawn() {
    let analysis = "[analysis.arc_length]\nrecord = [\"turning_point\"]\n";
    let Ran { result, out, .. } = run_of("statics_springs", &(truss(1.0, 0.5, 0.1) + analysis));
    let warnings = result["warnings"].to_string();
    assert_says(&warnings, &["limit point between", "would snap through"]);
    let text = read(out.join("step_0000.vtu"));
    let document = Document::parse(&text).unwrap();
    let piece = tagged(&document, "Piece").next().unwrap();
    assert_eq!(piece.attribute("NumberOfCells"), Some("2"));
    let ends = [-1.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.5, 0.0, 1.0, 0.0, 0.0];
    assert_eq!(grid_array(&document, "Points"), ends);
    assert_eq!(grid_array(&document, "types"), [3.0, 3.0]);
}

/// Displacements that turn back along a path, x = 3 sin(4π t)/5, and others that rest, under a dead load.
#[test]
fn arc_length_passes_where_displacements_turn_back_or_rest() {
    let hung = [
        hinge("crank", "ground", "prescribed = { proportional = 13 }"),
        hinge("pendulum", "ground", "spring = { k = 2 }"),
        body_of(
            "pendulum",
            0.6,
            "center = [0.05, -0.4, 0]\ninertia = [0.1, 0.1, 0.1]",
        ),
        body("crank"),
        "[[loads]]\ngravity = [0, -9.81, 0]\ntime = { constant = 1 }\n".to_owned(),
    ];
    let moved = [
        joint(
            "slider",
            "prismatic",
            "ground",
            "axis = [1, 0, 0]\nspring = { k = 5 }",
        ),
        body_of("slider", 1.0, ""),
        probe_of("x", "joint_coordinate", "joint = \"slider\""),
        "[[loads]]\nnode = \"slider\"\nforce = [3, 0, 0]\n\
         time = { sine = { amplitude = 1, omega = 12.566370614359172 } }\n"
            .to_owned(),
    ];
    for load_scale in [0.1, 1.0, 10.0] {
        let analysis = format!("[analysis.arc_length]\nload_scale = {load_scale}\n{PLAIN}");
        let text = [GROUND, &moved.concat(), &analysis];
        for row in recorded("statics_sine", &text.concat()) {
            let exact = 0.6 * (12.566370614359172 * number(&row, "t")).sin();
            assert_close(number(&row, "x"), exact, 1e-8, load_scale);
        }
        let ran = run_of(
            "statics_rests",
            &[GROUND, &hung.concat(), &analysis].concat(),
        );
        assert_eq!(ran.result["statistics"]["rejected"], 0, "{load_scale}");
    }
}
