//! The laws of a map: all operators of a [`Map`] are derivatives of φ.

use super::kinematics::{Mapped, kinematics, motion};
use super::pieces::{freeze_piece, pieces};
use crate::forces::TestState;
use crate::layout::Layout;
use crate::report::Report;
use crate::sample::{CLEARANCE, Random};
use crate::vectors::{larger, relative};
use nalgebra::{DVector, SVector};
use pullback_manifold::map::{Kinematics, Map, Parametrization, derived};

/// Time at which maps are evaluated: not zero, so that a missing t has an effect.
pub(crate) const TIME: f64 = 0.37;

/// Largest relative difference between a closed form and the exact derivative.
///
/// Both are sums of some hundred terms, each with a relative error of 1e-16, and cancel at worst
/// like the third power of the distance 0.3 to the edge of a rotation chart: below 1e-12. A wrong
/// formula differs in the first digits.
const CLOSED_FORM: f64 = 1e-10;

/// Checks every law of a map at every position within its domain.
pub fn map<M, const D: usize, const N: usize>(map: &M) -> Report
where
    M: Map<D, N> + Clone + 'static,
{
    let mut report = Report::new(short_name::<M>());
    let mut random = Random::default();
    let vector = |q: &[f64]| SVector::<f64, D>::from_column_slice(q);
    let margin = |q: &[f64]| map.domain(TIME, &vector(q)).unwrap_or(0.0);
    for (at, q) in within(&mut report, &mut random, D, margin) {
        laws(&mut report, map, at, &vector(&q), &mut random);
    }
    report
}

/// Checks every law of a map behind slices at every position within its domain.
pub fn parametrization(map: &dyn Parametrization) -> Report {
    let mut report = Report::new(shortened(map.kind()));
    let mut random = Random::default();
    let margin = |q: &[f64]| map.duplicate().domain(TIME, q).unwrap_or(0.0);
    for (at, q) in within(&mut report, &mut random, map.dims().0, margin) {
        laws_behind_slices(&mut report, map, at, &q, &mut random);
    }
    report
}

/// The laws of a map behind slices at one position, a failure outside its domain.
pub(crate) fn laws_behind_slices(
    report: &mut Report,
    map: &dyn Parametrization,
    at: &str,
    q: &[f64],
    random: &mut Random,
) {
    let d = map.dims().0;
    let mut one_piece = map.duplicate();
    freeze_piece(&mut *one_piece, Some((TIME, q)));
    match one_piece.domain(TIME, q) {
        Err(why) => return report.impossible("domain", at, why.to_string()),
        Ok(margin) if margin <= CLEARANCE => return,
        Ok(_) => {}
    }
    let mut vector = || random.entries(&vec![1.0; d]);
    let state = TestState {
        t: TIME,
        x: DVector::from_column_slice(q),
        v: vector(),
        a: vector(),
    };
    let layouts = unscaled(&*one_piece);
    let of = Mapped::of(&*one_piece, &layouts);
    slopes(report, "", of, at, &state, random);
    let mut moved = map.duplicate();
    if let Some(charts) = moved.state() {
        charts.change_charts(TIME, q);
    }
    saved(report, at, [map, &*moved], &state);
}

/// Checks that a copy of a map that takes over the saved state of another copy has its motion.
pub(crate) fn saved(
    report: &mut Report,
    at: &str,
    [map, moved]: [&dyn Parametrization; 2],
    s: &TestState,
) {
    let (mut copy, mut moved) = (map.duplicate(), moved.duplicate());
    let (Some(state), Some(changed)) = (copy.state(), moved.state()) else {
        return;
    };
    let mut same = state.restore(&changed.save());
    let motions = [copy, moved]
        .map(|map| motion(&*map, s.t, [&s.x, &s.v, &s.a].map(DVector::as_slice)).concat());
    same &= (motions[0].iter().zip(&motions[1])).all(|(a, b)| a == b || a.is_nan() && b.is_nan());
    let law = "state saved and restored";
    match same {
        true => report.defect(law, at, 0.0, 0.0),
        false => report.impossible(law, at, "a copy with the saved state moves otherwise"),
    }
}

/// The layouts of x and q without units.
pub(crate) fn unscaled(map: &dyn Parametrization) -> [Layout; 2] {
    let (d, n) = map.dims();
    [n, d].map(Layout::plain)
}

/// The laws at one state other than those of closed forms; returns whether all values are finite.
pub(crate) fn slopes(
    report: &mut Report,
    prefix: &str,
    of: Mapped<'_>,
    at: &str,
    state: &TestState,
    random: &mut Random,
) -> bool {
    let finite = kinematics(report, prefix, of, at, state, random);
    if finite {
        pieces(report, of, at, state, random);
    }
    finite
}

