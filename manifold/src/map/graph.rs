//! A graph of maps: compositions of maps from common inputs.
//!
//! With the operators B of a map and B₀ of what it reads, with respect to the inputs,
//!
//! ```text
//! B B₀,   Ḃ B₀ + B Ḃ₀,   B̈ B₀ + 2 Ḃ Ḃ₀ + B B̈₀,   K_σ(f) + B₀ᵀ K_σ,own(f) B₀ with Bᵀ f for what it reads
//! ```

mod link;

use super::{MapState, Order, Parametrization};
use crate::domain::DomainError;
use crate::system::ChartChanges;
use link::{Link, add_product};

/// Maps that read common inputs, and each other; its values are those of its last maps, the outputs. It
/// never changes their coordinates.
#[derive(Clone, Default)]
pub struct MapGraph {
    kind: Option<&'static str>,
    inputs: usize,
    /// Index of the first output, and the number of all values.
    first: usize,
    values: usize,
    links: Vec<Link>,
    /// The time and the inputs of the last evaluation; empty where links were changed since.
    at: Vec<f64>,
    K: Vec<f64>,
    stack: Vec<f64>,
    product: Vec<f64>,
}

impl MapGraph {
    /// A graph of this number of inputs, without maps.
    #[must_use]
    pub fn new(inputs: usize) -> Self {
        Self {
            inputs,
            ..Self::default()
        }
    }

    /// Adds a map with the sources of its coordinates, and the number of each; returns what reads its values.
    /// Maps come before those that read them.
    ///
    /// # Panics
    /// For a map with [`Segments`](super::Segments), which would read other sources on each of them, and for other numbers
    /// than those of the coordinates and of the values of an earlier map.
    pub fn add(&mut self, map: Box<dyn Parametrization>, reads: Vec<(Read, usize)>) -> Read {
        assert!(map.segments().is_none(), "a graph reads one segment");
        let (d, n) = map.dims();
        let all: usize = reads.iter().map(|(_, len)| len).sum();
        assert_eq!(all, d, "a map reads all of its coordinates");
        let whole = |&(read, len): &(Read, usize)| match read {
            Read::Input(first) => first + len <= self.inputs,
            Read::Link(j) => len == self.links[j].n,
            Read::Nothing => true,
        };
        assert!(reads.iter().all(whole), "a map reads what there is");
        let sources: Vec<Vec<usize>> = (reads.iter())
            .map(|&(read, len)| match read {
                Read::Input(first) => (first..first + len).collect(),
                Read::Nothing => Vec::new(),
                Read::Link(j) => self.links[j].columns.clone(),
            })
            .collect();
        let mut columns = sources.concat();
        columns.sort_unstable();
        columns.dedup();
        let position = |input: &usize| columns.partition_point(|c| c < input);
        let positions = sources.iter().map(|s| s.iter().map(position).collect());
        let positions = positions.collect();
        let N = columns.len();
        let z = |len: usize| [vec![0.0; len], vec![0.0; len], vec![0.0; len]];
        self.K.resize(self.K.len().max(d * d), 0.0);
        self.stack.resize(self.stack.len().max(d * N), 0.0);
        self.product.resize(self.product.len().max(d * N), 0.0);
        self.links.push(Link {
            map,
            reads,
            columns,
            positions,
            n,
            d,
            q: z(d),
            x: z(n),
            own: z(n * d),
            all: z(n * N),
            r: vec![0.0; n],
        });
        Read::Link(self.links.len() - 1)
    }

    /// The same graph, whose values are those of its last `count` maps.
    #[must_use]
    pub fn with_outputs(mut self, count: usize) -> Self {
        self.first = self.links.len().saturating_sub(count);
        self.values = self.links[self.first..].iter().map(|link| link.n).sum();
        self
    }

    /// The same graph by another name in reports.
    #[must_use]
    pub fn named(mut self, kind: &'static str) -> Self {
        self.kind = Some(kind);
        self
    }

    /// Evaluates these orders of all links at a motion of the inputs.
    fn evaluate_links(&mut self, t: f64, motion: [&[f64]; 3], orders: usize) {
        self.at.clear();
        self.at.push(t);
        self.at.extend_from_slice(motion[0]);
        for k in 0..self.links.len() {
            let (before, rest) = self.links.split_at_mut(k);
            let link = &mut rest[0];
            link.gather(before, motion, orders);
            link.evaluate(t, orders);
            link.chain(before, orders);
        }
    }

    /// Evaluates all links at y, if they are not there.
    fn evaluate_at(&mut self, t: f64, y: &[f64]) {
        if self.at.split_first() != Some((&t, y)) {
            self.evaluate_links(t, [y, &[], &[]], 1);
        }
    }

    /// Copies values and operators of the outputs, one under the other.
    fn collect(&self, order: usize, x: &mut [f64], B: &mut [f64]) {
        B.fill(0.0);
        let mut row = 0;
        for link in &self.links[self.first..] {
            let rows = row..row + link.n;
            x[rows.clone()].copy_from_slice(&link.x[order]);
            for (&j, own) in link
                .columns
                .iter()
                .zip(link.all[order].chunks_exact(link.n))
            {
                B[j * self.values..][rows.clone()].copy_from_slice(own);
            }
            row = rows.end;
        }
    }
}

