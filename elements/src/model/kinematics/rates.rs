//! Initial rates of joint coordinates.

use crate::model::build::builder::NodeId;
use crate::model::build::dependency_graph::behind;
use crate::model::kinematics::motion::RigidMotion;
use crate::model::{Context, Model, NodeForm, among};
use nalgebra::{DMatrix, DVector};
use pullback_manifold::system::{Point, SystemError};
use std::sync::Arc;

/// Part of a motion that may be missing by rounding.
const MISSING: f64 = 1e-9;

/// The time just before t = 0, at which initial velocities are given: rates of prescribed motions
/// are those from the left.
pub const BEFORE_START: f64 = 0.0_f64.next_down();

impl Model {
    /// Whether a mapped node is a frame among `nodes`.
    fn chosen(&self, n: u32, nodes: Option<&[NodeId]>) -> bool {
        let node = &self.nodes[n as usize];
        let frame = match node.form {
            NodeForm::Pose => node.partner,
            _ => n,
        };
        node.is_frame() && nodes.is_none_or(|nodes| nodes.contains(&NodeId(frame)))
    }

    /// The coordinates of the loop of a coordinate.
    fn loop_of(&self, n: u32) -> Option<u32> {
        let &[x] = self.nodes[n as usize].mapped()?.initial_parents() else {
            return None;
        };
        self.reports.iter().any(|r| r.map == Some(x)).then_some(x)
    }

    /// The first of the joints that close the loop of coordinates x.
    fn closing_joint(&self, x: u32) -> u32 {
        let report = self.reports.iter().find(|r| r.map == Some(x));
        let closed = report.and_then(|r| r.loops.first());
        closed.map_or(x, |closed| closed.frame)
    }

    /// The unknowns among the coordinates of nodes.
    pub(in crate::model) fn unknowns_of(&self, nodes: impl Iterator<Item = u32>) -> Vec<usize> {
        let all = nodes.flat_map(|m| self.carrier(&self.nodes[m as usize]).range());
        all.filter_map(|c| self.unknown_of(c)).collect()
    }

    /// Whether a joint coordinate or rotation belongs to a closed loop: it follows from the loop's
    /// independent coordinates.
    pub fn in_loop(&self, node: NodeId) -> bool {
        self.loop_of(node.0).is_some()
    }
}

impl Context {
    /// Fits the rates of joint coordinates in `v`, so that the frames that elements read (those among
    /// `nodes`, all if `None`) follow a rigid motion as closely as possible: frame by frame from
    /// the root, all frames of a loop at once, by least squares. Unknowns that are `held` keep theirs. Returns
    /// the nodes, and of loops the closing joints, that do not allow the motion, where they move and nothing is
    /// prescribed. Time is that just before t = 0.
    ///
    /// # Errors
    /// [`SystemError`] if the point is outside a chart.
    pub fn fit_rates(
        &mut self,
        q: &[f64],
        v: &mut [f64],
        nodes: Option<&[NodeId]>,
        motion: &RigidMotion,
        held: &[usize],
    ) -> Result<Vec<String>, SystemError> {
        let (mut fitted, mut against) = (Vec::new(), Vec::new());
        let model = Arc::clone(&self.model);
        let mut open = vec![true; v.len()];
        held.iter().for_each(|&u| open[u] = false);
        let mut read = vec![false; model.nodes.len()];
        let nodes_read = model.elements.iter().flat_map(|e| e.nodes.iter());
        nodes_read.for_each(|&n| read[n as usize] = true);
        for &n in &model.nodes.mapped {
            if !model.chosen(n, nodes) {
                continue;
            }
            let (frames, name) = match self.loop_behind(n) {
                Some(x) if fitted.contains(&x) => continue,
                Some(x) => {
                    fitted.push(x);
                    let all = model.nodes.mapped.iter().copied();
                    let of_loop =
                        |&k: &u32| model.chosen(k, nodes) && self.loop_behind(k) == Some(x);
                    (all.filter(of_loop).collect(), model.closing_joint(x))
                }
                None if read[n as usize] => (vec![n], n),
                None => continue,
            };
            let own = behind(&model.nodes, &self.state.maps, &frames);
            let released = |&m: &u32| model.nodes[m as usize].is_released();
            let mut unknowns = model.unknowns_of(own.iter().copied().filter(released));
            let moves = !unknowns.is_empty();
            unknowns.retain(|&u| std::mem::take(&mut open[u]));
            let left = self.fit_motion(q, v, &frames, &unknowns, motion)?;
            let given = |&m: &u32| {
                let all = among(&model.prescribed, model.nodes[m as usize].range());
                all.iter().any(|p| p.function.constant().is_none())
            };
            // What is fixed to supports stays, as supported nodes do.
            if left > MISSING && moves && !own.iter().any(given) {
                against.push(model.nodes[name as usize].name.clone());
            }
        }
        Ok(against)
    }

