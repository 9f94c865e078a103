//! Equations that elements enforce on a model ([`Enforced`](crate::constraint::Enforced)).

use crate::constraint::{Levels, MAX_EQUATIONS};
use crate::model::assembly::element_workspace::ElementWorkspace;
use crate::model::kinematics::node_entries::collect;
use crate::model::{Context, ElementEntry, Model, NodeForm};
use nalgebra::{DMatrix, DVector};
use pullback_manifold::domain::DomainError;
use pullback_manifold::system::{Point, SystemError};
use std::sync::Arc;

/// Residual of an omitted equation beyond which it does not follow from the others.
const LOOSE: f64 = 1e-8;
/// Part of the gradient of an equation by coordinates of nodes below which one by unknowns or prescribed coordinates is
/// rounding: both ends of a loop move alike.
const ROUNDING: f64 = 1e-12;
/// Limit of an omitted equation, in messages.
const FOLLOWED: &str = "zero, though it followed from the other equations at the start: that was a \
                        singular position; start in another one";

/// The same if it depends on a prescribed motion.
const OVERPRESCRIBED: &str = "zero, as the prescribed motions ask for what the linkage does not allow: \
                              prescribe no more than is free";

/// All enforced equations, with their derivatives by the unknowns.
pub(in crate::model) struct EnforcedEquations {
    pub(in crate::model) h: DVector<f64>,
    pub(in crate::model) h_dot: DVector<f64>,
    /// Derivatives: a row per equation, a column per scaled unknown.
    pub(in crate::model) J: DMatrix<f64>,
    /// The same by the prescribed coordinates.
    pub(in crate::model) prescribed: DMatrix<f64>,
    /// Largest derivative of each equation by a scaled coordinate of a node.
    pub(in crate::model) sizes: Vec<f64>,
    /// Element of each equation, and its index there.
    pub(in crate::model) of: Vec<(usize, usize)>,
}

impl Model {
    /// Whether elements enforce equations on the coordinates: multipliers, penalties.
    pub fn is_enforced(&self) -> bool {
        !self.enforced.is_empty()
    }

    /// Whether multipliers are among the unknowns: the equations of motion are then
    /// differential-algebraic ones of index 3.
    pub fn has_multipliers(&self) -> bool {
        self.nodes.iter().any(|n| n.form == NodeForm::Multipliers)
    }

    /// The default initial coordinates: zero, the model as drawn, but with loops closed by
    /// multipliers or penalties assembled.
    pub fn initial(&self) -> &[f64] {
        &self.initial
    }

    /// Typical size of an unknown.
    pub(in crate::model) fn unit(&self, u: usize) -> f64 {
        self.pattern.coordinates()[u].size
    }

    /// Typical size of a coordinate.
    pub(in crate::model) fn size(&self, coordinate: usize) -> f64 {
        self.quantities[coordinate].size(self.length)
    }

    /// The prescribed coordinates.
    pub(in crate::model) fn prescribed(&self) -> impl Iterator<Item = usize> + '_ {
        let prescribed = self
            .prescribed
            .iter()
            .filter(|p| p.function.constant() != Some(0.0));
        prescribed.map(|p| p.coordinate)
    }
}

impl Context {
    /// Largest residual |h| of the loop equations relative to their sizes, in the configuration
    /// last set: of implicit maps, multipliers and penalties. `None` for a model without them.
    pub fn violation(&mut self) -> Option<f64> {
        // Not a number is the worst.
        let worse = |a: Option<f64>, b: f64| match a {
            Some(a) if a >= b || a.is_nan() => Some(a),
            _ => Some(b),
        };
        let mut worst = None;
        for (_, _, d) in self.model.nodes.mapped() {
            let mut q = vec![0.0; d.direct];
            let parents = d.parents(&self.state.maps);
            collect(parents, &self.model.spans, &self.work.x, &mut q);
            if let Some(map) = self.state.maps[d.index].implicit() {
                worst = worse(worst, map.violation(self.work.t, &q));
            }
        }
        let model = Arc::clone(&self.model);
        let residuals = model.enforced.iter().flat_map(|&k| self.residuals(k));
        residuals.fold(worst, |worst, h| worse(worst, h.abs()))
    }

    /// The equations that an element enforces, in the configuration last set; zero beyond them.
    fn residuals(&mut self, k: usize) -> [f64; MAX_EQUATIONS] {
        let (e, state, w) = (
            &self.model.elements[k],
            &self.state.elements[k],
            &mut self.work,
        );
        let mut h = [0.0; MAX_EQUATIONS];
        if let Some(enforced) = e.element.abilities().enforced {
            w.local
                .read((e, state), &self.model.spans, [&w.x, &w.v, &w.a]);
            let (_, M) = enforced.dims();
            enforced.residual(&w.local.motion(e, w.t, true), &mut h[..M]);
        }
        h
    }

