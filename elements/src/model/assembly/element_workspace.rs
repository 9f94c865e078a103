//! Evaluation of one element: gather, change chart, evaluate, pull back.

use crate::constraint::Levels;
use crate::element::{Combined, Motion, Response};
use crate::model::assembly::couplings::Couplings;
use crate::model::assembly::residual::MAX_NODES;
use crate::model::constraints::omitted::Omitted;
use crate::model::kinematics::complement::ComplementOperators;
use crate::model::kinematics::node_entries::{collect, distribute};
use crate::model::state::ElementState;
use crate::model::{ElementEntry, NONE, Node, Span};
use pullback_manifold::domain::DomainError;
use pullback_manifold::system::{Scales, Weights};
use std::ops::Range;

/// Buffers of one element.
#[derive(Clone, Default)]
pub(in crate::model) struct ElementWorkspace {
    pub x: Vec<f64>,
    previous: Vec<f64>,
    /// Present inputs of the model.
    pub inputs: Vec<f64>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
    pub r: Vec<f64>,
    pub r_t: Vec<f64>,
    pub K: Vec<f64>,
    C: Vec<f64>,
    pub M: Vec<f64>,
    pub S: Vec<f64>,
    pub work: Vec<f64>,
    pub K_sigma: Vec<f64>,
    pub q: Vec<f64>,
    pub qv: Vec<f64>,
    pub qa: Vec<f64>,
    complements: Vec<ComplementOperators>,
    pub levels: Levels,
}

impl ElementWorkspace {
    /// Buffers for elements of at most `n` coordinates and joints that read at most `parents`.
    pub(in crate::model) fn new(n: usize, parents: usize) -> Self {
        let zeros = |len: usize| vec![0.0; len];
        Self {
            x: zeros(n),
            previous: zeros(n),
            inputs: Vec::new(),
            v: zeros(n),
            a: zeros(n),
            r: zeros(n),
            r_t: zeros(n),
            K: zeros(n * n),
            C: zeros(n * n),
            M: zeros(n * n),
            S: zeros(n * n),
            work: zeros(n.max(parents)),
            K_sigma: zeros(parents * parents),
            q: zeros(parents),
            qv: zeros(parents),
            qa: zeros(parents),
            complements: vec![ComplementOperators::default(); MAX_NODES],
            levels: Levels::default(),
        }
    }

    /// Reads the motion of an element's nodes, in its charts: those switched are seen through the complement
    /// map.
    pub(in crate::model) fn read(
        &mut self,
        (e, state): (&ElementEntry, &ElementState),
        spans: &[Span],
        [x, v, a]: [&[f64]; 3],
    ) {
        collect(&e.nodes, spans, x, &mut self.x);
        collect(&e.nodes, spans, v, &mut self.v);
        collect(&e.nodes, spans, a, &mut self.a);
        for (i, psi) in switched_rotations(e, state.switched, spans) {
            let [x, v, a] = [&mut self.x, &mut self.v, &mut self.a].map(|x| &mut x[psi.clone()]);
            self.complements[i].apply(x, v, a);
        }
    }

    /// Reads the previous iterate, before [`read`](Self::read): both use the operators of complement maps.
    pub(in crate::model) fn read_previous(
        &mut self,
        (e, state): (&ElementEntry, &ElementState),
        spans: &[Span],
        x: &[f64],
    ) {
        collect(&e.nodes, spans, x, &mut self.previous);
        for (i, psi) in switched_rotations(e, state.switched, spans) {
            let (mut v, mut a) = ([0.0; 3], [0.0; 3]);
            self.complements[i].apply(&mut self.previous[psi], &mut v, &mut a);
        }
    }

