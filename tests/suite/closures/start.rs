//! Where models begin whose loops are closed by multipliers or a penalty, and loops that are driven:
//! values and velocities that are kept, noted, or refused by their names.

use super::linkage_of;
use crate::support::closures::{start, *};
use crate::support::prelude::*;
use crate::support::program::{
    Ran, Rows, assert_close, assert_says, check, failed, number, recorded, refusal, run_of,
};

/// The linkage closed by a penalty, a spring on its crank and a force on the coupler's tip: angles
/// of crank, coupler and rocker in equilibrium, or why there is none.
fn loaded(force: [f64; 2], penalty: f64) -> Result<[f64; 3], String> {
    let closure = format!("closure = \"penalty\"\npenalty = {penalty}");
    let [x, y] = force;
    let load = format!("[[loads]]\nnode = \"coupler tip\"\nforce = [{x:?}, {y:?}, 0]\n");
    let linkage = four_bar(["spring = { k = 30 }", "", ""], &closure);
    let mut job = assemble_text("model.toml", &[GROUND, &linkage, &load].concat()).unwrap();
    let mut q = job.context.initial().to_vec();
    let options = StaticOptions::default();
    let go_on = &mut |_: &mut Context, _: &Step<'_>| ControlFlow::Continue(());
    solve_statics(&mut job.context, &mut q, &options, go_on).map_err(|error| error.to_string())?;
    Ok(["A", "B", "D"].map(|joint| {
        let angle = job.context.find(&format!("{joint} angle")).unwrap();
        q[job.context.unknown_at(angle, 0).unwrap()]
    }))
}

#[test]
fn a_penalty_stays_closed_under_any_load() {
    let tip = |crank: f64| {
        let (sin, cos) = linkage(crank)[1].sin_cos();
        [-0.4 * cos - 1.9 * sin, -0.4 * sin + 1.9 * cos]
    };
    for k in 0..28 {
        let size = [30.0, 100.0, 300.0, 1000.0][k / 7];
        let (sin, cos) = (TAU * (k % 7) as f64 / 7.0).sin_cos();
        let force = [size * cos, size * sin];
        let [crank, b, d] = loaded(force, 1e6).unwrap();
        let exact = linkage(crank);
        let off = apart(b, exact[0]).max(apart(d, exact[1]));
        // The spring balances the force by the tip's way over the crank's angle; gaps are of size F/p.
        let [ahead, behind] = [1e-5, -1e-5].map(|h| tip(crank + h));
        let along = |k: usize| (ahead[k] - behind[k]) / 2e-5;
        let balance = force[0] * along(0) + force[1] * along(1) - 30.0 * crank;
        assert!(off < 0.01, "load {k}: {off}");
        assert!(balance.abs() < 0.02 * size, "load {k}: {balance}");
    }
    let said = loaded([1000.0, 0.0], 3e3).unwrap_err();
    let named = "element closure of C left the neighbourhood of its closed position";
    assert!(said.contains(named), "{said}");
}

#[test]
fn a_motion_does_not_begin_with_a_loop_that_is_open() {
    let mut job = started(&linkage_of(["", "", ""], CLOSURES[1]));
    let options = DynamicOptions {
        scheme: "ga:0.8".parse().unwrap(),
        ..DynamicOptions::new(0.1, 0.01)
    };
    for (angle, fine) in [(0.0, true), (1e-9, true), (1e-3, false)] {
        let mut q = job.start.q.clone();
        q[0] += angle;
        let state = pullback::integrators::dynamics::start(&job.context, 0.0, &q, &[]).unwrap();
        let refused = Simulation::new(&mut job.context, state, &options).err();
        let said = refused.map_or("none".to_owned(), |error| error.to_string());
        let open = "the equation of multipliers of C and rocker tip, coordinate 1 is off by";
        assert_eq!(!said.contains(open), fine, "{angle}: {said}");
    }
}

#[test]
fn values_are_kept_in_the_order_of_the_file() {
    let [b, d] = linkage(0.5);
    for (k, closure) in CLOSURES.iter().enumerate() {
        // The second one is right to 7 digits.
        let few = format!("value = {d:.7}");
        let text = linkage_of(["value = 0.5", "", &few], closure);
        let (at, notes) = start(&text);
        assert!((at["A angle"][0] - 0.5).abs() < 1e-15, "{closure}: {at:?}");
        assert!((at["D angle"][0] - d).abs() < 1e-12, "{closure}: {at:?}");
        let notes = notes.join("\n");
        assert!(notes.contains("D angle starts at "), "{notes}");
        assert!(!notes.contains("A angle starts"), "{notes}");
        let (said, _) = rows(&format!("start-note-{k}"), &text);
        assert!(said.contains("D angle starts at "), "{said}");
        // All of them to all digits.
        let [vb, vd] = [b, d].map(|x| format!("value = {x:?}"));
        let text = linkage_of(["value = 0.5", &vb, &vd], closure);
        let (at, notes) = start(&text);
        let notes = notes.join("\n");
        assert!(!notes.contains("starts at"), "{notes}");
        for (name, x) in [("A angle", 0.5), ("B angle", b), ("D angle", d)] {
            assert!((at[name][0] - x).abs() < 1e-14, "{closure}: {name} {at:?}");
        }
        // One that nothing closes with: the other one is kept.
        let (at, _) = start(&linkage_of(["value = 0.5", "", "value = 2.5"], closure));
        assert!((at["A angle"][0] - 0.5).abs() < 1e-15, "{closure}: {at:?}");
        assert!((at["D angle"][0] - d).abs() < 1e-12, "{closure}: {at:?}");
    }
}

