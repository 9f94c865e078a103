//! The conditions of a symmetry: forces, frames, dampers and the kinetic energy along a motion.

use super::{Measured, NOTHING, motion_of, unit};
use crate::blocks::three;
use crate::model::assembly::residual::named;
use crate::model::{ElementEntry, NodeForm};
use nalgebra::Matrix3;
use pullback_manifold::so3;
use pullback_manifold::system::{
    Energetics, Evaluation, Point, RigidRates, Symmetry, System, SystemError,
};

/// Power along a motion, relative to that of its parts, that counts as rounding of a difference quotient.
const NEARLY: f64 = 1e-5;

impl Measured<'_> {
    /// The power of the steady loads along the six motions, with the size of its parts; writes that
    /// of all other static forces, relative to its parts, to `rows`.
    pub(super) fn forces_along(
        &mut self,
        t: f64,
        q: &[f64],
        rows: &mut Vec<[f64; 6]>,
    ) -> Result<([f64; 6], f64), SystemError> {
        let (mut r, at) = (vec![0.0; q.len()], Point::statics(t, q));
        self.0.evaluate(at, Evaluation::residual(&mut r))?;
        let (all, size) = self.powers(t, q, &r)?;
        let (steady, part) = self.load_powers(at, |e| e.time_independent)?;
        if size + part > 0.0 {
            // The sum of two cancelling parts has their rounding errors.
            rows.push(std::array::from_fn(|k| {
                (all[k] - steady[k]) / (size + part)
            }));
        }
        Ok((steady, part))
    }

    /// Keeps the symmetries along which all loads still have their constant power, and that all joints still follow.
    pub(in crate::model::results) fn keep(
        &mut self,
        at: Point<'_>,
        found: &mut Vec<Symmetry>,
    ) -> Result<(), SystemError> {
        if self.0.model.elements.iter().any(|e| e.load) {
            let (powers, size) = self.load_powers(at, |e| e.load)?;
            found.retain(|s| (self.along(&powers, &s.motion) - s.force).abs() <= NOTHING * size);
        }
        // Frames may be kept from it by joints alone.
        let mut rates = self.0.work.released.iter().flatten();
        if rates.any(|rate| *rate != 0.0) {
            let small = |errors: Vec<f64>| errors.iter().all(|error| error.abs() <= NOTHING);
            found.retain(|s| self.frame_errors(at.t, at.q, &s.motion).is_ok_and(small));
        }
        Ok(())
    }

    /// The sum of values of the six motions along one.
    pub(super) fn along(&self, values: &[f64; 6], motion: &RigidRates) -> f64 {
        let parts = values.iter().zip(motion).enumerate();
        parts
            .map(|(k, (value, xi))| value / self.0.model.measure(k) * xi)
            .sum()
    }

    /// The power of forces on the unknowns along the six motions, and the size of its parts.
    fn powers(&mut self, t: f64, q: &[f64], r: &[f64]) -> Result<([f64; 6], f64), SystemError> {
        let [mut X, mut a] = std::mem::take(&mut self.0.work.motion);
        X.resize(q.len(), 0.0);
        a.resize(q.len(), 0.0);
        let (mut powers, mut size) = ([0.0; 6], 0.0_f64);
        for (k, power) in powers.iter_mut().enumerate() {
            self.0.rigid_rates(q, &unit(k), &mut X);
            if self.0.has_spins() {
                // Forces on rotations may belong to angular velocities.
                self.0.expand(Point { t, q, v: &X, a: &a })?;
                for (X, &c) in X.iter_mut().zip(&self.0.model.coordinates) {
                    *X = self.0.work.v[c];
                }
            }
            let parts = r.iter().zip(&X).map(|(r, X)| r * X * self.0.measure(k));
            *power = parts.clone().sum();
            size = size.max(parts.map(f64::abs).sum());
        }
        self.0.work.motion = [X, a];
        Ok((powers, size))
    }

    /// The same of some loads.
    fn load_powers(
        &mut self,
        at: Point<'_>,
        kept: impl Fn(&ElementEntry) -> bool,
    ) -> Result<([f64; 6], f64), SystemError> {
        self.0.expand(at)?;
        let (w, model) = (&mut self.0.work, &*self.0.model);
        w.r.fill(0.0);
        for (e, state) in model.elements.iter().zip(&self.0.state.elements) {
            if !kept(e) {
                continue;
            }
            let local = &mut w.local;
            local.read((e, state), &model.spans, [&w.x, &w.v, &w.a]);
            local
                .evaluate((e, state), at.t, at.is_static(), None, false, false)
                .map_err(|error| named(error, &e.name))?;
            local.pull_back((e, state), &model.spans, 0, false);
            local.add_residual(e, &model.spans, &mut w.r);
        }
        self.0.pull_back_nodes(at.t, None, [false; 2]);
        let mut r = std::mem::take(&mut self.0.work.load);
        r.resize(at.q.len(), 0.0);
        self.0.model.gather(&self.0.work.r, "loads", &mut r)?;
        let powers = self.powers(at.t, at.q, &r);
        self.0.work.load = r;
        powers
    }

    /// Errors of frames with elements in the six motions.
    pub(super) fn frames_along(
        &mut self,
        t: f64,
        q: &[f64],
        rows: &mut Vec<[f64; 6]>,
    ) -> Result<(), SystemError> {
        let first = rows.len();
        for k in 0..6 {
            let errors = self.frame_errors(t, q, &unit(k))?;
            rows.resize(first + errors.len(), [0.0; 6]);
            for (row, error) in rows[first..].iter_mut().zip(errors) {
                row[k] = error * self.0.measure(k);
            }
        }
        Ok(())
    }

    /// Errors of frames with elements in a motion: of their velocities, in lengths of the model, and angular velocities.
    fn frame_errors(
        &mut self,
        t: f64,
        q: &[f64],
        xi: &RigidRates,
    ) -> Result<Vec<f64>, SystemError> {
        let (mut X, zero) = (vec![0.0; q.len()], vec![0.0; q.len()]);
        let rest = Point {
            t,
            q,
            v: &zero,
            a: &zero,
        };
        self.0.expand(rest)?;
        let prescribed = self.0.work.v.clone();
        self.0.rigid_rates(q, xi, &mut X);
        self.0.expand(Point { v: &X, ..rest })?;
        let (motion, mut errors) = (motion_of(xi), Vec::new());
        for frame in self.moving_frames() {
            let node = &self.0.model.nodes[frame];
            let rate = |i: usize| {
                let c = node.first + i;
                three(&self.0.work.v, c) - three(&prescribed, c)
            };
            let x = &self.0.work.x[node.range()];
            let position = node.position + three(x, 0);
            let T = match node.form {
                NodeForm::Pose => Matrix3::identity(),
                _ => so3::tangent(&three(x, 3)),
            };
            let missing = rate(0) - motion.velocity - motion.omega.cross(&position);
            let turned = T.tr_mul(&rate(3)) - motion.omega;
            errors.extend_from_slice((missing / self.0.model.length).as_slice());
            errors.extend_from_slice(turned.as_slice());
        }
        Ok(errors)
    }

    /// Frames with elements that are not entirely prescribed.
    fn moving_frames(&self) -> Vec<usize> {
        let (nodes, couplings) = (&self.0.model.nodes, &self.0.work.scatter_map.couplings);
        let mut met = vec![false; nodes.len()];
        for e in self.0.model.elements.iter().filter(|e| !e.load) {
            for &n in e.nodes.iter() {
                met[n as usize] = true;
            }
        }
        let kept = |&n: &usize| met[n] && nodes[n].is_frame() && !couplings.is_fixed(n as u32);
        (0..nodes.len()).filter(kept).collect()
    }

    /// Whether dampers dissipate more than rounding errors of a motion in a time.
    pub(super) fn is_lossy(
        &mut self,
        t: f64,
        q: &[f64],
        xi: &RigidRates,
        time: f64,
    ) -> Result<bool, SystemError> {
        let (mut X, zero) = (vec![0.0; q.len()], vec![0.0; q.len()]);
        self.0.rigid_rates(q, xi, &mut X);
        let at = Point {
            t,
            q,
            v: &X,
            a: &zero,
        };
        let energies = self.0.evaluate_energies(at, false)?.energies;
        Ok(energies.dissipated * time > NOTHING * energies.kinetic)
    }

    /// Whether the kinetic energy of a motion q̇ is unchanged along ξ: q + ε X, q̇ + ε DX q̇.
    pub(super) fn keeps_kinetic_energy(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        xi: &RigidRates,
    ) -> Result<bool, SystemError> {
        let n = q.len();
        let (epsilon, zero) = (1e-4, vec![0.0; n]);
        let mut size = v.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        if size == 0.0 {
            size = 1.0;
        }
        let mut unlike = self.near(&zero, 1);
        for (u, v) in unlike.iter_mut().zip(v) {
            *u += v / size;
        }
        let along = |x: &[f64], by: f64, y: &[f64]| -> Vec<f64> {
            x.iter().zip(y).map(|(x, y)| x + by * y).collect()
        };
        let mut field = |q: &[f64]| {
            let mut X = vec![0.0; n];
            self.0.rigid_rates(q, xi, &mut X);
            X
        };
        let X = field(q);
        let (ahead, back) = (
            field(&along(q, epsilon, &unlike)),
            field(&along(q, -epsilon, &unlike)),
        );
        let DXv: Vec<f64> = (ahead.iter().zip(&back))
            .map(|(a, b)| (a - b) / (2.0 * epsilon))
            .collect();
        let mut T = [0.0; 2];
        for (T, by) in T.iter_mut().zip([epsilon, -epsilon]) {
            let (q, v) = (along(q, by, &X), along(&unlike, by, &DXv));
            let at = Point {
                t,
                q: &q,
                v: &v,
                a: &zero,
            };
            *T = self.0.evaluate_energies(at, false)?.energies.kinetic;
        }
        let turn = three(xi, 3).norm() + 1.0 / self.0.model.length;
        Ok((T[0] - T[1]).abs() <= 2.0 * epsilon * turn * NEARLY * (T[0] + T[1]))
    }
}
