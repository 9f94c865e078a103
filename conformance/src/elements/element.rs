//! The laws of one element.

use super::in_charts::FRAME;
use super::{InCharts, inertia};
use crate::{Forces, Layout, Random, Report, TestState, forces_at, states};
use nalgebra::{DMatrix, DVector};
use pullback_elements::element::{Element, Motion, Response};
use pullback_manifold::system::Weights;

/// Checks every law of an element at every position within its domain.
///
/// The laws are those of tangents, at rest and in motion; symmetry where the element declares it; the force as the
/// derivative of the energy, if it has one or is a steady load, which does not change with time; inertial forces as those of the kinetic energy ½ ẋ·M ẋ, which is the one
/// that it gives; the balance of power; that neither the residual nor a tangent depends on what else is requested; and
/// that a combined tangent is the sum of its parts. An element that reads poses is checked in the charts of its frames.
pub fn element(element: &dyn Element) -> Report {
    let n = element.dim();
    let name = format!("element of {n} coordinates");
    if element.properties().reads_poses && !n.is_multiple_of(FRAME) {
        let mut report = Report::new(name);
        let why = "an element that reads poses has six coordinates for each frame";
        report.impossible("domain", "everywhere", why);
        return report;
    }
    let element = InCharts(element);
    element_at(&name, &Layout::plain(n), &states(n), element.element())
}

/// As [`element`], with a layout of the coordinates, at given states.
pub(crate) fn element_at(
    subject: &str,
    layout: &Layout,
    states: &[(String, TestState)],
    element: &dyn Element,
) -> Report {
    // The energy of an element that has none is zero everywhere; that of a steady load is its potential.
    let any = |of: &dyn Fn(&Motion<'_>) -> f64| states.iter().any(|(_, s)| of(&motion(s)) != 0.0);
    let conservative =
        element.properties().time_independent || any(&|at| element.abilities().energy(at));
    let symmetric = element.properties().symmetric;
    let mut report = forces_at(subject, layout, states, symmetric, |s| {
        let mut f = evaluate(element, s, Request::All)?;
        f.energy = conservative.then(|| element.abilities().energy(&motion(s)));
        Some(f)
    });
    let dissipative = any(&|at| element.abilities().dissipation(at));
    let mut random = Random::default();
    for (at, state) in states {
        if let Some(all) = evaluate(element, state, Request::All) {
            let one = One {
                element,
                layout,
                at,
                state,
                all: &all,
            };
            if dissipative {
                one.dissipation(&mut report);
            }
            if element.properties().time_independent {
                one.steady(&mut report);
            }
            one.requests(&mut report);
            one.iterates(&mut report, &mut random);
            one.combination(&mut report);
            inertia::laws(&mut report, &one, conservative, &mut random);
        }
    }
    report
}

/// An element at one state.
pub(crate) struct One<'a> {
    pub element: &'a dyn Element,
    pub layout: &'a Layout,
    pub at: &'a str,
    pub state: &'a TestState,
    /// Its forces and tangents there.
    pub all: &'a Forces,
}

impl One<'_> {
    /// A tangent in units of the coordinates: its entries are energies.
    pub(crate) fn scaled(&self, A: &DMatrix<f64>) -> DMatrix<f64> {
        let units = self.layout.units();
        DMatrix::from_fn(A.nrows(), A.ncols(), |i, j| A[(i, j)] * units[i] * units[j])
    }

    /// The norm of a tangent in units of the coordinates.
    pub(crate) fn norm(&self, A: &DMatrix<f64>) -> f64 {
        self.scaled(A).norm()
    }

    /// The same motion at other coordinates.
    pub(crate) fn moved(&self, x: DVector<f64>) -> TestState {
        TestState {
            x,
            ..self.state.clone()
        }
    }
}

/// The requested results of an evaluation.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Request {
    All,
    Residual,
    Stiffness,
}

pub(crate) fn motion(s: &TestState) -> Motion<'_> {
    Motion {
        t: s.t,
        inputs: &[1.0; 64],
        x: s.x.as_slice(),
        v: s.v.as_slice(),
        a: s.a.as_slice(),
        previous: None,
    }
}

pub(crate) fn evaluate(element: &dyn Element, s: &TestState, ask: Request) -> Option<Forces> {
    evaluate_from(element, None, s, ask)
}

fn evaluate_from(
    element: &dyn Element,
    previous: Option<&DVector<f64>>,
    s: &TestState,
    ask: Request,
) -> Option<Forces> {
    let n = element.dim();
    let matrix = || DMatrix::zeros(n, n);
    let (mut r, mut r_t) = (DVector::zeros(n), DVector::zeros(n));
    let (mut K, mut C, mut M) = (matrix(), matrix(), matrix());
    let moving = ask == Request::All && !s.is_static();
    let mut out = Response {
        r: r.as_mut_slice(),
        K: (ask != Request::Residual).then_some(K.as_mut_slice()),
        C: moving.then_some(C.as_mut_slice()),
        M: moving.then_some(M.as_mut_slice()),
        r_t: (ask == Request::All).then_some(r_t.as_mut_slice()),
    };
    let at = Motion {
        previous: previous.map(|x| x.as_slice()),
        ..motion(s)
    };
    element.evaluate(&at, &mut out).ok()?;
    Some(Forces {
        r,
        K,
        C,
        M,
        r_t: Some(r_t),
        energy: None,
    })
}

