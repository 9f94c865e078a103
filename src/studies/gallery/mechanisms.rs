//! Mechanisms in space: Bricard's, Bauchau's.

use super::case::{CaseProblem, CaseReport, largest, meshed, with_scheme, with_step};
use super::linkages::gap;
use super::motion::{History, continued, observed_order, richardson};
use crate::input::ModelFile;

/// Values, rates and accelerations of joint coordinates at the end, and the largest gap between
/// pairs of nodes during the motion.
pub(super) fn joints<const N: usize>(
    report: &CaseReport,
    file: &ModelFile,
    step: f64,
    names: [&str; N],
    pairs: &[[&str; 2]],
    seen: &mut dyn FnMut([f64; N]),
) -> Result<([[f64; N]; 3], f64), CaseProblem> {
    let nodes = names.map(|name| format!("{name} angle"));
    let watched = nodes.iter().map(String::as_str);
    let watched: Vec<&str> = watched
        .chain(pairs.as_flattened().iter().copied())
        .collect();
    let (mut run, nodes) = report.begin(&with_step(file, step), &watched)?;
    let (nodes, ends) = nodes.split_at(N);
    let (mut end, mut gap) = ([[f64::NAN; N]; 3], 0.0_f64);
    while run.step()?.is_some() {
        let model = run.system();
        for (k, &node) in nodes.iter().enumerate() {
            let motion = model.coordinate(node, 0).unwrap_or([f64::NAN; 3]);
            for d in 0..3 {
                end[d][k] = motion[d];
            }
        }
        for pair in ends.chunks_exact(2) {
            let [a, b] = [pair[0], pair[1]].map(|n| model.node_state(n).position);
            gap = gap.max((a - b).norm());
        }
        seen(end[0]);
    }
    Ok((end, gap))
}

/// Bricard's mechanism, an overconstrained loop with one degree of freedom.
pub(super) fn bricard(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("bricard")?;
    let names = [
        "hinge 1", "hinge 2", "hinge 3", "hinge 4", "hinge 5", "hinge 6",
    ];
    let (mut worst, mut uneven, mut travel) = (0.0_f64, 0.0_f64, 0.0_f64);
    let (_, gap) = joints(report, &file, 4e-3, names, &[["end 5", "last"]], &mut |x| {
        // Turned by a right angle where it is drawn, on a cube: cos of 90° + x.
        let [a, b] = [-x[0].sin(), -x[1].sin()];
        worst = worst.max((a + b + a * b).abs());
        let same = |k: usize| (x[k] - x[k % 2]).abs();
        uneven = (0..6).map(same).fold(uneven, f64::max);
        travel = travel.max(x[0].abs());
    })?;
    let source = "exact: threefold-symmetric Bricard linkage, twist 90° (Chen, You & Tarnai 2005)";
    let what = "cos θ + cos φ + cos θ cos φ, largest in 1250 steps";
    report.compare(what, worst, 0.0, 1e-12, source);
    let what = "largest difference of every other hinge";
    report.compare(what, uneven, 0.0, 1e-12, source);
    report.compare_gap("largest gap of the loop", gap, 1e-13);
    let run = report.motion(&with_step(&file, 2e-3), &["end 2"])?;
    report.compare_energy(&run, 1e-3);
    if travel < 0.5 {
        return Err(CaseProblem::Setup(
            "it does not move far enough to prove anything",
        ));
    }
    // `tests/studies/mechanisms.rs`
    let exact = [0.22555647346845764, -0.8533487686651305];
    let source = "exact: equation of its one freedom, closed-form kinematics, Runge-Kutta";
    let closure = [("joints.\"hinge 6\".closure", "multipliers")];
    let enforced = with_scheme(&report.model_with("bricard", &closure)?, "ga:0.8");
    for (file, how) in [(&file, "a map"), (&enforced, "multipliers")] {
        let mut ends = Vec::new();
        for step in [4e-3, 2e-3] {
            ends.push(joints(report, file, step, names, &[], &mut |_| {})?.0);
        }
        for (d, what) in ["hinge 1", "rate of hinge 1"].into_iter().enumerate() {
            let [found] = richardson([ends[0][d][0]], [ends[1][d][0]]);
            let what = format!("{what} at t = 5, closed by {how}");
            report.compare(what, found, exact[d], 1e-4, source);
        }
    }
    Ok(())
}

