//! The laws of forces: tangents are derivatives of the residual, conservative forces those of an energy.

mod system;
mod tangents;

use crate::block::{Rows, difference, wrong_entries};
use crate::layout::Layout;
use crate::report::Report;
use crate::sample::Random;
use crate::vectors::minus;
use nalgebra::{DMatrix, DVector};
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::Point;
pub(crate) use system::parts;
pub use system::system;
pub(crate) use system::{system_at, system_sizes};
pub(crate) use tangents::{CONFIRMED, FIRST, STEP};
use tangents::{Linearization, Part, tangents};

/// Time and motion at which forces are evaluated; `v` and `a` are empty in statics.
#[derive(Clone, Debug, PartialEq)]
pub struct TestState {
    /// Time.
    pub t: f64,
    /// Coordinates.
    pub x: DVector<f64>,
    /// Velocities.
    pub v: DVector<f64>,
    /// Accelerations.
    pub a: DVector<f64>,
}

impl TestState {
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

    /// The state with velocities and accelerations of zero.
    pub(crate) fn still(&self) -> Self {
        let zero = || DVector::zeros(self.x.len());
        Self {
            v: zero(),
            a: zero(),
            ..Self::statics(self.t, self.x.clone())
        }
    }

    /// Whether velocities and accelerations are absent.
    pub fn is_static(&self) -> bool {
        self.v.is_empty()
    }

    /// The state as the argument of a system.
    pub fn point(&self) -> Point<'_> {
        let [q, v, a] = [&self.x, &self.v, &self.a].map(|x| x.as_slice());
        Point { t: self.t, q, v, a }
    }

    /// The coordinates later by `tau`, with constant accelerations.
    pub(crate) fn ahead(&self, tau: f64) -> DVector<f64> {
        &self.x + &self.v * tau + &self.a * (0.5 * tau * tau)
    }

    /// The state later by `tau`, likewise.
    pub(crate) fn later(&self, tau: f64) -> Self {
        Self {
            t: self.t + tau,
            x: self.ahead(tau),
            v: &self.v + &self.a * tau,
            a: self.a.clone(),
        }
    }
}

/// Forces at a state. Absent values are not verified.
#[derive(Clone, Debug, PartialEq)]
pub struct Forces {
    /// Residual.
    pub r: DVector<f64>,
    /// −∂r/∂x.
    pub K: DMatrix<f64>,
    /// −∂r/∂ẋ; zero in statics.
    pub C: DMatrix<f64>,
    /// −∂r/∂ẍ; zero in statics.
    pub M: DMatrix<f64>,
    /// ∂r/∂t.
    pub r_t: Option<DVector<f64>>,
    /// Energy with r = −∂E/∂x in statics.
    pub energy: Option<f64>,
}

/// States in statics and in motion at every position.
pub fn states(n: usize) -> Vec<(String, TestState)> {
    let mut random = Random::default();
    let mut out = Vec::new();
    for (name, x) in random.positions(n) {
        let x = DVector::from_vec(x);
        out.push((
            format!("{name}, at rest"),
            TestState::statics(0.37, x.clone()),
        ));
        let (mut v, mut a) = (DVector::zeros(n), DVector::zeros(n));
        random.fill(v.as_mut_slice());
        random.fill(a.as_mut_slice());
        out.push((format!("{name}, moving"), TestState { t: 0.37, x, v, a }));
    }
    out
}

/// Checks forces of `n` coordinates at every position; `evaluate` returns `None` outside its domain.
pub fn forces(
    subject: &str,
    n: usize,
    symmetric: bool,
    evaluate: impl FnMut(&TestState) -> Option<Forces>,
) -> Report {
    forces_at(subject, &Layout::plain(n), &states(n), symmetric, evaluate)
}

/// As [`forces`], with a layout of the coordinates, at given states.
pub fn forces_at(
    subject: &str,
    layout: &Layout,
    states: &[(String, TestState)],
    symmetric: bool,
    mut evaluate: impl FnMut(&TestState) -> Option<Forces>,
) -> Report {
    at_states(subject, layout, states, |laws| {
        let f = evaluate(laws.state)?;
        laws.forces(&f, symmetric, &mut evaluate);
        Some(())
    })
}

