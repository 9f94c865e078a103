//! Nodes that are maps of others.

use crate::model::assembly::residual::MAX_NODES;
use crate::model::build::builder::{FRAME, FRAME_QUANTITIES, ModelBuilder, NodeId};
use crate::model::kinematics::mapped_node::MappedNode;
use crate::model::kinematics::pose::{add_pose, new_pose};
use crate::model::{ModelError, NodeForm};
use pullback_manifold::map::{Parametrization, Segments, ToChart};
use pullback_manifold::system::Quantity;

impl ModelBuilder {
    /// Adds a frame node whose six coordinates are a map of those of `parents`.
    ///
    /// # Errors
    /// [`ModelError::DuplicateNode`], [`ModelError::NotFinite`]; [`ModelError::JointDimension`] if
    /// the map is not from the parents' coordinates to six; [`ModelError::ForeignNode`].
    pub fn mapped_node(
        &mut self,
        name: impl Into<String>,
        position: [f64; 3],
        map: Box<dyn Parametrization>,
        parents: &[NodeId],
    ) -> Result<NodeId, ModelError> {
        self.mapped_node_along(name, position, map, &[parents])
    }

    /// As [`ModelBuilder::mapped_node`], for a map with a set of parents for each of its
    /// [`Segments`](pullback_manifold::map::Segments).
    ///
    /// # Errors
    /// As [`ModelBuilder::mapped_node`]; [`ModelError::Segments`].
    pub fn mapped_node_along(
        &mut self,
        name: impl Into<String>,
        position: [f64; 3],
        map: Box<dyn Parametrization>,
        segments: &[&[NodeId]],
    ) -> Result<NodeId, ModelError> {
        let name = name.into();
        let map = self.mapped(&name, FRAME, map, segments)?;
        self.add_node(
            name,
            position,
            NodeForm::Frame,
            &FRAME_QUANTITIES,
            Some(map),
        )
    }

    /// Adds a frame node whose pose is a map of the coordinates of `parents`; a frame among them is given by
    /// the node of its pose.
    ///
    /// # Errors
    /// As [`ModelBuilder::mapped_node`].
    pub(crate) fn mapped_pose(
        &mut self,
        name: String,
        position: [f64; 3],
        map: Box<dyn Parametrization>,
        parents: &[NodeId],
    ) -> Result<NodeId, ModelError> {
        let map = self.mapped(&name, FRAME, map, &[parents])?;
        let [frame, pose] = [0, 1].map(|k| self.nodes.len() as u32 + k);
        let view = Some(MappedNode::of(Box::new(ToChart::default()), vec![pose]));
        let id = self.add_node(name, position, NodeForm::Frame, &FRAME_QUANTITIES, view)?;
        let node = new_pose(&mut self.nodes, frame, map);
        self.nodes.push(node);
        Ok(id)
    }

    /// The node with the pose of a frame.
    ///
    /// # Errors
    /// [`ModelError::ForeignNode`]; [`ModelError::NoFrame`].
    pub(crate) fn pose_of(
        &mut self,
        node: NodeId,
        what: impl Fn() -> String,
    ) -> Result<NodeId, ModelError> {
        self.check_own(&[node], &what)?;
        let read = &self.nodes[node.0 as usize];
        if !read.is_frame() {
            return Err(ModelError::NoFrame {
                what: what(),
                node: read.name.clone(),
                dim: read.dim,
            });
        }
        Ok(NodeId(add_pose(&mut self.nodes, node.0)))
    }

    /// Adds scalar coordinates that are a map of those of `parents`: those of a loop that is closed
    /// by an [`Implicit`](pullback_manifold::implicit::Implicit) constraint, one of them
    /// ([`Linear::pick`](pullback_manifold::map::Linear::pick)), the other side of a gear. Joints
    /// and elements use them like any coordinates.
    ///
    /// # Errors
    /// As [`ModelBuilder::mapped_node`]. A map that reparametrizes its coordinates
    /// ([`Reparametrization`](pullback_manifold::map::Reparametrization)) must be their only
    /// user: otherwise [`ModelError::Reparametrized`] when the model is built.
    pub fn mapped_coordinates(
        &mut self,
        name: impl Into<String>,
        quantities: &[Quantity],
        map: Box<dyn Parametrization>,
        parents: &[NodeId],
    ) -> Result<NodeId, ModelError> {
        let name = name.into();
        let map = self.mapped(&name, quantities.len(), map, &[parents])?;
        self.add_node(name, [0.0; 3], NodeForm::Coordinates, quantities, Some(map))
    }

    /// A map to the `dim` coordinates of the node `name`, with its parents.
    fn mapped(
        &self,
        name: &str,
        dim: usize,
        map: Box<dyn Parametrization>,
        segments: &[&[NodeId]],
    ) -> Result<Box<MappedNode>, ModelError> {
        let (d, n) = map.dims();
        let (count, found) = (map.segments().map_or(1, Segments::count), segments.len());
        let segments = match segments {
            [all] => vec![*all; count],
            each => each.to_vec(),
        };
        if segments.len() != count || count == 0 {
            let node = name.to_owned();
            return Err(ModelError::Segments { node, count, found });
        }
        for parents in &segments {
            self.check_own(parents, || format!("joint at node {name}"))?;
            if parents.len() > MAX_NODES {
                return Err(ModelError::TooManyNodes {
                    element: format!("the joint at node {name}"),
                    found: parents.len(),
                    limit: MAX_NODES,
                });
            }
            let found: usize = parents.iter().map(|m| self.nodes[m.0 as usize].dim).sum();
            if d != found || n != dim {
                return Err(ModelError::JointDimension {
                    node: name.to_owned(),
                    parents: self.names_of(parents),
                    map: (d, n),
                    found,
                    dim,
                });
            }
        }
        let numbers = |parents: &&[NodeId]| parents.iter().map(|m| m.0).collect();
        let segments = segments.iter().map(numbers).collect();
        Ok(MappedNode::along(map, segments))
    }
}
