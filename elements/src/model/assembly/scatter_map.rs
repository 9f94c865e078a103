//! Positions of element matrices in the pattern.

#![allow(non_snake_case)]

use crate::model::build::dependency_graph::{Alternatives, Dependencies, union};
use crate::model::kinematics::mapped_node::Maps;
use crate::model::{ElementEntry, NONE, Node, Source, Span};
use pullback_manifold::sparse::BlockPattern;
use std::ops::Range;

/// Positions of element matrices in the pattern, found for the present segments of all maps.
///
/// Stored in the order of an assembly. Rows of the tangent at mapped nodes are added to panels
/// first, and from there to their parents, like forces: the cost is the number of joints of a chain
/// times the unknowns behind them, not the square of these for every body.
#[derive(Clone, Default)]
pub(in crate::model) struct ScatterMap {
    /// Own nodes behind the mapped ones.
    pub dependencies: Dependencies,
    /// Per coordinate: its row in the block of its own node, [`NONE`] if prescribed.
    pub rows: Vec<u32>,
    /// Per node: index of its block in the pattern, [`NONE`] if all is prescribed.
    pub blocks: Vec<u32>,
    /// Per element, consecutively: the position of each pair of blocks, column by column; then
    /// those of mapped nodes.
    pub positions: Vec<BlockPosition>,
    /// Per element: its first position.
    first_positions: Vec<usize>,
    /// Per node.
    pub panels: Vec<Panel>,
    /// Per value: whether an element writes the block that begins here.
    written: Vec<bool>,
    /// Values that no element writes.
    unwritten: Vec<Range<usize>>,
}

/// Rows of the tangent at a mapped node.
#[derive(Clone, Default)]
pub(in crate::model) struct Panel {
    /// Own nodes whose coordinates affect the forces at this one, ascending, and the first value of
    /// each of their blocks.
    pub columns: Vec<u32>,
    pub starts: Vec<u32>,
    /// First position of its geometric stiffness, and of its rows at its parents.
    stiffness: usize,
    pub parent_rows: usize,
}

/// BlockPosition of the rows of one node and the columns of an own node: in the pattern, or in the panel
/// of a mapped node.
#[derive(Clone, Copy)]
pub(in crate::model) struct BlockPosition {
    /// First value, [`NONE`] if there is no block.
    pub start: u32,
    /// Whether an assembly writes it here first, so that it need not be cleared.
    pub first: bool,
}

impl ScatterMap {
    /// Without positions, for nodes with `coordinates` in all.
    pub(in crate::model) fn new(
        nodes: usize,
        coordinates: usize,
        dependencies: Dependencies,
    ) -> Self {
        Self {
            dependencies,
            rows: vec![NONE; coordinates],
            blocks: vec![NONE; nodes],
            ..Self::default()
        }
    }

    /// Number of free coordinates of an own node.
    pub(in crate::model) fn width(&self, node: &Node) -> usize {
        let rows = &self.rows[node.range()];
        rows.iter().filter(|&&r| r != NONE).count()
    }

    /// Creates the panels, with room for all nodes that may be depended on; returns the number of
    /// values.
    pub(in crate::model) fn arrange(
        &mut self,
        nodes: &[Node],
        dependent: &[u32],
        elements: &[ElementEntry],
        alternatives: &Alternatives,
    ) -> usize {
        let follows = |m: &&u32| !nodes[**m as usize].is_own();
        let mut columns: Vec<Vec<u32>> = vec![Vec::new(); nodes.len()];
        for e in elements
            .iter()
            .filter(|e| e.nodes.iter().any(|m| follows(&m)))
        {
            let all = alternatives.behind(&e.nodes);
            for &n in e.nodes.iter().filter(follows) {
                columns[n as usize] = union(&columns[n as usize], &all);
            }
        }
        for &n in dependent.iter().rev() {
            if let Source::Mapped(d) = &nodes[n as usize].source {
                for &m in d.segments.iter().flatten().filter(follows) {
                    columns[m as usize] = union(&columns[m as usize], &columns[n as usize]);
                }
            }
        }
        self.panels.resize_with(nodes.len(), Panel::default);
        let mut len = 0;
        for &n in dependent {
            let node = &nodes[n as usize];
            let columns = std::mem::take(&mut columns[n as usize]);
            let starts = &mut self.panels[n as usize].starts;
            starts.reserve_exact(columns.len());
            for &a in &columns {
                let rows = &self.rows[nodes[a as usize].range()];
                self.panels[n as usize].starts.push(len as u32);
                len += node.dim * rows.iter().filter(|&&r| r != NONE).count();
            }
            self.panels[n as usize].columns = columns;
        }
        // Room for any positions, so that a change of segment allocates nothing.
        let most = |group: &[u32]| -> usize {
            let columns = |&n: &u32| match &nodes[n as usize].source {
                Source::Own => 1,
                Source::Mapped(d) => self.dependencies.0[d.index].nodes.capacity(),
            };
            group.iter().map(columns).sum::<usize>() * group.len()
        };
        let mut room: usize = elements.iter().map(|e| most(&e.nodes)).sum();
        for &n in dependent {
            if let Source::Mapped(d) = &nodes[n as usize].source {
                let parents = d.segments.iter().map(Vec::len).max().unwrap_or(0);
                room += d.segments.iter().map(|s| most(s)).max().unwrap_or(0);
                room += parents * self.panels[n as usize].columns.len();
            }
        }
        self.positions.reserve_exact(room);
        self.first_positions.reserve_exact(elements.len());
        len
    }

