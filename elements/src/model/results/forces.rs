//! Forces of supports and joints.

use crate::blocks::three;
use crate::model::build::builder::NodeId;
use crate::model::kinematics::node_entries::collect;
use crate::model::loops::upwards;
use crate::model::{Context, NONE, NodeForm};
use nalgebra::Vector3;
use pullback_manifold::so3;
use pullback_manifold::system::{Evaluation, Point, System, SystemError};

/// Reaction of a support on the structure, in global components.
#[derive(Clone, Debug, PartialEq)]
pub struct Reaction {
    /// The supported node.
    pub node: String,
    /// The prescribed ones of the six coordinates.
    pub prescribed: [bool; 6],
    /// Reaction force, zero along free directions.
    pub force: Vector3<f64>,
    /// Reaction moment, T⁻¹ of the covector for Ψ, which is zero along free rotations.
    pub moment: Vector3<f64>,
}

/// Forces of supports and joints at a point, by [`Context::forces`].
#[derive(Clone, Copy)]
pub struct Forces<'a>(&'a Context);

impl Context {
    /// Evaluates the forces of supports and joints at a point, such as the present state of a motion.
    ///
    /// # Errors
    /// [`SystemError`] if the point cannot be evaluated.
    pub fn forces(&mut self, at: Point<'_>) -> Result<Forces<'_>, SystemError> {
        let mut r = vec![0.0; at.q.len()];
        self.evaluate(at, Evaluation::residual(&mut r))?;
        Ok(self.last_forces())
    }

    /// The same without an evaluation: those of the last evaluation of the residual, or of
    /// [`energies_and_momentum`](Context::energies_and_momentum), if the state and its charts are still the same. A step of a motion
    /// ends with others.
    pub fn last_forces(&self) -> Forces<'_> {
        Forces(self)
    }

    /// Closing forces of loops at a joint. With the multipliers μ of the equations in the child's axes,
    /// the force and moment −R μ act on the child, and the opposite on the frame that coincides with
    /// it; they cancel at a node with both, except for a remainder: above a frame that rotates freely
    /// there is no moment about its axis, as loads and inertia balance the closing forces there.
    fn closing_force(&self, node: NodeId) -> [Vector3<f64>; 2] {
        let w = &self.work;
        let mut out = [Vector3::zeros(); 2];
        let partner = self.model.nodes[node.0 as usize].partner;
        let is_node = |&n: &u32| n == node.0 || n == partner;
        for report in &self.model.reports {
            let Some(x) = report.map else { continue };
            let mut ends = report.loops.iter().flat_map(|l| [l.frame, l.child]);
            if !ends.any(|end| upwards(&self.model.nodes, end).iter().any(is_node)) {
                continue;
            }
            let n = &self.model.nodes[x as usize];
            let Some(d) = n.mapped() else {
                continue;
            };
            let mut q = vec![0.0; d.direct];
            collect(d.parents(&self.state.maps), &self.model.spans, &w.x, &mut q);
            let mut mu = vec![0.0; 6 * report.loops.len()];
            // A copy, as its evaluation changes its buffers.
            if let Some(map) = self.state.maps[d.index].clone().implicit() {
                map.multipliers(w.t, &q, &w.r[n.range()], &mut mu);
            }
            for (closed, mu) in report.loops.iter().zip(mu.chunks_exact(6)) {
                let R = self.node_state(NodeId(closed.child)).R;
                let [force, moment] = [0, 3].map(|k| R * three(mu, k));
                for (end, sign) in [(closed.frame, -1.0), (closed.child, 1.0)] {
                    let path = upwards(&self.model.nodes, end);
                    let Some(above) = path.iter().rposition(is_node) else {
                        continue;
                    };
                    // These forces act on the frame at which the chains of this loop end for the
                    // map, and on those above.
                    let read =
                        |n: &u32| closed.ends_at(*n) && d.parents(&self.state.maps).contains(n);
                    if path[..=above].iter().any(read) {
                        continue;
                    }
                    let position = |n: u32| self.node_state(NodeId(n)).position;
                    let ball = |&&n: &&u32| self.free_rotation_of(NodeId(n)) != NodeId(n);
                    let (at, moment) = match path[..above].iter().rev().find(ball) {
                        Some(&ball) => (position(ball), Vector3::zeros()),
                        None => (position(end), moment),
                    };
                    let arm = at - position(node.0);
                    out[0] += force * sign;
                    out[1] += (moment + arm.cross(&force)) * sign;
                }
            }
        }
        out
    }
}

impl Forces<'_> {
    /// Reactions of all supported frame nodes.
    pub fn reactions(&self) -> Vec<Reaction> {
        let mut out: Vec<Reaction> = Vec::new();
        for (id, n) in self.0.nodes_that(|n| n.form == NodeForm::Frame) {
            let own = self.0.carrier(n);
            let prescribed = std::array::from_fn(|k| {
                self.0.model.unknowns[own.first + k] == NONE && own.is_own()
            });
            if !prescribed.contains(&true) {
                continue;
            }
            let psi = Vector3::from_column_slice(&self.0.work.x[n.first + 3..n.first + 6]);
            // Covector T m of a spatial moment m.
            let [force, turn] = self.0.closing_force(id);
            let turn = so3::tangent(&psi) * turn;
            let mut f = [0.0; 6];
            for k in (0..6).filter(|&k| prescribed[k]) {
                let closing = if k < 3 { force[k] } else { turn[k - 3] };
                f[k] = closing - self.0.work.r[n.first + k];
            }
            out.push(Reaction {
                node: n.name.clone(),
                prescribed,
                force: Vector3::new(f[0], f[1], f[2]),
                moment: so3::tangent_inverse(&psi) * Vector3::new(f[3], f[4], f[5]),
            });
        }
        out
    }

    /// Moment about the axis (force along it) of a joint that its prescribed coordinate requires; zero for a coordinate that is
    /// not prescribed.
    pub fn joint_effort(&self, coordinate: NodeId) -> f64 {
        let n = &self.0.model.nodes[coordinate.0 as usize];
        match n.is_own() && self.0.model.unknowns[n.first] == NONE {
            true => -self.0.work.r[n.first],
            false => 0.0,
        }
    }

    /// Force and moment (global components) of a joint on everything attached to it at a frame
    /// node; `None` for a node that is not attached.
    pub fn joint_force(&self, node: NodeId) -> Option<[Vector3<f64>; 2]> {
        let n = &self.0.model.nodes[node.0 as usize];
        if self.0.is_own(node) || !n.is_frame() {
            return None;
        }
        let mut out = self.0.wrench(n).map(|f| -f);
        for (out, closing) in out.iter_mut().zip(self.0.closing_force(node)) {
            *out += closing;
        }
        for &[_, child] in (self.0.model.carried.iter()).filter(|[at, _]| *at == node) {
            let [force, moment] = self.joint_force(child)?;
            let arm = self.0.node_state(child).position - self.0.node_state(node).position;
            let moment = match self.0.free_rotation_of(child) == child {
                true => moment,
                false => Vector3::zeros(),
            };
            out[0] += force;
            out[1] += moment + arm.cross(&force);
        }
        Some(out)
    }
}
