//! Motion of a model: initial velocities, joint coordinates.

use crate::blocks::three;
use crate::model::build::builder::NodeId;
use crate::model::kinematics::formulation::rotation_rate;
use crate::model::{Context, Model, NONE, Node, NodeForm, among};
use nalgebra::{Matrix3, Vector3};
use pullback_manifold::quotients::Quotients;
use pullback_manifold::so3;
use pullback_manifold::system::{Point, SystemError};
use std::f64::consts::PI;
use std::sync::Arc;

/// State of one frame node. In statics its rates are derivatives by the load parameter, of prescribed motion alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeState {
    /// Displacement from the reference position, global components.
    pub d: Vector3<f64>,
    /// Rotation vector in the chart in use, global components, radians.
    pub psi: Vector3<f64>,
    /// Current position.
    pub position: Vector3<f64>,
    /// Rotation from the reference orientation.
    pub R: Matrix3<f64>,
    /// Velocity ẋ, global components.
    pub velocity: Vector3<f64>,
    /// Angular velocity ω = Tᵀ Ψ̇, global components.
    pub omega: Vector3<f64>,
    /// Acceleration ẍ, global components.
    pub acceleration: Vector3<f64>,
    /// Rate ω̇ of the angular velocity, global components.
    pub omega_dot: Vector3<f64>,
}

/// A rigid motion: the velocity field v + ω × (x − about).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RigidMotion {
    /// Velocity of the point `about`, global components.
    pub velocity: Vector3<f64>,
    /// Angular velocity, global components.
    pub omega: Vector3<f64>,
    /// The point with `velocity`.
    pub about: Vector3<f64>,
}

impl Model {
    /// Unknown of coordinate `k` of any node, if it is free. Rotation vectors of a frame by
    /// increments ([`Formulation`](crate::model::Formulation)) are those since its chart was centred:
    /// before a run, from the reference orientation.
    pub fn unknown_at(&self, node: NodeId, k: usize) -> Option<usize> {
        let n = self.carrier(&self.nodes[node.0 as usize]);
        self.unknown_of((k < n.dim).then(|| n.first + k)?)
    }

    /// Sets coordinate `k` of a node in a vector of unknowns; false if it is not free.
    ///
    /// # Panics
    /// If the vector has too few entries.
    pub fn set(&self, unknowns: &mut [f64], node: NodeId, k: usize, value: f64) -> bool {
        let u = self.unknown_at(node, k);
        if let Some(u) = u {
            unknowns[u] = value;
        }
        u.is_some()
    }

    /// Whether a node has its own coordinates: it is not attached to a joint.
    pub fn is_own(&self, node: NodeId) -> bool {
        self.carrier(&self.nodes[node.0 as usize]).is_own()
    }

    /// Initial value of a prescribed coordinate.
    fn prescribed_value(&self, c: usize) -> f64 {
        let p = among(&self.prescribed, c..c + 1).first();
        p.map_or(0.0, |p| p.function.at(0.0, &self.start.inputs)[0])
    }

    /// Nodes of joint coordinates and rotations, with their names.
    pub fn joint_coordinates(&self) -> impl Iterator<Item = (NodeId, &str, usize)> + '_ {
        let nodes = self.nodes_that(Node::is_released);
        nodes.map(|(id, n)| (id, n.name.as_str(), n.dim))
    }

    /// Frame nodes that are attached to joints, with their names.
    pub fn mapped_frames(&self) -> impl Iterator<Item = (NodeId, &str)> + '_ {
        let mapped = |n: &Node| n.form == NodeForm::Frame && !self.carrier(n).is_own();
        self.nodes_that(mapped).map(|(id, n)| (id, n.name.as_str()))
    }

    /// The nodes that satisfy a condition.
    pub(in crate::model) fn nodes_that(
        &self,
        condition: impl Fn(&Node) -> bool,
    ) -> impl Iterator<Item = (NodeId, &Node)> {
        let all = (0..).map(NodeId).zip(self.nodes.iter());
        all.filter(move |(_, n)| condition(n))
    }
}