/// The way to a value is walked in steps, of which there is an end.
#[test]
fn a_value_that_no_digits_hold_is_refused() {
    for closure in CLOSURES {
        let text = linkage_of(["", "value = 1e15", ""], closure);
        check(&text, "\"B\"", "B angle cannot start at 1e15", "");
    }
    // A loop over a body that flies, which no map closes.
    let crank = hinge("A", "ground", "value = 1e6");
    let child = "child = \"free\"\nclosure = \"multipliers\"";
    let text = [
        "[nodes]\nground = [0, 0, 0]\nfree = [1, 0, 0]\n",
        &fixed("ground"),
        RUN,
        &crank,
        &arm("tip", "A", [1.0, 0.0, 0.0]),
        &joint("C", "weld", "tip", child),
        &body("A"),
        &body("free"),
    ];
    let (angles, _) = start(&text.concat());
    assert_eq!(angles["A angle"][0], 1e6);
}

/// The linkage is where a crank that turns by 1.2 rad/s has it, the angle D with this sign.
fn follows(rows: &Rows, sign: f64, what: &str) {
    for row in rows {
        let [b, d] = linkage(1.2 * number(row, "t"));
        for (joint, exact) in [("B", b), ("D", sign * d)] {
            let about = format_args!("{what}: {row:?}");
            assert_close(number(row, joint), exact, 1e-9, about);
        }
    }
}

#[test]
fn a_driven_crank_moves_a_loop_of_one_freedom() {
    let drive = "prescribed = { proportional = 1.2 }";
    for (k, closure) in CLOSURES[..2].iter().enumerate() {
        let text = linkage_of([drive, "", ""], closure);
        let (said, rows) = rows(&format!("start-driven-{k}"), &text);
        assert!(k > 0 || said.contains("nothing is free"), "{said}");
        assert!(rows.len() > 100);
        follows(&rows, 1.0, closure);
    }
    // In statics, with the moment of the drive by virtual work: M δA + F·δx = 0.
    let probe = "[[probes]]\nname = \"M\"\nquantity = \"joint_moment\"\nnode = \"A\"\n\
                 [[probes]]\nname = \"effort\"\nquantity = \"joint_effort\"\njoint = \"A\"\n\
                 [[loads]]\nnode = \"rocker tip\"\nforce = [3, -5, 0]\n";
    let tip = |crank: f64| {
        let turned = linkage(crank)[1] + 1.9_f64.atan2(-0.4);
        let r = 0.4_f64.hypot(1.9);
        3.0 * r * turned.cos() - 5.0 * r * turned.sin()
    };
    let h = 1e-4;
    let slope = (8.0 * (tip(1.2 + h) - tip(1.2 - h)) - tip(1.2 + 2.0 * h) + tip(1.2 - 2.0 * h))
        / (12.0 * h);
    for (k, closure) in CLOSURES[..2].iter().enumerate() {
        let text = [GROUND, STATIC, &four_bar([drive, "", ""], closure), probe].concat();
        let rows = recorded(&format!("start-statics-{k}"), &text);
        let last = rows.last().unwrap();
        assert!((number(last, "D") - linkage(1.2)[1]).abs() < 1e-9);
        for name in ["M.z", "effort"] {
            let moment = number(last, name);
            assert!((moment + slope).abs() < 1e-8, "{closure}: {moment} {slope}");
        }
    }
}

#[test]
fn drives_that_contradict_each_other_are_named() {
    let drive = "prescribed = { proportional = 1 }";
    let words = ["A angle", "D angle", "prescribe no more than is free"];
    for (k, closure) in CLOSURES[..2].iter().enumerate() {
        let text = linkage_of([drive, "", drive], closure);
        let said = failed(&format!("start-two-{k}"), &text);
        assert_says(&said, &words);
        assert!(!said.contains("singular"), "{said}");
        // At the start already.
        let drive = "prescribed = { constant = 0.3 }";
        let text = linkage_of([drive, "", drive], closure);
        let said = refusal(&text).to_string();
        assert_says(&said, &words);
    }
}

