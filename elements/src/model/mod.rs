//! Models: nodes, elements, loads and supports, numbered and assembled into a system.
//!
//! | | holds | changes |
//! |---|---|---|
//! | [`Model`] | nodes, elements, numbering, pattern | never |
//! | [`ModelState`] | inputs, charts, segments, splits, omitted equations | at converged states |
//! | [`Context`] | a model, one state of it, and buffers | in every evaluation |
//!
//! A [`Context`] is a [`System`](pullback_manifold::system::System) for integrators. Any number of
//! contexts, in any threads, share one model.

mod assembly;
mod build;
mod charts;
mod constraints;
mod context;
mod error;
mod kinematics;
mod loops;
mod results;
mod state;
mod system;

pub use build::beam_line::{BeamLine, BeamLineNodes};
pub use build::builder::{Dof, ElementId, ModelBuilder, NodeId};
pub use build::closures::Closure;
pub use build::reference_curve::{CircularArc, ReferenceCurve, StraightLine, frame_along};
pub use charts::nodes::FreeRotation;
pub use context::Context;
pub use error::{ModelError, Subject};
pub use kinematics::formulation::Formulation;
pub use kinematics::motion::{NodeState, RigidMotion};
pub use kinematics::rates::BEFORE_START;
pub use results::energies::{EnergiesAndMomentum, Momentum};
pub use results::forces::{Forces, Reaction};
pub use results::mobility::Mobility;
pub use state::{ModelState, SavedState};

use crate::constraint::Enforced;
use crate::element::Element;
use crate::time::TimeFunction;
use assembly::residual::MAX_NODES;
use assembly::workspace::Workspace;
use kinematics::mapped_node::MappedNode;
use nalgebra::Vector3;
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::Quantity;
use std::ops::{Deref, Range};

/// Marks an absent index.
pub(crate) const NONE: u32 = u32::MAX;

/// All nodes of a model, and the order of the mapped ones.
#[derive(Clone)]
struct Nodes {
    all: Vec<Node>,
    /// Mapped nodes, parents first.
    mapped: Vec<u32>,
}

impl Nodes {
    /// The mapped nodes, parents first, with their maps.
    fn mapped(&self) -> impl DoubleEndedIterator<Item = (u32, &Node, &MappedNode)> {
        self.mapped_of(&self.mapped)
    }

    /// The node of a coordinate of all nodes.
    fn of_coordinate(&self, c: usize) -> usize {
        self.partition_point(|n| n.first <= c) - 1
    }

    /// The mapped nodes among some nodes, with their maps.
    fn mapped_of<'a>(
        &'a self,
        some: &'a [u32],
    ) -> impl DoubleEndedIterator<Item = (u32, &'a Node, &'a MappedNode)> {
        some.iter().filter_map(|&n| {
            let node = &self[n as usize];
            Some((n, node, node.mapped()?))
        })
    }
}

impl Deref for Nodes {
    type Target = [Node];

    fn deref(&self) -> &[Node] {
        &self.all
    }
}

/// Kind of a node's coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum NodeForm {
    /// (d, Ψ) of a frame.
    Frame,
    /// The pose of a frame, as [`ToPose`](pullback_manifold::map::ToPose) writes it.
    Pose,
    /// (d, θ) behind a frame, or θ behind a rotation, θ since the last converged step; also coordinates of another chart of
    /// rotations.
    Increment,
    /// A rotation vector, alone or behind the displacement of a frame relative to another one.
    Rotation,
    /// Multipliers of equations: unknowns, but not coordinates.
    Multipliers,
    /// Scalar coordinates.
    Coordinates,
    /// The one unknown of a model with everything prescribed.
    Dummy,
}

/// Range of a node in the vector of all nodes' coordinates.
#[derive(Clone, Copy, Debug)]
struct Span {
    first: u32,
    dim: u32,
}

impl Span {
    fn of(node: &Node) -> Self {
        Self {
            first: node.first as u32,
            dim: node.dim as u32,
        }
    }

    #[inline]
    fn range(self) -> Range<usize> {
        self.first as usize..(self.first + self.dim) as usize
    }
}

/// A node: six coordinates (d, Ψ) of a frame, or the coordinates of a joint.
#[derive(Clone)]
pub struct Node {
    name: String,
    /// Reference position.
    position: Vector3<f64>,
    form: NodeForm,
    quantities: Vec<Quantity>,
    dim: usize,
    /// First coordinate in the vector of all nodes' coordinates.
    first: usize,
    /// The constraint map from other nodes' coordinates; `None` for coordinates of the model itself.
    map: Option<Box<MappedNode>>,
    /// Of a frame the node of its pose, of a pose that of its frame, or [`NONE`].
    partner: u32,
}

impl Node {
    /// A node without a position: scalar coordinates.
    fn new(
        name: String,
        form: NodeForm,
        quantities: &[Quantity],
        map: Option<Box<MappedNode>>,
    ) -> Self {
        Self {
            name,
            position: Vector3::zeros(),
            form,
            dim: quantities.len(),
            quantities: quantities.to_vec(),
            first: 0,
            map,
            partner: NONE,
        }
    }

