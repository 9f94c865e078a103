//! Assembly into a pattern that is found once.

use crate::blocks::three;
use crate::element::ONE_TURN;
use crate::model::Context;
use crate::model::assembly::scatter::ScatterTarget;
use crate::model::kinematics::free_coordinates::check_length;
use crate::model::kinematics::node_entries::distribute;
use pullback_manifold::domain::DomainError;
use pullback_manifold::system::{Evaluation, Point, System, SystemError, Weights};

/// Largest number of nodes of an element.
pub(in crate::model) const MAX_NODES: usize = 16;

/// A force that counts as a rounding error, relative to those of which it is the sum.
const ROUNDING: f64 = 1e-12;

impl Context {
    /// Writes coordinates (and velocities, accelerations if given) of all nodes at a point to the
    /// workspace: own nodes first, then mapped ones. Nothing is evaluated if they are known.
    pub(in crate::model) fn expand(&mut self, at: Point<'_>) -> Result<(), SystemError> {
        self.take_inputs();
        if !self.work.known.is(at) {
            self.expand_own(at)?;
            self.expand_dependent(at.t)?;
            self.work.known.set(at);
        }
        Ok(())
    }

    /// The part of [`expand`](Self::expand) for nodes that are not mapped, with the present inputs.
    pub(in crate::model) fn expand_own(&mut self, at: Point<'_>) -> Result<(), SystemError> {
        let statics = at.is_static();
        let (w, inputs) = (&mut self.work, &self.state.inputs);
        w.t = at.t;
        w.known.forget();
        let stirred = std::mem::replace(&mut w.stirred, !statics);
        if !statics {
            self.model.scatter("velocities v", at.v, &mut w.v)?;
            self.model.scatter("accelerations a", at.a, &mut w.a)?;
        } else if stirred {
            w.v.fill(0.0);
            w.a.fill(0.0);
        }
        self.model.scatter("coordinates q", at.q, &mut w.x)?;
        for p in &self.model.prescribed {
            // In statics the velocity of a prescribed coordinate is its derivative by the load
            // parameter; that of free coordinates stays zero.
            let c = p.coordinate;
            let motion = p.function.at(at.t, inputs);
            if !motion.iter().all(|x| x.is_finite()) {
                let what = format!("the prescribed motion of {}", self.model.coordinate_name(c));
                return Err(SystemError::NotFinite { what });
            }
            [w.x[c], w.v[c], w.a[c]] = motion;
        }
        for (&node, &turns) in (self.model.prescribed_rotations.iter()).zip(&self.state.turns) {
            let first = self.model.nodes[node].first + 3;
            crate::model::kinematics::complement::fold(
                turns,
                &mut w.x[first..first + 3],
                &mut w.v[first..first + 3],
                &mut w.a[first..first + 3],
            );
        }
        if w.stirred {
            self.take_spins();
        }
        Ok(())
    }

    /// Takes the rates by the load parameter from all that is prescribed at a static point.
    fn rest(&mut self) {
        let w = &mut self.work;
        w.known.forget();
        w.v.fill(0.0);
        w.a.fill(0.0);
        w.operators[1..].iter_mut().for_each(|B| B.fill(0.0));
    }

    /// Takes the present inputs, on which all may depend.
    pub(in crate::model) fn take_inputs(&mut self) {
        let (w, inputs) = (&mut self.work, &self.state.inputs);
        if w.local.inputs != *inputs {
            w.local.inputs.clone_from(inputs);
            w.dead_loads.t = None;
            w.known.forget();
        }
    }

    /// Sets residual and scales to those of the dead loads.
    fn begin_with_dead_loads(&mut self, t: f64) -> Result<(), SystemError> {
        let (w, model) = (&mut self.work, &*self.model);
        if w.dead_loads.t != Some(t) {
            w.dead_loads.t = None;
            w.dead_loads.r.fill(0.0);
            w.scales.force = [0.0; 3];
            let moved = (&model.unknowns[..], &w.scatter_map.couplings);
            for (e, state) in model.elements.iter().zip(&self.state.elements) {
                if !e.dead {
                    continue;
                }
                let local = &mut w.local;
                local
                    .evaluate((e, state), t, true, None, false, false)
                    .map_err(|error| named(error, &e.name))?;
                if e.load {
                    local.measure(e, &model.nodes, moved, &mut w.scales);
                }
                local.add_residual(e, &model.spans, &mut w.dead_loads.r);
            }
            w.dead_loads.force = w.scales.force;
            w.dead_loads.t = Some(t);
        }
        w.r.copy_from_slice(&w.dead_loads.r);
        w.scales.force = w.dead_loads.force;
        Ok(())
    }

