//! Buffers of an evaluation.

use crate::model::assembly::element_workspace::ElementWorkspace;
use crate::model::assembly::scatter_map::ScatterMap;
use crate::model::charts::nodes::MapCoordinates;
use crate::model::charts::segments::SegmentChanges;
use crate::model::kinematics::mapped_node::Operators;
use crate::model::{ElementEntry, Nodes};
use pullback_manifold::system::{Point, Scales};

/// Buffers of an evaluation.
#[derive(Clone, Default)]
pub(in crate::model) struct Workspace {
    /// Coordinates, velocities, accelerations of all nodes; in statics the rates are derivatives by the load
    /// parameter, zero without a support or a map that depends on it.
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
    /// Time of this state.
    pub t: f64,
    /// Number of assemblies so far.
    pub assemblies: usize,
    /// Residual at all nodes: reactions at prescribed coordinates, with opposite sign.
    pub r: Vec<f64>,
    pub r_t: Vec<f64>,
    /// Residual of loads at prescribed coordinates (undefined elsewhere).
    pub direct: Vec<f64>,
    /// Coordinates of own nodes at the previous iterate, if any.
    pub previous: Vec<f64>,
    pub has_previous: bool,
    /// Whether rates of free coordinates may be nonzero.
    pub stirred: bool,
    /// The point at which all nodes are known.
    pub known: Known,
    /// Kinematic operators of mapped nodes.
    pub operators: Operators,
    /// Positions of tangents in the present segments.
    pub scatter_map: ScatterMap,
    /// Tangents at mapped nodes, and scratch to pull them back.
    pub coupled: Vec<f64>,
    pub scratch: Vec<f64>,
    pub local: ElementWorkspace,
    /// Parts C and M of a tangent, if rates are angular velocities.
    pub parts: [Vec<f64>; 2],
    /// Coordinates of the maps that may reparametrize them.
    pub reparametrizations: Vec<MapCoordinates>,
    /// Whether the last change of charts changed a segment.
    pub segments_changed: bool,
    pub segment_changes: SegmentChanges,
    /// Step size of an evaluation of enforced equations at the level of accelerations.
    pub acceleration_step: Option<f64>,
    /// Rates of joint coordinates in the six rigid motions of the whole, once computed.
    pub released: Vec<Vec<f64>>,
    /// Forces of loads, and rates and accelerations of one of these motions, to find their power.
    pub load: Vec<f64>,
    pub motion: [Vec<f64>; 2],
    pub scales: Scales,
    /// Forces exerted by elements, used if neither loads nor reactions are a scale.
    pub exerted: Scales,
    pub dead_loads: DeadLoads,
}

/// Sum of the loads that depend on time only: a step evaluates them repeatedly at the same time.
#[derive(Clone, Default)]
pub(in crate::model) struct DeadLoads {
    /// Their time; `None` if they must be updated.
    pub t: Option<f64>,
    /// Their residual at all nodes.
    pub r: Vec<f64>,
    /// Their largest entries per quantity.
    pub force: [f64; 3],
}

/// A point at which all nodes are known, maps included; none at first.
#[derive(Clone, Default)]
pub(in crate::model) struct Known {
    t: Option<f64>,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
}

impl Known {
    /// Forgets the point, after a change of what the nodes depend on.
    pub(in crate::model) fn forget(&mut self) {
        self.t = None;
    }

    pub(in crate::model) fn set(&mut self, at: Point<'_>) {
        self.t = Some(at.t);
        for (known, x) in [
            (&mut self.q, at.q),
            (&mut self.v, at.v),
            (&mut self.a, at.a),
        ] {
            known.clear();
            known.extend_from_slice(x);
        }
    }

    /// Whether it is this point.
    pub(in crate::model) fn is(&self, at: Point<'_>) -> bool {
        self.t == Some(at.t) && self.q == at.q && self.v == at.v && self.a == at.a
    }
}

impl Workspace {
    pub(in crate::model) fn new(
        nodes: &Nodes,
        elements: &[ElementEntry],
        [operators, coupled, scratch]: [usize; 3],
        scatter_map: ScatterMap,
        length: f64,
        levers: [f64; 2],
    ) -> Self {
        let total = nodes.iter().map(|n| n.dim).sum::<usize>();
        let direct = nodes.mapped().map(|(_, _, d)| d.direct);
        let parents = direct.max().unwrap_or(0);
        let n = elements.iter().map(|e| e.element.dim()).max().unwrap_or(0);
        let zeros = |len: usize| vec![0.0; len];
        let scales = Scales {
            length,
            levers,
            ..Scales::default()
        };
        Self {
            x: zeros(total),
            v: zeros(total),
            a: zeros(total),
            r: zeros(total),
            r_t: zeros(total),
            direct: zeros(total),
            previous: zeros(total),
            operators: [(); 3].map(|()| vec![0.0; operators]),
            scatter_map,
            coupled: zeros(coupled),
            scratch: zeros(scratch),
            local: ElementWorkspace::new(n, parents),
            reparametrizations: MapCoordinates::all(nodes),
            scales,
            exerted: scales,
            dead_loads: DeadLoads {
                r: zeros(total),
                ..DeadLoads::default()
            },
            ..Self::default()
        }
    }
}
