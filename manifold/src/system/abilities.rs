//! Abilities of a system beyond its evaluation.

use super::{ChartChanges, Energies, Point, RigidRates, Symmetry, SystemError};

/// Charts of a system that change between steps.
pub trait Charts {
    /// Changes charts where needed, after a converged step at time `t`.
    ///
    /// Transforms the coordinates `q`, a velocity-like vector `v` and any number of
    /// acceleration-like vectors (ä ↦ B a + Ḃ v) in place.
    fn change_charts(
        &mut self,
        t: f64,
        q: &mut [f64],
        v: &mut [f64],
        accelerations: &mut [&mut [f64]],
    ) -> ChartChanges;

    /// Starts a run at `q` and time `t`, or restarts it after a failed step: a system with more
    /// state than its coordinates restores the state that belongs to them. Nothing by default.
    fn start(&mut self, t: f64, q: &[f64]) {
        let _ = (t, q);
    }

    /// Warnings about nearby singular configurations, for the report of a failed step; none by
    /// default.
    fn singularity_warnings(&mut self) -> Vec<String> {
        Vec::new()
    }
}

/// Discontinuities of a system, at which steps end: kinks of prescribed functions, inputs that change
/// from outside, and segments of piecewise maps.
pub trait Events {
    /// Times at which a derivative of a prescribed function jumps; a time step may end there but
    /// not cross them. In any order, possibly repeated; none by default.
    fn kinks(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Values that a program sets during a run, as part of the state. If one changes between two steps,
    /// accelerations jump, as at a kink. None by default.
    fn inputs(&mut self) -> &mut [f64] {
        &mut []
    }

    /// Amount by which the step overshot the first change of segment, in units of time; negative before
    /// it. Such a change keeps values but not their derivatives, and a step across it loses its order,
    /// so integrators end a step there. Static points are a unit of time apart, at rest. −∞ if there is no change ahead, and
    /// by default.
    fn value(&mut self, from: Point<'_>, to: Point<'_>) -> f64 {
        let _ = (from, to);
        f64::NEG_INFINITY
    }

    /// Makes the next [`Charts::change_charts`] enter all segments whose [`Events::value`] is at
    /// least `since`.
    fn apply(&mut self, from: Point<'_>, to: Point<'_>, since: f64) {
        let _ = (from, to, since);
    }

    /// Writes the momentum to conserve across the last change of segment to `p`, before the change
    /// or at a point after it; false if no segment changed. The values of the map are continuous
    /// there, its operator jumps from B₋ to B₊.
    ///
    /// This is ½ (B₊ + B₋)ᵀ M ẋ: the motion continues as along a curve that the corner
    /// approximates, in every moving frame, while B₋ᵀ M ẋ₋ = B₊ᵀ M ẋ₊ depends on the observer.
    ///
    /// # Errors
    /// As [`System::evaluate`](super::System::evaluate).
    fn kept_momentum(&mut self, at: Option<Point<'_>>, p: &mut [f64]) -> Result<bool, SystemError> {
        let _ = (at, p);
        Ok(false)
    }
}

/// Energies, momenta and symmetries of a system.
pub trait Energetics {
    /// Energies and powers at a point in motion.
    ///
    /// # Errors
    /// As [`System::evaluate`](super::System::evaluate).
    fn energies(&mut self, at: Point<'_>) -> Result<Energies, SystemError>;

    /// Power of dampers at a point in motion, [`Energies::dissipated`] alone.
    ///
    /// # Errors
    /// As [`Energetics::energies`].
    fn dissipation(&mut self, at: Point<'_>) -> Result<f64, SystemError> {
        Ok(self.energies(at)?.dissipated)
    }

    /// Writes the generalised momentum p = ∂T/∂q̇ at a point in motion to `p`; false, with `p`
    /// unchanged, if it does not depend on t at fixed q and q̇.
    ///
    /// When a prescribed velocity jumps, p is continuous: the free velocities take the impulse.
    ///
    /// # Errors
    /// As [`System::evaluate`](super::System::evaluate).
    fn momentum(&mut self, at: Point<'_>, p: &mut [f64]) -> Result<bool, SystemError> {
        let _ = (at, p);
        Ok(false)
    }

    /// Symmetries of the system around the state q, q̇: a basis of the rigid motions (velocity of
    /// the origin, angular velocity) along which steady loads have constant power and no other
    /// force or constraint does work between the two times. None by default.
    fn symmetries(&mut self, span: [f64; 2], q: &[f64], v: &[f64]) -> Vec<Symmetry> {
        let _ = (span, q, v);
        Vec::new()
    }

    /// Keeps those of the [`Energetics::symmetries`] that still are symmetries at another point, which a step has
    /// reached: a joint may follow a motion for some time only, as a point on a track that begins straight, and a load
    /// may begin to work, as drag with the velocity. All by default.
    fn keep_symmetries(&mut self, at: Point<'_>, found: &mut Vec<Symmetry>) {
        let _ = (at, found);
    }

    /// Rates of all coordinates at q in a rigid motion from [`Energetics::symmetries`], or in a sum
    /// of these.
    fn rigid_rates(&mut self, q: &[f64], motion: &RigidRates, rates: &mut [f64]) {
        let _ = (q, motion);
        rates.fill(0.0);
    }
}
