//! Statics is not content with its predictions: what is small beside other loads, or beside the
//! rounding errors of stiff neighbours, is corrected too. All against closed forms.

use super::solved;
use crate::support::beams::line;
use crate::support::closures::{beam_line, fixed, hinge};
use crate::support::prelude::*;
use crate::support::program::assert_close;

/// Runs a text to the end of its loads, under an analysis of its own.
fn run(text: &str, analysis: &str) -> Context {
    located(text, analysis).unwrap().0
}

/// The same, with the loads at which events on the path were located.
fn located(text: &str, analysis: &str) -> Result<(Context, Vec<f64>), StaticsError> {
    let mut found = vec![];
    let text = format!("{text}\n{analysis}\n");
    let context = solved(&text, &mut |step| found.extend(step.event.map(|_| step.t)))?;
    Ok((context, found))
}

/// The displacement of a node along an axis.
fn moved(context: &Context, node: &str, axis: usize) -> f64 {
    let node = context.find(node).unwrap();
    context.coordinate(node, axis).unwrap()[0]
}

const ANALYSES: [&str; 2] = ["[analysis.static]", "[analysis.arc_length]"];

#[test]
fn a_column_bends_by_the_smallest_lateral_load() {
    // A cantilever column, EI = L = 1, under P and e across it at its tip: (tan k/k − 1) e/P, k² = P
    // (Timoshenko & Gere 1961, Theory of Elastic Stability, section 1.11).
    for slenderness in [1e3, 1e4, 1e5] {
        for (part, e) in [
            (0.5, 1e-6),
            (0.9, 1e-7),
            (0.9, 1e-8),
            (0.9, 1e-9),
            (0.99, 1e-8),
        ] {
            let stiff = slenderness * slenderness;
            let P = part * std::f64::consts::PI.powi(2) / 4.0;
            let stiffness = format!("EA = {stiff}, GA = [{stiff}, {stiff}], GJ = 1, EI = [1, 1]");
            let load = format!("[[loads]]\nnode = \"B\"\nforce = [{}, {e}, 0]\n", -P);
            let text = line(&stiffness, 8, 3, &(fixed("A") + &load));
            for analysis in ANALYSES {
                let found = moved(&run(&text, analysis), "B", 1);
                let exact = e / P * (P.sqrt().tan() / P.sqrt() - 1.0);
                let gap = (found / exact - 1.0).abs();
                // Shortening and shear, of the order of P/EA, grow like the deflection.
                let allowed = (1e-6 + 10.0 / stiff) / (1.0 - part);
                assert!(gap < allowed, "{analysis}, {part}, {e:e}: off by {gap:.1e}");
            }
        }
    }
}

/// A stiff lever of length 1 on a hinge of moment φ + k₃ φ³, pulled along by F and turned by P.
fn lever(stiff: f64, k3: f64, [F, P]: [f64; 2]) -> String {
    let spring = format!("spring = {{ k = 1, k3 = {k3:e} }}");
    [
        &format!(
            "[sections.s]\nstiffness = {{ EA = {stiff}, GA = [{stiff}, {stiff}], GJ = {stiff}, \
             EI = [{stiff}, {stiff}] }}\n"
        ),
        "[nodes]\nroot = [0, 0, 0]\ntip = [1, 0, 0]\n",
        &fixed("root"),
        &hinge("hinge", "root", &spring),
        &beam_line("lever", ["hinge", "tip"], 1, "s"),
        &format!(
            "[[loads]]\nnode = \"tip\"\nforce = [{F}, 0, 0]\ntime = {{ constant = 1 }}\n\
             [[loads]]\nnode = \"tip\"\nforce = [0, {P}, 0]\n"
        ),
    ]
    .concat()
}

/// Its small turn, the real root of k₃ φ³ + (1 + F) φ = P, by Cardano's formula.
fn turn(k3: f64, [F, P]: [f64; 2]) -> f64 {
    let half = 0.5 * P / k3;
    let root = (half * half + ((1.0 + F) / (3.0 * k3)).powi(3)).sqrt();
    (half + root).cbrt() + (half - root).cbrt()
}

#[test]
fn a_soft_spring_among_stiff_beams_finds_its_place() {
    let (k3, loads) = (1e13, [1.0, 3e-6]);
    let exact = turn(k3, loads);
    for stiff in [1e8, 1e10] {
        for analysis in ANALYSES {
            let found = moved(&run(&lever(stiff, k3, loads), analysis), "tip", 1);
            assert_close(found / exact, 1.0, 1e-6, format!("{analysis}, {stiff:e}"));
        }
    }
}