impl Context {
    /// A frame node in the configuration last evaluated or set by [`Context::configure`]; not a number for a node without a
    /// frame.
    pub fn node_state(&self, node: NodeId) -> NodeState {
        let n = &self.model.nodes[node.0 as usize];
        let [x, v, a] = match n.is_frame() {
            true => self.chart_motion(n),
            false => [[f64::NAN; 6]; 3],
        };
        let (d, psi) = (three(&x, 0), three(&x, 3));
        let [psi_dot, psi_ddot] = [&v, &a].map(|x| three(x, 3));
        let R = so3::rotation(&psi);
        // ω̇ = R Ω̇ with Ω̇ = T Ψ̈ + Ṫ Ψ̇, [M04] (50).
        let rest = so3::T_dot_psi_dot(&psi_dot, &psi, &Quotients::new(psi.norm()));
        NodeState {
            d,
            psi,
            position: n.position + d,
            R,
            velocity: three(&v, 0),
            omega: so3::tangent(&psi).tr_mul(&psi_dot),
            acceleration: three(&a, 0),
            omega_dot: R * (so3::tangent(&psi) * psi_ddot + rest),
        }
    }

    /// Value, rate and acceleration of a coordinate of a node, such as the angle of a joint, in the configuration last set;
    /// the acceleration is that of prescribed motion alone after an evaluation without accelerations. `None` if the node
    /// has no such coordinate.
    pub fn coordinate(&self, node: NodeId, k: usize) -> Option<[f64; 3]> {
        let n = &self.model.nodes[node.0 as usize];
        (k < n.dim).then(|| match n.is_frame() {
            true => self.chart_motion(n).map(|x| x[k]),
            false => self.configuration().map(|x| x[n.first + k]),
        })
    }

    /// Rotates the free rotations of joints (ball joints, points on curves and surfaces) with the
    /// frames that they are attached to, as given by `q` at t = 0: their coordinates are rotation
    /// vectors in space, independent of the joints above. Rotations in `given` stay, and so do
    /// those in loops. Returns the changed unknowns.
    ///
    /// # Errors
    /// [`SystemError`] if a joint is outside its domain.
    pub fn carry_rotations(
        &mut self,
        q: &mut [f64],
        given: &[usize],
    ) -> Result<Vec<usize>, SystemError> {
        let t = 0.0;
        self.expand(Point::statics(t, q))?;
        let closing = self
            .model
            .enforced
            .iter()
            .flat_map(|&e| self.model.elements[e].nodes.iter());
        let closing: Vec<NodeId> = closing.map(|&n| NodeId(n)).collect();
        let mut stay = self.unknowns_behind(&closing);
        stay.extend(given);
        let mut carried = Vec::new();
        self.work.known.forget();
        let model = Arc::clone(&self.model);
        for (n, _, d) in model.nodes.mapped() {
            // The frames above have been rotated already.
            self.expand_node(t, n)?;
            let rotation = self.free_rotation_of(NodeId(n));
            let parents = d.parents(&self.state.maps).iter();
            let mut parents = parents.map(|&m| &model.nodes[m as usize]);
            let Some(parent) = parents.find(|m| m.is_frame()) else {
                continue;
            };
            let [[.., x, y, z], ..] = self.chart_motion(parent);
            let mut psi = Vector3::new(x, y, z);
            if psi.norm() > PI {
                psi = so3::complement(&psi);
            }
            let [Some(u), Some(_), Some(_)] = [0, 1, 2].map(|k| self.unknown_at(rotation, k))
            else {
                continue;
            };
            let given = rotation == NodeId(n) || stay.contains(&u);
            if given || q[u..u + 3] == *psi.as_slice() {
                continue;
            }
            q[u..u + 3].copy_from_slice(psi.as_slice());
            carried.extend(u..u + 3);
            let turned = &self.model.nodes[rotation.0 as usize];
            for c in [turned.first, self.carrier(turned).first] {
                self.work.x[c..c + 3].copy_from_slice(psi.as_slice());
            }
            self.expand_node(t, n)?;
        }
        Ok(carried)
    }

