//! A frame whose rotation is an unknown in a chart of its own.

use super::RotationChart;
use crate::domain::{CHART_EDGE, DomainError};
use crate::map::{Map, MapState, Reparametrization};
use crate::scalar::Scalar;
use crate::so3::{self, Quaternion};
use nalgebra::{SVector, Vector3};
use std::f64::consts::TAU;

/// A frame or a rotation whose coordinates are those of a chart: (d, c) ↦ (d, Ψ) with D = 6, c ↦ Ψ with
/// D = 3.
///
/// Initial values are rotation vectors. The first converged state transforms them to the chart, with
/// velocities and accelerations, and each one with ψ > π leads to the coordinates of the opposite
/// quaternion. Only this map may use the coordinates c ([`Reparametrization`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Charted<C, const D: usize> {
    chart: C,
    /// Whether the coordinates are those of the chart already.
    entered: bool,
}

impl<C: RotationChart, const D: usize> Charted<C, D> {
    /// From the reference orientation.
    pub fn new(chart: C) -> Self {
        let entered = false;
        Self { chart, entered }
    }

    fn quaternion<S: Scalar>(&self, q: &SVector<S, D>) -> Quaternion<S> {
        let c = Vector3::new(q[D - 3], q[D - 2], q[D - 1]);
        match self.entered {
            true => self.chart.quaternion(&c),
            false => so3::quaternion(&c),
        }
    }
}

impl<C: RotationChart, const D: usize> Map<D, D> for Charted<C, D> {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, D>) -> SVector<S, D> {
        let Psi = so3::log_quaternion(&self.quaternion(q));
        let mut x = *q;
        x.fixed_rows_mut::<3>(D - 3).copy_from(&Psi);
        x
    }

    fn domain(&self, _t: f64, q: &SVector<f64, D>) -> Result<f64, DomainError> {
        let edge = match self.entered {
            true => self
                .chart
                .margin(&Vector3::new(q[D - 3], q[D - 2], q[D - 1])),
            false => f64::INFINITY,
        };
        let psi = so3::log_quaternion(&self.quaternion(q)).norm();
        DomainError::within(edge.min(TAU - psi), CHART_EDGE)
    }

    fn state(&mut self) -> Option<&mut dyn MapState> {
        Some(self)
    }
}

/// From the present coordinates of a rotation to the better ones.
#[derive(Clone, Copy)]
struct Change<C> {
    from: Charted<C, 3>,
    opposite: bool,
}

impl<C: RotationChart> Map<3, 3> for Change<C> {
    fn phi<S: Scalar>(&self, _t: S, q: &Vector3<S>) -> Vector3<S> {
        let rotation = self.from.quaternion(q);
        self.from.chart.coordinates(&match self.opposite {
            true => rotation.opposite(),
            false => rotation,
        })
    }
}

impl<C: RotationChart, const D: usize> MapState for Charted<C, D> {
    /// Whether the coordinates are those of the chart already.
    fn save(&self) -> Vec<f64> {
        vec![f64::from(self.entered)]
    }

    fn restore(&mut self, saved: &[f64]) -> bool {
        let &[entered] = saved else {
            return false;
        };
        self.entered = entered != 0.0;
        true
    }

    fn reparametrization(&mut self) -> Option<&mut dyn Reparametrization> {
        Some(self)
    }
}

impl<C: RotationChart, const D: usize> Reparametrization for Charted<C, D> {
    fn reparametrize(&mut self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]) -> bool {
        let opposite = self.quaternion(&SVector::from_column_slice(q)).w < 0.0;
        if self.entered && !opposite {
            return false;
        }
        let Self { chart, entered } = *self;
        let from = Charted { chart, entered };
        let three = |x: &[f64]| Vector3::from_column_slice(&x[D - 3..]);
        let zero = Vector3::zeros();
        let change = Change { from, opposite }.kinematics(t, &three(q), &three(v), &zero);
        for a in a {
            let second = change.B * three(a) + change.x_ddot;
            a[D - 3..].copy_from_slice(second.as_slice());
        }
        v[D - 3..].copy_from_slice(change.x_dot.as_slice());
        q[D - 3..].copy_from_slice(change.x.as_slice());
        self.entered = true;
        true
    }
}