/// D06: a linkage that moves only by the flexibility of its bars.
pub(super) fn misaligned(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("four_bar_misaligned")?;
    let watched = ["C", "tip of bar 3", "axis A", "axis D"];
    let turn = |run: &History, node: usize| {
        let turns = continued(&run.nodes[node]);
        turns.last().map_or(f64::NAN, |psi| psi.z)
    };
    // A parallelogram where the axis is not misaligned: bar 3 turns like bar 1.
    let axis = [("joints.\"axis C\".axis", "[0, 0, 1]")];
    let aligned = report.model_with("four_bar_misaligned", &axis)?;
    let run = report.motion(&with_step(&aligned, 8e-3), &watched)?;
    let source = "exact: rigid parallelogram";
    let what = "aligned: angle of bar 3 at t = 12";
    report.compare(what, turn(&run, 3), -7.2, 1e-3, source);
    let off = |run: &History| largest(run.nodes[0].iter().map(|s| s.d.z));
    let what = "aligned: largest deflection at C";
    report.compare(what, off(&run), 0.0, 1e-12, source);
    let turns = |elements: usize, order: usize, loads: &[f64]| {
        let file = meshed(&file, elements, order);
        let records = report.build(&file, "C")?.at_loads(loads)?;
        Ok::<_, CaseProblem>(records.iter().map(|r| r.state.d).collect::<Vec<_>>())
    };
    let mut ends = Vec::new();
    for elements in [4, 8, 16] {
        ends.push(turns(elements, 1, &[1.0, 2.0])?[1]);
    }
    // Bar 1 turns by 0.012 each, so that no other equilibrium is met beyond the flat positions.
    let loads: Vec<f64> = (1..=600).map(|k| 0.02 * f64::from(k)).collect();
    let path = turns(4, 2, &loads)?;
    let found = observed_order(&[ends[0], ends[1], ends[2]]);
    let source = "theory: linear elements, integrated at their middle";
    let what = "order in the mesh of C, bar 1 turned by 1.2";
    report.compare(what, found, 2.0, 0.05, source);
    let source = "independent: Reissner's rods by shooting, followed by the length of the path";
    let angles = [0.6, 0.9, 1.2, 1.8, 3.6, 7.2];
    let equilibria = [
        [0.067_737_263_413, -0.020_978_222_108, -0.002_043_880_842],
        [0.093_969_805_269, -0.045_464_886_765, -0.003_023_838_218],
        [0.111_811_237_120, -0.076_699_899_577, -0.003_834_949_750],
        [0.094_526_996_393, -0.046_255_657_519, -0.004_053_579_594],
        [-0.110_111_559_952, -0.072_324_531_427, 0.001_315_285_227],
        [0.095_210_318_522, -0.047_059_634_564, -0.003_075_281_311],
    ];
    for (angle, exact) in angles.into_iter().zip(equilibria) {
        let what = format!("C in equilibrium, bar 1 turned by {angle},");
        let k = (angle / 0.012_f64).round() as usize;
        report.compare_vector(&what, path[k - 1], exact, 3e-8, source);
    }
    let run = report.motion(&with_step(&meshed(&file, 4, 2), 8e-3), &watched)?;
    // So slow that inertia and steps contribute 1e-7.
    let what = "largest deflection at C across the plane";
    report.compare(what, off(&run), 0.004_264_418_4, 3e-7, source);
    // Where the bars lie in one line the bent ones let it turn back as an antiparallelogram.
    let what = "angle of bar 3 at t = 12, which turns back at the flat positions";
    report.compare(what, turn(&run, 3), -0.918_418_949_6, 1e-7, source);
    report.compare_gap("largest gap at C", gap(&run, [0, 1]), 1e-14);
    Ok(())
}

/// The same in static equilibrium, with decreasing misalignment.
pub(super) fn hardly_misaligned(report: &mut CaseReport) -> Result<(), CaseProblem> {
    // Bar 1 turns by 0.15 each.
    let loads: Vec<f64> = (1..=8).map(|k| 0.25 * f64::from(k)).collect();
    let mut found = Vec::new();
    for degrees in [0.5_f64, 0.25] {
        let (s, c) = degrees.to_radians().sin_cos();
        let axis = [("joints.\"axis C\".axis", &*format!("[{s}, 0, {c}]"))];
        let file = report.model_with("four_bar_misaligned", &axis)?;
        let records = report.build(&meshed(&file, 4, 2), "C")?.at_loads(&loads)?;
        found.push([3, 5, 7].map(|k| records[k].state.d.z * c / s));
    }
    // The other sign of the misalignment reverses the bending: the remainder is quadratic, and with both signs
    // of fourth order, 6e-9.
    let limit = richardson(found[0], found[1]);
    let source = "linear theory: a grid of Timoshenko beams without mass, solved apart";
    for (found, angle, exact) in [
        (limit[0], 0.6, -0.023_453_943_60),
        (limit[1], 0.9, -0.034_707_914_43),
        (limit[2], 1.2, -0.044_023_635_82),
    ] {
        let what = format!("deflection at C over misalignment, bar 1 turned by {angle}");
        report.compare(what, found, exact, 3e-10, source);
    }
    Ok(())
}