#[test]
fn a_loop_ends_at_supports_that_carry_nothing_else() {
    for (k, closure) in CLOSURES[..2].iter().enumerate() {
        // The chain goes round to a node that is only the child of its last joint.
        let chain = [
            "[nodes]\nground = [0, 0, 0]\np = [1.6, 0, 0]\n",
            &["ground", "p"].map(fixed).concat(),
            &hinge("A", "ground", "prescribed = { proportional = 1.2 }"),
            &arm("crank tip", "A", [0.0, 1.0, 0.0]),
            &hinge("B", "crank tip", ""),
            &arm("coupler tip", "B", [1.2, 1.9, 0.0]),
            &hinge("C", "coupler tip", ""),
            &arm("rocker foot", "C", [1.6, 0.0, 0.0]),
            &hinge("D", "rocker foot", &format!("child = \"p\"\n{closure}")),
            &["A", "B", "C"].map(body).concat(),
            &["B", "D"].map(angle).concat(),
            RUN,
        ];
        let rows = recorded(&format!("start-chain-{k}"), &chain.concat());
        // The ground turns against the rocker.
        follows(&rows, -1.0, closure);
    }
    // A rocker without mass is attached to a node that nothing else is fixed to.
    let text = four_bar(["prescribed = { proportional = 1.2 }", "", ""], CLOSURES[0])
        .replace(&body("D"), "")
        .replace(&arm("foot", "ground", [1.6, 0.0, 0.0]), "");
    let nodes = GROUND.replace("[[supports]]", "foot = [1.6, 0, 0]\n[[supports]]");
    let foot = fixed("foot");
    let rows = recorded("start-foot", &[&nodes, &foot, RUN, &text].concat());
    let last = rows.last().unwrap();
    assert!((number(last, "D") - linkage(0.6)[1]).abs() < 1e-9);
    // A support of nothing is refused as ever.
    let text = [&nodes, &foot, RUN, &hinge("A", "ground", ""), &body("A")].concat();
    check(&text, "foot", "node foot carries no element", "");
}

#[test]
fn a_linkage_at_rest_starts_closed_to_rounding_and_stays() {
    for (k, value) in ["0.1", "0.3", "-0.2"].iter().enumerate() {
        let value = format!("value = {value}");
        let text = linkage_of([&value, "", ""], CLOSURES[1]);
        let violation = started(&text).context.violation().unwrap();
        assert!(violation < 5e-16, "{violation:e}");
        let rows = recorded(&format!("start-rest-{k}"), &text);
        let [first, last] = [rows.first(), rows.last()].map(|r| number(r.unwrap(), "D"));
        assert!((first - last).abs() < 1e-12, "{first} {last}");
    }
}

/// Three parallel cranks of 1 on a coupler: two loops of one freedom, which share the first crank.
fn three_cranks(first: &str, closures: [&str; 2]) -> String {
    let closing = |k: usize, name: &str| {
        let child = format!("child = \"end {k}\"\n{}", closures[k - 1]);
        hinge(name, &format!("at {k}"), &child)
    };
    let crank = |k: usize| {
        let (pin, name) = (format!("pin {k}"), format!("crank {k}"));
        let at = k as f64;
        [
            arm(&pin, "ground", [at, 0.0, 0.0]),
            hinge(&name, &pin, ""),
            arm(&format!("end {k}"), &name, [at, 1.0, 0.0]),
            body(&name),
            arm(&format!("at {k}"), "coupler", [at, 1.0, 0.0]),
        ]
        .concat()
    };
    [
        GROUND,
        &hinge("crank 0", "ground", first),
        &body("crank 0"),
        &arm("end 0", "crank 0", [0.0, 1.0, 0.0]),
        &hinge("coupler", "end 0", ""),
        &body("coupler"),
        &crank(1),
        &crank(2),
        &closing(1, "first"),
        &closing(2, "second"),
        RUN,
    ]
    .concat()
}

/// All cranks start at this angle with this rate.
#[track_caller]
fn assert_cranks(first: &str, closures: [&str; 2], [angle, rate]: [f64; 2]) {
    let (found, _) = start(&three_cranks(first, closures));
    for crank in ["crank 0", "crank 1", "crank 2"] {
        let [x, v, _] = found[&format!("{crank} angle")];
        assert_close(x, angle, 1e-9, format_args!("{closures:?}: {crank}"));
        assert_close(v, rate, 1e-8, format_args!("{closures:?}: {crank}"));
    }
}

/// A value and a rate in a loop that a map closes are kept where others are closed by forces, and move these.
#[test]
fn loops_that_are_closed_in_two_ways_start_as_the_joints_that_they_share() {
    for a in CLOSURES {
        for b in CLOSURES {
            assert_cranks("value = 0.3\nrate = 2", [a, b], [0.3, 2.0]);
        }
    }
}