    /// The element's motion as read.
    pub(in crate::model) fn motion(&self, e: &ElementEntry, t: f64, statics: bool) -> Motion<'_> {
        let n = e.element.dim();
        let end = if statics { 0 } else { n };
        Motion {
            t,
            inputs: &self.inputs,
            x: &self.x[..n],
            v: &self.v[..end],
            a: &self.a[..end],
            previous: None,
        }
    }

    pub(in crate::model) fn evaluate(
        &mut self,
        (e, state): (&ElementEntry, &ElementState),
        t: f64,
        statics: bool,
        weights: Option<Weights>,
        rates: bool,
        previous: bool,
    ) -> Result<(), DomainError> {
        let n = e.element.dim();
        let tangent = weights.is_some() || rates;
        let moving = tangent && !statics;
        self.r[..n].fill(0.0);
        if rates {
            self.r_t[..n].fill(0.0);
        }
        let omitted = Omitted::of(e, state.left_out, &mut self.x);
        let end = if statics { 0 } else { n };
        let at = Motion {
            t,
            inputs: &self.inputs,
            x: &self.x[..n],
            v: &self.v[..end],
            a: &self.a[..end],
            previous: previous.then_some(&self.previous[..n]),
        };
        let r = &mut self.r[..n];
        if let (Some(weights), Some(combined)) = (weights, combined((e, state), statics, rates)) {
            let S = &mut self.S[..n * n];
            S.fill(0.0);
            return combined.add(&at, r, &mut [Some((weights, S)), None, None]);
        }
        if tangent {
            self.K[..n * n].fill(0.0);
        }
        if moving {
            self.C[..n * n].fill(0.0);
            self.M[..n * n].fill(0.0);
        }
        // Enforced equations take h_x from K as their mass: `raise_to_accelerations`.
        let alone = !rates
            && weights.is_some_and(|w| w.needed(statics).start == 2)
            && e.element.abilities().enforced.is_none();
        let mut out = Response {
            r,
            K: (tangent && !alone).then_some(&mut self.K[..n * n]),
            C: (moving && !alone).then_some(&mut self.C[..n * n]),
            M: moving.then_some(&mut self.M[..n * n]),
            r_t: rates.then_some(&mut self.r_t[..n]),
        };
        e.element.evaluate(&at, &mut out)?;
        if let Some(omitted) = omitted {
            omitted.replace(&mut self.x, &mut out);
        }
        Ok(())
    }

    /// Writes the residual to `r` and, in motion, the generalised momenta p = M ẋ to `work`.
    pub(in crate::model) fn momenta(
        &mut self,
        (e, state): (&ElementEntry, &ElementState),
        t: f64,
        statics: bool,
    ) -> Result<(), DomainError> {
        let n = e.element.dim();
        // Loads and equations have no mass.
        let massless = statics || e.load || e.element.abilities().enforced.is_some();
        let weights = (!massless).then_some(Weights::MASS);
        self.evaluate((e, state), t, statics, weights, false, false)?;
        let p = &mut self.work[..n];
        p.fill(0.0);
        if massless {
            return Ok(());
        }
        let M = match combined((e, state), statics, false) {
            Some(_) => &self.S,
            None => &self.M,
        };
        for (v, M) in self.v.iter().zip(M.chunks_exact(n)).take(n) {
            for (p, M) in p.iter_mut().zip(M) {
                *p += M * v;
            }
        }
        Ok(())
    }

    /// Adds the residual to those of all nodes.
    pub(in crate::model) fn add_residual(&self, e: &ElementEntry, spans: &[Span], r: &mut [f64]) {
        distribute(&e.nodes, spans, &self.r, r);
    }

    /// Updates the scales with the forces of an element, without those at held coordinates: these
    /// go directly to the support and do not load the structure.
    pub(in crate::model) fn measure(
        &self,
        e: &ElementEntry,
        nodes: &[Node],
        (unknowns, couplings): (&[u32], &Couplings),
        scales: &mut Scales,
    ) {
        let mut k = 0;
        for &n in e.nodes.iter() {
            let node = &nodes[n as usize];
            if couplings.is_fixed(n) {
                k += node.dim;
                continue;
            }
            for (quantity, c) in node.quantities.iter().zip(node.range()) {
                if !(e.dependent_coordinates && node.is_own() && unknowns[c] == NONE) {
                    let force = &mut scales.force[quantity.index()];
                    *force = force.max(self.r[k].abs());
                }
                k += 1;
            }
        }
    }

    /// First stage, from the element's charts to those of its nodes: the residual, as many of K, C and M, and
    /// with `rates` ∂r/∂t.
    pub(in crate::model) fn pull_back(
        &mut self,
        (e, state): (&ElementEntry, &ElementState),
        spans: &[Span],
        tangents: usize,
        rates: bool,
    ) {
        let n = e.element.dim();
        let parts = [&mut self.K, &mut self.C, &mut self.M];
        let mut parts = parts.map(|part| &mut part[..n * n]);
        for (i, psi) in switched_rotations(e, state.switched, spans) {
            let r_t = rates.then_some(&mut self.r_t[..n]);
            self.complements[i].pull_back(psi, &mut parts[..tangents], r_t, &mut self.r[..n]);
        }
    }

    /// Second stage if no node is mapped: the weighted sum of the tangents.
    pub(in crate::model) fn combine(
        &mut self,
        (e, state): (&ElementEntry, &ElementState),
        weights: Weights,
        [statics, rates]: [bool; 2],
    ) {
        let n = e.element.dim();
        if combined((e, state), statics, rates).is_some() {
            return;
        }
        if statics {
            std::mem::swap(&mut self.K, &mut self.S);
            if weights.K != 1.0 {
                self.S[..n * n].iter_mut().for_each(|s| *s *= weights.K);
            }
        } else {
            for (k, S) in self.S[..n * n].iter_mut().enumerate() {
                *S = weights.K * self.K[k] + weights.C * self.C[k] + weights.M * self.M[k];
            }
        }
    }

    /// The tangents K, C and M of an element in the coordinates of its nodes.
    pub(in crate::model) fn tangents(&self, e: &ElementEntry) -> [&[f64]; 3] {
        let values = e.element.dim().pow(2);
        [&self.K, &self.C, &self.M].map(|all| &all[..values])
    }
}

/// The nodes that an element evaluates through the complement map, and their rotation vectors among its coordinates.
pub(in crate::model) fn switched_rotations<'a>(
    e: &'a ElementEntry,
    switched: u32,
    spans: &'a [Span],
) -> impl Iterator<Item = (usize, Range<usize>)> + 'a {
    let mut first = 0;
    let nodes = e
        .nodes
        .iter()
        .enumerate()
        .take_while(move |_| switched != 0);
    nodes.filter_map(move |(i, &node)| {
        let psi = first + 3..first + 6;
        first += spans[node as usize].range().len();
        (switched & (1 << i) != 0).then_some((i, psi))
    })
}

/// The element's combined tangent, if the parts are not needed: in motion, for nodes that are not
/// switched and not mapped, and without omitted equations.
fn combined<'a>(
    (e, state): (&'a ElementEntry, &ElementState),
    statics: bool,
    rates: bool,
) -> Option<&'a dyn Combined> {
    let parts = statics || rates || e.mapped || state.switched != 0 || state.left_out != 0;
    if parts {
        None
    } else {
        e.element.abilities().combined
    }
}
