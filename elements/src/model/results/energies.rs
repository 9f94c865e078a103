//! Energies, powers and momenta of a model.

use crate::model::assembly::element_workspace::ElementWorkspace;
use crate::model::assembly::residual::named;
use crate::model::assembly::workspace::Workspace;
use crate::model::kinematics::mapped_node::Maps;
use crate::model::kinematics::pose::spatial;
use crate::model::results::symmetry::{Measured, motion_of};
use crate::model::{Context, ElementEntry, Model, Node};
use nalgebra::Vector3;
use pullback_manifold::system::{Energetics, Energies, Point, RigidRates, Symmetry, SystemError};

/// Linear and angular momentum, components in the global frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Momentum {
    /// Linear momentum.
    pub linear: Vector3<f64>,
    /// Angular momentum about the origin.
    pub angular: Vector3<f64>,
}

/// Energies, powers and momenta of a model at one point of a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergiesAndMomentum {
    /// Kinetic and stored energy, supplied and dissipated power.
    pub energies: Energies,
    /// Potential of the loads that have one (gravity, constant forces). Their power is also part of
    /// the supplied power.
    pub load_potential: f64,
    /// Momentum of all mass.
    pub momentum: Momentum,
}

impl Momentum {
    /// Adds the momentum of an element with coordinates `x` and generalised momenta `p`.
    fn add(&mut self, e: &ElementEntry, nodes: &[Node], x: &[f64], p: &[f64]) {
        let mut k = 0;
        for node in e.nodes.iter().map(|&n| &nodes[n as usize]) {
            if node.is_frame() {
                let (x, p) = (&x[k..k + node.dim], &p[k..k + node.dim]);
                let [linear, spin] = spatial(node, x, p);
                let d = Vector3::new(x[0], x[1], x[2]);
                self.linear += linear;
                self.angular += (node.position + d).cross(&linear) + spin;
            }
            k += node.dim;
        }
    }
}

impl Energetics for Context {
    fn energies(&mut self, at: Point<'_>) -> Result<Energies, SystemError> {
        self.enter_element_charts();
        Ok(self.evaluate_energies(at, false)?.energies)
    }

    /// Without forces and mass matrices.
    fn dissipation(&mut self, at: Point<'_>) -> Result<f64, SystemError> {
        self.enter_element_charts();
        self.expand(at)?;
        let (w, model) = (&mut self.work, &*self.model);
        let mut dissipated = 0.0;
        for (e, state) in model.elements.iter().zip(&self.state.elements) {
            let Some(energies) = e.element.abilities().energies.filter(|_| !e.load) else {
                continue;
            };
            let local = &mut w.local;
            local.read((e, state), &model.spans, [&w.x, &w.v, &w.a]);
            dissipated += energies.dissipation(&local.motion(e, at.t, at.is_static()));
        }
        Ok(dissipated)
    }

    /// p = Bᵀ M ẋ; false without prescribed and mapped coordinates, as it cannot jump then.
    fn momentum(&mut self, at: Point<'_>, p: &mut [f64]) -> Result<bool, SystemError> {
        if self.model.prescribed.is_empty() && self.model.nodes.mapped.is_empty() {
            return Ok(false);
        }
        self.node_momenta(at)?;
        self.pull_back_nodes(at.t, None, [false; 2]);
        self.model.gather(&self.work.r, "momentum p", p)?;
        Ok(true)
    }

    /// A state that cannot be evaluated has none.
    fn symmetries(&mut self, span: [f64; 2], q: &[f64], v: &[f64]) -> Vec<Symmetry> {
        Measured(self).symmetries(span, q, v).unwrap_or_default()
    }

    fn keep_symmetries(&mut self, at: Point<'_>, found: &mut Vec<Symmetry>) {
        if !found.is_empty() && Measured(self).keep(at, found).is_err() {
            found.clear();
        }
    }

    /// Joint coordinates have constant rates.
    fn rigid_rates(&mut self, q: &[f64], motion: &RigidRates, rates: &mut [f64]) {
        rates.fill(0.0);
        self.set_velocity(q, rates, None, &motion_of(motion));
        for (xi, released) in motion.iter().zip(&self.work.released) {
            for (rate, released) in rates.iter_mut().zip(released) {
                *rate += xi * released;
            }
        }
    }
}

