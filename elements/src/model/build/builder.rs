//! Building a model: nodes, elements, supports.

use crate::element::Element;
use crate::model::assembly::residual::MAX_NODES;
use crate::model::kinematics::formulation::RotationMaps;
use crate::model::kinematics::mapped_node::MappedNode;
use crate::model::loops::Closing;
use crate::model::{ElementEntry, ModelError, NONE, Node, NodeForm, NodeList};
use crate::time::{Constant, Input, TimeFunction};
use nalgebra::Vector3;
use pullback_manifold::map::Parametrization;
use pullback_manifold::system::Quantity;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Coordinates of a frame node.
pub(in crate::model) const FRAME: usize = 6;

/// Quantities of the coordinates of a frame node.
pub(in crate::model) const FRAME_QUANTITIES: [Quantity; FRAME] = {
    use Quantity::{Angle, Length};
    [Length, Length, Length, Angle, Angle, Angle]
};

/// A node of a model builder, and of the models that it builds. It is a number: one of another builder is refused where there is no
/// such number, and is another node otherwise; questions about it panic where there is no such number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub(crate) u32);

/// An element of a model builder, and of the models that it builds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ElementId(pub(crate) u32);

/// The six coordinates of a frame node, in global components.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dof {
    /// Displacement along e1.
    X,
    /// Displacement along e2.
    Y,
    /// Displacement along e3.
    Z,
    /// Rotation vector component about e1.
    RX,
    /// Rotation vector component about e2.
    RY,
    /// Rotation vector component about e3.
    RZ,
}

impl Dof {
    /// All six, in the order of the coordinates.
    pub const ALL: [Self; FRAME] = [Self::X, Self::Y, Self::Z, Self::RX, Self::RY, Self::RZ];
    /// The three displacements.
    pub const TRANSLATIONS: [Self; 3] = [Self::X, Self::Y, Self::Z];
    /// The three rotations.
    pub const ROTATIONS: [Self; 3] = [Self::RX, Self::RY, Self::RZ];

    /// Index among the six coordinates.
    pub fn index(self) -> usize {
        self as usize
    }
}

/// Names of the six coordinates of a frame.
pub(in crate::model) const DOF_NAMES: [&str; FRAME] = [
    "displacement along e1",
    "displacement along e2",
    "displacement along e3",
    "rotation about e1",
    "rotation about e2",
    "rotation about e3",
];

/// Builder of a model; [`ModelBuilder::build`] validates it.
#[derive(Default)]
pub struct ModelBuilder {
    pub(in crate::model) nodes: Vec<Node>,
    names: HashMap<String, NodeId>,
    pub(in crate::model) elements: Vec<ElementEntry>,
    pub(in crate::model) prescribed: Vec<(NodeId, usize, Arc<dyn TimeFunction>)>,
    pub(in crate::model) closings: Vec<Closing>,
    /// Desired initial values of coordinates in loops.
    pub(in crate::model) starts: HashMap<(NodeId, usize), f64>,
    /// Coordinates that loops should leave free.
    pub(in crate::model) preferred: HashSet<NodeId>,
    /// Coordinates that follow another one by gears, and their ratios to it.
    gears: HashMap<NodeId, (NodeId, f64)>,
    /// Frames fixed to another one at a distance.
    pub(crate) offsets: HashMap<NodeId, (NodeId, Vector3<f64>)>,
    /// See [`Model`](crate::model::Model).
    pub(crate) carried: Vec<[NodeId; 2]>,
    /// Maps behind rotations that are free, if rotation vectors are not the unknowns.
    pub(in crate::model) rotations: Option<RotationMaps>,
    pub(in crate::model) inputs: Vec<f64>,
}

impl ModelBuilder {
    /// An empty model.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a frame node (displacement and rotation, six coordinates) at a reference position.
    ///
    /// # Errors
    /// [`ModelError::DuplicateNode`], [`ModelError::NotFinite`].
    pub fn node(
        &mut self,
        name: impl Into<String>,
        position: [f64; 3],
    ) -> Result<NodeId, ModelError> {
        let (form, quantities) = (NodeForm::Frame, &FRAME_QUANTITIES);
        self.add_node(name.into(), position, form, quantities, None)
    }