    /// The coordinates of the loop from which a frame follows.
    fn loop_behind(&self, n: u32) -> Option<u32> {
        let d = self.model.nodes[n as usize].mapped()?;
        let mut parents = d.parents(&self.state.maps).iter();
        parents.find_map(|&m| self.model.loop_of(m))
    }

    /// Fits the rates of unknowns to a motion of frames; returns the missing part relative to the whole.
    fn fit_motion(
        &mut self,
        q: &[f64],
        v: &mut [f64],
        frames: &[u32],
        unknowns: &[usize],
        motion: &RigidMotion,
    ) -> Result<f64, SystemError> {
        let a = vec![0.0; v.len()];
        let t = BEFORE_START;
        self.expand(Point { t, q, v, a: &a })?;
        let mut wanted = Vec::with_capacity(6 * frames.len());
        for node in frames.iter().map(|&n| NodeId(n)) {
            let arm = self.node_state(node).position - motion.about;
            let velocity = motion.velocity + motion.omega.cross(&arm);
            let both = velocity.iter().chain(motion.omega.iter()).enumerate();
            wanted.extend(both.map(|(k, rate)| (node, k, *rate)));
        }
        let (missing, _) = self.fit(q, v, unknowns, &wanted)?;
        Ok(missing.amax())
    }

    /// Unknowns of nodes: their own free coordinates, and those that they depend on.
    pub fn unknowns_behind(&self, nodes: &[NodeId]) -> Vec<usize> {
        let group: Vec<u32> = nodes.iter().map(|n| n.0).collect();
        let own = behind(&self.model.nodes, &self.state.maps, &group);
        let all = (own.iter()).flat_map(|&m| self.model.nodes[m as usize].range());
        let mut free: Vec<usize> = all.filter_map(|c| self.unknown_of(c)).collect();
        free.sort_unstable();
        free
    }

    /// Finds velocities `v` with given rates at `q` and [`BEFORE_START`]: of coordinates of joints, as (node, number of the
    /// coordinate, rate), and of frames, whose six rates are velocity and angular velocity (global components). The coordinates
    /// of their joints, and of their loops, change by the smallest change of all together, but for those of the unknowns
    /// `held`. Returns what is missing of each rate, relative to the largest (zero to rounding if joints and loops
    /// allow them), and the unknowns on which the rates depend.
    ///
    /// # Errors
    /// [`SystemError`] if the point is outside a chart.
    pub fn fit_coordinate_rates(
        &mut self,
        q: &[f64],
        v: &mut [f64],
        rates: &[(NodeId, usize, f64)],
        held: &[usize],
    ) -> Result<(Vec<f64>, Vec<usize>), SystemError> {
        let of = rates.iter().flat_map(|r| self.released_at(r.0));
        let mut unknowns = self.unknowns_behind(&of.collect::<Vec<_>>());
        unknowns.retain(|u| !held.contains(u));
        let (missing, columns) = self.fit(q, v, &unknowns, rates)?;
        let matter = |k: &usize| columns.column(*k).amax() > MISSING * columns.amax();
        let these = (0..unknowns.len()).filter(matter).map(|k| unknowns[k]);
        Ok((missing.iter().copied().collect(), these.collect()))
    }

    /// The coordinates of the joint that a frame is attached to, on a joint without any those of its parents; any other node
    /// itself.
    fn released_at(&self, node: NodeId) -> Vec<NodeId> {
        let nodes = &self.model.nodes;
        let n = &nodes[node.0 as usize];
        let n = match n.is_view() {
            true => &nodes[n.partner as usize],
            false => n,
        };
        let Some(d) = n.mapped().filter(|_| n.is_frame()) else {
            return vec![node];
        };
        let parents = d.parents(&self.state.maps).iter().map(|&m| NodeId(m));
        let (frames, released): (Vec<_>, Vec<_>) =
            parents.partition(|m| nodes[m.0 as usize].is_frame());
        match released.is_empty() {
            true => frames
                .into_iter()
                .flat_map(|m| self.released_at(m))
                .collect(),
            false => released,
        }
    }