impl One<'_> {
    /// A request for less gives the same numbers, to the last bit.
    fn requests(&self, report: &mut Report) {
        let (element, at, s, all) = (self.element, self.at, self.state, self.all);
        let gap = |f: Option<Forces>, of: fn(&Forces, &Forces) -> f64| {
            f.map_or(f64::NAN, |f| of(&f, all))
        };
        let alone = gap(evaluate(element, s, Request::Residual), |f, all| {
            (&f.r - &all.r).norm()
        });
        let law = "r does not depend on what else is requested";
        report.defect(law, at, alone, 0.0);
        let with_K = gap(evaluate(element, s, Request::Stiffness), |f, all| {
            (&f.K - &all.K).norm() + (&f.r - &all.r).norm()
        });
        let law = "K does not depend on what else is requested";
        report.defect(law, at, with_K, 0.0);
        if s.is_static() {
            // Sums of terms that are zero may still be ordered differently.
            let size = all.r.norm() + all.K.norm() * (1.0 + s.x.norm());
            let moving = gap(
                evaluate(element, &self.state.still(), Request::All),
                |f, all| (&f.r - &all.r).norm() + (&f.K - &all.K).norm(),
            );
            report.defect("statics is the motion at rest", at, moving, 1e-14 * size);
        }
    }

    /// The force and the potential are the same at another time.
    fn steady(&self, report: &mut Report) {
        let energy = |s: &TestState| self.element.abilities().energy(&motion(s));
        let later = TestState {
            t: self.state.t + 1.0,
            ..self.state.clone()
        };
        let there = evaluate(self.element, &later, Request::Residual);
        let gap = there.map_or(f64::NAN, |there| (&there.r - &self.all.r).norm());
        let gap = gap + (energy(&later) - energy(self.state)).abs();
        report.defect("a steady load does not change with time", self.at, gap, 0.0);
    }

    /// The combined tangent is the sum of its parts, and a dead element has none.
    fn combination(&self, report: &mut Report) {
        let (element, at, s, all) = (self.element, self.at, self.state, self.all);
        let rate = self.layout.rate;
        let weights = Weights {
            K: 1.0,
            C: 2.0 / rate,
            M: 3.0 / (rate * rate),
        };
        let parts = [
            (weights.K, &all.K),
            (weights.C, &all.C),
            (weights.M, &all.M),
        ];
        let mut sum = DMatrix::zeros(s.x.len(), s.x.len());
        let mut size = self.layout.forces(all.r.as_slice()).iter().sum::<f64>();
        for (weight, part) in parts {
            sum += part * weight;
            size += weight * self.norm(part);
        }
        if element.properties().load {
            report.defect("a load has no mass", at, self.norm(&all.M), 0.0);
        }
        if element.properties().dead {
            report.defect("a dead element has no tangent", at, sum.norm(), 0.0);
        }
        let Some(combined) = element.abilities().combined else {
            return;
        };
        let (mut r, mut S) = (all.r.clone() * 0.0, sum.clone() * 0.0);
        let tangents = &mut [Some((weights, S.as_mut_slice())), None, None];
        let done = combined.add(&motion(s), r.as_mut_slice(), tangents);
        let off = |()| {
            let r = self.layout.forces((r - &all.r).as_slice());
            r.iter().sum::<f64>() + self.norm(&(S - &sum))
        };
        let gap = done.map_or(f64::NAN, off);
        report.defect("S = cK K + cC C + cM M", at, gap, 1e-13 * size);
    }

    /// The dissipation is not negative, and is the power of damping.
    ///
    /// Without inertia the change of the force with velocities is damping: its power at ẋ is the dissipation. With
    /// inertia only the sign is known, since gyroscopic forces also have power.
    fn dissipation(&self, report: &mut Report) {
        let (element, at, s, all) = (self.element, self.at, self.state, self.all);
        let lost = element.abilities().dissipation(&motion(s));
        report.defect("dissipation >= 0", at, (-lost).max(0.0), 0.0);
        if s.is_static() {
            report.defect("no dissipation at rest", at, lost.abs(), 0.0);
        } else if all.M.norm() == 0.0 {
            let power = evaluate(element, &self.state.still(), Request::Residual)
                .map_or(f64::NAN, |rest| (&all.r - rest.r).dot(&s.v));
            let size = lost + all.r.norm() * s.v.norm();
            let law = "power of damping = -dissipation";
            report.defect(law, at, (power + lost).abs(), 1e-12 * size);
        }
    }

    /// The tangent of a Newton iterate has an error of second order in the step from the previous one.
    fn iterates(&self, report: &mut Report, random: &mut Random) {
        let (element, at, s, all) = (self.element, self.at, self.state, self.all);
        let d = random.direction_in(&self.layout.units());
        let from = |e: f64| evaluate_from(element, Some(&(&s.x - &d * e)), s, Request::Stiffness);
        let gap = from(0.05).map_or(f64::NAN, |f| (&f.r - &all.r).norm());
        report.defect("r does not depend on the previous iterate", at, gap, 0.0);
        let size = self.norm(&all.K) * (1.0 + s.x.norm());
        report.slope("K from the previous iterate", at, 2.0, 0.05, size, |e| {
            from(e).map_or(f64::NAN, |f| self.norm(&(&f.K - &all.K)))
        });
    }
}