    /// Adds scalar coordinates, such as those of a joint.
    ///
    /// # Errors
    /// [`ModelError::DuplicateNode`].
    pub fn coordinates(
        &mut self,
        name: impl Into<String>,
        quantities: &[Quantity],
    ) -> Result<NodeId, ModelError> {
        self.add_coordinates_of(name, NodeForm::Coordinates, quantities)
    }

    /// Adds coordinates of the model that belong to no frame.
    pub(crate) fn add_coordinates_of(
        &mut self,
        name: impl Into<String>,
        form: NodeForm,
        quantities: &[Quantity],
    ) -> Result<NodeId, ModelError> {
        self.add_node(name.into(), [0.0; 3], form, quantities, None)
    }

    /// Adds a rotation vector, such as the three coordinates of a spherical joint. Its chart
    /// changes like that of a frame.
    ///
    /// # Errors
    /// [`ModelError::DuplicateNode`].
    pub fn rotation(&mut self, name: impl Into<String>) -> Result<NodeId, ModelError> {
        self.add_coordinates_of(name, NodeForm::Rotation, &[Quantity::Angle; 3])
    }

    pub(in crate::model) fn add_node(
        &mut self,
        name: String,
        position: [f64; 3],
        form: NodeForm,
        quantities: &[Quantity],
        map: Option<Box<MappedNode>>,
    ) -> Result<NodeId, ModelError> {
        if position.iter().any(|x| !x.is_finite()) {
            return Err(ModelError::NotFinite {
                node: name,
                position,
            });
        }
        self.check_name(&name)?;
        let id = NodeId(self.nodes.len() as u32);
        self.names.insert(name.clone(), id);
        self.nodes.push(Node {
            position: position.into(),
            ..Node::new(name, form, quantities, map)
        });
        Ok(id)
    }

    /// Refuses the name of another node.
    pub(crate) fn check_name(&self, name: &str) -> Result<(), ModelError> {
        match self.names.contains_key(name) {
            true => Err(ModelError::DuplicateNode { node: name.into() }),
            false => Ok(()),
        }
    }

    /// Node with a name.
    ///
    /// # Errors
    /// [`ModelError::UnknownNode`], with a list of all names.
    pub fn find(&self, name: &str) -> Result<NodeId, ModelError> {
        self.names.get(name).copied().ok_or_else(|| {
            let mut known: Vec<&str> = self.nodes.iter().map(|n| n.name.as_str()).collect();
            let many = known.len() > 12;
            known.truncate(12);
            ModelError::UnknownNode {
                node: name.to_owned(),
                known: known.join(", ") + if many { ", ..." } else { "" },
            }
        })
    }

    /// Name of a node.
    pub fn node_name(&self, node: NodeId) -> &str {
        &self.nodes[node.0 as usize].name
    }

    /// Reference position of a node.
    pub fn position(&self, node: NodeId) -> Vector3<f64> {
        self.nodes[node.0 as usize].position
    }

    /// What the coordinates of a node measure: three lengths and three angles for a frame.
    pub fn quantities(&self, node: NodeId) -> &[Quantity] {
        &self.nodes[node.0 as usize].quantities
    }

    /// Whether a node has coordinates of its own and is not mapped.
    pub(crate) fn is_own(&self, node: NodeId) -> bool {
        self.nodes[node.0 as usize].is_own()
    }

    /// The coordinate at the end of a chain of gears, and the ratio to it.
    pub(crate) fn behind_gears(&self, mut node: NodeId) -> (NodeId, f64) {
        let mut ratio = 1.0;
        while let Some(&(leader, r)) = self.gears.get(&node) {
            (node, ratio) = (leader, ratio * r);
        }
        (node, ratio)
    }