    /// Writes the velocities of a rigid motion of the nodes in `nodes` (all if `None`) at
    /// coordinates `q` to `v`: displacements move with v + ω × (x − about), rotation vectors with Ψ̇
    /// = T⁻ᵀ ω. Joint coordinates stay at rest: see [`Context::fit_rates`]. Prescribed coordinates count with their values
    /// at t = 0 and the first inputs.
    ///
    /// # Panics
    /// If `q` or `v` has too few entries.
    pub fn set_velocity(
        &mut self,
        q: &[f64],
        v: &mut [f64],
        nodes: Option<&[NodeId]>,
        motion: &RigidMotion,
    ) {
        let count = nodes.map_or(self.model.nodes.len(), <[_]>::len);
        for k in 0..count {
            let node = nodes.map_or(NodeId(k as u32), |nodes| nodes[k]);
            if nodes.is_none() && self.model.nodes[k].form != NodeForm::Frame {
                continue;
            }
            for id in [node, self.free_rotation_of(node)] {
                let n = &self.model.nodes[id.0 as usize];
                let own = self.model.carrier(n);
                if !own.is_own() {
                    continue;
                }
                let value = |c: usize| match self.model.unknowns[c] {
                    NONE => self.model.prescribed_value(c),
                    u => q[u as usize],
                };
                let vector = |c: usize| Vector3::new(value(c), value(c + 1), value(c + 2));
                let mut put = |c: usize, x: &Vector3<f64>| {
                    for (k, x) in x.iter().enumerate() {
                        if self.model.unknowns[c + k] != NONE {
                            v[self.model.unknowns[c + k] as usize] = *x;
                        }
                    }
                };
                if n.form == NodeForm::Frame {
                    let position = n.position + vector(own.first);
                    let arm = position - motion.about;
                    put(own.first, &(motion.velocity + motion.omega.cross(&arm)));
                }
                if n.rotation().is_some() {
                    let first = own.first + n.dim - 3;
                    let map = n.mapped().map(|d| &mut self.state.maps[d.index]);
                    let rate = rotation_rate(map, &vector(first), &motion.omega);
                    put(first, &rate);
                }
            }
        }
    }

    /// The node whose coordinates are the rotation of a frame: the frame itself, or the rotation of
    /// a joint such as a spherical one.
    pub fn free_rotation_of(&self, node: NodeId) -> NodeId {
        let frame = &self.model.nodes[node.0 as usize];
        let Some(d) = frame.mapped().filter(|_| frame.form == NodeForm::Frame) else {
            return node;
        };
        let released = |&&n: &&u32| self.model.nodes[n as usize].form == NodeForm::Rotation;
        d.parents(&self.state.maps)
            .iter()
            .find(released)
            .map_or(node, |&n| NodeId(n))
    }

    /// Scalar unknowns that belong to no frame, rotation vector or loop: the joint coordinates.
    pub fn single_unknowns(&self) -> Vec<usize> {
        let loops = (self.model.nodes.mapped()).filter(|(_, _, d)| d.reparametrizes);
        let chosen = loops.filter_map(|(_, _, d)| d.parents(&self.state.maps).first());
        let of_loops: Vec<u32> = chosen.copied().collect();
        let scalar = |n: &Node| n.form == NodeForm::Coordinates && n.dim == 1 && n.is_own();
        let nodes = self.nodes_that(scalar);
        nodes
            .filter(|(id, _)| !of_loops.contains(&id.0))
            .filter_map(|(_, n)| self.unknown_of(n.first))
            .collect()
    }
}
