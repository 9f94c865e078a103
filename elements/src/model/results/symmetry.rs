//! Symmetries of a model: rigid motions of the whole along which only steady loads do work, at a
//! constant rate.
//!
//! They are measured (Noether's theorem): one of the six motions ξ is a symmetry if all frames with
//! elements can follow it; if, at several states and times, the steady loads have constant power
//! along it and other static forces none; if dampers dissipate nothing; and if the kinetic energy
//! is unchanged. Its momentum then changes at the rate of that power.

#![allow(non_snake_case)]

use crate::blocks::three;
use crate::model::assembly::residual::named;
use crate::model::charts::nodes::at_rest;
use crate::model::kinematics::motion::RigidMotion;
use crate::model::{Context, Model, NONE, Node, NodeForm};
use nalgebra::{DMatrix, Matrix3, Vector3};
use pullback_manifold::so3;
use pullback_manifold::system::{
    Evaluation, Point, Quantity, RigidRates, Symmetry, System, SystemError,
};

/// Power along a motion, relative to that of its parts, that counts as rounding.
const NOTHING: f64 = 1e-8;
/// The same for a difference quotient.
const NEARLY: f64 = 1e-5;
/// Relative times in the span at which forces are evaluated, each at a state of its own.
const TIMES: [f64; 9] = [0.01, 0.37, 0.83, 0.11, 0.53, 0.97, 0.23, 0.71, 0.44];

fn motion_of(xi: &RigidRates) -> RigidMotion {
    RigidMotion {
        velocity: three(xi, 0),
        omega: three(xi, 3),
        about: Vector3::zeros(),
    }
}

fn unit(k: usize) -> RigidRates {
    std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 })
}

impl Model {
    /// Unit of a motion: translations are measured in lengths of the model.
    fn measure(&self, k: usize) -> f64 {
        if k < 3 { self.length } else { 1.0 }
    }
}

impl Context {
    /// See [`Energetics::rigid_rates`](pullback_manifold::system::Energetics::rigid_rates): joint coordinates have constant rates.
    pub(in crate::model) fn write_rigid_rates(
        &mut self,
        q: &[f64],
        xi: &RigidRates,
        rates: &mut [f64],
    ) {
        rates.fill(0.0);
        self.set_velocity(q, rates, None, &motion_of(xi));
        for (xi, released) in xi.iter().zip(&self.work.released) {
            for (rate, released) in rates.iter_mut().zip(released) {
                *rate += xi * released;
            }
        }
    }

    /// See [`Energetics::symmetries`](pullback_manifold::system::Energetics::symmetries). A state that cannot be evaluated has none.
    pub(in crate::model) fn find_symmetries(
        &mut self,
        span: [f64; 2],
        q: &[f64],
        v: &[f64],
    ) -> Vec<Symmetry> {
        let found = self.measure_symmetries(span, q, v).unwrap_or_default();
        let a = vec![0.0; q.len()];
        // Restores the state for observers.
        let _ = self.expand(Point {
            t: span[0],
            q,
            v,
            a: &a,
        });
        found
    }

    fn measure_symmetries(
        &mut self,
        span: [f64; 2],
        q: &[f64],
        v: &[f64],
    ) -> Result<Vec<Symmetry>, SystemError> {
        self.fit_released(q)?;
        let states: Vec<Vec<f64>> = (0..TIMES.len()).map(|k| self.near(q, k)).collect();
        let times = TIMES.map(|part| span[0] + part * (span[1] - span[0]));
        let (mut rows, mut steady) = (Vec::new(), Vec::new());
        for (q, t) in states.iter().zip(times) {
            steady.push(self.forces_along(t, q, &mut rows)?);
            self.frames_along(t, q, &mut rows)?;
        }
        let largest = steady
            .iter()
            .fold(0.0, |most: f64, (_, size)| most.max(*size));
        let first = steady[0].0;
        if largest > 0.0 {
            let change = |row: &[f64; 6]| std::array::from_fn(|k| (row[k] - first[k]) / largest);
            rows.extend(steady.iter().map(|(row, _)| change(row)));
        }
        let flat = rows.iter().flatten().copied();
        let R = DMatrix::from_row_iterator(rows.len(), 6, flat);
        let mut found = Vec::new();
        for xi in null_space(&R, self.model.length) {
            let lost = self.is_lossy(times[1], &states[1], &xi, span[1] - span[0])?;
            // Angular velocities are not rates: a motion that is rigid by frames and forces also
            // conserves kinetic energy.
            let keeps =
                self.has_spins() || self.keeps_kinetic_energy(times[1], &states[1], v, &xi)?;
            if keeps && !lost {
                let powers = (0..6).map(|k| first[k] / self.measure(k) * xi[k]);
                let force: f64 = powers.sum();
                found.push(Symmetry {
                    motion: xi,
                    // Zero if it is balanced to rounding.
                    force: if force.abs() > NOTHING * largest {
                        force
                    } else {
                        0.0
                    },
                });
            }
        }
        Ok(found)
    }

