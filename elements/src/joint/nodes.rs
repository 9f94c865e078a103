//! Joints in a model: the frame that is attached to one, and the coordinates that it releases.

use super::shape::Chain;
use super::{Joint, JointMap, Released, Slide, SphericalNodes};
use crate::beam::Interpolation;
use crate::model::{ModelBuilder, ModelError, NodeId};
use nalgebra::Vector3;
use pullback_manifold::map::Map;
use pullback_manifold::system::Quantity;

/// The nodes that a joint makes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JointNodes {
    /// The frame that is attached to the joint.
    pub frame: NodeId,
    /// A node for each of the coordinates that it releases, in their order.
    pub released: Vec<NodeId>,
}

/// The nodes of a revolute joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RevoluteNodes {
    /// The frame that is attached to the joint.
    pub frame: NodeId,
    /// The angle about the axis: the released coordinate, in radians, any number of turns.
    pub angle: NodeId,
}

/// The nodes of a slide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlideNodes {
    /// The frame that runs along the chain.
    pub frame: NodeId,
    /// Arc length along the chain in the reference configuration: the released coordinate.
    pub arc_length: NodeId,
}

impl From<NodeId> for JointNodes {
    fn from(frame: NodeId) -> Self {
        let released = Vec::new();
        Self { frame, released }
    }
}

impl From<RevoluteNodes> for JointNodes {
    fn from(made: RevoluteNodes) -> Self {
        let (frame, released) = (made.frame, vec![made.angle]);
        Self { frame, released }
    }
}

impl From<SphericalNodes> for JointNodes {
    fn from(made: SphericalNodes) -> Self {
        let (frame, released) = (made.frame, vec![made.rotation]);
        Self { frame, released }
    }
}

impl From<SlideNodes> for JointNodes {
    fn from(made: SlideNodes) -> Self {
        let (frame, released) = (made.frame, vec![made.arc_length]);
        Self { frame, released }
    }
}

impl ModelBuilder {
    /// Adds a joint on one frame: as [`ModelBuilder::join`], at the position of `parent`.
    ///
    /// # Errors
    /// As [`ModelBuilder::mapped_node`].
    pub fn attach<J, const D: usize>(
        &mut self,
        name: &str,
        parent: NodeId,
        joint: J,
    ) -> Result<JointNodes, ModelError>
    where
        J: Joint<D> + Clone + 'static,
    {
        self.join(name, self.position(parent).into(), joint, &[parent])
    }

    /// Adds a joint: a node for each coordinate that it releases, named `name` and what it is
    /// called, and the frame node `name` that is attached to it, at `position` in the reference
    /// configuration. The parents are the nodes that the joint reads before those.
    ///
    /// # Errors
    /// As [`ModelBuilder::mapped_node`]; [`ModelError::Released`] where the joint does not take just the
    /// coordinates of its parents and those that it releases.
    pub fn join<J, const D: usize>(
        &mut self,
        name: &str,
        position: [f64; 3],
        joint: J,
        parents: &[NodeId],
    ) -> Result<JointNodes, ModelError>
    where
        J: Joint<D> + Clone + 'static,
    {
        let mut released = Vec::new();
        for &coordinate in joint.released() {
            let name = format!("{name} {}", coordinate.name());
            released.push(match coordinate {
                Released::Coordinate(_, kind) => self.coordinates(name, &[kind])?,
                Released::Rotation => self.rotation(name)?,
            });
        }
        let all: Vec<NodeId> = parents.iter().chain(&released).copied().collect();
        let count = joint.released().iter().map(|r| r.dim()).sum();
        let frame = self.add_joint_frame(name, position, joint, &all);
        let frame = frame.map_err(|error| match error {
            ModelError::JointDimension {
                node, map, found, ..
            } => ModelError::Released {
                joint: node,
                parents: self.names_of(parents),
                takes: map.0,
                theirs: found - count,
                count,
            },
            other => other,
        })?;
        Ok(JointNodes { frame, released })
    }

    /// Adds a frame node that is attached to a joint, with nodes for all of its coordinates given.
    ///
    /// # Errors
    /// As [`ModelBuilder::mapped_node`].
    pub fn add_joint_frame<J, const D: usize>(
        &mut self,
        name: impl Into<String>,
        position: [f64; 3],
        joint: J,
        parents: &[NodeId],
    ) -> Result<NodeId, ModelError>
    where
        J: Joint<D> + Clone + 'static,
    {
        self.mapped_node(name, position, JointMap::new(joint).boxed(), parents)
    }
}

/// Adds a frame node `name` that slides along the two-node beam elements between `chain`'s nodes,
/// starting at arc length `origin` of the chain, and the node `name arc_length` of its coordinate. The
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
    let positions: Vec<Vector3<f64>> = chain.iter().map(|&n| b.position(n)).collect();
    let along = Chain::new(&positions, origin).ok_or_else(|| ModelError::Slide {
        joint: name.to_owned(),
        nodes: chain.len(),
        start: origin,
    })?;
    let position = along.start().into();
    let joint = Slide::new(along, interpolation);
    let arc_length = b.coordinates(format!("{name} arc_length"), &[Quantity::Length])?;
    let segments: Vec<[NodeId; 3]> = chain.windows(2).map(|p| [p[0], p[1], arc_length]).collect();
    let segments: Vec<&[NodeId]> = segments.iter().map(|s| &s[..]).collect();
    let frame = b.mapped_node_along(name, position, joint.boxed(), &segments)?;
    Ok(SlideNodes { frame, arc_length })
}