    /// Whether it is a frame, by its chart or by its pose.
    pub fn is_frame(&self) -> bool {
        matches!(self.form, NodeForm::Frame | NodeForm::Pose)
    }

    /// Whether it has coordinates that a joint releases.
    fn is_released(&self) -> bool {
        matches!(self.form, NodeForm::Coordinates | NodeForm::Rotation)
    }

    /// First coordinate of the rotation vector, if there is one.
    fn rotation(&self) -> Option<usize> {
        match self.form {
            NodeForm::Frame | NodeForm::Rotation => Some(self.first + self.dim - 3),
            NodeForm::Pose
            | NodeForm::Increment
            | NodeForm::Coordinates
            | NodeForm::Multipliers
            | NodeForm::Dummy => None,
        }
    }

    fn is_own(&self) -> bool {
        self.map.is_none()
    }

    /// Its map and parents; `None` for coordinates of the model itself.
    fn mapped(&self) -> Option<&MappedNode> {
        self.map.as_deref()
    }

    /// The parents of its map for each segment; none without a map.
    fn segments(&self) -> &[Vec<u32>] {
        self.mapped().map_or(&[], |d| &d.segments)
    }

    /// The parents of its map in all segments.
    fn all_parents(&self) -> impl DoubleEndedIterator<Item = u32> + '_ {
        self.segments().iter().flatten().copied()
    }
}

/// The nodes of an element, stored inline to avoid cache misses in an assembly.
#[derive(Clone)]
struct NodeList {
    len: u32,
    nodes: [u32; MAX_NODES],
}

impl NodeList {
    /// At most [`MAX_NODES`] nodes.
    fn new(of: &[NodeId]) -> Self {
        let mut nodes = [NONE; MAX_NODES];
        for (node, id) in nodes.iter_mut().zip(of) {
            *node = id.0;
        }
        Self {
            len: of.len() as u32,
            nodes,
        }
    }
}

impl Deref for NodeList {
    type Target = [u32];

    fn deref(&self) -> &[u32] {
        &self.nodes[..self.len as usize]
    }
}

/// An element or load of a model with its name and nodes.
#[derive(Clone)]
pub struct ElementEntry {
    name: String,
    element: std::sync::Arc<dyn Element>,
    nodes: NodeList,
    /// Bit k: node k is a frame whose rotation is used.
    frames: u32,
    /// Whether any node is mapped.
    mapped: bool,
    /// Whether a coordinate of its nodes is prescribed or mapped.
    dependent_coordinates: bool,
    /// Whether all its tangents are zero.
    dead: bool,
    /// Whether it is an applied load.
    load: bool,
    /// Whether it is a load with a potential that does not depend on time.
    time_independent: bool,
}

impl ElementEntry {
    /// The element if it enforces equations by multipliers.
    fn multiplied(&self) -> Option<&dyn Enforced> {
        let enforced = self.element.abilities().enforced;
        enforced.filter(|e| e.penalty().is_none())
    }
}

/// A coordinate that is a prescribed function of time.
#[derive(Clone)]
struct Prescribed {
    coordinate: usize,
    function: std::sync::Arc<dyn TimeFunction>,
}

/// The prescribed ones among these coordinates, of all in ascending order.
fn among(prescribed: &[Prescribed], coordinates: Range<usize>) -> &[Prescribed] {
    let before = |end: usize| prescribed.partition_point(|p| p.coordinate < end);
    &prescribed[before(coordinates.start)..before(coordinates.end)]
}

/// An assembled model: immutable, shared by all its [`Context`]s.
///
/// Created by [`ModelBuilder::build`]. The unknowns q are the coordinates of all nodes that are
/// neither prescribed nor mapped.
#[derive(Clone)]
pub struct Model {
    nodes: Nodes,
    spans: Vec<Span>,
    /// Frames by increments whose rates may be angular velocities.
    spin_frames: Vec<u32>,
    /// Frames fixed to another one at a distance, each with the child of a joint there: it is mapped from the other one.
    carried: Vec<[NodeId; 2]>,
    /// Report on the loops.
    reports: Vec<loops::LoopReport>,
    elements: Vec<ElementEntry>,
    /// Elements that enforce equations.
    enforced: Vec<usize>,
    /// Default initial coordinates, and the state there.
    initial: Vec<f64>,
    start: ModelState,
    /// Ascending by coordinate.
    prescribed: Vec<Prescribed>,
    /// Frames with a fully prescribed rotation.
    prescribed_rotations: Vec<usize>,
    /// Coordinate of each unknown.
    coordinates: Vec<usize>,
    /// Unknown of each coordinate, or [`NONE`].
    unknowns: Vec<u32>,
    quantities: Vec<Quantity>,
    /// Size of the model: the diagonal of the box around its nodes.
    length: f64,
    pattern: BlockPattern,
    /// Buffers without values, and the positions of tangents in the initial segments.
    work: Workspace,
}