    /// Finds the positions of all blocks of elements and of mapped nodes.
    pub(in crate::model) fn locate(
        &mut self,
        nodes: &[Node],
        dependent: &[u32],
        maps: &Maps,
        elements: &[ElementEntry],
        pattern: &BlockPattern,
    ) {
        self.dependencies.find(nodes, dependent, maps);
        self.positions.clear();
        self.first_positions.clear();
        self.written.clear();
        self.written.resize(pattern.len(), false);
        for e in elements {
            self.first_positions.push(self.positions.len());
            if !(e.dead && e.mapped) {
                self.locate_group(nodes, &e.nodes, pattern, !e.dead);
            }
        }
        for &n in dependent {
            let Source::Mapped(d) = &nodes[n as usize].source else {
                continue;
            };
            if self.panels[n as usize].columns.is_empty() {
                continue;
            }
            self.panels[n as usize].stiffness = self.positions.len();
            let parents = d.parents(maps);
            self.locate_group(nodes, parents, pattern, false);
            self.panels[n as usize].parent_rows = self.positions.len();
            for k in 0..self.panels[n as usize].columns.len() {
                let a = self.panels[n as usize].columns[k];
                for &m in parents {
                    let start = self.find(nodes, m, a, pattern);
                    let first = false;
                    self.positions.push(BlockPosition { start, first });
                }
            }
        }
        let all = (0..pattern.blocks()).flat_map(|j| pattern.column(j));
        self.unwritten.clear();
        // Room for any positions, so that a change of segment allocates nothing.
        self.unwritten.reserve_exact(all.clone().count());
        let unwritten = all.filter(|(_, block)| !self.written[block.start]);
        self.unwritten.extend(unwritten.map(|(_, block)| block));
    }

    /// The positions of all rows of a group of nodes, for each own node behind each of them.
    fn locate_group(
        &mut self,
        nodes: &[Node],
        group: &[u32],
        pattern: &BlockPattern,
        writes: bool,
    ) {
        for j in group {
            for k in 0..self.dependencies.behind(nodes, j).len() {
                let a = self.dependencies.behind(nodes, j)[k];
                for &i in group {
                    let start = self.find(nodes, i, a, pattern);
                    let first = writes
                        && start != NONE
                        && nodes[i as usize].is_own()
                        && !std::mem::replace(&mut self.written[start as usize], true);
                    self.positions.push(BlockPosition { start, first });
                }
            }
        }
    }

    /// First value of the block with the rows of node i and the columns of own node a.
    fn find(&self, nodes: &[Node], i: u32, a: u32, pattern: &BlockPattern) -> u32 {
        let column = self.blocks[a as usize];
        if column == NONE {
            return NONE;
        }
        if !nodes[i as usize].is_own() {
            let panel = &self.panels[i as usize];
            let found = panel.columns.binary_search(&a);
            return found.map_or(NONE, |k| panel.starts[k]);
        }
        let row = self.blocks[i as usize];
        let found = (row != NONE).then(|| pattern.find(row as usize, column as usize));
        found.flatten().map_or(NONE, |start| start as u32)
    }

    /// First position of a node's geometric stiffness; `None` if no force can act on it.
    pub(in crate::model) fn geometric_stiffness(&self, n: u32) -> Option<usize> {
        let panel = &self.panels[n as usize];
        (!panel.columns.is_empty()).then_some(panel.stiffness)
    }

    /// Clears the values that no element writes; [`ScatterMap::scatter`] of all elements then fills
    /// the rest.
    pub(in crate::model) fn clear_unwritten(&self, values: &mut [f64]) {
        for block in &self.unwritten {
            values[block.clone()].fill(0.0);
        }
    }

    /// First position of element `k`.
    pub(in crate::model) fn first_position(&self, k: usize) -> usize {
        self.first_positions[k]
    }