/// The positions within a domain, given its margin; a failure if there are none, and where the margin is not a number.
pub(crate) fn within(
    report: &mut Report,
    random: &mut Random,
    dim: usize,
    margin: impl Fn(&[f64]) -> f64,
) -> Vec<(&'static str, Vec<f64>)> {
    let mut inside = Vec::new();
    for (at, q) in random.positions(dim) {
        let margin = margin(&q);
        if margin.is_nan() {
            let why = "the distance to the edge of the domain is not a number";
            report.impossible("domain", at, why);
        } else if margin > CLEARANCE {
            inside.push((at, q));
        }
    }
    if inside.is_empty() {
        report.impossible("domain", "everywhere", "no position is inside the domain");
    }
    inside
}

/// A type's name without the paths of its crates.
pub(crate) fn short_name<M>() -> String {
    shortened(std::any::type_name::<M>())
}

/// A type's full name without the paths of its crates: `OnCurve<Helix>`.
pub(crate) fn shortened(full: &str) -> String {
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

/// The words of a type's name without its parameters: `on curve` of `pullback::joint::OnCurve<Helix>`.
pub(crate) fn plain(full: &str) -> String {
    let short = shortened(full);
    let name = short.split('<').next().unwrap_or(&short);
    let mut out = String::new();
    for c in name.chars() {
        if c.is_uppercase() && !out.is_empty() {
            out.push(' ');
        }
        out.extend(c.to_lowercase());
    }
    out
}

/// All laws of a map at one point.
pub(crate) fn laws<M, const D: usize, const N: usize>(
    report: &mut Report,
    map: &M,
    at: &str,
    q: &SVector<f64, D>,
    random: &mut Random,
) where
    M: Map<D, N> + Clone + 'static,
{
    let t = TIME;
    let (v, a) = (random.vector::<D>(), random.vector::<D>());
    let f = random.vector::<N>();
    let vector = |x: &SVector<f64, D>| DVector::from_column_slice(x.as_slice());
    let state = TestState {
        t,
        x: vector(q),
        v: vector(&v),
        a: vector(&a),
    };
    let boxed = map.clone().boxed();
    let layouts = unscaled(&*boxed);
    let of = Mapped::of(&*boxed, &layouts);
    if !slopes(report, "", of, at, &state, random) {
        return;
    }

    // Overridden closed forms against what φ gives by itself.
    let exact = derived::kinematics(map, t, q, &v, &a);
    let exact_tangent = derived::tangent(map, t, q);
    let exact_K = derived::geometric_stiffness(map, t, q, &f);
    let k = map.kinematics(t, q, &v, &a);
    let tangent = map.tangent(t, q);
    let K = map.geometric_stiffness(t, q, &f);
    // φ over numbers is φ over jets.
    let size = tangent.x.norm() + tangent.B.norm() * (1.0 + q.norm());
    let gap = (map.phi(t, q) - tangent.x).norm();
    report.defect("x = phi", at, gap, CLOSED_FORM * size);
    // A vector or operator may vanish by symmetry, as Ḃ at rest: its size is then that of B.
    let unit = exact.B.norm() + exact.x.norm();
    let gaps = [
        relative(tangent.x.as_slice(), exact_tangent.x.as_slice(), unit),
        relative(tangent.B.as_slice(), exact_tangent.B.as_slice(), unit),
    ];
    agree(report, "tangent = derived", at, &gaps);
    let (found, exact) = (slices(&k), slices(&exact));
    let gaps = [0, 1, 2, 3, 4, 5].map(|i| relative(found[i], exact[i], unit));
    agree(report, "kinematics = derived", at, &gaps);
    let gap = relative(K.as_slice(), exact_K.as_slice(), unit * f.norm());
    agree(report, "geometric_stiffness = derived", at, &[gap]);
}

/// x, ẋ, ẍ, B, Ḃ, B̈.
fn slices<const D: usize, const N: usize>(k: &Kinematics<D, N>) -> [&[f64]; 6] {
    let [x, x_dot, x_ddot] = [&k.x, &k.x_dot, &k.x_ddot].map(|x| x.as_slice());
    let [B, B_dot, B_ddot] = [&k.B, &k.B_dot, &k.B_ddot].map(|B| B.as_slice());
    [x, x_dot, x_ddot, B, B_dot, B_ddot]
}

pub(crate) fn agree(report: &mut Report, law: &str, at: &str, differences: &[f64]) {
    let worst = differences.iter().copied().fold(0.0, larger);
    report.defect(law, at, worst, CLOSED_FORM);
}
