//! A slide in a model: its nodes, and the chain by that of nodes.

use super::Slide;
use crate::beam::Interpolation;
use crate::model::{ModelBuilder, ModelError, NodeId};
use nalgebra::Vector3;
use pullback_manifold::map::Map;
use pullback_manifold::system::Kind;

/// The nodes of a slide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlideNodes {
    /// The frame that runs along the chain.
    pub frame: NodeId,
    /// Its way along the chain in the reference configuration: the released coordinate.
    pub way: NodeId,
}

/// Adds a frame node `name` that slides along the two-node beam elements between `chain`'s nodes,
/// starting at arc length `origin` of the chain, and the node `name way` of its coordinate. The
/// elements interpolate total rotation vectors; [`slide_on`] is for others.
///
/// # Errors
/// [`ModelError::Slide`] for a chain that is none or a start outside it; as
/// [`ModelBuilder::mapped_node`].
pub fn slide(
    b: &mut ModelBuilder,
    name: &str,
    chain: &[NodeId],
    origin: f64,
) -> Result<SlideNodes, ModelError> {
    slide_on(b, name, chain, origin, Interpolation::Total)
}

/// As [`slide`], on elements with this interpolation of rotations.
///
/// # Errors
/// As there.
pub fn slide_on(
    b: &mut ModelBuilder,
    name: &str,
    chain: &[NodeId],
    origin: f64,
    interpolation: Interpolation,
) -> Result<SlideNodes, ModelError> {
    let places: Vec<Vector3<f64>> = chain.iter().map(|&n| b.place(n)).collect();
    let joint = Slide::new(&places, origin).ok_or_else(|| ModelError::Slide {
        joint: name.to_owned(),
        nodes: chain.len(),
        start: origin,
    })?;
    let joint = joint.with_interpolation(interpolation);
    let way = b.coordinates(format!("{name} way"), &[Kind::Length])?;
    let place = joint.place().into();
    let segments: Vec<[NodeId; 3]> = chain.windows(2).map(|p| [p[0], p[1], way]).collect();
    let segments: Vec<&[NodeId]> = segments.iter().map(|s| &s[..]).collect();
    let frame = b.mapped_node_along(name, place, joint.boxed(), &segments)?;
    Ok(SlideNodes { frame, way })
}