    /// All equations at a state; without velocities at rest.
    pub(in crate::model) fn equations(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
    ) -> Result<EnforcedEquations, SystemError> {
        let a = vec![0.0; v.len()];
        self.expand(Point { t, q, v, a: &a })?;
        let n = q.len();
        let (mut h, mut h_dot, mut of) = (vec![], vec![], vec![]);
        let mut levels = Levels::default();
        let (mut rows, mut prescribed, mut sizes) = (vec![], vec![], vec![]);
        let model = Arc::clone(&self.model);
        for &k in &model.enforced {
            let (e, state) = (&model.elements[k], self.state.elements[k]);
            let w = &mut self.work;
            w.local.read((e, &state), &model.spans, [&w.x, &w.v, &w.a]);
            let motion = w.local.motion(e, t, !w.stirred);
            let Some(enforced) = e.element.abilities().enforced else {
                continue;
            };
            let (N, M) = enforced.dims();
            enforced.levels(&motion, &mut levels);
            h.extend(&levels.h);
            h_dot.extend(&levels.h_dot);
            for i in 0..M {
                of.push((k, i));
                let w = &mut self.work;
                w.r.fill(0.0);
                w.local.r[..e.element.dim()].fill(0.0);
                for j in 0..N {
                    w.local.r[j] = levels.J[i + j * M];
                }
                w.local.pull_back((e, &state), &model.spans, 0, false);
                w.local.add_residual(e, &self.model.spans, &mut w.r);
                let scaled = w.r.iter().enumerate().map(|(c, r)| r * self.model.size(c));
                let size = scaled.fold(0.0, |a: f64, x| a.max(x.abs()));
                sizes.push(size);
                self.pull_back_nodes(t, None, [false; 2]);
                let scaled = |c: usize| {
                    let slope = self.work.r[c] * self.size(c);
                    if slope.abs() > ROUNDING * size {
                        slope
                    } else {
                        0.0
                    }
                };
                rows.extend(self.model.coordinates.iter().map(|&c| scaled(c)));
                prescribed.extend(self.prescribed().map(scaled));
            }
        }
        Ok(EnforcedEquations {
            J: DMatrix::from_row_slice(of.len(), n, &rows),
            prescribed: DMatrix::from_row_slice(of.len(), self.prescribed().count(), &prescribed),
            sizes,
            h: DVector::from_vec(h),
            h_dot: DVector::from_vec(h_dot),
            of,
        })
    }

    /// Checks at a converged state whether the omitted equations still follow from the others.
    pub(in crate::model) fn watch_left_out(&mut self) {
        if self.state.unwatched {
            return;
        }
        let model = Arc::clone(&self.model);
        for &k in &model.enforced {
            let left_out = self.state.elements[k].left_out;
            if left_out != 0 {
                let h = self.residuals(k);
                let off = |i: &usize| left_out & (1 << i) != 0 && h[*i].abs() > LOOSE;
                self.state.elements[k].violated = (0..h.len()).find(off).map(|i| (i, h[i]));
            }
        }
    }

    /// Fails if an omitted equation is violated.
    pub(in crate::model) fn check_left_out(&self) -> Result<(), SystemError> {
        for &k in &self.model.enforced {
            let e = &self.model.elements[k];
            if let Some((i, h)) = self.state.elements[k].violated {
                let what = format!("{} of element {}", e.equation(i), e.name);
                let prescribed = self
                    .state
                    .overprescribed
                    .iter()
                    .find(|(of, _)| *of == (k, i));
                let (limit, what) = match prescribed {
                    None => (FOLLOWED, what),
                    Some((_, names)) => (OVERPRESCRIBED, format!("{what} (prescribed: {names})")),
                };
                let margin = -h.abs();
                let why = DomainError::Beyond { limit, margin };
                return Err(SystemError::Domain { what, why });
            }
        }
        Ok(())
    }

    /// Report on the redundant ones of the equations that an element enforces.
    pub(in crate::model) fn describe_left_out(&self, k: u32) -> Option<String> {
        let e = &self.model.elements[k as usize];
        let left_out = self.state.elements[k as usize].left_out;
        let bits = (0..MAX_EQUATIONS).filter(|i| left_out & (1 << i) != 0);
        let names: Vec<String> = bits.map(|i| e.equation(i)).collect();
        (!names.is_empty()).then(|| format!("redundant: {}", names.join(", ")))
    }
}

impl ElementWorkspace {
    /// Converts the equations of an element to the level of accelerations, after an evaluation in
    /// motion: for multipliers rows −ḧ, with h_x as mass; for a penalty p an inertia p h².
    pub(in crate::model) fn raise_to_accelerations(
        &mut self,
        e: &ElementEntry,
        left_out: u32,
        t: f64,
        h: f64,
    ) {
        let Some(enforced) = e.element.abilities().enforced else {
            return;
        };
        let n = e.element.dim();
        let (N, M) = enforced.dims();
        let mut levels = std::mem::take(&mut self.levels);
        enforced.levels(&self.motion(e, t, false), &mut levels);
        let Levels { h_ddot, J, .. } = &levels;
        if let Some(p) = enforced.penalty() {
            let inertia = p * h * h;
            for (j, J_j) in J.chunks_exact(M).enumerate() {
                let force: f64 = J_j.iter().zip(h_ddot).map(|(J, h)| J * h).sum();
                self.r[j] -= inertia * force;
                for (i, J_i) in J.chunks_exact(M).enumerate() {
                    let product: f64 = J_i.iter().zip(J_j).map(|(a, b)| a * b).sum();
                    self.M[i + j * n] += inertia * product;
                }
            }
        } else {
            for i in (0..M).filter(|i| left_out & (1 << i) == 0) {
                self.r[N + i] = -h_ddot[i];
            }
            for j in 0..n {
                for i in (0..n).filter(|i| j >= N || *i >= N) {
                    self.M[i + j * n] = self.K[i + j * n];
                }
            }
        }
        self.levels = levels;
    }
}

impl ElementEntry {
    /// Name of an enforced equation.
    pub(in crate::model) fn equation(&self, i: usize) -> String {
        let enforced = self.element.abilities().enforced;
        enforced.map_or_else(String::new, |e| e.equation(i))
    }
}