    /// Makes a coordinate follow an earlier one by a gear of this ratio.
    pub(crate) fn follow(
        &mut self,
        leader: NodeId,
        follower: NodeId,
        ratio: f64,
        map: Box<dyn Parametrization>,
    ) {
        self.gears.insert(follower, (leader, ratio));
        self.nodes[follower.0 as usize].map = Some(MappedNode::of(map, vec![leader.0]));
    }

    pub(crate) fn check_own(
        &self,
        nodes: &[NodeId],
        what: impl Fn() -> String,
    ) -> Result<(), ModelError> {
        if nodes.iter().all(|n| (n.0 as usize) < self.nodes.len()) {
            Ok(())
        } else {
            Err(ModelError::ForeignNode { what: what() })
        }
    }

    pub(crate) fn names_of(&self, nodes: &[NodeId]) -> String {
        let names: Vec<&str> = nodes.iter().map(|&n| self.node_name(n)).collect();
        names.join(", ")
    }

    /// Adds an element or a load on nodes.
    ///
    /// # Errors
    /// [`ModelError::Dimension`] if the nodes do not have the coordinates of the element.
    pub fn element(
        &mut self,
        name: impl Into<String>,
        element: impl Into<Box<dyn Element>>,
        nodes: &[NodeId],
    ) -> Result<ElementId, ModelError> {
        let (name, element) = (name.into(), element.into());
        self.check_own(nodes, || format!("element {name}"))?;
        if nodes.len() > MAX_NODES {
            return Err(ModelError::TooManyNodes {
                element: format!("element {name}"),
                found: nodes.len(),
                limit: MAX_NODES,
            });
        }
        let found: usize = nodes.iter().map(|n| self.nodes[n.0 as usize].dim).sum();
        if found != element.dim() {
            return Err(ModelError::Dimension {
                expected: element.dim(),
                found,
                nodes: self.names_of(nodes),
                element: name,
            });
        }
        let properties = element.properties();
        let mut nodes = nodes.to_vec();
        for n in &mut nodes {
            let node = &self.nodes[n.0 as usize];
            // Positions are the same in both.
            let either = !properties.sees_rotations && !node.is_own() && node.partner != NONE;
            if properties.reads_poses || either {
                *n = self.pose_of(*n, || format!("element {name}"))?;
            }
        }
        let nodes = &nodes[..];
        self.elements.push(ElementEntry {
            name,
            frames: (0..)
                .zip(nodes)
                .filter(|_| properties.sees_rotations)
                .filter(|(_, n)| self.nodes[n.0 as usize].form == NodeForm::Frame)
                .map(|(k, _)| 1 << k)
                .sum(),
            dead: properties.dead,
            load: properties.load,
            time_independent: properties.load && properties.time_independent,
            element: element.into(),
            nodes: NodeList::new(nodes),
            mapped: false,
            dependent_coordinates: false,
        });
        Ok(ElementId(self.elements.len() as u32 - 1))
    }

    /// Fixes coordinates of a node at zero.
    pub fn support(&mut self, node: NodeId, dofs: &[Dof]) {
        for &dof in dofs {
            self.prescribe(node, dof, Constant(0.0));
        }
    }

    /// Adds an input with its initial value, for loads and prescribed coordinates. Maps read it as a
    /// prescribed coordinate.
    pub fn input(&mut self, value: f64) -> Input {
        self.inputs.push(value);
        Input(self.inputs.len() - 1)
    }

    /// Prescribes a coordinate of a frame node as a function of time (of the load parameter in
    /// statics).
    pub fn prescribe(
        &mut self,
        node: NodeId,
        dof: Dof,
        function: impl Into<Box<dyn TimeFunction>>,
    ) {
        self.prescribe_coordinate(node, dof.index(), function);
    }

    /// Prescribes coordinate `k` of any node, such as the angle of a revolute joint.
    pub fn prescribe_coordinate(
        &mut self,
        node: NodeId,
        k: usize,
        function: impl Into<Box<dyn TimeFunction>>,
    ) {
        self.prescribed.push((node, k, Arc::from(function.into())));
    }
}