impl Context {
    /// Energies, powers and momenta at a point in motion.
    ///
    /// They follow from the elements' forces and mass matrices: the generalised momentum is p = M
    /// ẋ, the kinetic energy ½ ẋ·p, and a load's power r·ẋ. A support supplies −r ẋ at its
    /// prescribed coordinate, a time-dependent map −r·∂φ/∂t.
    ///
    /// # Errors
    /// [`SystemError`] if the point is outside a chart.
    pub fn energies_and_momentum(
        &mut self,
        at: Point<'_>,
    ) -> Result<EnergiesAndMomentum, SystemError> {
        self.evaluate_energies(at, true)
    }

    /// The same, with zero momentum unless `momenta`.
    pub(in crate::model) fn evaluate_energies(
        &mut self,
        at: Point<'_>,
        momenta: bool,
    ) -> Result<EnergiesAndMomentum, SystemError> {
        let statics = at.is_static();
        self.expand(at)?;
        let mut out = EnergiesAndMomentum::default();
        let energies = &mut out.energies;
        let (w, model) = (&mut self.work, &*self.model);
        w.r.fill(0.0);
        for (e, state) in model.elements.iter().zip(&self.state.elements) {
            let (local, n) = (&mut w.local, e.element.dim());
            local.read((e, state), &model.spans, [&w.x, &w.v, &w.a]);
            let (abilities, motion) = (e.element.abilities(), local.motion(e, at.t, statics));
            let energy = abilities.energy(&motion);
            if e.load {
                out.load_potential += energy;
                if e.time_independent {
                    energies.potential += energy;
                }
            } else {
                energies.stored += energy;
            }
            if !statics {
                let lost = (!e.load).then(|| abilities.dissipation(&motion));
                energies.dissipated += lost.unwrap_or(0.0);
                // Its force is only needed at prescribed and mapped nodes.
                let known = (!momenta && !e.load && !e.dependent_coordinates)
                    .then(|| abilities.kinetic_energy(&motion));
                if let Some(energy) = known.flatten() {
                    energies.kinetic += energy;
                    continue;
                }
            }
            local
                .momenta((e, state), at.t, statics)
                .map_err(|error| named(error, &e.name))?;
            if !statics {
                let ElementWorkspace { x, v, r, work, .. } = local;
                if e.load {
                    let power = dot(&r[..n], v);
                    energies.supplied += power;
                    if e.time_independent {
                        energies.drawn += power;
                    }
                }
                energies.kinetic += 0.5 * dot(&work[..n], v);
                if momenta {
                    out.momentum.add(e, &model.nodes, x, work);
                }
            }
            local.pull_back((e, state), &model.spans, 0, false);
            local.add_residual(e, &model.spans, &mut w.r);
        }
        self.pull_back_nodes(at.t, None, [false; 2]);
        if !statics {
            out.energies.supplied += supplied_at_nodes(&self.model, &self.state.maps, &self.work);
        }
        Ok(out)
    }

    /// Writes the momenta M ẋ of all nodes to the residuals.
    pub(in crate::model) fn node_momenta(&mut self, at: Point<'_>) -> Result<(), SystemError> {
        self.expand(at)?;
        let (w, model) = (&mut self.work, &*self.model);
        w.r.fill(0.0);
        for (e, state) in model.elements.iter().zip(&self.state.elements) {
            if e.load {
                continue;
            }
            let local = &mut w.local;
            local.read((e, state), &model.spans, [&w.x, &w.v, &w.a]);
            local
                .momenta((e, state), at.t, false)
                .map_err(|error| named(error, &e.name))?;
            let n = e.element.dim();
            local.r[..n].copy_from_slice(&local.work[..n]);
            if let Some(enforced) = e.multiplied() {
                // The momentum of a multiplier is the rate of its equation.
                let (N, M) = enforced.dims();
                let mut levels = std::mem::take(&mut local.levels);
                enforced.levels(&local.motion(e, at.t, false), &mut levels);
                for i in (0..M).filter(|i| state.left_out & (1 << i) == 0) {
                    local.r[N + i] = levels.h_dot[i];
                }
                local.levels = levels;
            }
            local.pull_back((e, state), &model.spans, 0, false);
            local.add_residual(e, &model.spans, &mut w.r);
        }
        Ok(())
    }
}

/// The power of supports and of time-dependent maps in the forces last pulled back.
fn supplied_at_nodes(model: &Model, maps: &Maps, w: &Workspace) -> f64 {
    let mut supplied = 0.0;
    for p in &model.prescribed {
        supplied -= w.r[p.coordinate] * w.v[p.coordinate];
    }
    for (_, node, d) in model.nodes.mapped() {
        let own = node.range();
        let r = &w.r[own.clone()];
        let through = d.carried_power(d.parents(maps), r, &model.spans, &w.v, &w.operators);
        supplied -= dot(r, &w.v[own]) - through;
    }
    supplied
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
