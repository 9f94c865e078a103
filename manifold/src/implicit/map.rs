//! The map of an implicit constraint: φ over any number type, and its derivatives in closed form.

#![allow(non_snake_case)]

use super::{Equations, Implicit, Solved};
use crate::jet::Taylor;
use crate::map::{Kinematics, Map, Reparametrized, Tangent, derived};
use crate::scalar::Scalar;
use crate::system::ChartChanges;
use nalgebra::{SMatrix, SVector};

impl<H, const D: usize, const X: usize, const M: usize> Map<D, X> for Solved<H, D, X, M>
where
    H: Implicit<X, M>,
{
    /// The value by Newton's method. Over jets each further correction −P h, with a plain P, is
    /// exact to one order more; as many as the order of the jet make all derivatives exact.
    ///
    /// Not a number if the equations cannot be solved; the margin is negative there.
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, D>) -> SVector<S, X> {
        let value = q.map(|q| q.re());
        let Ok(at) = self.solve(t.re(), &value) else {
            return SVector::repeat(S::constant(f64::NAN));
        };
        let mut x = at.x.map(S::constant);
        for j in 0..D {
            let dq = q[j] - value[j];
            for k in 0..X {
                x[k] += dq * at.inverse.B[(k, j)];
            }
        }
        for _ in 0..S::ORDER {
            let h = self.constraint.h(t, &x);
            for i in (0..M).filter(|&i| self.chart.used[i]) {
                for k in 0..X {
                    x[k] -= h[i] * at.inverse.P[(k, i)];
                }
            }
        }
        x
    }

    /// Inverse condition number of A, less the limit of singularity; −1 if the equations cannot be
    /// solved near the last converged state.
    fn margin(&self, t: f64, q: &SVector<f64, D>) -> f64 {
        match self.solve(t, q) {
            Ok(at) => 1.0 / at.inverse.condition - super::chart::RANK,
            Err(_) => -1.0,
        }
    }

    fn domain_error(&self, t: f64, q: &SVector<f64, D>) -> Option<String> {
        self.solve(t, q).err().map(|error| error.to_string())
    }

    /// Not a number if the equations cannot be solved.
    fn violation(&self, t: f64, q: &SVector<f64, D>) -> Option<f64> {
        let h = self.constraint.h(t, &Map::<D, X>::phi(self, t, q));
        let relative = h.iter().zip(&self.sizes).map(|(h, size)| (h / size).abs());
        Some(relative.fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a }))
    }

    /// The charts of x are fixed; Newton's method starts from this state next.
    fn change_charts(&mut self, t: f64, q: &SVector<f64, D>) -> ChartChanges {
        self.remember(t, q);
        ChartChanges::default()
    }

    fn reparametrizes(&self) -> bool {
        self.choice() != super::Choice::Fixed
    }

    fn reparametrize(
        &mut self,
        t: f64,
        q: &SVector<f64, D>,
        v: &SVector<f64, D>,
    ) -> Option<Reparametrized<D>> {
        self.settle(t, q, v)
    }

    fn describe(&self) -> Option<String> {
        let chart = match self.independent() {
            Some(independent) => {
                let names = independent.map(|k| self.constraint.coordinate(k));
                format!("independent: {}", names.join(", "))
            }
            None => "coordinates in the tangent space".to_owned(),
        };
        let redundant = self.redundant();
        Some(if redundant.is_empty() {
            chart
        } else {
            format!("{chart}; redundant: {}", redundant.join(", "))
        })
    }

    fn tangent(&self, t: f64, q: &SVector<f64, D>) -> Tangent<D, X> {
        match self.solve(t, q) {
            Ok(at) => Tangent {
                x: at.x,
                B: at.inverse.B,
            },
            Err(_) => Tangent {
                x: SVector::repeat(f64::NAN),
                B: SMatrix::repeat(f64::NAN),
            },
        }
    }

    fn kinematics(
        &self,
        t: f64,
        q: &SVector<f64, D>,
        v: &SVector<f64, D>,
        a: &SVector<f64, D>,
    ) -> Kinematics<D, X> {
        let Ok(at) = self.solve(t, q) else {
            let nothing = SMatrix::repeat(f64::NAN);
            let nowhere = SVector::repeat(f64::NAN);
            return Kinematics {
                x: nowhere,
                x_dot: nowhere,
                x_ddot: nowhere,
                B: nothing,
                B_dot: nothing,
                B_ddot: nothing,
            };
        };
        let (x, B, P) = (at.x, at.inverse.B, at.inverse.P);
        // h along t + τ and the motion x + ẋτ, with two unknown terms.
        let along = |x_dot: &SVector<f64, X>| {
            let time = Taylor {
                v: t,
                d: 1.0,
                dd: 0.0,
            };
            let x = SVector::from_fn(|k, _| Taylor {
                v: x[k],
                d: x_dot[k],
                dd: 0.0,
            });
            self.constraint.h(time, &x)
        };
        let x_dot = B * v - P * along(&SVector::zeros()).map(|h| h.d);
        let x_ddot = B * a - P * along(&x_dot).map(|h| h.dd);
        let h = derived::kinematics(&Equations(&self.constraint), t, &x, &x_dot, &x_ddot);
        let B_dot = -P * (h.B_dot * B);
        Kinematics {
            x,
            x_dot,
            x_ddot,
            B,
            B_dot,
            B_ddot: -P * (h.B_ddot * B + h.B_dot * B_dot * 2.0),
        }
    }

    fn geometric_stiffness(
        &self,
        t: f64,
        q: &SVector<f64, D>,
        f: &SVector<f64, X>,
    ) -> SMatrix<f64, D, D> {
        let Ok(at) = self.solve(t, q) else {
            return SMatrix::repeat(f64::NAN);
        };
        let lambda = at.inverse.P.tr_mul(f);
        let bend = derived::geometric_stiffness(&Equations(&self.constraint), t, &at.x, &lambda);
        -at.inverse.B.tr_mul(&(bend * at.inverse.B))
    }
}
