//! Rigid bodies with a fixed point, and free ones.

use super::bent::stiffer;
use super::case::{CaseProblem, CaseReport, largest, peak, with_scheme, with_step};
use super::motion::{History, observed_order, richardson};
use crate::input::{Fix, Group, ModelFile};
use crate::output::plot::PlotCurve;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use pullback_elements::model::NodeState;

/// Inclination of the axis e3 of a node.
fn nutation(state: &NodeState) -> f64 {
    let axis = state.R.column(2);
    axis.x.hypot(axis.y).atan2(axis.z)
}

/// The smallest and the largest value of a curve, which are positive.
fn extremes(curve: &[(f64, f64)]) -> [f64; 2] {
    let values = || curve.iter().map(|p| p.1);
    let smallest = values().fold(f64::INFINITY, f64::min);
    [smallest, largest(values())]
}

/// Case 3 of [M04] and R02: the fast symmetrical top. Its plot redraws Fig. 33.
pub(super) fn top(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("top")?;
    let source = "exact: cubic of the top, R02";
    let converged = report.motion(&with_step(&file, 1e-4), &["O"])?;
    let angle = converged.curve(0, nutation);
    let [smallest, largest] = extremes(&angle);
    report.compare("smallest nutation", smallest, 0.3, 1e-5, source);
    report.compare("largest nutation", largest, 0.326733714644854, 1e-5, source);
    // Maxima of the nutation are a period apart.
    let maxima: Vec<usize> = (1..angle.len() - 1)
        .filter(|&k| angle[k].1 > angle[k - 1].1 && angle[k].1 >= angle[k + 1].1)
        .collect();
    let (Some(&first), Some(&last)) = (maxima.first(), maxima.last()) else {
        return Err(CaseProblem::Setup("the top does not nutate"));
    };
    let turns = (maxima.len() - 1) as f64;
    let times = [first, last].map(|k| peak(&angle, k).0);
    let source = "exact: complete elliptic integral, R02";
    let period = (times[1] - times[0]) / turns;
    report.compare("nutation period", period, 0.6822560158311819, 1e-4, source);
    let precession = [first, last].map(|k| {
        let axis = converged.nodes[0][k].R.column(2).into_owned();
        axis.x.atan2(-axis.y)
    });
    let rate = (precession[1] - precession[0]) / (converged.t[last] - converged.t[first]);
    let source = "exact: mean precession, R02";
    report.compare("precession rate", rate, 0.416425036235478, 1e-4, source);

    // `tests/studies/mechanisms.rs`
    let source = "independent: quaternion, Runge-Kutta";
    for (t, exact) in [
        (
            0.5,
            [
                0.07699884072809793,
                -0.30016633557043243,
                0.9507740791148798,
            ],
        ),
        (
            1.0,
            [0.12709142991869804, -0.2944097797667466, 0.9471909258533447],
        ),
        (
            1.5,
            [0.16761536545436162, -0.254168428214729, 0.9525248024920164],
        ),
    ] {
        let axis: Vector3<f64> = converged.at(0, t).R.column(2).into();
        let what = format!("axis at t = {t}");
        report.compare_vector(&what, axis, exact, 1e-4, source);
    }
    as_published(report, &file)
}

