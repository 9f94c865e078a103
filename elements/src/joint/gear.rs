//! Gears and racks: coordinates of joints in a fixed ratio.

use crate::model::{ModelBuilder, ModelError, NodeId};
use pullback_manifold::map::{Linear, Map};

/// Error of a gear.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "each message says what its variant is")]
#[non_exhaustive]
pub enum GearError {
    #[error("its ratio {0} must be finite and not zero")]
    Ratio(f64),
    /// A node is no single coordinate that could follow another one.
    #[error("{0} is not a coordinate that a joint releases, or follows other nodes already")]
    Coordinate(String),
    #[error("other gears between them have the ratio {found}, so that it cannot be {requested}")]
    Contradiction { found: f64, requested: f64 },
}

impl ModelBuilder {
    /// Couples two joint coordinates, x₂ = `ratio` x₁. A pair of gears with z₁ and z₂ teeth has the ratio
    /// −z₁/z₂, or z₁/z₂ if one of them is an internal gear; equal angles have the ratio 1. From an angle to
    /// a displacement the ratio is the radius of the pinion of a rack, negative for a rack on its other side.
    ///
    #[doc = include_str!("../../images/gear.svg")]
    #[doc = include_str!("../../images/rack.svg")]
    ///
    /// The node that was added later becomes a mapped one, x = r q of the earlier one. Actuators, springs
    /// and inertias may act on both; only the earlier one can be prescribed. Gears may form trains, and a
    /// redundant gear with a consistent ratio is allowed.
    ///
    /// # Errors
    /// [`ModelError::Gear`] for a ratio that is zero or not finite, a node that is no coordinate, and
    /// gears that contradict each other; [`ModelError::ForeignNode`].
    pub fn gear(&mut self, coordinates: [NodeId; 2], ratio: f64) -> Result<(), ModelError> {
        self.check_own(&coordinates, || "a gear".to_owned())?;
        couple(self, coordinates, ratio).map_err(|source| {
            let [first, second] = coordinates.map(|n| self.node_name(n).to_owned());
            ModelError::Gear {
                first,
                second,
                source,
            }
        })
    }
}

fn couple(b: &mut ModelBuilder, [first, second]: [NodeId; 2], ratio: f64) -> Result<(), GearError> {
    if ratio == 0.0 || !ratio.is_finite() {
        return Err(GearError::Ratio(ratio));
    }
    // x₁ = r₁ x_a and x₂ = r₂ x_z with coordinates a, z that follow no gear.
    let ((a, r1), (z, r2)) = (b.behind_gears(first), b.behind_gears(second));
    if a == z {
        let (found, given) = (r2 / r1, ratio);
        let agrees = (found - given).abs() <= 1e-12 * given.abs();
        let contradiction = GearError::Contradiction {
            found,
            requested: given,
        };
        return agrees.then_some(()).ok_or(contradiction);
    }
    let ratio = ratio * r1 / r2;
    let (leader, follower, ratio) = if a < z {
        (a, z, ratio)
    } else {
        (z, a, 1.0 / ratio)
    };
    for node in [leader, follower] {
        if b.quantities(node).len() != 1 || (node == follower && !b.is_own(node)) {
            return Err(GearError::Coordinate(b.node_name(node).to_owned()));
        }
    }
    b.follow(leader, follower, ratio, Linear::sum([ratio], 0.0).boxed());
    Ok(())
}
