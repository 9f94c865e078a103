//! Formulations of rotations: the rotational unknowns of a frame, and their rates.

use crate::blocks::three;
use crate::model::build::builder::{FRAME, ModelBuilder, NodeId};
use crate::model::kinematics::mapped_node::MappedNode;
use crate::model::{Context, Model, Node, NodeForm};
use crate::time::TimeFunction;
use nalgebra::{Matrix3, Vector3};
use pullback_manifold::chart::{Charted, RotationChart, WienerMilenkovic};
use pullback_manifold::map::{Increment, Map, Parametrization};
use pullback_manifold::so3::{self, Spin, VelocityKind};
use pullback_manifold::system::{Evaluation, Point, SystemError, Weights};
use std::collections::HashMap;
use std::sync::Arc;

/// Rotational unknowns of frames in a motion.
///
/// Applies to rotations that are free as a whole: those of frames with their own coordinates, and
/// of spherical and free joints. Rotations that are partly prescribed, or unknowns of a loop, stay total,
/// and angles are angles. Positions, velocities, forces and energies of a state are the same in all
/// formulations: only the sums of a time integration scheme differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Formulation {
    /// Total Lagrangian: the rotation vector Ψ from the reference orientation and its time
    /// derivatives (\[M04\] ch. 3).
    #[default]
    Total,
    /// Updated Lagrangian: the material rotation vector θ since the last step, R = Rₙ R(θ), and its
    /// time derivatives (Cardona & Géradin 1988, \[M04\] 3.3).
    Updated,
    /// Lie group: the rotation by θ, its rates by the material angular velocity Ω and its rate Ω̇
    /// (Brüls, Cardona & Arnold 2012; with Newmark's coefficients the material form of Simo &
    /// Vu-Quoc 1988).
    LieGroup,
    /// Spatial spins: the angular velocities ω and their rates ω̇ at both ends of a step, vectors of
    /// the tangent spaces at Rₙ and at Rₙ₊₁, are added in the fixed frame, and so is the spatial
    /// rotation vector of the step, Rₙ₊₁ = R(hωₙ + h²[…]) Rₙ. There is no transport between the two
    /// spaces, which \[M04\] 3.3 calls inconsistent with the manifold.
    SpatialSpins,
    /// Mixed spins: spatial ones with the material rates Ω̇ of both ends in body components, ωₙ₊₁ =
    /// ωₙ + h Rₙ[(1−γ) Ω̇ₙ + γ Ω̇ₙ₊₁]. Components in two frames are added without transport, which
    /// costs every scheme an order; for demonstration.
    MixedSpins,
    /// Total Lagrangian by the parameters of Wiener and Milenković, 4 tan(ψ/4) e, and their time
    /// derivatives ([`WienerMilenkovic`]).
    WienerMilenkovic,
}

/// The maps behind frames and behind rotations alone.
pub(in crate::model) type RotationMaps = [Box<dyn Parametrization>; 2];

impl Formulation {
    /// Its maps, unless rotation vectors are the unknowns.
    fn maps(self) -> Option<RotationMaps> {
        let by_velocities = |kind| -> Option<RotationMaps> {
            Some([
                Increment::<6>::with_velocities(kind).boxed(),
                Increment::<3>::with_velocities(kind).boxed(),
            ])
        };
        match self {
            Self::Total => None,
            Self::Updated => Some([
                Increment::<6>::default().boxed(),
                Increment::<3>::default().boxed(),
            ]),
            Self::LieGroup => by_velocities(VelocityKind::Material),
            Self::SpatialSpins => by_velocities(VelocityKind::Spatial),
            Self::MixedSpins => by_velocities(VelocityKind::Mixed),
            Self::WienerMilenkovic => Some(charted(WienerMilenkovic)),
        }
    }
}

fn charted(chart: impl RotationChart) -> RotationMaps {
    [
        Charted::<_, 6>::new(chart).boxed(),
        Charted::<_, 3>::new(chart).boxed(),
    ]
}

impl ModelBuilder {
    /// Selects the formulation of rotations; [`Formulation::Total`] by default.
    ///
    /// Initial coordinates, velocities and accelerations of a run are those of the total
    /// formulation in all of them (rotation vectors from the reference orientation, ψ < π): the
    /// first converged state centres the charts, and transforms them.
    ///
    /// Sums of spins ([`Formulation::LieGroup`], `SpatialSpins`, `MixedSpins`) are for schemes of one stage: those of
    /// several, such as Radau IIA, have order two at most with them.
    pub fn formulate(&mut self, formulation: Formulation) {
        self.rotations = formulation.maps();
    }