    /// Adds all elements (without dead loads, unless rates are requested): residuals to the nodes,
    /// tangents to `S`.
    pub(in crate::model) fn add_elements(
        &mut self,
        t: f64,
        statics: bool,
        mut S: Option<(Weights, &mut [f64])>,
        rates: bool,
    ) -> Result<(), SystemError> {
        let (w, model) = (&mut self.work, &*self.model);
        let (local, spans) = (&mut w.local, &model.spans);
        w.exerted.force = [0.0; 3];
        let moved = (&model.unknowns[..], &w.scatter_map.couplings);
        let unloaded = w.scales.force == [0.0; 3];
        let last = &self.state.element_charts.now;
        for (k, (e, state)) in (model.elements.iter().zip(&self.state.elements)).enumerate() {
            let rotation = |n: usize| three(&w.x, model.nodes[n].first + 3);
            if state.overturned || last.passed_zero(e, state.switched, rotation) {
                let (limit, margin) = (ONE_TURN, 0.0);
                return Err(named(DomainError::Beyond { limit, margin }, &e.name));
            }
            if !rates && e.dead {
                continue;
            }
            let n = e.element.dim();
            // Corrections are linear in the unknowns, not in what is mapped from them.
            let previous = w.has_previous && !e.mapped;
            if !e.dead {
                if previous {
                    local.read_previous((e, state), spans, &w.previous);
                }
                local.read((e, state), spans, [&w.x, &w.v, &w.a]);
            }
            let S = S.as_mut().filter(|_| !e.dead);
            let weights = S.as_ref().map(|(weights, _)| *weights);
            local
                .evaluate((e, state), t, statics, weights, rates, previous)
                .map_err(|error| named(error, &e.name))?;
            if let Some(h) = w.acceleration_step {
                local.raise_to_accelerations(e, state.left_out, t, h);
            }
            if e.load {
                local.measure(e, &model.nodes, moved, &mut w.scales);
            } else if unloaded {
                local.measure(e, &model.nodes, moved, &mut w.exerted);
            }
            if rates && !e.dead {
                // ∂r/∂t through the nodes' motion at fixed unknowns: −K ẋ.
                for (j, &v) in local.v[..n].iter().enumerate() {
                    if v != 0.0 {
                        for (r, K) in local.r_t[..n].iter_mut().zip(&local.K[j * n..(j + 1) * n]) {
                            *r -= K * v;
                        }
                    }
                }
            }
            let tangents = match weights.is_some() || rates {
                true if statics => 1,
                true => 3,
                false => 0,
            };
            local.pull_back((e, state), spans, tangents, rates);
            local.add_residual(e, spans, &mut w.r);
            if e.load && e.dependent_coordinates {
                local.add_residual(e, spans, &mut w.direct);
            }
            if rates && local.r_t[..n].iter().any(|r| *r != 0.0) {
                distribute(&e.nodes, spans, &local.r_t, &mut w.r_t);
            }
            let Some((weights, values)) = S else {
                continue;
            };
            if !e.mapped {
                local.combine((e, state), *weights, [statics, rates]);
                w.scatter_map.scatter(k, e, spans, &local.S, values);
                continue;
            }
            let mut into = ScatterTarget::new(values, &mut w.coupled, weights, statics);
            let tangents = local.tangents(e);
            w.scatter_map
                .scatter_mapped(k, e, &model.nodes, tangents, &mut into);
        }
        Ok(())
    }

    fn measure_reactions(&mut self) {
        let w = &mut self.work;
        let force = &mut w.scales.force;
        for p in &self.model.prescribed {
            let quantity = self.model.quantities[p.coordinate].index();
            let passed_on = w.r[p.coordinate] - w.direct[p.coordinate];
            force[quantity] = force[quantity].max(passed_on.abs());
        }
        // Where neither loads nor supports act, as on a rotor in balance, elements are measured by the forces that they
        // exert on each other.
        let mut pairs = force.iter().zip(w.exerted.measures());
        if pairs.all(|(force, exerted)| *force <= ROUNDING * exerted) {
            *force = w.exerted.force;
        }
    }

    /// The residual and the tangent for rates of coordinates.
    pub(in crate::model) fn assemble(
        &mut self,
        at: Point<'_>,
        out: Evaluation<'_>,
    ) -> Result<(), SystemError> {
        let rates = out.r_t.is_some();
        self.work.assemblies += 1;
        let Evaluation { r, mut S, r_t, .. } = out;
        let mut statics = at.is_static();
        let mut rests = false;
        if let Some((weights, values)) = &S {
            check_length("tangent S", self.model.pattern.len(), values.len())?;
            rests = statics && !weights.is_static();
            statics &= !rests;
        }
        self.check_left_out()?;
        self.enter_element_charts();
        self.expand(at)?;
        if rests {
            self.rest();
        }
        if rates {
            self.work.r.fill(0.0);
            self.work.r_t.fill(0.0);
            self.work.scales.force = [0.0; 3];
        } else {
            self.begin_with_dead_loads(at.t)?;
        }
        for p in &self.model.prescribed {
            let (c, w) = (p.coordinate, &mut self.work);
            w.direct[c] = w.r[c];
        }
        if let Some((_, values)) = &mut S {
            self.work.scatter_map.clear_unwritten(values);
            self.work.coupled.fill(0.0);
        }
        let borrow = S.as_mut().map(|(w, values)| (*w, &mut **values));
        self.add_elements(at.t, statics, borrow, rates)?;
        self.pull_back_nodes(at.t, S, [statics, rates]);
        self.measure_reactions();
        self.model.gather(&self.work.r, "residual r", r)?;
        if let Some(u) = r.iter().position(|r| !r.is_finite()) {
            return Err(SystemError::NotFinite { what: self.name(u) });
        }
        if let Some(r_t) = r_t {
            self.model.gather(&self.work.r_t, "rate r_t", r_t)?;
        }
        Ok(())
    }
}

pub(in crate::model) fn named(why: DomainError, name: &str) -> SystemError {
    let what = format!("element {name}");
    SystemError::Domain { what, why }
}