/// Checks laws at each state; `check` returns `None` outside of the domain.
fn at_states(
    subject: &str,
    layout: &Layout,
    states: &[(String, TestState)],
    mut check: impl FnMut(&mut Laws<'_>) -> Option<()>,
) -> Report {
    let mut report = Report::new(subject);
    let mut random = Random::new(7);
    let mut evaluated = 0;
    for (at, state) in states {
        let mut laws = Laws {
            report: &mut report,
            layout,
            at,
            state,
            random: &mut random,
        };
        evaluated += usize::from(check(&mut laws).is_some());
    }
    if evaluated == 0 {
        report.impossible("domain", "everywhere", "no state is inside the domain");
    }
    report
}

/// A state at which laws are checked, and the report of them.
pub(crate) struct Laws<'a> {
    pub report: &'a mut Report,
    pub layout: &'a Layout,
    pub at: &'a str,
    pub state: &'a TestState,
    pub random: &'a mut Random,
}

/// The magnitude of the terms of the residual in each group, as an energy: its round-off is a fraction of them.
pub(crate) fn sizes(layout: &Layout, state: &TestState, f: &Forces) -> Vec<f64> {
    let pattern = BlockPattern::dense(state.x.len());
    f.tangents(&pattern).sizes(layout, state)
}

impl Forces {
    fn tangents<'a>(&'a self, pattern: &'a BlockPattern) -> Linearization<'a> {
        Linearization {
            pattern,
            r: self.r.as_slice(),
            values: [&self.K, &self.C, &self.M].map(|A| A.as_slice().to_vec()),
        }
    }
}

impl Laws<'_> {
    fn forces(
        &mut self,
        f: &Forces,
        symmetric: bool,
        evaluate: &mut dyn FnMut(&TestState) -> Option<Forces>,
    ) {
        let (n, at, state) = (self.state.x.len(), self.at, self.state);
        let pattern = BlockPattern::dense(n);
        let all = f.tangents(&pattern);
        let mut residual = |s: &TestState| evaluate(s).map(|f| f.r.as_slice().to_vec());
        let sizes = all.sizes(self.layout, self.state);
        tangents(self, &all, &sizes, &mut residual);
        if symmetric && state.is_static() {
            all.symmetric(self, Part::K, &[]);
        }
        if let Some(r_t) = &f.r_t {
            let size = f.r.norm() + r_t.norm() * (1.0 + state.t.abs());
            self.report.slope("r_t = dr/dt", at, 2.0, FIRST, size, |e| {
                let t = state.t + e;
                let later = TestState { t, ..state.clone() };
                let there = evaluate(&later).map(|f| f.r);
                there.map_or(f64::NAN, |there| (there - &f.r - r_t * e).norm())
            });
        }
        if let (Some(energy), true) = (f.energy, state.is_static()) {
            self.conservative(f, energy, evaluate);
        }
    }

    /// r = −∂E/∂x in statics.
    fn conservative(
        &mut self,
        f: &Forces,
        energy: f64,
        evaluate: &mut dyn FnMut(&TestState) -> Option<Forces>,
    ) {
        let (at, state) = (self.at, self.state);
        let units = self.layout.units();
        let d = self.random.direction_in(&units);
        let magnitudes = self.layout.magnitudes(state.x.as_slice(), 0);
        let work = f.r.iter().zip(&magnitudes).map(|(r, x)| (r * x).abs());
        let size = energy.abs() + work.sum::<f64>();
        let mut there = |x: DVector<f64>| {
            let moved = TestState::statics(state.t, x);
            evaluate(&moved).and_then(|f| f.energy)
        };
        self.report.slope("r = -dE/dx", at, 2.0, FIRST, size, |e| {
            let there = there(&state.x + &d * e).unwrap_or(f64::NAN);
            (there - energy + f.r.dot(&d) * e).abs()
        });
        if self.report.rows().last().is_some_and(|row| row.passed) {
            return;
        }
        let by_differences = units.iter().enumerate().map(|(i, unit)| {
            let slope = difference(STEP * unit, |e| {
                let mut x = state.x.clone();
                x[i] += e;
                Some(vec![there(x)?])
            });
            slope.map_or(f64::NAN, |slope| -slope[0])
        });
        let (found, right) = (f.r.as_slice(), by_differences.collect::<Vec<_>>());
        let off = self.layout.forces(&minus(found, &right)).iter().sum();
        self.report.second_opinion(|| Some((off, CONFIRMED * size)));
        let blocks = || wrong_entries("force", Rows::Forces(self.layout), found, &right);
        self.report.blame(blocks);
    }
}