    /// Adds the smallest change of the velocities of unknowns, in their sizes, that gives wanted rates by least squares; for
    /// the independent coordinates of a loop, all of the loop count. Returns what is still missing of the rates, relative to
    /// the largest, and their derivatives.
    fn fit(
        &mut self,
        q: &[f64],
        v: &mut [f64],
        unknowns: &[usize],
        wanted: &[(NodeId, usize, f64)],
    ) -> Result<(DVector<f64>, DMatrix<f64>), SystemError> {
        let (t, a) = (BEFORE_START, vec![0.0; v.len()]);
        let model = Arc::clone(&self.model);
        let nodes = (0..)
            .zip(&model.nodes.all)
            .filter(|(n, _)| model.loop_of(*n).is_some());
        let in_loops: Vec<usize> = nodes.flat_map(|(_, node)| node.range()).collect();
        // Velocities are compared with angular ones over the size of the model.
        let scaled = |&(node, k, rate): &(NodeId, usize, f64)| {
            rate / model.size(model.nodes[node.0 as usize].first + k)
        };
        let mut rates = |v: &[f64]| {
            self.expand(Point { t, q, v, a: &a })?;
            let mut all = DVector::zeros(wanted.len());
            for (out, &(node, k, _)) in all.iter_mut().zip(wanted) {
                *out = scaled(&(node, k, self.rate(node, k)));
                if !f64::is_finite(*out) {
                    let name = model.nodes[node.0 as usize].name();
                    let what = format!("the velocity of node {name}");
                    return Err(SystemError::NotFinite { what });
                }
            }
            let loops = in_loops.iter().map(|&c| self.work.v[c] / model.size(c));
            Ok((all, DVector::from_iterator(in_loops.len(), loops)))
        };
        let now = rates(v)?;
        let mut columns = DMatrix::zeros(wanted.len(), unknowns.len());
        let mut changes = DMatrix::zeros(in_loops.len(), unknowns.len());
        for (k, &u) in unknowns.iter().enumerate() {
            let own = v[u];
            v[u] += model.unit(u);
            let then = rates(v)?;
            columns.set_column(k, &(then.0 - &now.0));
            changes.set_column(k, &(then.1 - &now.1));
            v[u] = own;
        }
        let wanted = DVector::from_iterator(wanted.len(), wanted.iter().map(scaled));
        let mut missing = &wanted - &now.0;
        // Prescribed or locked coordinates keep their rates.
        if let Some(more) = smallest(&columns, &missing, &changes) {
            for (&u, more) in unknowns.iter().zip(more.iter()) {
                v[u] += more * model.unit(u);
            }
            missing -= &columns * more;
        }
        let size = wanted.amax().max(now.0.amax());
        Ok((missing / if size > 0.0 { size } else { 1.0 }, columns))
    }

    /// The rate of a coordinate; of a frame a component of its velocity or angular velocity.
    fn rate(&self, node: NodeId, k: usize) -> f64 {
        let n = &self.model.nodes[node.0 as usize];
        if !n.is_frame() {
            return self.work.v[n.first + k];
        }
        let state = self.node_state(node);
        [state.velocity, state.omega][k / 3][k % 3]
    }
}

/// The least squares solution of J x = b with the smallest change B x; columns of zeros in B count by themselves.
fn smallest(J: &DMatrix<f64>, b: &DVector<f64>, B: &DMatrix<f64>) -> Option<DVector<f64>> {
    if J.ncols() == 0 {
        return None;
    }
    let mut metric = B.tr_mul(B);
    for k in 0..J.ncols() {
        if metric[(k, k)] == 0.0 {
            metric[(k, k)] = 1.0;
        }
    }
    let L = metric.cholesky()?.unpack();
    let over = L.solve_lower_triangular(&J.transpose())?.transpose();
    L.tr_solve_lower_triangular(&shortest(over, b)?)
}

/// The shortest least squares solution of A x = b, by a complete orthogonal decomposition (Golub & Van Loan 2013, Matrix
/// Computations, section 5.5.2). The SVD of nalgebra errs where singular values are almost equal.
fn shortest(A: DMatrix<f64>, b: &DVector<f64>) -> Option<DVector<f64>> {
    let outer = A.col_piv_qr();
    let R = outer.r();
    let rank = (0..R.nrows()).filter(|&k| R[(k, k)].abs() > 1e-9).count();
    let mut c = b.clone();
    outer.q_tr_mul(&mut c);
    let inner = R.rows(0, rank).transpose().qr();
    let mut x = inner.q() * inner.r().tr_solve_upper_triangular(&c.rows(0, rank))?;
    outer.p().inv_permute_rows(&mut x);
    Some(x)
}
