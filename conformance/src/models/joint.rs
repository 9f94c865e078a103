//! The laws of a model's joints: maps from the coordinates of parents to those of a frame.

use super::segments;
use super::view::{self, maps, parent_state};
use crate::elements::{Carrier, Component, EXACT, FIRST, FrameAt, carry};
use crate::{Mapped, Random, Report, TestState, kinematics, pieces};
use nalgebra::{DVector, Vector3};
use pullback_elements::model::Context;
use pullback_manifold::map::Parametrization;
use pullback_manifold::so3::{log_quaternion, quaternion};

/// The laws of all joints at a state.
pub(super) fn laws(
    report: &mut Report,
    context: &mut Context,
    units: &[f64],
    (at, state): &(String, TestState),
    random: &mut Random,
) {
    if let Err(error) = context.configure(state.point()) {
        return report.impossible("domain", at, error.to_string());
    }
    for (n, map, parents) in maps(context) {
        let joint = view::joint(context, (n, &*map, parents), units);
        let rows = view::rows(context, n, units);
        let node = &context.nodes()[n as usize];
        let mut own = Report::new(joint.name.clone());
        let s = parent_state(context, parents, state.t);
        let of = Mapped {
            map: joint.thing,
            rows: &rows,
            columns: &joint.layout,
        };
        // Velocities have the rate of the model, not that of the map.
        let mut columns = joint.layout.clone();
        columns.rate = rate(&joint.layout.units(), &s);
        let rated = Mapped {
            columns: &columns,
            ..of
        };
        if !kinematics(&mut own, "", rated, at, &s, random) {
            report.extend(own);
            continue;
        }
        pieces(&mut own, of, at, &s, random);
        for sides in segments::changes(context, n, s.t) {
            segments::laws(&mut own, (node, &rows), at, &sides, random);
        }
        if node.is_frame() && !joint.frames.is_empty() && joint.thing.is_objective() {
            Carried {
                of,
                position: node.position(),
                joint: &joint,
            }
            .laws(&mut own, at, &s, random);
        }
        report.extend(own);
    }
}

/// The rate of change of coordinates in units; at a turning point of a loop that of their accelerations.
fn rate(units: &[f64], s: &TestState) -> f64 {
    let speeds = s.v.iter().zip(units).map(|(v, u)| (v / u).abs());
    let turns = s.a.iter().zip(units).map(|(a, u)| (a / u).abs().sqrt());
    let fastest = speeds.chain(turns).fold(0.0, f64::max);
    if fastest.is_normal() { fastest } else { 1.0 }
}

/// A joint whose parents have a superposed rigid motion.
struct Carried<'a> {
    of: Mapped<'a>,
    position: Vector3<f64>,
    joint: &'a Component<&'a dyn Parametrization>,
}

impl Carried<'_> {
    /// The coordinates of the frame at a state of the parents.
    fn child(&self, s: &TestState) -> DVector<f64> {
        DVector::from_vec(self.of.tangent(s.t, s.x.as_slice()).0)
    }

    /// The distance of the frame from the rigid motion of its parents, in lengths and in radians, in any chart.
    fn defect(&self, by: Carrier, turn: &Vector3<f64>, s: &TestState) -> Vec<f64> {
        let still = TestState::statics(s.t, s.x.clone());
        let mut moved = carry(by, &self.joint.frames, &still).state;
        for &k in &self.joint.rotations {
            // Rotations of joints are those of frames, in global components.
            let psi = moved.x.fixed_rows::<3>(k).into_owned();
            let turned = log_quaternion(&quaternion(turn).product(&quaternion(&psi)));
            moved.x.fixed_rows_mut::<3>(k).copy_from(&turned);
        }
        let here = TestState::statics(s.t, self.child(&still));
        let own = [FrameAt {
            first: 0,
            position: self.position,
        }];
        let right = carry(by, &own, &here).state.x;
        let found = self.child(&moved);
        let [a, b] = [&found, &right].map(|x| quaternion(&x.fixed_rows::<3>(3).into_owned()));
        let turns = a.conjugate().product(&b).v.norm() * 2.0;
        let gap = (found.fixed_rows::<3>(0) - right.fixed_rows::<3>(0)).norm();
        vec![gap / self.joint.length(), turns]
    }

    fn laws(&self, report: &mut Report, at: &str, s: &TestState, random: &mut Random) {
        let (about, length) = (self.joint.frames[0].position, self.joint.length());
        let turn = random.of_norm(0.9);
        let by = Carrier::still(about, turn, random.of_norm(length));
        let most = |x: Vec<f64>| x.into_iter().fold(0.0, f64::max);
        let reach = most(self.of.rows.magnitudes(self.child(s).as_slice(), 0));
        let all = most(self.of.columns.magnitudes(s.x.as_slice(), 0));
        let sizes = [(reach + all) / length, 1.0];
        let law = "frames move rigidly with their parents";
        let allowed = sizes.map(|s| EXACT * s);
        let defects = self.defect(by, &turn, s);
        let exact = defects.iter().zip(&allowed).all(|(d, a)| d <= a);
        if exact || self.joint.frames.len() == 1 {
            report.defects(law, at, &defects, &allowed);
            return;
        }
        let law = format!("{law} in the limit of small strains");
        report.twice(|report| self.limit(report, &law, (by, &turn), s, &sizes, random));
    }

    /// The error of interpolated rotation vectors is of second order in the relative motion of the parents.
    fn limit(
        &self,
        report: &mut Report,
        law: &str,
        (by, turn): (Carrier, &Vector3<f64>),
        s: &TestState,
        sizes: &[f64],
        random: &mut Random,
    ) {
        let noise = random.entries(&self.of.columns.units());
        let about = self.joint.frames[0].position;
        let rigid = Carrier::still(about, random.of_norm(1.3), Vector3::zeros());
        let near = |e: f64| {
            let mut x = s.x.clone();
            for f in &self.joint.frames {
                for k in f.first..f.first + 6 {
                    x[k] = noise[k] * e;
                }
            }
            carry(rigid, &self.joint.frames, &TestState::statics(s.t, x)).state
        };
        report.slopes(law, "rigid", 2.0, FIRST, sizes, |e| {
            self.defect(by, turn, &near(e))
        });
    }
}
