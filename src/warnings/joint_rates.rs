//! Angles of joints whose rates change too much in a step.

use pullback_elements::model::Context;
use pullback_integrators::dynamics::State;
use pullback_integrators::significant;
use pullback_manifold::system::{Quantity, System};
use serde::{Deserialize, Serialize};

/// Change of a rate in a step, times the step, above which steps do not resolve a motion, in radians: a
/// swing of one radian with 14 steps per period reaches it.
const FAR: f64 = 0.2;

/// The largest change of the rate of an angle in a step.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct RateChange {
    name: String,
    by: f64,
    t: f64,
}

/// Records the angles of joints from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointRates {
    /// Unknowns that are single angles.
    angles: Vec<usize>,
    /// Their values and rates at the last step.
    last: Vec<[f64; 2]>,
}

impl JointRates {
    /// Starts at a state.
    pub(crate) fn new(context: &Context, state: &State) -> Self {
        let mut angles = context.single_unknowns();
        angles.retain(|&i| context.pattern().coordinates()[i].quantity == Quantity::Angle);
        let last = angles.iter().map(|&i| [state.q[i], state.v[i]]).collect();
        Self { angles, last }
    }

    /// Records a converged step of size `h`; `furthest` is replaced by a larger change.
    pub(crate) fn record(
        &mut self,
        context: &Context,
        state: &State,
        h: f64,
        furthest: &mut Option<RateChange>,
    ) {
        for (&i, last) in self.angles.iter().zip(&mut self.last) {
            // From the mean rate: that at the end may have jumped with a prescribed motion.
            let by = 2.0 * (state.q[i] - last[0] - h * last[1]).abs();
            *last = [state.q[i], state.v[i]];
            if by > furthest.as_ref().map_or(FAR, |turn| turn.by) {
                *furthest = Some(RateChange {
                    name: context.name(i),
                    by,
                    t: state.t,
                });
            }
        }
    }
}

impl RateChange {
    /// The warning.
    pub(crate) fn warning(&self) -> String {
        format!(
            "the rate of {} changes by {:.2} rad a step within one step (that to t = {}): steps do not \
             resolve what moves there; take smaller ones, or `adaptive`. If it is hardly any mass that \
             turns (a universal joint at a right angle, whose shaft has no inertia about itself), give \
             the body `inertia`, or take a spherical joint",
            self.name,
            self.by,
            significant(self.t)
        )
    }
}
