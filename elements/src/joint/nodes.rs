//! Joints in a model: the frame that hangs on one, and the coordinates that it releases.

use super::{Hung, Joint, Released, SlideNodes, SphericalNodes};
use crate::model::{ModelBuilder, ModelError, NodeId};
use pullback_manifold::map::Map;

/// The nodes that a joint makes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JointNodes {
    /// The frame that hangs on the joint.
    pub frame: NodeId,
    /// A node for each of the coordinates that it releases, in their order.
    pub released: Vec<NodeId>,
}

/// The nodes of a revolute joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RevoluteNodes {
    /// The frame that hangs on the joint.
    pub frame: NodeId,
    /// The angle about the axis: the released coordinate, in radians, any number of turns.
    pub angle: NodeId,
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
        let (frame, released) = (made.frame, vec![made.way]);
        Self { frame, released }
    }
}

impl ModelBuilder {
    /// Adds a joint on one frame: as [`ModelBuilder::join`], at the place of `master`.
    ///
    /// # Errors
    /// As [`ModelBuilder::mapped_node`].
    pub fn attach<J, const D: usize>(
        &mut self,
        name: &str,
        master: NodeId,
        joint: J,
    ) -> Result<JointNodes, ModelError>
    where
        J: Joint<D> + Clone + 'static,
    {
        self.join(name, self.place(master).into(), joint, &[master])
    }

    /// Adds a joint: a node for each coordinate that it releases, named `name` and what it is
    /// called, and the frame node `name` that hangs on it, at `place` in the reference
    /// configuration. The masters are the nodes that the joint reads before those.
    ///
    /// # Errors
    /// As [`ModelBuilder::mapped_node`].
    pub fn join<J, const D: usize>(
        &mut self,
        name: &str,
        place: [f64; 3],
        joint: J,
        masters: &[NodeId],
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
        let all: Vec<NodeId> = masters.iter().chain(&released).copied().collect();
        let frame = self.hang(name, place, joint, &all)?;
        Ok(JointNodes { frame, released })
    }

    /// Adds a frame node that hangs on a joint, with nodes for all of its coordinates given.
    ///
    /// # Errors
    /// As [`ModelBuilder::mapped_node`].
    pub fn hang<J, const D: usize>(
        &mut self,
        name: impl Into<String>,
        place: [f64; 3],
        joint: J,
        masters: &[NodeId],
    ) -> Result<NodeId, ModelError>
    where
        J: Joint<D> + Clone + 'static,
    {
        self.mapped_node(name, place, Hung::new(joint).boxed(), masters)
    }
}
