//! Gears, racks: coordinates of joints in a fixed ratio.

use crate::model::{ModelBuilder, ModelError, NodeId};
use pullback_manifold::map::{Linear, Map};

/// What is wrong with a gear.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GearError {
    /// The ratio is zero, or not finite.
    #[error("its ratio {0} must be finite and not zero")]
    Ratio(f64),
    /// A node is no single coordinate that could follow another one.
    #[error("{0} is no coordinate that a joint releases, or follows other nodes already")]
    Coordinate(String),
    /// Other gears between the two coordinates have another ratio.
    #[error("other gears between them have the ratio {found}, so that it cannot be {given}")]
    Contradiction {
        /// What the other gears say.
        found: f64,
        /// What this one says.
        given: f64,
    },
}

impl ModelBuilder {
    /// Couples two coordinates that joints release, x₂ = `ratio` x₁: a pair of gears with z₁ and z₂ teeth
    /// has the ratio −z₁/z₂ (z₁/z₂ where one of them has its teeth inside), any angles that turn as one
    /// have 1. From an angle to a displacement the ratio is the radius of a pinion: a rack, on its other
    /// side if the radius is negative.
    ///
    #[doc = include_str!("../../../docs/images/joints/gear.svg")]
    #[doc = include_str!("../../../docs/images/joints/rack.svg")]
    ///
    /// The later one of the two is no coordinate of the model any more: it follows the earlier one through
    /// the map x = r q, and actuators, springs and inertias on it act on that. Only the earlier one can be
    /// prescribed. Gears form trains; one that says what others say already does no harm.
    ///
    /// # Errors
    /// [`ModelError::Gear`] for a ratio that is zero or not finite, a node that is no coordinate, and
    /// gears that contradict each other.
    pub fn gear(&mut self, coordinates: [NodeId; 2], ratio: f64) -> Result<(), ModelError> {
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
        let contradiction = GearError::Contradiction { found, given };
        return agrees.then_some(()).ok_or(contradiction);
    }
    let ratio = ratio * r1 / r2;
    let (leader, follower, ratio) = if a < z {
        (a, z, ratio)
    } else {
        (z, a, 1.0 / ratio)
    };
    for node in [leader, follower] {
        if b.dim(node) != 1 || (node == follower && !b.is_own(node)) {
            return Err(GearError::Coordinate(b.node_name(node).to_owned()));
        }
    }
    b.follow(leader, follower, ratio, Linear::ratio(ratio, 0.0).boxed());
    Ok(())
}