#[test]
fn what_converges_slowly_is_not_called_rounding() {
    let once = "[analysis.static]\nsteps = 1";
    let right = |text: &str, k3: f64, loads: [f64; 2], most: f64| match located(text, once) {
        Ok((model, _)) => {
            assert_close(moved(&model, "tip", 1) / turn(k3, loads), 1.0, most, text);
        }
        Err(error) => assert!(matches!(error, StaticsError::Step(_)), "{error}"),
    };
    // In one step, of which the cubic spring leaves two thirds with each correction.
    let (k3, loads) = (1.4e21, [0.02, 2.4e-9]);
    right(&lever(3.5e10, k3, loads), k3, loads, 1e-3);
    // Beside it something that moves much further has settled: 1e-9 of its moment is let go.
    let beside = [
        "[sections.soft]\nstiffness = { EA = 1e3, GA = [1e3, 1e3], GJ = 1, EI = [1, 1] }\n",
        &beam_line("soft", ["foot", "end"], 4, "soft"),
        &fixed("foot"),
        "[[loads]]\nnode = \"end\"\nforce = [0, 0.25, 0]\n",
    ]
    .concat();
    for stiff in [1.5e5, 1e7, 1e9, 1.5e11] {
        let (k3, loads) = (2.87e18, [0.0, 8.84e-9]);
        let text = lever(stiff, k3, loads) + &beside;
        let nodes = "tip = [1, 0, 0]\n";
        let more = format!("{nodes}foot = [0, 0, 1]\nend = [1, 0, 1]\n");
        let most = 1e-3 + 1e-9 * 0.25 / loads[1];
        right(&text.replacen(nodes, &more, 1), k3, loads, most);
    }
}

/// Two springs of stiffness `k` from (∓1, 0) to (0, `h`), pressed down there. There is nothing but
/// springs in this model.
pub(super) fn truss(k: f64, h: f64, P: f64) -> String {
    format!(
        "[nodes]\nA = [-1, 0, 0]\nB = [1, 0, 0]\nT = [0, {h}, 0]\n\
         [[springs]]\nname = \"s1\"\nnodes = [\"A\", \"T\"]\nstiffness = {k}\n\
         [[springs]]\nname = \"s2\"\nnodes = [\"T\", \"B\"]\nstiffness = {k}\n\
         [[supports]]\nnode = \"A\"\nfix = \"position\"\n\
         [[supports]]\nnode = \"B\"\nfix = \"position\"\n\
         [[supports]]\nnode = \"T\"\nfix = [\"z\"]\n\
         [[loads]]\nnode = \"T\"\nforce = [0, {}, 0]\n",
        -P
    )
}

/// What that truss carries where the crown is `d` lower, P = 2 k (l₀ − l) (h − d)/l.
fn carried(k: f64, h: f64, d: f64) -> f64 {
    // l₀ − l by l₀² − l² = d (2 h − d), without loss of digits.
    let (rest, now) = (1.0_f64.hypot(h), 1.0_f64.hypot(h - d));
    let shorter = d * (2.0 * h - d) / (rest + now);
    2.0 * k * shorter * (h - d) / now
}

#[test]
fn paths_do_not_jump_over_limit_points_of_shallow_structures() {
    let fine = |step: f64| format!("load_scale = 1e6\nmax_step = {step}\nfirst_step = {step}");
    for (h, steps) in [
        (1e-1, String::new()),
        (1e-2, String::new()),
        (1e-3, fine(2e-5)),
        (1e-4, fine(2e-6)),
    ] {
        assert_limits(h, 2.0, &steps).unwrap();
    }
    // Steps in which loads outweigh displacements are shortened, or it is said that they are too long.
    for h in [3e-1, 3e-2, 3e-3, 1e-3] {
        for scale in [1.0, 10.0] {
            if let Err(error) = assert_limits(h, 2.0, &format!("load_scale = {scale}")) {
                let step = matches!(error, StaticsError::Step(_));
                assert!(step, "{h}, {scale}: {error}");
            }
        }
    }
    // A step that ends far behind both, where its prediction happens to lead, has no way back.
    for (h, times) in [
        (0.0145, 9.4),
        (0.0068, 19.5),
        (0.05, 20.0),
        (0.016, 80.0),
        (0.034, 175.0),
    ] {
        assert_limits(h, times, "").unwrap();
    }
}

/// Follows the truss of a rise over both of its limit points: dP/dy = 0 where l³ = l₀ at the height y,
/// there and at −y. A load of so many times the limit is reached behind both.
fn assert_limits(h: f64, times: f64, steps: &str) -> Result<(), StaticsError> {
    let rest = 1.0_f64.hypot(h);
    let y = (rest.powf(2.0 / 3.0) - 1.0).sqrt();
    let limit = carried(1.0, h, h - y);
    let analysis = format!("[analysis.arc_length]\nrecord = [\"turning_point\"]\n{steps}");
    let (_, loads) = located(&truss(1.0, h, times * limit), &analysis)?;
    assert_eq!(loads.len(), 3, "{h}, {steps}: {loads:?}");
    for (load, expected) in loads.iter().zip([1.0 / times, -1.0 / times, 1.0]) {
        assert_close(*load, expected, 1e-6, format!("{h}, {steps}"));
    }
    Ok(())
}

#[test]
fn a_shallow_truss_of_springs_feels_small_loads() {
    let (k, h) = (1e9, 1e-3);
    for P in [1e-6, 1e-4, 1e-2] {
        for analysis in ["[analysis.static]\nsteps = 50", ANALYSES[0], ANALYSES[1]] {
            let d = -moved(&run(&truss(k, h, P), analysis), "T", 1);
            assert!(d < 0.4 * h, "before the limit load");
            let what = format!("{analysis}, P = {P:e}");
            assert_close(carried(k, h, d) / P, 1.0, 1e-8, what);
        }
    }
}
