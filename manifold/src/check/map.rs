//! The laws of a map: everything that [`Map`] offers is a derivative of φ.

use super::report::Report;
use super::sample::{CLEARANCE, Random};
use crate::map::{Kinematics, Map, derived};
use nalgebra::{SMatrix, SVector};

/// Time at which maps are asked: not zero, so that a forgotten t shows.
pub(super) const TIME: f64 = 0.37;

/// Largest relative difference between a closed form and the exact derivative.
///
/// Both are sums of some hundred terms, each with a relative error of 1e-16, and cancel at worst
/// like the third power of the distance 0.3 to the edge of a rotation chart: below 1e-12. A wrong
/// formula differs in the first digits.
pub(super) const CLOSED_FORM: f64 = 1e-10;

/// Checks every law of a map at every place within its domain.
pub fn map<M, const D: usize, const N: usize>(map: &M) -> Report
where
    M: Map<D, N>,
{
    let mut report = Report::new(short_name::<M>());
    let mut random = Random::default();
    let mut asked = 0;
    for (name, q) in random.places(D) {
        let q = SVector::<f64, D>::from_column_slice(&q);
        // Written so that a margin that is not a number is skipped, and shows as "no place".
        if map.margin(TIME, &q) > CLEARANCE {
            asked += 1;
            laws(&mut report, "", map, name, TIME, &q, &mut random);
        }
    }
    if asked == 0 {
        report.impossible("domain", "everywhere", "no place is inside the domain");
    }
    report
}

/// A type's name without the paths of its crates.
pub(super) fn short_name<M>() -> String {
    let full = std::any::type_name::<M>();
    let mut out = String::new();
    let mut word = String::new();
    for c in full.chars() {
        if c.is_alphanumeric() || c == '_' {
            word.push(c);
        } else if c == ':' {
            word.clear();
        } else {
            out += &word;
            word.clear();
            out.push(c);
        }
    }
    out + &word
}

/// All laws of a map at one time and point.
#[allow(clippy::too_many_arguments, reason = "what is checked, where and how")]
pub(super) fn laws<M, const D: usize, const N: usize>(
    report: &mut Report,
    prefix: &str,
    map: &M,
    at: &str,
    t: f64,
    q: &SVector<f64, D>,
    random: &mut Random,
) where
    M: Map<D, N>,
{
    let law = |name: &str| format!("{prefix}{name}");
    let first = (0.3 * map.margin(t, q)).min(0.1);
    let mut direction = SVector::<f64, D>::zeros();
    random.direction(1.0, direction.as_mut_slice());
    let (v, a) = (random.vector::<D>(), random.vector::<D>());
    let f = random.vector::<N>();

    let x0 = map.phi(t, q);
    let k = map.kinematics(t, q, &v, &a);
    let tangent = map.tangent(t, q);
    let K = map.geometric_stiffness(t, q, &f);

    // The operators against finite differences of what they differentiate.
    let size = x0.norm() + tangent.B.norm() * (1.0 + q.norm());
    report.slope(&law("B = dphi/dq"), at, 2.0, first, size, |e| {
        (map.phi(t, &(q + direction * e)) - x0 - tangent.B * direction * e).norm()
    });
    let along = |tau: f64| (t + tau, q + v * tau + a * (0.5 * tau * tau));
    let size_x = x0.norm() + k.B.norm() * (1.0 + q.norm()) + k.x_dot.norm() + k.x_ddot.norm();
    report.slope(
        &law("x_dot, x_ddot along the motion"),
        at,
        3.0,
        first,
        size_x,
        |tau| {
            let (t, q) = along(tau);
            (map.phi(t, &q) - x0 - k.x_dot * tau - k.x_ddot * (0.5 * tau * tau)).norm()
        },
    );
    let size_B = k.B.norm() + k.B_dot.norm() * (1.0 + q.norm()) + k.B_ddot.norm();
    report.slope(
        &law("B_dot, B_ddot along the motion"),
        at,
        3.0,
        first,
        size_B,
        |tau| {
            let (t, q) = along(tau);
            let B = map.tangent(t, &q).B;
            (B - k.B - k.B_dot * tau - k.B_ddot * (0.5 * tau * tau)).norm()
        },
    );
    let Bf = tangent.B.tr_mul(&f);
    let size_K = tangent.B.norm() * f.norm() + K.norm() * (1.0 + q.norm());
    report.slope(&law("K_sigma = d(B'f)/dq"), at, 2.0, first, size_K, |e| {
        let B = map.tangent(t, &(q + direction * e)).B;
        (B.tr_mul(&f) - Bf - K * direction * e).norm()
    });
    report.defect(
        &law("K_sigma symmetric"),
        at,
        (K - K.transpose()).norm(),
        CLOSED_FORM * K.norm(),
    );

    // Overridden closed forms against what φ gives by itself.
    let exact = derived::kinematics(map, t, q, &v, &a);
    let exact_tangent = derived::tangent(map, t, q);
    let exact_K = derived::geometric_stiffness(map, t, q, &f);
    // A vector or operator may vanish by symmetry (Ḃ at rest, say): its size is then that of B.
    let unit = exact.B.norm() + exact.x.norm();
    agree(
        report,
        &law("tangent = derived"),
        at,
        &[
            relative(&tangent.x, &exact_tangent.x, unit),
            relative(&tangent.B, &exact_tangent.B, unit),
        ],
    );
    agree(
        report,
        &law("kinematics = derived"),
        at,
        &differences(&k, &exact, unit),
    );
    agree(
        report,
        &law("geometric_stiffness = derived"),
        at,
        &[relative(&K, &exact_K, unit * f.norm())],
    );
}

pub(super) fn agree(report: &mut Report, law: &str, at: &str, differences: &[f64]) {
    // f64::max drops NaN: a sum keeps it.
    let worst = if differences.iter().any(|d| d.is_nan()) {
        f64::NAN
    } else {
        differences.iter().copied().fold(0.0, f64::max)
    };
    report.defect(law, at, worst, CLOSED_FORM);
}

pub(super) fn relative<const R: usize, const C: usize>(
    found: &SMatrix<f64, R, C>,
    exact: &SMatrix<f64, R, C>,
    unit: f64,
) -> f64 {
    (found - exact).norm() / (exact.norm() + unit)
}

fn differences<const D: usize, const N: usize>(
    k: &Kinematics<D, N>,
    exact: &Kinematics<D, N>,
    unit: f64,
) -> [f64; 6] {
    [
        relative(&k.x, &exact.x, unit),
        relative(&k.x_dot, &exact.x_dot, unit),
        relative(&k.x_ddot, &exact.x_ddot, unit),
        relative(&k.B, &exact.B, unit),
        relative(&k.B_dot, &exact.B_dot, unit),
        relative(&k.B_ddot, &exact.B_ddot, unit),
    ]
}
