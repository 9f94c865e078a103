//! Mobility of a model: degrees of freedom, locked loops, coordinates without mass.

use crate::model::{Context, Model, NONE, Node, NodeForm, NodeId};
use pullback_manifold::system::{Evaluation, Point, System, SystemError, Weights};
use std::fmt;

/// Degrees of freedom of a model, and the counts of its loop equations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mobility {
    /// Degrees of freedom of the whole model.
    pub freedoms: usize,
    /// Joints that close a loop, by a map or by multipliers.
    pub loops: usize,
    /// Number of coordinates without loop equations, not prescribed.
    pub coordinates: usize,
    /// Number of equations of the loops.
    pub equations: usize,
    /// Number of redundant equations at the start.
    pub redundant: usize,
}

impl fmt::Display for Mobility {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            freedoms,
            loops,
            coordinates,
            equations,
            redundant,
        } = self;
        write!(f, "degrees of freedom: {freedoms}")?;
        if *loops > 0 {
            let many = if *loops == 1 { "" } else { "s" };
            write!(
                f,
                " of {coordinates} coordinates, {loops} loop{many} with {equations} equations, of \
                 which {redundant} are redundant"
            )?;
        }
        Ok(())
    }
}

/// Result of closing a loop by a map.
struct Closed {
    /// Number of coordinates of its joints, free ones, and prescribed ones.
    x: usize,
    free: usize,
    prescribed: usize,
    equations: usize,
}

impl Model {
    /// The loops closed by maps, with the name of the first joint of each.
    fn closed(&self) -> impl Iterator<Item = (&str, Closed)> {
        self.reports.iter().filter_map(|report| {
            let d = self.nodes[report.map? as usize].mapped()?;
            let (all, x) = d.map.dims();
            let own = d.initial_parents().first().filter(|_| d.reparametrizes);
            let free = own.map_or(0, |&n| self.nodes[n as usize].dim);
            let name = &self.nodes[report.loops.first()?.frame as usize].name;
            let closed = Closed {
                x,
                free,
                prescribed: all - free,
                equations: 6 * report.loops.len(),
            };
            Some((name.as_str(), closed))
        })
    }

    /// Degrees of freedom at the initial configuration.
    pub fn mobility(&self) -> Mobility {
        let count = |form: NodeForm| {
            let of_form = self.nodes.iter().filter(|n| n.form == form);
            let all = of_form.flat_map(Node::range);
            all.filter(|&c| self.unknowns[c] != NONE).count()
        };
        let multipliers = count(NodeForm::Multipliers);
        let free = self.coordinates.len() - multipliers - count(NodeForm::Dummy);
        let mut out = Mobility {
            coordinates: free,
            ..Mobility::default()
        };
        for report in &self.reports {
            out.loops += match report.element {
                Some(k) => usize::from(self.elements[k as usize].multiplied().is_some()),
                None => report.loops.len(),
            };
        }
        let mut lost = 0;
        for (_, closed) in self.closed() {
            out.coordinates += closed.x - closed.free;
            out.equations += closed.equations;
            out.redundant += closed.equations - (closed.x - closed.free);
        }
        for &k in &self.enforced {
            let Some(e) = self.elements[k].multiplied() else {
                continue;
            };
            let redundant = self.start.elements[k].left_out.count_ones() as usize;
            let equations = e.dims().1;
            out.equations += equations;
            out.redundant += redundant;
            lost += equations - redundant;
        }
        out.freedoms = free.saturating_sub(lost);
        out
    }

    /// Loops in which nothing can move, though nothing is prescribed: name of a closing joint of
    /// each, number of its coordinates and of its equations.
    pub fn locked(&self) -> Vec<(String, usize, usize)> {
        let locked = |(_, c): &(&str, Closed)| c.free == 0 && c.prescribed == 0;
        let loops = self.closed().filter(locked);
        loops
            .map(|(name, c)| (name.to_owned(), c.x, c.equations))
            .collect()
    }
}

impl Context {
    /// Names of the unknowns without mass at a state, alone or in a direction of their node, and
    /// without a multiplier: only forces determine their motion. Those of `closing` nodes are left out.
    ///
    /// # Errors
    /// [`SystemError`] if the state is outside a chart.
    pub fn massless(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
        closing: &[NodeId],
    ) -> Result<Vec<String>, SystemError> {
        let n = q.len();
        let (a, mut r) = (vec![0.0; n], vec![0.0; n]);
        let mut M = vec![0.0; self.model.pattern.len()];
        let out = Evaluation::with_tangent(&mut r, Weights::MASS, &mut M);
        self.evaluate(Point { t, q, v, a: &a }, out)?;
        let pattern = &self.model.pattern;
        let (mut heavy, mut tied) = (vec![false; n], vec![false; n]);
        pattern.triplets(&M).for_each(|(r, c, mass)| {
            heavy[r] |= mass != 0.0;
            tied[r] |= pattern.coordinates()[c].is_multiplier;
        });
        for u in self.model.unknowns_of(closing.iter().map(|n| n.0)) {
            tied[u] = true;
        }
        let mut names = Vec::new();
        for j in 0..pattern.blocks() {
            let all = pattern.unknowns(j);
            let without = |i: &usize| !heavy[*i] && !tied[*i];
            names.extend(all.clone().filter(without).map(|i| self.name(i)));
            let Some(first) = pattern.find(j, j).filter(|_| all.clone().all(|i| !tied[i])) else {
                continue;
            };
            let own = &M[first..first + all.len() * all.len()];
            let hollow = hollow(own, all.len()).map(|k| self.name(all.start + k));
            names.extend(hollow.map(|name| format!("{name}, together with others of its node")));
        }
        Ok(names)
    }
}

/// Relative mass of a direction that counts as zero.
const HOLLOW: f64 = 1e-12;

/// The coordinate at which the Cholesky factorisation of a block of M ends because a direction of
/// the earlier ones has no mass; coordinates without mass of their own are omitted.
fn hollow(block: &[f64], n: usize) -> Option<usize> {
    let mut L = vec![0.0; n * n];
    for j in 0..n {
        let size = block[j + j * n];
        if size == 0.0 {
            continue;
        }
        let dot = |i: usize, L: &[f64]| (0..j).map(|k| L[i + k * n] * L[j + k * n]).sum::<f64>();
        let pivot = size - dot(j, &L);
        if pivot <= HOLLOW * size {
            return Some(j);
        }
        let root = pivot.sqrt();
        for i in j..n {
            L[i + j * n] = (block[i + j * n] - dot(i, &L)) / root;
        }
    }
    None
}
