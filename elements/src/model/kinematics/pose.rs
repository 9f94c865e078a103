//! Nodes of the poses of frames.
//!
//! Chains of joints, and the elements that read poses, go from pose to pose. A frame that is attached to a joint
//! is the chart of its pose ([`ToChart`]), which is evaluated only if an element or a map reads it; the
//! pose of any other frame is mapped from its chart ([`ToPose`]).

use crate::blocks::three;
use crate::model::assembly::workspace::Workspace;
use crate::model::build::builder::FRAME_QUANTITIES;
use crate::model::kinematics::mapped_node::MappedNode;
use crate::model::{Context, ElementEntry, NONE, Node, NodeForm};
use nalgebra::Vector3;
use pullback_manifold::map::pose::orientation;
use pullback_manifold::map::{MapState, Parametrization, ToChart, ToPose};
use pullback_manifold::so3;

/// A node for the pose of a frame, at the end of all nodes.
pub(in crate::model) fn new_pose(nodes: &mut [Node], frame: u32, map: Box<MappedNode>) -> Node {
    let number = nodes.len() as u32;
    let node = &mut nodes[frame as usize];
    node.partner = number;
    Node {
        position: node.position,
        partner: frame,
        ..Node::new(
            node.name.clone(),
            NodeForm::Pose,
            &FRAME_QUANTITIES,
            Some(map),
        )
    }
}

/// The node with the pose of a frame, which is added if there is none.
pub(in crate::model) fn add_pose(nodes: &mut Vec<Node>, frame: u32) -> u32 {
    let node = &nodes[frame as usize];
    if node.form != NodeForm::Frame {
        return frame;
    }
    if node.partner == NONE {
        let map = MappedNode::of(Box::new(ToPose), vec![frame]);
        let pose = new_pose(nodes, frame, map);
        nodes.push(pose);
    }
    nodes[frame as usize].partner
}

/// Force and moment of a covector of a frame at coordinates x: the covector of a moment m is T m in a chart.
pub(in crate::model) fn spatial(node: &Node, x: &[f64], covector: &[f64]) -> [Vector3<f64>; 2] {
    let turn = three(covector, 3);
    let moment = match node.form {
        NodeForm::Pose => turn,
        _ => so3::tangent_inverse(&three(x, 3)) * turn,
    };
    [three(covector, 0), moment]
}

/// Marks the charts of frames that nothing reads, and the poses of frames fixed to another one that nothing else reads.
pub(in crate::model) fn mark_unread(nodes: &mut [Node], elements: &[ElementEntry]) {
    let of_elements = elements.iter().flat_map(|e| e.nodes.iter().copied());
    let of_maps = nodes.iter().flat_map(Node::all_parents);
    let mut readers = vec![0; nodes.len()];
    of_elements
        .chain(of_maps)
        .for_each(|n| readers[n as usize] += 1);
    for n in 0..nodes.len() {
        if readers[n] > 0 || !nodes[n].is_view() {
            continue;
        }
        let pose = nodes[n].partner as usize;
        let alone = readers[pose] == 1;
        for (n, unread) in [(n, true), (pose, alone && nodes[pose].is_fixed())] {
            if let (true, Some(d)) = (unread, &mut nodes[n].map) {
                d.read = false;
            }
        }
    }
}

impl Node {
    /// Whether it is the chart of its pose.
    pub(in crate::model) fn is_view(&self) -> bool {
        let of_partner = |d: &MappedNode| *d.initial_parents() == [self.partner];
        self.form == NodeForm::Frame && self.mapped().is_some_and(of_partner)
    }

    /// Whether it is the pose of a frame fixed to another one.
    fn is_fixed(&self) -> bool {
        self.mapped()
            .is_some_and(|d| d.direct == self.dim && d.segments.len() == 1)
    }
}

impl Context {
    /// Force and moment of the residual at a frame and at all that follows from it.
    pub(in crate::model) fn wrench(&self, node: &Node) -> [Vector3<f64>; 2] {
        let node = match node.is_view() {
            true => &self.model.nodes[node.partner as usize],
            false => node,
        };
        let [x, r] = [&self.work.x, &self.work.r].map(|x| &x[node.range()]);
        spatial(node, x, r)
    }

    /// Rotation angle of a frame, that of its rotation vector, in the configuration last set.
    pub(in crate::model) fn angle(&self, node: &Node) -> f64 {
        if node.is_view() {
            let [x, ..] = self.pose_motion(&self.model.nodes[node.partner as usize]);
            let turn = orientation(&x);
            return 2.0 * turn.v.norm().atan2(turn.w.abs());
        }
        three(&self.work.x, node.first + 3).norm()
    }

    /// Coordinates, velocities and accelerations of a node, those of a frame in its chart, in the
    /// configuration last set.
    pub fn node_motion(&self, node: &Node) -> [Vec<f64>; 3] {
        match node.is_frame() {
            true => self.chart_motion(node).map(|x| x.to_vec()),
            false => self.configuration().map(|x| x[node.range()].to_vec()),
        }
    }

    /// Coordinates, velocities and accelerations of a frame in its chart, in the configuration last set.
    pub(in crate::model) fn chart_motion(&self, node: &Node) -> [[f64; 6]; 3] {
        let pose = match node.form {
            NodeForm::Pose => self.pose_motion(node),
            _ if node.is_view() => self.pose_motion(&self.model.nodes[node.partner as usize]),
            _ => return motion_of(&self.work, node),
        };
        let mut chart = ToChart::default();
        chart.change_charts(self.work.t, &pose[0]);
        motion_by(&mut chart, self.work.t, &pose)
    }

    /// The same of a pose, also of one that no evaluation reads.
    fn pose_motion(&self, pose: &Node) -> [[f64; 6]; 3] {
        match pose.mapped() {
            Some(d) if !d.read => {
                let parent = &self.model.nodes[d.initial_parents()[0] as usize];
                let mut map = self.state.maps[d.index].clone();
                motion_by(&mut *map, self.work.t, &self.pose_motion(parent))
            }
            _ => motion_of(&self.work, pose),
        }
    }
}

fn motion_of(w: &Workspace, frame: &Node) -> [[f64; 6]; 3] {
    [&w.x, &w.v, &w.a].map(|x| std::array::from_fn(|k| x[frame.first + k]))
}

/// The motion of a frame that a map gives by another one.
fn motion_by(map: &mut dyn Parametrization, t: f64, of: &[[f64; 6]; 3]) -> [[f64; 6]; 3] {
    let mut out = [[0.0; 6]; 3];
    let mut operators = [[0.0; 36]; 3];
    let [x, x_dot, x_ddot] = &mut out;
    let [B, B_dot, B_ddot] = &mut operators;
    let motion = of.each_ref().map(|x| &x[..]);
    map.evaluate(t, motion, &mut [[x, B], [x_dot, B_dot], [x_ddot, B_ddot]]);
    out
}
