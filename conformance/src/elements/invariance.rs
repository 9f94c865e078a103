//! Objectivity and independence of charts: forces and energies do not depend on a superposed rigid motion, nor on the
//! chart.
//!
//! Some elements have both properties exactly, up to round-off. Others interpolate total rotation vectors and have them
//! in the limit of small relative rotations only, which is that of fine meshes: as the relative motion of the nodes
//! goes to zero, the defect must decrease faster than the force itself.

use super::element::{Request, evaluate, motion};
use super::rigid::{Carrier, FrameAt, Moved, angles, carry};
use crate::block::{Rows, wrong_entries};
use crate::forces::sizes;
use crate::{Layout, Random, Report, TestState};
use nalgebra::{DVector, Vector3};
use pullback_elements::element::Element;
use std::f64::consts::TAU;

/// Largest relative round-off of two logarithms and two tangents, there and back.
pub(crate) const EXACT: f64 = 1e-11;
/// Rotation vectors closer to 0 or 2π than this are not evaluated in the other chart.
const CLEAR: f64 = 0.2;
/// First relative motion of the nodes in the limit of small ones, in units.
pub(crate) const FIRST: f64 = 0.1;

/// A component of a model with its coordinates.
pub(crate) struct Component<T> {
    /// Name in reports.
    pub name: String,
    pub thing: T,
    pub layout: Layout,
    /// The frames among its coordinates.
    pub frames: Vec<FrameAt>,
    /// First coordinates of rotation vectors that belong to no frame.
    pub rotations: Vec<usize>,
}

/// A law of invariance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Law {
    Objectivity,
    Charts,
}

/// Checks objectivity, if the element declares it, and independence of charts.
pub(crate) fn laws(
    report: &mut Report,
    of: &Component<&dyn Element>,
    states: &[(String, TestState)],
    random: &mut Random,
) {
    if of.frames.is_empty() {
        return;
    }
    if of.thing.properties().objective {
        of.check(report, Law::Objectivity, states, random);
    }
    of.check(report, Law::Charts, states, random);
}

impl<T> Component<T> {
    /// A typical length: the unit of the first frame's displacement.
    pub(crate) fn length(&self) -> f64 {
        self.layout.units()[self.frames[0].first]
    }
}

impl Component<&dyn Element> {
    fn center(&self) -> Vector3<f64> {
        self.frames[0].position
    }

    /// The change of a state under which a law holds.
    fn carrier(&self, law: Law, random: &mut Random) -> Carrier {
        match law {
            Law::Charts => Carrier::Chart,
            Law::Objectivity => {
                let shift = random.of_norm(self.length());
                Carrier::still(self.center(), random.of_norm(1.0), shift)
            }
        }
    }

    fn check(
        &self,
        report: &mut Report,
        law: Law,
        states: &[(String, TestState)],
        random: &mut Random,
    ) {
        let name = match law {
            Law::Objectivity => "objective",
            Law::Charts => "the same in the other chart",
        };
        let mut exact = Report::new(report.subject());
        for (at, s) in states {
            // Away from Ψ = 0, where there is no other chart.
            let turn = Carrier::still(self.center(), random.of_norm(1.3), Vector3::zeros());
            let state = match law {
                Law::Objectivity => s.clone(),
                Law::Charts => carry(turn, &self.frames, s).state,
            };
            let moved = carry(self.carrier(law, random), &self.frames, &state);
            if [&state, &moved.state].iter().all(|s| self.clear(s)) {
                self.compare(&mut exact, name, at, &state, &moved);
            }
        }
        // The largest defect decides whether the law holds exactly or in the limit.
        let exactly = exact.is_ok() || self.frames.len() == 1;
        if exactly && !exact.rows().is_empty() {
            return report.extend(exact);
        }
        for moving in [false, true] {
            report.twice(|report| self.limit(report, law, name, moving, &states[0].1, random));
        }
    }

    fn clear(&self, s: &TestState) -> bool {
        let [most, least] = angles(&self.frames, &s.x);
        most < TAU - CLEAR && least > CLEAR || most < TAU / 2.0 && least > 0.0
    }