    /// Rates of joint coordinates in the six motions, fitted at q.
    fn fit_released(&mut self, q: &[f64]) -> Result<(), SystemError> {
        self.work.released.clear();
        let mut all = Vec::with_capacity(6);
        for k in 0..6 {
            let motion = motion_of(&unit(k));
            let mut rates = vec![0.0; q.len()];
            self.set_velocity(q, &mut rates, None, &motion);
            let frames = rates.clone();
            self.fit_rates(q, &mut rates, None, &motion)?;
            for (rate, frame) in rates.iter_mut().zip(frames) {
                // Rounded, so that a continued run gets the same.
                *rate = ((*rate - frame) * 1e12).round() * 1e-12;
            }
            all.push(rates);
        }
        self.work.released = all;
        Ok(())
    }

    /// A state near q: q itself, or q with changes without symmetry.
    fn near(&self, q: &[f64], number: usize) -> Vec<f64> {
        let size = |i: usize| match self.model.quantities[self.model.coordinates[i]] {
            _ if number == 0 || self.coordinate_info(i).is_multiplier => 0.0,
            Quantity::Length => 0.02 * self.model.length,
            Quantity::Angle => 0.1,
            Quantity::Other => 0.0,
        };
        let wave = |i: usize| ((1.3 + number as f64) * ((i + 1) as f64).powf(1.4)).sin();
        q.iter()
            .enumerate()
            .map(|(i, q)| q + size(i) * wave(i))
            .collect()
    }

    fn fields(&mut self, q: &[f64]) -> Vec<Vec<f64>> {
        let field = |k| {
            let mut X = vec![0.0; q.len()];
            self.write_rigid_rates(q, &unit(k), &mut X);
            X
        };
        (0..6).map(field).collect()
    }

    /// The same as rates of coordinates; those of rotations may be angular velocities.
    fn coordinate_rates(&mut self, t: f64, q: &[f64]) -> Result<Vec<Vec<f64>>, SystemError> {
        let (mut fields, a) = (self.fields(q), vec![0.0; q.len()]);
        if self.has_spins() {
            for X in &mut fields {
                self.expand(Point { t, q, v: X, a: &a })?;
                for (X, &c) in X.iter_mut().zip(&self.model.coordinates) {
                    *X = self.work.v[c];
                }
            }
        }
        Ok(fields)
    }

    /// The power of the steady loads along the six motions, with the size of its parts; writes that
    /// of all other static forces, relative to its parts, to `rows`.
    fn forces_along(
        &mut self,
        t: f64,
        q: &[f64],
        rows: &mut Vec<[f64; 6]>,
    ) -> Result<([f64; 6], f64), SystemError> {
        let (mut r, mut steady) = (vec![0.0; q.len()], vec![0.0; q.len()]);
        let at = at_rest(t, q);
        self.evaluate(at, Evaluation::residual(&mut r))?;
        self.steady_loads(at, &mut steady)?;
        let fields = self.coordinate_rates(t, q)?;
        let (mut of_steady, mut of_others) = ([0.0; 6], [0.0; 6]);
        let mut sizes = [0.0_f64; 2];
        for (k, X) in fields.iter().enumerate() {
            let mut parts = [0.0; 2];
            for ((r, s), X) in r.iter().zip(&steady).zip(X) {
                let X = X * self.measure(k);
                of_steady[k] += s * X;
                of_others[k] += (r - s) * X;
                // The sum of two cancelling parts has their rounding errors.
                parts = [
                    parts[0] + (s * X).abs(),
                    parts[1] + ((s * X).abs() + (r * X).abs()),
                ];
            }
            sizes = std::array::from_fn(|i| sizes[i].max(parts[i]));
        }
        if sizes[1] > 0.0 {
            rows.push(of_others.map(|x| x / sizes[1]));
        }
        Ok((of_steady, sizes[0]))
    }

    /// The forces of the steady loads on the unknowns, in statics.
    fn steady_loads(&mut self, at: Point<'_>, r: &mut [f64]) -> Result<(), SystemError> {
        self.expand(at)?;
        let (w, model) = (&mut self.work, &*self.model);
        w.r.fill(0.0);
        for (e, state) in model.elements.iter().zip(&self.state.elements) {
            if !e.steady {
                continue;
            }
            let local = &mut w.local;
            local.read((e, state), &model.spans, &w.x, None);
            local
                .evaluate((e, state), at.t, true, None, false, false)
                .map_err(|error| named(error, &e.name))?;
            local.pull_back((e, state), &model.spans, 0, false);
            local.add_residual(e, &model.spans, &mut w.r);
        }
        self.pull_back_nodes(at.t, None, [false; 2]);
        self.model.free.gather(&self.work.r, "steady loads", r)
    }