impl Parametrization for MapGraph {
    fn kind(&self) -> &'static str {
        self.kind.unwrap_or("graph of maps")
    }

    fn dims(&self) -> (usize, usize) {
        (self.inputs, self.values)
    }

    fn is_objective(&self) -> bool {
        self.links.iter().all(|link| link.map.is_objective())
    }

    /// The least margin of its maps.
    fn domain(&mut self, t: f64, y: &[f64]) -> Result<f64, DomainError> {
        self.evaluate_at(t, y);
        (self.links.iter_mut()).try_fold(f64::INFINITY, |least, link| {
            Ok(least.min(link.map.domain(t, &link.q[0])?))
        })
    }

    fn evaluate(&mut self, t: f64, motion: [&[f64]; 3], out: &mut [Order<'_>]) {
        self.evaluate_links(t, motion, out.len());
        for (order, [x, B]) in out.iter_mut().enumerate() {
            self.collect(order, x, B);
        }
    }

    fn geometric_stiffness(&mut self, t: f64, y: &[f64], f: &[f64], K: &mut [f64]) {
        let N = self.inputs;
        self.evaluate_at(t, y);
        K.fill(0.0);
        self.links.iter_mut().for_each(|l| l.r.fill(0.0));
        let mut rest = f;
        for link in &mut self.links[self.first..] {
            let (own, others) = rest.split_at(link.n);
            link.r.copy_from_slice(own);
            rest = others;
        }
        for k in (0..self.links.len()).rev() {
            let (before, rest) = self.links.split_at_mut(k);
            let link = &mut rest[0];
            if link.r.iter().all(|r| *r == 0.0) {
                continue;
            }
            let (d, columns) = (link.d, &link.columns);
            let own = &mut self.K[..d * d];
            link.map.geometric_stiffness(t, &link.q[0], &link.r, own);
            // Operators of the coordinates with respect to the inputs, and Bᵀ r for their sources.
            let stack = &mut self.stack[..d * columns.len()];
            stack.fill(0.0);
            let mut column = 0;
            for (&(read, len), positions) in link.reads.iter().zip(&link.positions) {
                match read {
                    Read::Nothing => {}
                    Read::Input(_) => {
                        for (i, &position) in positions.iter().enumerate() {
                            stack[column + i + position * d] += 1.0;
                        }
                    }
                    Read::Link(j) => {
                        let from = before[j].all[0].chunks_exact(len);
                        for (&position, from) in positions.iter().zip(from) {
                            let at = position * d + column;
                            stack[at..at + len].copy_from_slice(from);
                        }
                        let B = &link.own[0][column * link.n..];
                        for (r, B) in before[j].r.iter_mut().zip(B.chunks_exact(link.n)) {
                            *r += B.iter().zip(&link.r).map(|(b, r)| b * r).sum::<f64>();
                        }
                    }
                }
                column += len;
            }
            let product = &mut self.product[..d * columns.len()];
            product.fill(0.0);
            add_product([d, d], 1.0, own, stack, product);
            for (&j, p) in columns.iter().zip(product.chunks_exact(d)) {
                for (&i, s) in columns.iter().zip(stack.chunks_exact(d)) {
                    K[i + j * N] += s.iter().zip(p).map(|(s, p)| s * p).sum::<f64>();
                }
            }
        }
    }

    fn state(&mut self) -> Option<&mut dyn MapState> {
        Some(self)
    }
}

impl MapState for MapGraph {
    /// Chooses the charts of each map, from the inputs outwards.
    fn change_charts(&mut self, t: f64, y: &[f64]) -> ChartChanges {
        let mut all = ChartChanges::default();
        self.at.clear();
        for k in 0..self.links.len() {
            let (before, rest) = self.links.split_at_mut(k);
            let link = &mut rest[0];
            link.gather(before, [y, &[], &[]], 1);
            if let Some(state) = link.map.state() {
                let changes = state.change_charts(t, &link.q[0]);
                all.charts += changes.charts;
                all.residual |= changes.residual;
            }
            link.evaluate(t, 1);
        }
        all
    }

    fn freeze_piece(&mut self, at: Option<(f64, &[f64])>) {
        if let Some((t, y)) = at {
            self.evaluate_links(t, [y, &[], &[]], 1);
        }
        self.at.clear();
        for link in &mut self.links {
            if let Some(state) = link.map.state() {
                state.freeze_piece(at.map(|(t, _)| (t, &link.q[0][..])));
            }
        }
    }

    /// The states of its maps, one after the other.
    fn save(&self) -> Vec<f64> {
        self.links.iter().flat_map(|link| link.map.save()).collect()
    }

    fn restore(&mut self, saved: &[f64]) -> bool {
        self.at.clear();
        let mut rest = saved;
        let restored = self.links.iter_mut().all(|link| {
            let (own, others) = rest.split_at(link.map.save().len().min(rest.len()));
            rest = others;
            link.map.restore(own)
        });
        restored && rest.is_empty()
    }
}

/// Where a map of a graph takes some of its coordinates from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Read {
    /// Inputs of the graph, from this index on.
    Input(usize),
    /// Constant zeros.
    Nothing,
    /// The values of an earlier map.
    Link(usize),
}
