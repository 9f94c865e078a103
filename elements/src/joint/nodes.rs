//! Joints in a model: the child of each, and nodes for its coordinates.

use super::shape::Chain;
use super::{Free, Joint, JointMap, Offset, Slide};
use crate::beam::Interpolation;
use crate::model::{ModelBuilder, ModelError, NodeForm, NodeId};
use nalgebra::{SVector, Vector3};
use pullback_manifold::system::Quantity;

/// The nodes of a joint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JointNodes {
    /// The child of the joint.
    pub frame: NodeId,
    /// A node for each of its coordinates, in their order.
    pub coordinates: Vec<NodeId>,
}

impl From<NodeId> for JointNodes {
    fn from(frame: NodeId) -> Self {
        let coordinates = Vec::new();
        Self { frame, coordinates }
    }
}

impl ModelBuilder {
    /// Adds a joint: its child, the frame node `name`, and a node for each of its coordinates, named `name`
    /// and the name of the coordinate. The reference position of the child is that of the joint's pose
    /// relative to `parent`.
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
        let coordinates = self.add_coordinates(name, parent, &joint)?;
        let frame = self.add_joint_frame(name, parent, joint, &coordinates)?;
        Ok(JointNodes { frame, coordinates })
    }

    /// As [`ModelBuilder::attach`], for a child that rotates freely: only its position follows from the
    /// joint. Its rotation vector is the node `name rotation`, the last one of the joint's coordinates.
    ///
    /// # Errors
    /// As [`ModelBuilder::attach`].
    pub fn attach_free<J, const D: usize>(
        &mut self,
        name: &str,
        parent: NodeId,
        joint: J,
    ) -> Result<JointNodes, ModelError>
    where
        J: Joint<D> + Clone + 'static,
    {
        let mut coordinates = self.add_coordinates(name, parent, &joint)?;
        coordinates.push(self.rotation(format!("{name} rotation"))?);
        let (parents, at) = self.parents(name, parent, &coordinates)?;
        let position = self.child_position(parent, &joint);
        let map = Box::new(JointMap::turning_freely(joint).at(at));
        let frame = self.mapped_node(name, position, map, &parents)?;
        self.carry(parent, frame);
        Ok(JointNodes { frame, coordinates })
    }

    /// Adds a spherical joint: its child has the position of `parent`, d_s = d_m, and turns freely.
    ///
    /// The coordinates are the child's own rotation vector, in global components and not relative to the parent; its chart
    /// changes at ψ > π.
    ///
    #[doc = include_str!("../../images/spherical.svg")]
    ///
    /// # Errors
    /// As [`ModelBuilder::attach`].
    pub fn spherical(&mut self, name: &str, parent: NodeId) -> Result<JointNodes, ModelError> {
        let c = Vector3::zeros();
        self.attach_free(name, parent, Offset { c })
    }

    /// Adds a frame node fixed to `parent`, with its reference `position`, which may be that of the parent.
    ///
    #[doc = include_str!("../../images/weld.svg")]
    ///
    /// # Errors
    /// As [`ModelBuilder::mapped_node`].
    pub fn offset(
        &mut self,
        name: impl Into<String>,
        parent: NodeId,
        position: [f64; 3],
    ) -> Result<NodeId, ModelError> {
        let name = name.into();
        self.check_own(&[parent], || format!("joint at node {name}"))?;
        let c = Vector3::from(position) - self.position(parent);
        let frame = self.add_joint_frame(name, parent, Offset { c }, &[])?;
        let (carrier, at) = self.carrier_of(parent);
        self.offsets.insert(frame, (carrier, at + c));
        Ok(frame)
    }

    /// Adds a frame node whose six coordinates, the node `name coordinates`, are relative to another frame: see
    /// [`Free`].
    ///
    /// # Errors
    /// As [`ModelBuilder::mapped_node`].
    pub fn relative_node(
        &mut self,
        name: impl Into<String>,
        parent: NodeId,
        position: [f64; 3],
    ) -> Result<JointNodes, ModelError> {
        let name = name.into();
        self.check_own(&[parent], || format!("joint at node {name}"))?;
        let joint = Free {
            c: Vector3::from(position) - self.position(parent),
        };
        let quantities = joint.coordinates().map(|(_, quantity)| quantity);
        let own = format!("{name} coordinates");
        // The rotation vector changes its chart, as that of a frame does.
        let own = self.add_coordinates_of(own, NodeForm::Rotation, &quantities)?;
        let frame = self.add_joint_frame(name, parent, joint, &[own])?;
        let coordinates = vec![own];
        Ok(JointNodes { frame, coordinates })
    }

    /// Adds a frame node `name` that slides along the two-node beam elements between `chain`'s nodes,
    /// starting at arc length `origin` of the chain, and the node `name arc_length` of its coordinate.
    /// `interpolation` is that of the elements.
    ///
    /// # Errors
    /// [`ModelError::Slide`] for fewer than two different positions or a start outside the chain; as
    /// [`ModelBuilder::mapped_node`].
    pub fn slide(
        &mut self,
        name: &str,
        chain: &[NodeId],
        origin: f64,
        interpolation: Interpolation,
    ) -> Result<JointNodes, ModelError> {
        self.check_own(chain, || format!("joint at node {name}"))?;
        let positions: Vec<Vector3<f64>> = chain.iter().map(|&n| self.position(n)).collect();
        let along = Chain::new(&positions, origin).ok_or_else(|| ModelError::Slide {
            joint: name.to_owned(),
            nodes: chain.len(),
            start: origin,
        })?;
        let position = along.start().into();
        let joint = Box::new(Slide::new(along, interpolation));
        let arc_length = self.coordinates(format!("{name} arc_length"), &[Quantity::Length])?;
        let segments: Vec<[NodeId; 3]> =
            chain.windows(2).map(|p| [p[0], p[1], arc_length]).collect();
        let segments: Vec<&[NodeId]> = segments.iter().map(|s| &s[..]).collect();
        let frame = self.mapped_node_along(name, position, joint, &segments)?;
        let coordinates = vec![arc_length];
        Ok(JointNodes { frame, coordinates })
    }

    /// Adds the child of a joint, with existing nodes for its coordinates.
    ///
    /// # Errors
    /// As [`ModelBuilder::mapped_node`].
    pub fn add_joint_frame<J, const D: usize>(
        &mut self,
        name: impl Into<String>,
        parent: NodeId,
        joint: J,
        coordinates: &[NodeId],
    ) -> Result<NodeId, ModelError>
    where
        J: Joint<D> + Clone + 'static,
    {
        let name = name.into();
        let (parents, at) = self.parents(&name, parent, coordinates)?;
        let position = self.child_position(parent, &joint);
        let map = Box::new(JointMap::new(joint).at(at));
        let frame = self.mapped_pose(name, position, map, &parents)?;
        self.carry(parent, frame);
        Ok(frame)
    }

    /// The frame to which a frame is fixed at a distance, and the distance: a chain of joints goes on from there.
    fn carrier_of(&self, frame: NodeId) -> (NodeId, Vector3<f64>) {
        let fixed = self.offsets.get(&frame).copied();
        fixed.unwrap_or((frame, Vector3::zeros()))
    }

    /// Notes that a joint hands its forces on to the frame that carries its parent.
    fn carry(&mut self, parent: NodeId, child: NodeId) {
        if self.offsets.contains_key(&parent) {
            self.carried.push([parent, child]);
        }
    }

    fn child_position<J: Joint<D>, const D: usize>(&self, parent: NodeId, joint: &J) -> [f64; 3] {
        (self.position(parent) + joint.pose(0.0, &SVector::zeros()).d).into()
    }

    /// What the map of a joint reads, and the position of the joint in the frame that carries its parent.
    fn parents(
        &mut self,
        name: &str,
        parent: NodeId,
        coordinates: &[NodeId],
    ) -> Result<(Vec<NodeId>, Vector3<f64>), ModelError> {
        let (carrier, at) = self.carrier_of(parent);
        let pose = self.pose_of(carrier, || format!("joint at node {name}"))?;
        Ok(([&[pose], coordinates].concat(), at))
    }

    /// Adds the coordinates of a joint, unless its child is refused.
    fn add_coordinates<J: Joint<D>, const D: usize>(
        &mut self,
        name: &str,
        parent: NodeId,
        joint: &J,
    ) -> Result<Vec<NodeId>, ModelError> {
        self.parents(name, parent, &[])?;
        self.check_name(name)?;
        let coordinates = joint.coordinates().into_iter();
        let nodes = coordinates.map(|(c, kind)| self.coordinates(format!("{name} {c}"), &[kind]));
        nodes.collect()
    }
}