    /// Selects the chart of rotations, in the total formulation: rotation vectors by default. As with
    /// [`ModelBuilder::formulate`], initial values are those of rotation vectors.
    pub fn chart_rotations(&mut self, chart: impl RotationChart) {
        self.rotations = Some(charted(chart));
    }
}

/// Adds the unknowns behind the frames.
pub(in crate::model) fn apply(
    rotations: Option<RotationMaps>,
    nodes: &mut Vec<Node>,
    prescribed: &mut [(NodeId, usize, Arc<dyn TimeFunction>)],
) {
    let Some([of_frames, alone]) = rotations else {
        return;
    };
    let turns =
        |node: &Node| matches!(node.form, NodeForm::Frame | NodeForm::Rotation) && node.is_own();
    let mut turning: Vec<bool> = nodes.iter().map(turns).collect();
    for (n, k, _) in &*prescribed {
        // A rotation with a held component stays total.
        let held = |n: &Node| *k >= n.dim.saturating_sub(3);
        if nodes.get(n.0 as usize).is_some_and(held) {
            turning[n.0 as usize] = false;
        }
    }
    let mut carriers = HashMap::new();
    for n in (0..nodes.len()).filter(|&n| turning[n]) {
        let node = &nodes[n];
        let own = nodes.len() as u32;
        let map = match node.dim {
            FRAME => of_frames.clone(),
            _ => alone.clone(),
        };
        let (name, quantities) = (node.name.clone(), node.quantities.clone());
        nodes.push(Node::new(name, NodeForm::Increment, &quantities, None));
        nodes[n].map = Some(MappedNode::of(map, vec![own]));
        carriers.insert(NodeId(n as u32), NodeId(own));
    }
    for (n, ..) in prescribed {
        *n = carriers.get(n).copied().unwrap_or(*n);
    }
}

/// The node behind a frame or a rotation by increments.
fn behind(nodes: &[Node], node: &Node) -> Option<usize> {
    let first = *node.mapped()?.initial_parents().first()? as usize;
    (nodes[first].form == NodeForm::Increment).then_some(first)
}

/// The frames and rotations by increments.
pub(in crate::model) fn turning(nodes: &[Node]) -> impl Iterator<Item = u32> + '_ {
    (0..nodes.len() as u32).filter(|&n| behind(nodes, &nodes[n as usize]).is_some())
}

impl Model {
    /// The node with the unknowns of a node: the increments behind a frame, or the node itself.
    pub(in crate::model) fn carrier<'a>(&'a self, node: &'a Node) -> &'a Node {
        behind(&self.nodes, node).map_or(node, |own| &self.nodes[own])
    }

    /// Number of rotations whose unknowns are not the rotation vector ([`Formulation`]).
    pub fn increments(&self) -> usize {
        self.spin_frames.len()
    }
}

/// Rates of the three unknowns θ of a rotation with the angular velocity ω, where Ψ̇ = B θ̇ for the map
/// behind it, if there is one.
pub(in crate::model) fn rotation_rate(
    map: Option<&mut Box<dyn Parametrization>>,
    theta: &Vector3<f64>,
    omega: &Vector3<f64>,
) -> Vector3<f64> {
    let Some(map) = map else {
        return so3::tangent_inverse(theta).tr_mul(omega);
    };
    let n = map.dims().0;
    let (mut q, mut x, mut operator) = ([0.0; FRAME], [0.0; FRAME], [0.0; FRAME * FRAME]);
    q[n - 3..n].copy_from_slice(theta.as_slice());
    map.tangent(0.0, &q[..n], &mut x[..n], &mut operator[..n * n]);
    let psi = three(&x, n - 3);
    let Omega = so3::rotation(&psi).tr_mul(omega);
    let velocities = map.reparametrization();
    match velocities.and_then(|map| map.velocity_kind()) {
        None => {
            let B = Matrix3::from_fn(|i, j| operator[(n - 3 + j) * n + n - 3 + i]);
            let psi_dot = so3::tangent_inverse(&psi).tr_mul(omega);
            // B is regular within a chart.
            B.lu().solve(&psi_dot).unwrap_or(psi_dot)
        }
        Some(VelocityKind::Material) => Omega,
        Some(VelocityKind::Spatial | VelocityKind::Mixed) => so3::rotation(theta) * Omega,
    }
}