/// The published figure: a rigid body, and one beam element that is stiff or flexible.
fn as_published(report: &mut CaseReport, file: &ModelFile) -> Result<(), CaseProblem> {
    let rigid = report.motion(file, &["O"])?;
    let beam = report.model("top_beam")?;
    let stiff = report.motion(&beam, &["O"])?;
    let flexible = report.motion(&stiffer(&beam, 0.01), &["O"])?;
    let curves = [&rigid, &stiff, &flexible].map(|h| h.curve(0, nutation));
    let both = curves[0].iter().zip(&curves[1]);
    let apart = largest(both.map(|(a, b)| a.1 - b.1));
    // A hundredth of the nutation, 0.0267: the width of a line.
    let source = "published: they coincide in the plot (Mäkinen 2004, case 3)";
    report.compare("stiff beam off the rigid body", apart, 0.0, 2.67e-4, source);
    let [least, most] = extremes(&curves[0]);
    // The range is published to four digits.
    let source = "published: nutation in [0.3, 0.3267] (Mäkinen 2004, case 3)";
    report.compare("plot: smallest nutation", least, 0.3, 5e-5, source);
    report.compare("plot: largest nutation", most, 0.3267, 5e-5, source);
    let names = ["rigid body", "stiff beam", "flexible beam"];
    let curves = names.into_iter().zip(curves);
    // Every eighth step suffices for a line.
    let thin = |c: Vec<(f64, f64)>| c.into_iter().step_by(8).collect();
    report.figure(
        "Fast symmetrical top",
        ["time t", "nutation angle (rad)"],
        curves
            .map(|(name, c)| PlotCurve::new(name, thin(c)))
            .collect(),
    )
}

/// R01: the heavy top.
pub(super) fn heavy_top(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let exact = [
        (0.1, [0.42129666, 0.89457197, -0.1491647]),
        (0.2, [0.6055505613771, 0.5989576817949, -0.52398302743]),
        (1.0, [0.1733439640984, 0.6400885920706, -0.7484907911336]),
    ];
    let vector = Vector3::new(-0.2782857193376, 0.5318246113342, -0.3201761427363);
    let turned = Quaternion::from_parts(0.7329439806797, vector);
    let top = report.model("heavy_top")?;
    // The same body with a pinned node instead of a joint.
    let mut pinned = top.clone();
    pinned.joints.clear();
    pinned.probes.clear();
    pinned.nodes.insert("top".to_owned(), [0.0; 3]);
    pinned.nodes.remove("ground");
    pinned.supports[0].node = "top".to_owned();
    pinned.supports[0].fix = Some(Fix::Group(Group::Position));
    for (name, file) in [("fixed point", &pinned), ("spherical joint", &top)] {
        let [a, b, c] = report.motions([4e-4, 2e-4, 1e-4].map(|h| with_step(file, h)), &["top"])?;
        let axis = |h: &History, t: f64| -> Vector3<f64> { h.at(0, t).R.column(1).into() };
        let source = "exact: order-8 Runge-Kutta in extended precision, R01";
        for (t, x) in exact {
            let [coarse, fine] = [&b, &c].map(|h| axis(h, t).into());
            let what = format!("{name}, extrapolated position at t = {t}");
            let position: [f64; 3] = richardson(coarse, fine);
            report.compare_vector(&what, position, x, 1e-5, source);
        }
        // The attitude turns 24 times: changes of chart at other times for each step size spoil the extrapolation
        // of its error.
        let third = with_scheme(file, "radau");
        let third = report.motion(&with_step(&third, 1e-4), &["top"])?;
        let what = format!("{name}, body axis");
        compare_axes(report, &what, axes(&third), turned, source);
        let what = format!("{name}, body rate at t = 1 over 150");
        let exact = Vector3::new(-0.8220781016826, 150.0, -5.9232913481173);
        let [rate, exact] = [body_rate(&third), exact].map(|r| (r / 150.0).into());
        report.compare_vector(&what, rate, exact, 1e-5, source);
        let order = observed_order(&[&a, &b, &c].map(|h| axis(h, 1.0)));
        report.compare_order(format!("{name}, order in the step"), order, 0.1);
    }
    Ok(())
}

/// Angular velocity in axes of the body, of the first recorded node at t = 1.
fn body_rate(run: &History) -> Vector3<f64> {
    let state = run.at(0, 1.0);
    state.R.transpose() * state.omega
}

/// The axes of the first recorded node at t = 1.
fn axes(run: &History) -> [[f64; 3]; 3] {
    let R = run.at(0, 1.0).R;
    [0, 1, 2].map(|k| Vector3::from(R.column(k)).into())
}

