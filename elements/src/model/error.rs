//! Errors of models, with names and remedies.

use crate::beam::BeamError;
use crate::constraint::PenaltyError;
use crate::joint::GearError;
use crate::model::{Node, NodeId};
use pullback_manifold::implicit::ImplicitError;
use pullback_manifold::system::SystemError;
use std::fmt::{self, Display, Formatter};

/// What an error is about: a node, the joint that it belongs to, or one of its coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    /// The node; the first of several.
    pub node: NodeId,
    /// Its name, or theirs.
    pub name: String,
}

impl Subject {
    pub(super) fn node(nodes: &[Node], n: u32) -> Self {
        Self::named(n, nodes[n as usize].name.clone())
    }

    pub(super) fn coordinate(nodes: &[Node], n: u32, k: usize) -> Self {
        Self::named(n, nodes[n as usize].coordinate_name(k))
    }

    pub(super) fn named(n: u32, name: String) -> Self {
        let node = NodeId(n);
        Self { node, name }
    }
}

impl Display for Subject {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

/// Error of a model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "each message says what its variant is")]
#[non_exhaustive]
pub enum ModelError {
    #[error("a model needs at least one node")]
    Empty,
    #[error("node {node} is defined twice; give each node its own name")]
    DuplicateNode { node: String },
    #[error("there is no node {node}; known nodes: {known}")]
    UnknownNode { node: String, known: String },
    #[error("node {node} has a coordinate that is not finite: {position:?}")]
    NotFinite { node: String, position: [f64; 3] },
    #[error(
        "element {element} has {expected} coordinates, but its nodes ({nodes}) have {found} together"
    )]
    Dimension {
        element: String,
        nodes: String,
        expected: usize,
        found: usize,
    },
    #[error(
        "the chain of joints to node {node} needs more than {needs:.1} GB of memory, and {free:.1} GB are free: \
         it grows with the square of the number of joints; take a shorter one"
    )]
    Chain {
        node: Subject,
        needs: f64,
        free: f64,
    },
    #[error("{element} reads {found} nodes; at most {limit} are possible")]
    TooManyNodes {
        element: String,
        found: usize,
        limit: usize,
    },
    #[error(
        "the map of the joint at node {node} needs a set of parents for each segment ({count}) or one for all, and has {found}"
    )]
    Segments {
        node: String,
        count: usize,
        found: usize,
    },
    #[error(
        "the map of the joint at node {node} takes {} coordinates to {}, but it must take the \
         {found} of its parents ({parents}) to {dim}", map.0, map.1
    )]
    JointDimension {
        node: String,
        parents: String,
        map: (usize, usize),
        found: usize,
        dim: usize,
    },
    #[error("{what} refers to a node of another model builder")]
    ForeignNode { what: String },
    #[error("{what} reads node {node} as a frame, but it has {dim} coordinates")]
    NoFrame {
        what: String,
        node: String,
        dim: usize,
    },
    #[error("node {node} has {dim} coordinates, so there is no number {coordinate} to prescribe")]
    NoCoordinate {
        node: String,
        coordinate: usize,
        dim: usize,
    },
    #[error("element {element}: {source}")]
    Beam { element: String, source: BeamError },
    #[error("line {line}: {problem}")]
    Line { line: String, problem: String },
    #[error(
        "{coordinate} is prescribed twice; remove one of the supports or prescribed motions that name it"
    )]
    PrescribedTwice { coordinate: Subject },
    #[error(
        "{coordinate} follows from other nodes through a joint and cannot be prescribed; \
         prescribe a coordinate of its parents {parents}"
    )]
    PrescribedDependent {
        coordinate: Subject,
        parents: String,
    },
    #[error(
        "{coordinate} follows from the equations that {solved} is solved from and cannot be \
         prescribed; add the equation x - f(t) = 0 of its motion to them, or let one of the \
         coordinates be independent for good (`Choice::Fixed`) and prescribe that"
    )]
    PrescribedSolved { coordinate: Subject, solved: String },
    #[error("gear between {first} and {second}: {source}")]
    Gear {
        first: String,
        second: String,
        source: GearError,
    },
    #[error(
        "the coordinates {coordinates} of {node} change their meaning in a run, as others become \
         better: {user} cannot use them. Use {node} itself (or a coordinate picked from it), or \
         choose the coordinates once and for all (`Choice::Fixed`)"
    )]
    Reparametrized {
        node: String,
        coordinates: String,
        user: String,
    },
    #[error(
        "joint {joint} cannot slide from start = {start}: that must lie between 0 and the length of \
         its chain ({nodes} nodes at different positions are given, two at least are needed)"
    )]
    Slide {
        joint: String,
        nodes: usize,
        start: f64,
    },
    #[error("{first} and {second} cannot be one: two different frames are needed")]
    NotFrames { first: String, second: String },
    #[error(
        "joint {joint} and its child {child} are {gap:.3e} apart; draw both at the same position"
    )]
    Apart {
        joint: Subject,
        child: String,
        gap: f64,
    },
    #[error(
        "joint {joint} closes a loop that ends at {node}, which is neither held nor carries the \
         other end. Hold {node} in all six coordinates, or let it be free and the child of a joint, \
         so that it is attached there; a node that is held in part may be attached to a prismatic, cylindrical \
         or planar joint instead. Multipliers or a penalty (`closure`) close any loop, also over slides and flexible parts"
    )]
    LooseLoop { joint: Subject, node: String },
    #[error(
        "joint {joint}: its child {child} is the frame that it is attached to; a joint goes from one frame \
         to another one"
    )]
    OwnParent { joint: String, child: String },
    #[error(
        "joint {joint} and its child {child} are {gap:.3e} apart and turned by {turn:.3e}, and no \
         joint between them can move: draw both as one, or release something along the loop"
    )]
    Rigid {
        joint: Subject,
        child: String,
        gap: f64,
        turn: f64,
    },
    #[error(
        "the loop closed by joint {joints} has no freedom left: all of its coordinates ({prescribed}) \
         are prescribed; leave one of them to follow from the others"
    )]
    AllPrescribed { joints: Subject, prescribed: String },
    #[error("the loop closed by joint {joints}: {source}")]
    Loop {
        joints: Subject,
        source: ImplicitError,
    },
    #[error("the closure of joint {joint}: {source}")]
    Penalty { joint: String, source: PenaltyError },
    #[error(
        "no configuration nearby satisfies what {joint} closes or enforces{}: {equation} remains \
         {gap:.3e} of its size; {}draw the model closer to a closed configuration, or start it there",
        if prescribed.is_empty() { String::new() } else { format!(" with {prescribed} as prescribed") },
        if prescribed.is_empty() { "" } else { "prescribe no more than is free, or " }
    )]
    Unclosed {
        joint: Subject,
        equation: String,
        gap: f64,
        prescribed: String,
    },
    #[error(
        "{coordinate} cannot start at {value:e}: beyond {most:.0e} rounding errors are not a small part of a \
         turn or of the model. Give the same position by a smaller number"
    )]
    FarStart {
        coordinate: Subject,
        value: f64,
        most: f64,
    },
    #[error("the model cannot be assembled: {source}")]
    Start { source: SystemError },
    #[error("node {node} carries no element (loads do not count); connect it or remove it")]
    Unconnected { node: Subject },
    #[error(
        "the loop closed by joint {joints} has no freedom left, and nothing else in the model has \
         one: nothing can move. Release something along the loop, or see whether axes and positions \
         are given with all their digits"
    )]
    LockedLoop { joints: Subject },
}

impl ModelError {
    /// The node that it is about, if it is about one.
    pub fn node(&self) -> Option<NodeId> {
        match self {
            Self::Chain { node: about, .. }
            | Self::PrescribedTwice { coordinate: about }
            | Self::PrescribedDependent {
                coordinate: about, ..
            }
            | Self::PrescribedSolved {
                coordinate: about, ..
            }
            | Self::Apart { joint: about, .. }
            | Self::LooseLoop { joint: about, .. }
            | Self::Rigid { joint: about, .. }
            | Self::AllPrescribed { joints: about, .. }
            | Self::Loop { joints: about, .. }
            | Self::Unclosed { joint: about, .. }
            | Self::FarStart {
                coordinate: about, ..
            }
            | Self::Unconnected { node: about }
            | Self::LockedLoop { joints: about } => Some(about.node),
            _ => None,
        }
    }
}