impl Context {
    /// Number of assemblies of residual or tangent so far: one per evaluation, three for a tangent
    /// if rates are angular velocities.
    pub fn assemblies(&self) -> usize {
        self.work.assemblies
    }

    /// Whether any rates are angular velocities at present.
    pub(in crate::model) fn has_spins(&mut self) -> bool {
        let mut frames = 0..self.model.spin_frames.len();
        frames.any(|k| self.spin_coordinates(self.model.spin_frames[k]).is_some())
    }

    /// The first of the coordinates θ behind a frame whose rates are angular velocities at present, the
    /// frame's increments, and the kind of velocity.
    fn spin_coordinates(&mut self, n: u32) -> Option<(usize, u32, VelocityKind)> {
        let d = self.model.nodes[n as usize].mapped()?;
        let own = d.parents(&self.state.maps)[0];
        let end = self.model.spans[own as usize].range().end;
        let kind = self.state.maps[d.index]
            .reparametrization()?
            .velocity_kind()?;
        Some((end - 3, own, kind))
    }

    /// Converts angular velocities to the rates of their rotation vectors, in the workspace.
    pub(in crate::model) fn take_spins(&mut self) {
        for k in 0..self.model.spin_frames.len() {
            let Some((theta, _, kind)) = self.spin_coordinates(self.model.spin_frames[k]) else {
                continue;
            };
            let w = &mut self.work;
            let [x, v, a] = [&w.x, &w.v, &w.a].map(|x| three(x, theta));
            let rates = Spin::rates(kind, &x, &v, &a);
            w.v[theta..theta + 3].copy_from_slice(rates.theta_dot.as_slice());
            w.a[theta..theta + 3].copy_from_slice(rates.theta_ddot.as_slice());
        }
    }

    /// The residual and the tangent if rates are angular velocities.
    ///
    /// With θ̇ and θ̈ as functions of (θ, Ω, Ω̇), and δθ̇, δθ̈ along δθ = cK e, δΩ = cC e, δΩ̇ = cM e
    /// ([`Spin::varied`]), the columns of θ are cK K + C (∂θ̇/∂e) + M (∂θ̈/∂e): those for rates of
    /// coordinates plus the differences of these derivatives to cC and cM. Rows stay those of θ, so
    /// M is symmetric at θ = 0 only.
    pub(in crate::model) fn evaluate_spinning(
        &mut self,
        at: Point<'_>,
        r: &mut [f64],
        (weights, S): (Weights, &mut [f64]),
        r_t: Option<&mut [f64]>,
    ) -> Result<(), SystemError> {
        let mut parts = std::mem::take(&mut self.work.parts);
        let mut outcome = Ok(());
        for (part, weights) in parts.iter_mut().zip([Weights::DAMPING, Weights::MASS]) {
            part.resize(S.len(), 0.0);
            outcome = outcome
                .and_then(|()| self.assemble(at, Evaluation::with_tangent(r, weights, part)));
        }
        let whole = Evaluation {
            r_t,
            ..Evaluation::with_tangent(r, weights, S)
        };
        outcome = outcome.and_then(|()| self.assemble(at, whole));
        if outcome.is_ok() {
            self.turn_columns(weights, &parts, S);
        }
        self.work.parts = parts;
        outcome
    }

    fn turn_columns(&mut self, weights: Weights, [C, M]: &[Vec<f64>; 2], S: &mut [f64]) {
        for k in 0..self.model.spin_frames.len() {
            let Some((theta, own, kind)) = self.spin_coordinates(self.model.spin_frames[k]) else {
                continue;
            };
            let w = &self.work;
            let rates = Spin {
                kind,
                theta_dot: three(&w.v, theta),
                theta_ddot: three(&w.a, theta),
            };
            let numbers = [weights.K, weights.C, weights.M];
            let [mut first, mut second] = rates.varied(numbers, &three(&w.x, theta));
            for k in 0..3 {
                first[(k, k)] -= weights.C;
                second[(k, k)] -= weights.M;
            }
            let block = self.work.scatter_map.blocks[own as usize] as usize;
            let offset = self.work.scatter_map.rows[theta] as usize;
            for (i, values) in self.model.pattern.column(block) {
                let height = self.model.pattern.size(i);
                for c in 0..3 {
                    let to = values.start + (offset + c) * height;
                    for k in 0..3 {
                        let from = values.start + (offset + k) * height;
                        let (x, y) = (first[(k, c)], second[(k, c)]);
                        for row in 0..height {
                            S[to + row] += C[from + row] * x + M[from + row] * y;
                        }
                    }
                }
            }
        }
    }
}