    /// Errors of frames with elements in the six motions.
    fn frames_along(
        &mut self,
        t: f64,
        q: &[f64],
        rows: &mut Vec<[f64; 6]>,
    ) -> Result<(), SystemError> {
        let frames = self.moving_frames();
        let zero = vec![0.0; q.len()];
        let rest = Point {
            t,
            q,
            v: &zero,
            a: &zero,
        };
        self.expand(rest)?;
        let prescribed = self.work.v.clone();
        let first = rows.len();
        rows.resize(first + 6 * frames.len(), [0.0; 6]);
        for (k, X) in self.fields(q).iter().enumerate() {
            self.expand(Point { v: X, ..rest })?;
            let motion = motion_of(&unit(k));
            for (frame, rows) in frames.iter().zip(rows[first..].chunks_exact_mut(6)) {
                let node = &self.model.nodes[*frame];
                let rate = |i: usize| {
                    let c = node.first + i;
                    three(&self.work.v, c) - three(&prescribed, c)
                };
                let x = &self.work.x[node.range()];
                let position = node.position + three(x, 0);
                let T = match node.form {
                    NodeForm::Pose => Matrix3::identity(),
                    _ => so3::tangent(&three(x, 3)),
                };
                let missing =
                    (rate(0) - motion.velocity - motion.omega.cross(&position)) / self.model.length;
                let turned = T.tr_mul(&rate(3)) - motion.omega;
                for i in 0..3 {
                    rows[i][k] = missing[i] * self.measure(k);
                    rows[3 + i][k] = turned[i] * self.measure(k);
                }
            }
        }
        Ok(())
    }

    /// Frames with elements that are not entirely prescribed.
    fn moving_frames(&self) -> Vec<usize> {
        let nodes = &self.model.nodes;
        let free = |n: &Node| n.range().any(|c| self.model.unknowns[c] != NONE);
        let mut moves: Vec<bool> = nodes.iter().map(|n| n.is_own() && free(n)).collect();
        for &n in &self.model.dependent {
            if let Some(d) = nodes[n as usize].mapped() {
                let mut parents = d.parents(&self.state.maps).iter();
                moves[n as usize] = parents.any(|&m| moves[m as usize]);
            }
        }
        let mut met = vec![false; nodes.len()];
        for e in self.model.elements.iter().filter(|e| !e.load) {
            for &n in e.nodes.iter() {
                met[n as usize] = true;
            }
        }
        let kept = |&n: &usize| met[n] && nodes[n].is_frame() && moves[n];
        (0..nodes.len()).filter(kept).collect()
    }

    /// Whether dampers dissipate more than rounding errors of a motion in a time.
    fn is_lossy(
        &mut self,
        t: f64,
        q: &[f64],
        xi: &RigidRates,
        time: f64,
    ) -> Result<bool, SystemError> {
        let (mut X, zero) = (vec![0.0; q.len()], vec![0.0; q.len()]);
        self.write_rigid_rates(q, xi, &mut X);
        let at = Point {
            t,
            q,
            v: &X,
            a: &zero,
        };
        let energies = self.evaluate_energies(at, false)?.energies;
        Ok(energies.dissipated * time > NOTHING * energies.kinetic)
    }

    /// Whether the kinetic energy of a motion q̇ is unchanged along ξ: q + ε X, q̇ + ε DX q̇.
    fn keeps_kinetic_energy(
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
            self.write_rigid_rates(q, xi, &mut X);
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
            *T = self.evaluate_energies(at, false)?.energies.kinetic;
        }
        let turn = three(xi, 3).norm() + 1.0 / self.model.length;
        Ok((T[0] - T[1]).abs() <= 2.0 * epsilon * turn * NEARLY * (T[0] + T[1]))
    }
}

/// Null space of a matrix over rigid motions (its translations in units of `length`), pure
/// translations first; by elimination, so that as many entries as possible are zero.
fn null_space(R: &DMatrix<f64>, length: f64) -> Vec<RigidRates> {
    // With rows of zeros the decomposition has all six directions.
    let padded = R.clone().resize_vertically(R.nrows().max(6), 0.0);
    let svd = padded.svd(false, true);
    let Some(V) = svd.v_t else { return Vec::new() };
    let mut basis: Vec<[f64; 6]> = (0..6)
        .filter(|&k| svd.singular_values[k] <= NOTHING)
        .map(|k| std::array::from_fn(|i| V[(k, i)]))
        .collect();
    let mut done = 0;
    for column in [3, 4, 5, 0, 1, 2] {
        let best = (done..basis.len())
            .max_by(|&a, &b| basis[a][column].abs().total_cmp(&basis[b][column].abs()));
        let Some(best) = best.filter(|&b| basis[b][column].abs() > 1e-6) else {
            continue;
        };
        basis.swap(done, best);
        let pivot = basis[done][column];
        basis[done].iter_mut().for_each(|x| *x /= pivot);
        let row = basis[done];
        for other in (0..basis.len()).filter(|&k| k != done) {
            let factor = basis[other][column];
            for (x, y) in basis[other].iter_mut().zip(row) {
                *x -= factor * y;
            }
        }
        done += 1;
    }
    for xi in &mut basis {
        for (i, x) in xi.iter_mut().enumerate() {
            if x.abs() < 1e-9 {
                *x = 0.0;
            }
            if i < 3 {
                *x *= length;
            }
        }
    }
    basis.sort_by_key(|xi| xi[3..].iter().any(|x| *x != 0.0));
    basis
}
