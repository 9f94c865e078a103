//! Objectivity, and independence of charts: forces and energies are those of a body, whoever looks.
//!
//! Some elements have both exactly. Others interpolate total rotation vectors and have them in the
//! limit of small relative rotations only, which is that of fine meshes: exactness is required to
//! be so to round-off, and what is not has to lose its defect faster than the force itself when the
//! relative motion of its nodes goes to zero. An element that does not turn with its nodes has
//! neither.

#![allow(non_snake_case)]

use super::element::{Request, evaluate, motion};
use super::rigid::{Carrier, FrameAt, Moved, angles, carry};
use crate::{Compared, Layout, Random, Report, State, sizes};
use nalgebra::{DVector, Vector3};
use pullback_elements::element::Element;
use std::f64::consts::TAU;

/// What round-off explains, as a fraction of the sizes that cancel: two logarithms and two tangents
/// there and back.
pub(crate) const EXACT: f64 = 1e-11;
/// Rotation vectors closer to 0 or 2π than this are not looked at in the other chart.
const CLEAR: f64 = 0.2;
/// First relative motion of the nodes in the limit of small ones, in units.
const FIRST: f64 = 0.1;

/// An element as a model uses it.
pub(crate) struct Placed<'a> {
    pub element: &'a dyn Element,
    pub layout: &'a Layout,
    pub frames: &'a [FrameAt],
}

/// A law of invariance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Law {
    Objectivity,
    Charts,
}

/// Notes objectivity (where the element has to have it) and independence of charts.
pub(crate) fn laws(
    report: &mut Report,
    of: &Placed<'_>,
    states: &[(String, State)],
    random: &mut Random,
) {
    if of.frames.is_empty() {
        return;
    }
    if of.element.properties().objective {
        of.check(report, Law::Objectivity, states, random);
    }
    of.check(report, Law::Charts, states, random);
}

/// A vector of a norm in a random direction.
pub(crate) fn vector(random: &mut Random, norm: f64) -> Vector3<f64> {
    let mut out = Vector3::zeros();
    random.direction(norm, out.as_mut_slice());
    out
}

