//! Abilities of a map beyond its evaluation.

use super::Parametrization;
use crate::implicit::ImplicitMap;
use crate::so3::VelocityKind;
use crate::system::ChartChanges;

/// Copies of a map behind a pointer: those of every map that is `Clone`.
pub trait Duplicate {
    /// A copy, in the same charts.
    fn duplicate(&self) -> Box<dyn Parametrization>;
}

impl<M: Parametrization + Clone + 'static> Duplicate for M {
    fn duplicate(&self) -> Box<dyn Parametrization> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn Parametrization> {
    fn clone(&self) -> Self {
        (**self).duplicate()
    }
}

/// What can change in a map between evaluations: charts of its values (branch of a logarithm, segment of a
/// curve), the start of an iteration, the piece in use.
pub trait MapState {
    /// Changes the charts of the values if others are better at q. Called at converged states only: within
    /// a step φ is one smooth function. Nothing by default.
    fn change_charts(&mut self, t: f64, q: &[f64]) -> ChartChanges {
        let _ = (t, q);
        ChartChanges::default()
    }

    /// Makes the next [`MapState::change_charts`] enter this segment, a result of
    /// [`Segments::overshoot`]. Nothing by default, for a map without segments.
    fn enter(&mut self, segment: usize) {
        let _ = segment;
    }

    /// Freezes a piecewise φ (the cubics of a spline) to the piece that holds at (t, q), also
    /// beyond its ends; `None` releases it. Used by the conformance kit to compare derivatives with
    /// differences of one smooth function. Nothing by default, for a smooth φ.
    fn freeze_piece(&mut self, at: Option<(f64, &[f64])>) {
        let _ = at;
    }

    /// The state in numbers, for checkpoints: everything that the next evaluation depends on besides t and q, branches
    /// and segments included. Empty by default.
    fn save(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Restores the state from [`MapState::save`] of the same map; false, with an undefined state, if it belongs to
    /// another map.
    fn restore(&mut self, saved: &[f64]) -> bool {
        saved.is_empty()
    }

    /// Changes of the coordinates.
    fn reparametrization(&mut self) -> Option<&mut dyn Reparametrization> {
        None
    }

    /// The equations that the map solves; `None` for an explicit map.
    fn implicit(&mut self) -> Option<&mut ImplicitMap> {
        None
    }
}

/// A map that changes its coordinates at converged states. No other map or element may use them.
pub trait Reparametrization {
    /// Changes the coordinates q to better ones: transforms them, their velocities and any number of
    /// accelerations in place, and returns whether they changed; x, ẋ and ẍ stay the same to rounding.
    /// Called at every converged state, and never between.
    fn reparametrize(&mut self, t: f64, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]) -> bool;

    /// Kind of angular velocity that replaces the rates of the last three coordinates θ at present,
    /// if any: Ω and Ω̇ are then stored as velocities and accelerations. The model converts them to
    /// θ̇ and θ̈ before it evaluates the map ([`so3::Spin`](crate::so3::Spin)). None by default.
    fn velocity_kind(&self) -> Option<VelocityKind> {
        None
    }
}

/// A map along a chain of elements, which reads other parents on each segment.
pub trait Segments {
    /// Number of segments.
    fn count(&self) -> usize;

    /// Index of the present segment.
    fn segment(&self) -> usize;

    /// Amount by which a step of size h between two states (q, q̇) overshot the first change of
    /// segment, in units of time, negative before it; and the new segment. Integrators end a step
    /// there, by [`MapState::enter`]. `None` if there is no change ahead, or nothing moves along the chain.
    fn overshoot(&self, h: f64, from: [&[f64]; 2], to: [&[f64]; 2]) -> Option<(f64, usize)>;
}