    /// The difference of forces in the same coordinates, group by group.
    fn gap(&self, s: &TestState, moved: &Moved) -> Option<[DVector<f64>; 2]> {
        let here = evaluate(self.thing, s, Request::Residual)?.r;
        let there = evaluate(self.thing, &moved.state, Request::Residual)?.r;
        Some([moved.B.tr_mul(&there), here])
    }

    fn compare(&self, report: &mut Report, name: &str, at: &str, s: &TestState, moved: &Moved) {
        let Some(all) = evaluate(self.thing, s, Request::All) else {
            return;
        };
        let Some([there, here]) = self.gap(s, moved) else {
            return report.impossible(name, at, "outside of the domain there");
        };
        // Forces go through B, whose entries may be large near the edge of a chart.
        let bend = 1.0 + moved.B.amax().powi(2);
        let sizes = sizes(&self.layout, s, &all);
        let mut allowed: Vec<f64> = sizes.iter().map(|s| EXACT * s * bend).collect();
        let mut defects = self.layout.forces((&there - &here).as_slice());
        // A conservative load in a field may be objective in its forces and not in its energy.
        if !self.thing.properties().load {
            let [a, b] = [s, &moved.state].map(|s| self.thing.abilities().energy(&motion(s)));
            defects.push((a - b).abs());
            allowed.push(EXACT * (a.abs() + sizes.iter().sum::<f64>()));
        }
        report.defects(name, at, &defects, &allowed);
        report.blame(|| self.blocks(&there, &here));
    }

    fn blocks(&self, there: &DVector<f64>, here: &DVector<f64>) -> Vec<crate::Block> {
        let rows = Rows::Forces(&self.layout);
        wrong_entries("force", rows, there.as_slice(), here.as_slice())
    }

    /// Defects near a rigid motion, as the relative motion of the nodes goes to zero: of second order at rest, where
    /// forces are of first order; of first order in motion and for loads, where forces are finite.
    fn limit(
        &self,
        report: &mut Report,
        law: Law,
        name: &str,
        moving: bool,
        s: &TestState,
        random: &mut Random,
    ) {
        let rate = self.layout.rate;
        let units = self.layout.units();
        let mut noise = || random.entries(&units);
        let (dx, dv, da) = (noise(), noise() * rate, noise() * (rate * rate));
        let rigid = Carrier::Rigid {
            about: self.center(),
            turn: random.of_norm(1.3),
            spin: random.of_norm(if moving { rate } else { 0.0 }),
            shift: random.of_norm(self.length()),
            drift: random.of_norm(if moving { rate * self.length() } else { 0.0 }),
        };
        let to = self.carrier(law, random);
        let at = |e: f64| -> TestState {
            let mut near = TestState::statics(s.t, &dx * e);
            if moving {
                (near.v, near.a) = (&dv * e, &da * e);
            }
            // Coordinates that belong to no frame stay as they are.
            let framed =
                |i: usize| (self.frames.iter()).any(|f| (f.first..f.first + 6).contains(&i));
            for i in (0..units.len()).filter(|&i| !framed(i)) {
                near.x[i] = s.x[i];
            }
            carry(rigid, &self.frames, &near).state
        };
        let law = format!("{name} in the limit of small strains");
        let name = format!("rigid, {}", if moving { "moving" } else { "at rest" });
        let Some(all) = evaluate(self.thing, &at(0.0), Request::All) else {
            return report.impossible(&law, &name, "outside of the domain");
        };
        let first_order = moving || self.thing.properties().load;
        let order = if first_order { 1.0 } else { 2.0 };
        let sizes = sizes(&self.layout, &at(0.0), &all);
        let gap = |e: f64| {
            let state = at(e);
            let moved = carry(to, &self.frames, &state);
            self.gap(&state, &moved)
        };
        report.slopes(&law, &name, order, FIRST, &sizes, |e| match gap(e) {
            Some([there, here]) => self.layout.forces((there - here).as_slice()),
            None => vec![f64::NAN; sizes.len()],
        });
        report
            .blame(|| gap(FIRST).map_or_else(Vec::new, |[there, here]| self.blocks(&there, &here)));
    }
}