/// Compares the axes of a body at t = 1 with those of a quaternion.
fn compare_axes(
    report: &mut CaseReport,
    what: &str,
    axes: [[f64; 3]; 3],
    exact: Quaternion<f64>,
    source: &str,
) {
    let exact = UnitQuaternion::new_normalize(exact);
    for (k, axis) in axes.into_iter().enumerate() {
        let what = format!("{what} {} at t = 1,", k + 1);
        let exact = exact * Vector3::ith(k, 1.0);
        report.compare_vector(&what, axis, exact.into(), 1e-5, source);
    }
}

/// Time between two zeros, downwards, of the second component of a body's rate.
fn period(run: &History) -> f64 {
    let rate: Vec<(f64, f64)> = (run.t.iter().zip(&run.nodes[0]))
        .map(|(&t, s)| (t, (s.R.transpose() * s.omega).y))
        .collect();
    let zeros: Vec<f64> = rate
        .windows(2)
        .filter(|w| w[0].1 > 0.0 && w[1].1 <= 0.0)
        .map(|w| w[0].0 + (w[1].0 - w[0].0) * w[0].1 / (w[0].1 - w[1].1))
        .collect();
    match zeros[..] {
        [first, .., last] => (last - first) / (zeros.len() - 1) as f64,
        _ => f64::NAN,
    }
}

/// R03: a free body near its middle axis.
pub(super) fn free_body(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("free_body")?;
    let steps = [2e-3, 1e-3, 5e-4];
    let [a, b, c] = report.motions(steps.map(|h| with_step(&file, h)), &["O"])?;
    let omega = richardson(body_rate(&b).into(), body_rate(&c).into());
    let source = "exact: order-8 Runge-Kutta in extended precision, R03";
    let exact = [-8.74573438, 4.84996187, 5.05001221];
    let what = "extrapolated body rate at t = 1";
    report.compare_vector(what, omega, exact, 1e-5, source);
    let exact = Quaternion::new(0.24270299, 0.11814413, -0.82272015, -0.50026871);
    let [coarse, fine] = [axes(&b), axes(&c)];
    let extrapolated = [0, 1, 2].map(|k| richardson(coarse[k], fine[k]));
    let what = "extrapolated body axis";
    compare_axes(report, what, extrapolated, exact, source);
    let period = richardson([period(&b)], [period(&c)])[0];
    let source = "exact: Jacobi's elliptic functions, R03";
    let what = "extrapolated period";
    report.compare(what, period, 3.91057341972687, 1e-4, source);
    let order = observed_order(&[&a, &b, &c].map(body_rate));
    report.compare_order("order in the step", order, 0.1);
    // Energy is conserved to the order of the scheme only.
    let drift = |h: &History| {
        let energy = h.total_energy();
        let first = energy[0].1;
        let relative = energy.iter().map(|&(t, e)| (t, (e - first) / first));
        relative.collect::<Vec<_>>()
    };
    let curves = [drift(&a), drift(&b), drift(&c)];
    let size = |c: &[(f64, f64)]| largest(c.iter().map(|p| p.1));
    let order = (size(&curves[0]) / size(&curves[1])).log2();
    report.compare_order("order of the energy error", order, 0.1);
    // The scheme with energy projection, at a coarse step.
    let kept = with_scheme(&file, "projected-newmark");
    let kept = report.motion(&with_step(&kept, 1e-2), &["O"])?;
    let spins: Vec<Vector3<f64>> = kept.balances.iter().map(|a| a.momentum.angular).collect();
    let changes = (spins.iter()).map(|L| (L - spins[0]).norm() / spins[0].norm());
    let source = "exact: conservation";
    for (what, worst) in [
        ("energy", size(&drift(&kept))),
        ("angular momentum", largest(changes)),
    ] {
        let what = format!("energy-momentum scheme, change of {what}");
        report.compare(what, worst, 0.0, 1e-11, source);
    }
    let curves = steps.iter().zip(curves);
    report.figure(
        "Free body near its middle axis: energy error by steps h",
        ["time t", "relative error of the energy"],
        curves
            .map(|(h, c)| PlotCurve::new(format!("h = {h}"), c))
            .collect(),
    )
}
