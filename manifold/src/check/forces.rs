//! The laws of forces: tangents are derivatives of the residual, conservative forces those of an
//! energy.

use super::report::Report;
use super::sample::Random;
use nalgebra::{DMatrix, DVector};

/// Time and motion at which forces are asked; `v` and `a` are empty in statics.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Time.
    pub t: f64,
    /// Coordinates.
    pub x: DVector<f64>,
    /// Velocities.
    pub v: DVector<f64>,
    /// Accelerations.
    pub a: DVector<f64>,
}

impl State {
    /// A state at rest for statics: without velocities and accelerations.
    pub fn statics(t: f64, x: DVector<f64>) -> Self {
        let none = || DVector::zeros(0);
        Self {
            t,
            x,
            v: none(),
            a: none(),
        }
    }

    /// Whether velocities and accelerations are absent.
    pub fn is_static(&self) -> bool {
        self.v.is_empty()
    }
}

/// What forces answer at a state. Absent tangents count as zero, other absent things are not asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Forces {
    /// Residual.
    pub r: DVector<f64>,
    /// −∂r/∂x.
    pub K: DMatrix<f64>,
    /// −∂r/∂ẋ.
    pub C: Option<DMatrix<f64>>,
    /// −∂r/∂ẍ.
    pub M: Option<DMatrix<f64>>,
    /// ∂r/∂t.
    pub r_t: Option<DVector<f64>>,
    /// Energy with r = −∂E/∂x in statics.
    pub energy: Option<f64>,
}

/// States in statics and in motion at every place.
pub fn states(n: usize) -> Vec<(String, State)> {
    let mut random = Random::default();
    let mut out = Vec::new();
    for (name, x) in random.places(n) {
        let x = DVector::from_vec(x);
        out.push((format!("{name}, at rest"), State::statics(0.37, x.clone())));
        let (mut v, mut a) = (DVector::zeros(n), DVector::zeros(n));
        random.fill(v.as_mut_slice());
        random.fill(a.as_mut_slice());
        out.push((format!("{name}, moving"), State { t: 0.37, x, v, a }));
    }
    out
}

/// Checks forces of `n` coordinates at every place; `evaluate` answers `None` outside its domain.
pub fn forces(
    subject: &str,
    n: usize,
    symmetric: bool,
    evaluate: impl FnMut(&State) -> Option<Forces>,
) -> Report {
    forces_at(subject, &states(n), symmetric, evaluate)
}

/// As [`forces`], at given states.
pub fn forces_at(
    subject: &str,
    states: &[(String, State)],
    symmetric: bool,
    mut evaluate: impl FnMut(&State) -> Option<Forces>,
) -> Report {
    let mut report = Report::new(subject);
    let mut random = Random::new(7);
    let mut asked = 0;
    for (at, state) in states {
        if let Some(f) = evaluate(state) {
            asked += 1;
            laws(
                &mut report,
                at,
                state,
                &f,
                symmetric,
                &mut random,
                &mut evaluate,
            );
        }
    }
    if asked == 0 {
        report.impossible("domain", "everywhere", "no state is inside the domain");
    }
    report
}

/// First step along coordinates: half the change at which a rotation chart's edge is left.
const FIRST: f64 = 0.05;

/// Which part of a state is varied.
type Part = fn(&mut State) -> &mut DVector<f64>;

fn laws(
    report: &mut Report,
    at: &str,
    state: &State,
    f: &Forces,
    symmetric: bool,
    random: &mut Random,
    evaluate: &mut dyn FnMut(&State) -> Option<Forces>,
) {
    let n = state.x.len();
    let mut d = DVector::zeros(n);
    random.direction(1.0, d.as_mut_slice());
    let residual = |evaluate: &mut dyn FnMut(&State) -> Option<Forces>, state: &State| {
        evaluate(state).map_or_else(|| DVector::from_element(n, f64::NAN), |f| f.r)
    };

    let parts: [(&str, Part, Option<&DMatrix<f64>>); 3] = [
        ("K = -dr/dx", |s| &mut s.x, Some(&f.K)),
        ("C = -dr/dv", |s| &mut s.v, f.C.as_ref()),
        ("M = -dr/da", |s| &mut s.a, f.M.as_ref()),
    ];
    for (law, part, tangent) in parts {
        let mut varied = state.clone();
        let base = part(&mut varied).clone();
        if base.is_empty() {
            continue;
        }
        let zero = DMatrix::zeros(n, n);
        let slope = tangent.unwrap_or(&zero) * &d;
        let size = f.r.norm() + tangent.map_or(0.0, DMatrix::norm) * (1.0 + base.norm());
        report.slope(law, at, 2.0, FIRST, size, |e| {
            *part(&mut varied) = &base + &d * e;
            (residual(evaluate, &varied) - &f.r + &slope * e).norm()
        });
    }
    if let Some(r_t) = &f.r_t {
        let size = f.r.norm() + r_t.norm() * (1.0 + state.t.abs());
        report.slope("r_t = dr/dt", at, 2.0, FIRST, size, |e| {
            let later = State {
                t: state.t + e,
                ..state.clone()
            };
            (residual(evaluate, &later) - &f.r - r_t * e).norm()
        });
    }
    if symmetric && state.is_static() {
        let size = f.K.norm();
        report.defect(
            "K symmetric",
            at,
            (&f.K - f.K.transpose()).norm(),
            1e-13 * size,
        );
    }
    if let (Some(energy), true) = (f.energy, state.is_static()) {
        let size = energy.abs() + f.r.norm() * (1.0 + state.x.norm());
        report.slope("r = -dE/dx", at, 2.0, FIRST, size, |e| {
            let moved = State::statics(state.t, &state.x + &d * e);
            let there = evaluate(&moved).and_then(|f| f.energy);
            (there.unwrap_or(f64::NAN) - energy + f.r.dot(&d) * e).abs()
        });
    }
}
