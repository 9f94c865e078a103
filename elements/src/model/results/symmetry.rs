//! Symmetries of a model: rigid motions of the whole along which only steady loads do work, at a
//! constant rate.
//!
//! They are measured (Noether's theorem): one of the six motions ξ is a symmetry if all frames with
//! elements can follow it; if, at several states and times, the steady loads have constant power
//! along it and other static forces none; if dampers dissipate nothing; and if the kinetic energy
//! is unchanged. Its momentum then changes at the rate of that power.

mod conditions;

use crate::blocks::three;
use crate::model::kinematics::motion::RigidMotion;
use crate::model::{Context, Model};
use nalgebra::{DMatrix, Vector3};
use pullback_manifold::system::{Quantity, RigidRates, Symmetry, System, SystemError};

/// Power along a motion, relative to that of its parts, that counts as rounding.
const NOTHING: f64 = 1e-8;
/// Relative times in the span at which forces are evaluated, each at a state of its own.
const TIMES: [f64; 9] = [0.01, 0.37, 0.83, 0.11, 0.53, 0.97, 0.23, 0.71, 0.44];

pub(super) fn motion_of(xi: &RigidRates) -> RigidMotion {
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

/// A model whose symmetries are measured.
pub(super) struct Measured<'a>(pub(super) &'a mut Context);

impl Measured<'_> {
    /// Those motions that all conditions allow.
    pub(super) fn symmetries(
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
        // A decomposition needs a row.
        rows.resize(rows.len().max(1), [0.0; 6]);
        let flat = rows.iter().flatten().copied();
        if flat.clone().any(|x| !x.is_finite()) {
            return Ok(Vec::new());
        }
        let R = DMatrix::from_row_iterator(rows.len(), 6, flat);
        let mut found = Vec::new();
        for xi in null_space(R, self.0.model.length) {
            let lost = self.is_lossy(times[1], &states[1], &xi, span[1] - span[0])?;
            // Angular velocities are not rates: a motion that is rigid by frames and forces also
            // conserves kinetic energy.
            let keeps =
                self.0.has_spins() || self.keeps_kinetic_energy(times[1], &states[1], v, &xi)?;
            if keeps && !lost {
                let force = self.along(&first, &xi);
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
        self.0.work.released.clear();
        let mut all = Vec::with_capacity(6);
        // Rates of what is prescribed are no part of a rigid motion.
        let mut still = vec![0.0; q.len()];
        (self.0).fit_rates(q, &mut still, None, &RigidMotion::default(), &[])?;
        for k in 0..6 {
            let motion = motion_of(&unit(k));
            let mut rates = vec![0.0; q.len()];
            self.0.set_velocity(q, &mut rates, None, &motion);
            let frames = rates.clone();
            self.0.fit_rates(q, &mut rates, None, &motion, &[])?;
            for ((rate, frame), still) in rates.iter_mut().zip(frames).zip(&still) {
                // Rounded, so that a continued run gets the same.
                *rate = ((*rate - frame - still) * 1e12).round() * 1e-12;
            }
            all.push(rates);
        }
        self.0.work.released = all;
        Ok(())
    }

    /// A state near q: q itself, or q with changes without symmetry.
    fn near(&self, q: &[f64], number: usize) -> Vec<f64> {
        let size = |i: usize| match self.0.model.quantities[self.0.model.coordinates[i]] {
            _ if number == 0 || self.0.pattern().coordinates()[i].is_multiplier => 0.0,
            Quantity::Length => 0.02 * self.0.model.length,
            Quantity::Angle | Quantity::Other => 0.1,
        };
        let wave = |i: usize| ((1.3 + number as f64) * ((i + 1) as f64).powf(1.4)).sin();
        q.iter()
            .enumerate()
            .map(|(i, q)| q + size(i) * wave(i))
            .collect()
    }
}

/// Null space of a matrix over rigid motions (its translations in units of `length`), pure
/// translations first; by elimination, so that as many entries as possible are zero.
fn null_space(R: DMatrix<f64>, length: f64) -> Vec<RigidRates> {
    let qr = R.transpose().col_piv_qr();
    let mut Qt = DMatrix::identity(6, 6);
    qr.q_tr_mul(&mut Qt);
    let U = qr.r();
    let rank = (0..U.nrows())
        .filter(|&k| U[(k, k)].abs() > NOTHING)
        .count();
    let mut basis: Vec<[f64; 6]> = (rank..6)
        .map(|k| std::array::from_fn(|i| Qt[(k, i)]))
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
