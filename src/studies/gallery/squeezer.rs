//! Andrews' squeezer against its published reference.

use super::case::{CaseProblem, CaseReport, largest};
use super::mechanisms::joints;

/// Angle, rate and acceleration of each joint of Andrews' mechanism at t = 0.03.
const PUBLISHED: [[f64; 3]; 7] = [
    [15.81077119629904, 1139.920302151208, -24631.76316945196],
    [-15.75637105984298, -1424.379294994111, 51850.37701610329],
    [0.04082224013073101, 11.03291221937134, 324102.5686413781],
    [-0.5347301163226948, 19.29337464421385, 566749.3645176213],
    [0.5244099658805303, 0.5735699284790808, 16743.62929479361],
    [0.5347301163226948, -19.29337464421385, -566749.3645176222],
    [1.048080741042263, 0.3231791658026955, 9826.520791458423],
];
const NAMES: [&str; 7] = ["beta", "theta", "gamma", "phi", "delta", "omega", "epsilon"];
/// Accelerations for these angles and rates by the equations of the test set (`tests/studies/andrews.rs`), and
/// their changes for errors of angles and rates of size
/// [`TRUST`].
const FOLLOWING: [[f64; 2]; 7] = [
    [-24_631.764_251, 5e-7],
    [51_850.321_376, 4e-7],
    [324_102.600_587, 3.2e-9],
    [566_749.421_789, 3.2e-9],
    [16_743.635_403, 2e-8],
    [-566_749.421_789, 3.2e-9],
    [9_826.507_826, 5e-8],
];
/// Relative accuracy of the published values according to R06.
const TRUST: f64 = 1e-9;

/// R06: seven bodies, three loops.
pub(super) fn run(report: &mut CaseReport) -> Result<(), CaseProblem> {
    let file = report.model("squeezer")?;
    let pairs = [["P", "K3 end"], ["P", "K4 end"], ["P", "K6 end"]];
    let mut runs = Vec::new();
    let mut gap = 0.0_f64;
    for step in [2e-5, 1e-5, 5e-6] {
        let (end, open) = joints(report, &file, step, NAMES, &pairs, &mut |_| {})?;
        runs.push(end);
        gap = gap.max(open);
    }
    // The trapezoidal rule is symmetric: its errors have even powers of the step.
    let mix = |coarse: &[[f64; 7]; 3], fine: &[[f64; 7]; 3], power: f64| -> [[f64; 7]; 3] {
        std::array::from_fn(|d| {
            std::array::from_fn(|k| fine[d][k] + (fine[d][k] - coarse[d][k]) / (power - 1.0))
        })
    };
    let once = [mix(&runs[0], &runs[1], 4.0), mix(&runs[1], &runs[2], 4.0)];
    let found = mix(&once[0], &once[1], 16.0);
    let source = "published: IVP test set II-9 (PSIDE, 1e-14), R06";
    // The accuracy of beta as a time.
    let late = TRUST * PUBLISHED[0][0] / PUBLISHED[0][1];
    let most = largest(PUBLISHED.map(|[.., a]| a));
    for (k, name) in NAMES.into_iter().enumerate() {
        let [q, v, a] = PUBLISHED[k];
        let what = format!("angle {name} at t = 0.03");
        report.compare(what, found[0][k], q, TRUST * q.abs(), source);
        let what = format!("rate of {name} at t = 0.03");
        let tolerance = TRUST * v.abs() + late * a.abs();
        report.compare(what, found[1][k], v, tolerance, source);
        // They are 1.0e-7 of the largest off those below.
        let what = format!("acceleration of {name} at t = 0.03");
        report.compare(what, found[2][k], a, 1.2e-7 * most, source);
    }
    let source = "equations of the IVP test set at its published angles and rates";
    for (k, name) in NAMES.into_iter().enumerate() {
        let what = format!("following acceleration of {name}");
        let [a, part] = FOLLOWING[k];
        report.compare(what, found[2][k], a, part * a.abs(), source);
    }
    let source = "exact: the loops are closed at all times";
    report.compare("largest gap at P", gap, 0.0, 1e-15, source);
    Ok(())
}
