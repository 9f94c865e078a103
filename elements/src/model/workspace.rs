//! Buffers of an evaluation.

use super::charts::Reparametrization;
use super::element_charts::ElementCharts;
use super::element_workspace::ElementWorkspace;
use super::mapped_node::Operators;
use super::segments::SegmentChanges;
use super::{ElementEntry, Node, Source};
use pullback_manifold::system::{Quantity, Scales};

/// Buffers of an evaluation, made once.
#[derive(Default)]
pub(super) struct Workspace {
    /// Coordinates, velocities, accelerations of all nodes.
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
    /// Time of these.
    pub t: f64,
    /// How often the model has been assembled.
    pub assemblies: usize,
    /// Residual at all nodes: the reactions at prescribed coordinates, with the sign changed.
    pub r: Vec<f64>,
    pub r_t: Vec<f64>,
    /// Residual of loads at prescribed coordinates (elsewhere without meaning).
    pub direct: Vec<f64>,
    /// Coordinates of all nodes at the previous iterate, while there is one.
    pub previous: Vec<f64>,
    pub has_previous: bool,
    /// Whether anything moves: always in dynamics, and in statics where a support or a map is
    /// driven (the rates are then those with the load parameter).
    pub moving: bool,
    /// Whether rates of free coordinates may differ from zero.
    pub stirred: bool,
    /// Kinematic operators of nodes that follow others.
    pub operators: Operators,
    /// Rows of the tangent at these nodes, on their way to own ones.
    pub panels: Vec<f64>,
    pub local: ElementWorkspace,
    /// Accelerations of a map's coordinates, while it changes their meaning.
    pub accelerations: Vec<Vec<f64>>,
    /// Parts C and M of a tangent, while rates are spins.
    pub parts: [Vec<f64>; 2],
    /// Coordinates of the maps that may change their meaning.
    pub reparametrizations: Vec<Reparametrization>,
    /// Whether a map was handed over with the last change of charts.
    pub segments_changed: bool,
    pub segment_changes: SegmentChanges,
    /// Step size, while equations that elements enforce are asked for at the level of accelerations.
    pub accelerations_asked: Option<f64>,
    /// Rates of the coordinates that joints release in the six rigid motions of the whole, once they
    /// have been looked for.
    pub released: Vec<Vec<f64>>,
    /// For the choice of the elements' charts.
    pub element_charts: ElementCharts,
    pub scales: Scales,
    /// What elements exert, where neither loads nor reactions are a measure.
    pub exerted: Scales,
    pub dead_loads: DeadLoads,
}

/// Loads that read nothing but the time, summed up: a step asks for them at one time again and again.
#[derive(Default)]
pub(super) struct DeadLoads {
    /// The time of these; none when it is not known which loads are in it.
    pub t: Option<f64>,
    /// What was set from outside.
    pub inputs: Vec<f64>,
    /// Their residual at all nodes.
    pub r: Vec<f64>,
    /// Their largest entries per quantity.
    pub force: [f64; 3],
}

impl DeadLoads {
    /// Elements see their nodes in other charts than before.
    pub(super) fn forget(&mut self) {
        self.t = None;
    }
}

impl Workspace {
    pub(super) fn new(
        nodes: &[Node],
        elements: &[ElementEntry],
        [operators, panels]: [usize; 2],
        length: f64,
        levers: [f64; 2],
    ) -> Self {
        let total = nodes.iter().map(|n| n.dim).sum::<usize>();
        let direct = |node: &Node| match &node.source {
            Source::Own => 0,
            Source::Mapped(d) => d.direct,
        };
        let parents = nodes.iter().map(direct).max().unwrap_or(0);
        let n = elements.iter().map(|e| e.element.dim()).max().unwrap_or(0);
        let zeros = |len: usize| vec![0.0; len];
        let mut scales = Scales {
            levers,
            ..Scales::default()
        };
        scales.coordinate[Quantity::Length.index()] = length;
        Self {
            x: zeros(total),
            v: zeros(total),
            a: zeros(total),
            t: 0.0,
            assemblies: 0,
            r: zeros(total),
            r_t: zeros(total),
            direct: zeros(total),
            previous: zeros(total),
            has_previous: false,
            moving: false,
            stirred: false,
            operators: Operators::new(operators),
            panels: zeros(panels),
            local: ElementWorkspace::new(n, parents),
            accelerations: Vec::new(),
            parts: [Vec::new(), Vec::new()],
            reparametrizations: Vec::new(),
            segments_changed: false,
            segment_changes: SegmentChanges::default(),
            accelerations_asked: None,
            released: Vec::new(),
            element_charts: ElementCharts::default(),
            scales,
            exerted: Scales::default(),
            dead_loads: DeadLoads {
                r: zeros(total),
                ..DeadLoads::default()
            },
        }
    }
}