/// The cranks begin far from where they are drawn.
#[test]
fn a_drive_that_begins_far_away_takes_its_loops_along() {
    for angle in [0.5, 1.2] {
        let drive =
            format!("prescribed = {{ sine = {{ amplitude = 0.1, omega = 3, offset = {angle} }} }}");
        for a in CLOSURES {
            assert_cranks(&drive, [a, a], [angle, 0.3]);
        }
    }
}

/// Two bodies with arms of 1 and 0.2 that meet in a ball joint. The position of the first and the displacement of the second close
/// the loop, the rotation of the second no longer does.
#[test]
fn positions_are_kept_in_the_order_of_the_file() {
    for closure in &CLOSURES[1..] {
        let child = format!("child = \"end b\"\n{closure}");
        let text = [
            "[nodes]\na = [0, 0, 0]\nb = [2, 0, 0]\n",
            &body("a"),
            &body("b"),
            &arm("end a", "a", [1.0, 0.2, 0.0]),
            &arm("end b", "b", [1.0, 0.2, 0.0]),
            &joint("ball", "spherical", "end a", &child),
            "[[initial]]\nnode = \"a\"\ndisplacement = [0.1, 0, 0.3]\n\
             [[initial]]\nnode = \"b\"\ndisplacement = [0, 0, 0.1]\nrotation = [0, 0, 0]\n",
            RUN,
        ];
        let job = started(&text.concat());
        for (node, exact) in [("a", [0.1, 0.0, 0.3]), ("b", [0.0, 0.0, 0.1])] {
            let d = job.context.node_state(job.context.find(node).unwrap()).d;
            let off = (d - Vector3::from(exact)).norm();
            assert!(off < 1e-9, "{node} {closure}: {d}");
        }
    }
}

/// Corrections of a tilt that are lost in its rounding, beside others that are not, do not keep a loop open.
#[test]
fn a_loop_is_closed_where_its_gaps_are_smaller_than_rounding_errors() {
    let tip = |name: &str, of: &str| arm(name, of, [1.993, 0.0468, -0.323]);
    let text = [
        "[nodes]\nA = [0, 0, 0]\nB = [0.9385, 0.6883, -0.022]\n",
        &["A", "B"].map(fixed).concat(),
        &joint(
            "driver",
            "constant_velocity",
            "A",
            "axis = [0.902, 0.3513, 0.251]\nsecond_axis = [0.6872, 0.3744, 0.6226]",
        ),
        &tip("driver tip", "driver"),
        &joint("rod", "cylindrical", "B", "axis = [-0.0639, 0.9344, 0.3504]"),
        &tip("rod tip", "rod"),
        &joint(
            "close",
            "planar",
            "driver tip",
            "child = \"rod tip\"\naxis = [0.0495, 0.1424, 0.9886]\nsecond_axis = [-0.151, -0.9773, 0.1484]",
        ),
        &["driver", "rod"].map(body).concat(),
        &motion(0.1, 0.01),
    ]
    .concat();
    for closure in CLOSURES {
        let closed = format!("child = \"rod tip\"\n{closure}");
        recorded(
            "start_rounding",
            &text.replace("child = \"rod tip\"", &closed),
        );
    }
}

/// A crank that is prescribed over turns in statics: its rocker swings, and no coordinate loses a turn, even if steps
/// begin with a whole one.
#[test]
fn a_prescribed_crank_takes_a_loop_along_in_statics() {
    let loads = "[[loads]]\ngravity = [0.3, -9.81, 0.1]\n[analysis.static]\n";
    let [map, multipliers, _] = CLOSURES;
    for (turns, closure) in [
        (2.0, map),
        (10.0, map),
        (2.0, multipliers),
        (10.0, multipliers),
    ] {
        let crank = format!("prescribed = {{ proportional = {} }}", turns * TAU);
        let model = [GROUND, &four_bar([&crank, "", ""], closure), loads];
        let Ran { rows, result, .. } = run_of("start_crank", &model.concat());
        let count = |key: &str| result["statistics"][key].as_u64().unwrap();
        assert!(3 * count("rejected") < count("steps"), "{closure}");
        for row in &rows {
            let [crank, coupler, rocker] = ["A", "B", "D"].map(|joint| number(row, joint));
            let exact = linkage(crank);
            let off = apart(coupler, exact[0]).max(apart(rocker, exact[1]));
            assert!(off < 1e-9, "{coupler} and {rocker} at {crank}, {closure}");
            let turned = rocker.abs().max((crank + coupler).abs());
            assert!(turned < PI, "{coupler} and {rocker} at {crank}, {closure}");
            assert_eq!(row["unstable"], "0", "at {crank}, {closure}");
        }
    }
}