    /// Writes or adds the local matrix `S` (d×d) of element `k`.
    pub(in crate::model) fn scatter(
        &self,
        k: usize,
        e: &ElementEntry,
        spans: &[Span],
        S: &[f64],
        values: &mut [f64],
    ) {
        let nodes = &e.nodes[..];
        let positions = &self.positions[self.first_positions[k]..][..nodes.len() * nodes.len()];
        let d = e.element.dim();
        let mut column = 0;
        for (&nj, positions) in nodes.iter().zip(positions.chunks_exact(nodes.len())) {
            let columns = spans[nj as usize].range();
            let mut row = 0;
            for (&ni, position) in nodes.iter().zip(positions) {
                let rows = spans[ni as usize].range();
                let size = (rows.len(), columns.len());
                if position.start != NONE {
                    let (S, values) = (
                        &S[row + column * d..],
                        &mut values[position.start as usize..],
                    );
                    let first = position.first;
                    // Most nodes are frames with all coordinates free: constant extents.
                    if e.held || size != (6, 6) || !d.is_multiple_of(6) {
                        let (rows, columns) = (&self.rows[rows], &self.rows[columns.clone()]);
                        free_part(rows, columns, S, d, values, first);
                    } else if first {
                        whole_block(S, d / 6, values, |value, s| *value = s);
                    } else {
                        whole_block(S, d / 6, values, |value, s| *value += s);
                    }
                }
                row += size.0;
            }
            column += columns.len();
        }
    }
}

/// Applies `put` to a 6×6 block and its values; `S` has leading dimension 6·stride.
#[inline(always)]
fn whole_block(S: &[f64], stride: usize, values: &mut [f64], put: impl Fn(&mut f64, f64)) {
    let values: Option<&mut [[f64; 6]; 6]> = values.as_chunks_mut().0.first_chunk_mut();
    let S = S.as_chunks::<6>().0.iter().step_by(stride);
    for (values, S) in values.into_iter().flatten().zip(S) {
        for k in 0..6 {
            put(&mut values[k], S[k]);
        }
    }
}

/// Copies the free rows and columns of one dense block to its values; `S` has leading dimension d.
fn free_part(rows: &[u32], columns: &[u32], S: &[f64], d: usize, values: &mut [f64], first: bool) {
    let height = rows.iter().filter(|&&r| r != NONE).count();
    for (c, &column) in columns.iter().enumerate() {
        if column == NONE {
            continue;
        }
        for (r, &row) in rows.iter().enumerate() {
            if row != NONE {
                let value = &mut values[row as usize + column as usize * height];
                let s = S[r + c * d];
                *value = if first { s } else { *value + s };
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use crate::body::RigidBody;
    use crate::joint::{offset, revolute};
    use crate::model::{Context, Dof, ModelBuilder};
    use nalgebra::{Matrix3, Vector3};

    /// Bars in a chain.
    fn chain(count: usize) -> Context {
        let mut b = ModelBuilder::new();
        let mut end = b.node("ground", [0.0; 3]).unwrap();
        b.support(end, &Dof::ALL);
        for k in 0..count {
            let pin = revolute(&mut b, &format!("pin {k}"), end, [0.0, 0.0, 1.0]).unwrap();
            let body = RigidBody::new(1.0, Matrix3::identity(), Vector3::x()).unwrap();
            b.element(format!("bar {k}"), body, &[pin.frame]).unwrap();
            let position = [k as f64 + 1.0, 0.0, 0.0];
            end = offset(&mut b, &format!("end {k}"), pin.frame, position).unwrap();
        }
        Context::new(b.build().unwrap())
    }

    /// The cost and the memory of a chain are quadratic in its length, like its mass matrix;
    /// tangents of every body for every pair of coordinates before it would be cubic.
    #[test]
    fn chains_grow_with_the_square_of_their_length() {
        let sizes = [20, 40, 80].map(|count| {
            let model = chain(count);
            let (p, w) = (&model.work.scatter_map, &model.work);
            assert_eq!(model.pattern.len(), count * count);
            [w.operators.B.len(), w.panels.len(), p.positions.len()]
        });
        for k in 0..3 {
            for pair in sizes.windows(2) {
                let growth = pair[1][k] as f64 / pair[0][k] as f64;
                assert!((1.9..4.3).contains(&growth), "{k}: {sizes:?}");
            }
        }
    }

    /// Every coordinate occurs once in the operators of a frame, even if several joints depend on it.
    #[test]
    fn coordinates_are_counted_once() {
        let mut b = ModelBuilder::new();
        let ground = b.node("ground", [0.0; 3]).unwrap();
        b.support(ground, &Dof::ALL);
        let pin = revolute(&mut b, "pin", ground, [0.0, 0.0, 1.0]).unwrap();
        let other = b
            .add_joint_frame(
                "other",
                pin.frame,
                crate::joint::Revolute::new([0.0, 0.0, 1.0]).unwrap(),
                &[pin.angle],
            )
            .unwrap();
        let body = RigidBody::new(1.0, Matrix3::identity(), Vector3::x()).unwrap();
        b.element("body", body, &[other]).unwrap();
        let model = Context::new(b.build().unwrap());
        let crate::model::Source::Mapped(d) = &model.nodes[other.0 as usize].source else {
            panic!("it follows others");
        };
        let ancestors = &model.work.scatter_map.dependencies.0[d.index];
        assert_eq!(ancestors.coordinates, 7);
        assert_eq!(ancestors.nodes.len(), 2);
    }
}