impl Placed<'_> {
    /// A typical length: the unit of the first frame's displacement.
    fn length(&self) -> f64 {
        self.layout.units()[self.frames[0].first]
    }

    fn center(&self) -> Vector3<f64> {
        self.frames[0].position
    }

    /// What a law does to a state.
    fn carrier(&self, law: Law, random: &mut Random) -> Carrier {
        match law {
            Law::Charts => Carrier::Chart,
            Law::Objectivity => {
                let shift = vector(random, self.length());
                Carrier::still(self.center(), vector(random, 1.0), shift)
            }
        }
    }

    fn check(
        &self,
        report: &mut Report,
        law: Law,
        states: &[(String, State)],
        random: &mut Random,
    ) {
        let name = match law {
            Law::Objectivity => "objective",
            Law::Charts => "the same in the other chart",
        };
        let mut exact = Report::new(report.subject());
        for (at, s) in states {
            // Away from Ψ = 0, where there is no other chart.
            let turn = Carrier::still(self.center(), vector(random, 1.3), Vector3::zeros());
            let state = match law {
                Law::Objectivity => s.clone(),
                Law::Charts => carry(turn, 0.0, self.frames, s).state,
            };
            let moved = carry(self.carrier(law, random), 0.0, self.frames, &state);
            if [&state, &moved.state].iter().all(|s| self.clear(s)) {
                self.compare(&mut exact, name, at, &state, &moved);
            }
        }
        // The largest defect decides which of the two laws it is.
        let exactly = exact.is_ok() || self.frames.len() == 1;
        if exactly && !exact.rows().is_empty() {
            return report.extend(exact);
        }
        for moving in [false, true] {
            // Terms of two orders may cancel by chance: not in two directions.
            for last in [false, true] {
                self.limit(report, law, name, moving, &states[0].1, random);
                if last || !report.retry() {
                    break;
                }
            }
        }
    }

    fn clear(&self, s: &State) -> bool {
        let [most, least] = angles(self.frames, &s.x);
        most < TAU - CLEAR && least > CLEAR || most < TAU / 2.0 && least > 0.0
    }

    /// The difference of forces in the same coordinates, group by group.
    fn gap(&self, s: &State, moved: &Moved) -> Option<[DVector<f64>; 2]> {
        let here = evaluate(self.element, s, Request::Residual)?.r;
        let there = evaluate(self.element, &moved.state, Request::Residual)?.r;
        Some([moved.B.tr_mul(&there), here])
    }

    fn compare(&self, report: &mut Report, name: &str, at: &str, s: &State, moved: &Moved) {
        let Some(all) = evaluate(self.element, s, Request::All) else {
            return;
        };
        let Some([there, here]) = self.gap(s, moved) else {
            return report.impossible(name, at, "outside of the domain there");
        };
        // Forces go through B, whose entries may be large near the edge of a chart.
        let bend = 1.0 + moved.B.amax().powi(2);
        let sizes = sizes(self.layout, s, &all);
        let mut allowed: Vec<f64> = sizes.iter().map(|s| EXACT * s * bend).collect();
        let mut defects = self.layout.forces((&there - &here).as_slice());
        // A conservative load in a field may be objective in its forces and not in its energy.
        if !self.element.properties().load {
            let [a, b] = [s, &moved.state].map(|s| self.element.energy(&motion(s)));
            defects.push((a - b).abs());
            allowed.push(EXACT * (a.abs() + sizes.iter().sum::<f64>()));
        }
        report.defects(name, at, &defects, &allowed);
        report.blame(|| self.blocks(&there, &here));
    }

    fn blocks(&self, there: &DVector<f64>, here: &DVector<f64>) -> Vec<crate::Block> {
        Compared {
            matrix: "force",
            rows: self.layout,
            columns: &Layout::single(),
            forces: true,
            values: vec![(0, there.as_slice().to_vec(), here.as_slice().to_vec())],
        }
        .worst()
    }

    /// Defects beside a rigid motion, as the relative motion of the nodes goes to zero: of second
    /// order at rest, where forces are of first order; of first order in motion and for loads,
    /// where forces stay.
    fn limit(
        &self,
        report: &mut Report,
        law: Law,
        name: &str,
        moving: bool,
        s: &State,
        random: &mut Random,
    ) {
        let rate = self.layout.rate;
        let units = DVector::from_vec(self.layout.units());
        let n = units.len();
        let mut noise = || {
            let mut d = DVector::zeros(n);
            random.fill(d.as_mut_slice());
            d.component_mul(&units)
        };
        let (dx, dv, da) = (noise(), noise() * rate, noise() * (rate * rate));
        let rigid = Carrier::Rigid {
            about: self.center(),
            turn: vector(random, 1.3),
            spin: vector(random, if moving { rate } else { 0.0 }),
            shift: vector(random, self.length()),
            drift: vector(random, if moving { rate * self.length() } else { 0.0 }),
        };
        let to = self.carrier(law, random);
        let at = |e: f64| -> State {
            // Coordinates that are no frame stay where they are.
            let mut near = match moving {
                true => State {
                    t: s.t,
                    x: &dx * e,
                    v: &dv * e,
                    a: &da * e,
                },
                false => State::statics(s.t, &dx * e),
            };
            let framed = |i: usize| {
                self.frames
                    .iter()
                    .any(|f| (f.first..f.first + 6).contains(&i))
            };
            for i in (0..n).filter(|&i| !framed(i)) {
                near.x[i] = s.x[i];
            }
            carry(rigid, 0.0, self.frames, &near).state
        };
        let law = format!("{name} in the limit of small strains");
        let name = format!("rigid, {}", if moving { "moving" } else { "at rest" });
        let Some(all) = evaluate(self.element, &at(0.0), Request::All) else {
            return report.impossible(&law, &name, "outside of the domain");
        };
        let order = if moving || self.element.properties().load {
            1.0
        } else {
            2.0
        };
        let sizes = sizes(self.layout, &at(0.0), &all);
        report.slopes(&law, &name, order, FIRST, &sizes, |e| {
            let state = at(e);
            let moved = carry(to, 0.0, self.frames, &state);
            let gap = self.gap(&state, &moved);
            gap.map_or_else(
                || vec![f64::NAN; sizes.len()],
                |[there, here]| self.layout.forces((there - here).as_slice()),
            )
        });
        report.blame(|| {
            let state = at(FIRST);
            let moved = carry(to, 0.0, self.frames, &state);
            let gap = self.gap(&state, &moved);
            gap.map_or_else(Vec::new, |[there, here]| self.blocks(&there, &here))
        });
    }
}
