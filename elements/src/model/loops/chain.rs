//! The two chains of joints of a loop.

use super::set::{self, Inputs};
use super::{Closing, Setting};
use crate::model::build::dependency_graph::ancestors;
use crate::model::{ModelError, Node, NodeForm, Subject};
use pullback_manifold::map::{Parametrization, Read};
use pullback_manifold::system::Quantity;

/// A loop: its two frames, and the frame where their chains meet.
#[derive(Clone, Debug)]
pub(in crate::model) struct JointLoop {
    /// The frame that is attached to the closing joint, and the frame that coincides with it.
    pub frame: u32,
    pub child: u32,
    /// The frame that carries both chains; `None` if they end at different held frames.
    pub root: Option<u32>,
    /// The held frames in this case.
    pub ends: [Option<u32>; 2],
}

/// The frames above a frame, itself first.
pub(in crate::model) fn upwards(nodes: &[Node], n: u32) -> Vec<u32> {
    let mut out = vec![n];
    let mut at = n;
    while let Some(d) = nodes[at as usize].mapped() {
        let frame = |m: &&u32| nodes[**m as usize].is_frame();
        let mut parents = d.initial_parents().iter().filter(frame);
        match (parents.next(), parents.next(), d.segments.len()) {
            (Some(&m), None, 1) => {
                out.push(m);
                at = m;
            }
            _ => break,
        }
    }
    out
}

impl JointLoop {
    /// Whether its chains end at a frame.
    pub(in crate::model) fn ends_at(&self, frame: u32) -> bool {
        [self.root, self.ends[0], self.ends[1]].contains(&Some(frame))
    }

    /// The chains of the coinciding frames.
    ///
    /// # Errors
    /// [`ModelError::LooseLoop`] if one of them ends at a frame that neither carries the other nor
    /// is held.
    pub(super) fn find(
        nodes: &[Node],
        closing: Closing,
        setting: &Setting<'_>,
    ) -> Result<Self, ModelError> {
        let (frame, child) = (closing.frame.0, closing.child.0);
        let (a, b) = (upwards(nodes, frame), upwards(nodes, child));
        if let Some(&root) = a.iter().find(|n| b.contains(n)) {
            // The chart of a frame that carries joints.
            let partner = nodes[root as usize].partner;
            let root = if a.contains(&partner) && !nodes[partner as usize].is_view() {
                partner
            } else {
                root
            };
            return Ok(Self {
                frame,
                child,
                root: Some(root),
                ends: [None; 2],
            });
        }
        let mut ends = [None; 2];
        for (end, chain) in ends.iter_mut().zip([&a, &b]) {
            let last = chain[chain.len() - 1];
            let node = &nodes[last as usize];
            let steady = match node.is_own() {
                true => (0..6).all(|k| setting.function(last as usize, k).is_some()),
                false => reads_no_frame(nodes, last),
            };
            if !steady {
                return Err(loose(nodes, frame, last));
            }
            *end = Some(last).filter(|_| node.is_own());
        }
        Ok(Self {
            frame,
            child,
            root: None,
            ends,
        })
    }

    /// Extends the chains above their root, to its parent frame.
    ///
    /// # Errors
    /// [`ModelError::LooseLoop`] if it has several parents.
    pub(super) fn lengthen(&mut self, nodes: &[Node]) -> Result<(), ModelError> {
        let Some(root) = self.root else { return Ok(()) };
        self.root = upwards(nodes, root).get(1).copied();
        if self.root.is_none() && !reads_no_frame(nodes, root) {
            return Err(loose(nodes, self.frame, root));
        }
        Ok(())
    }
}

/// Error of a chain of joints with an invalid end.
fn loose(nodes: &[Node], frame: u32, end: u32) -> ModelError {
    ModelError::LooseLoop {
        joint: Subject::node(nodes, frame),
        node: nodes[end as usize].name.clone(),
    }
}

/// Whether a frame follows from scalar coordinates alone.
fn reads_no_frame(nodes: &[Node], n: u32) -> bool {
    let no_frame = |m: &u32| !nodes[*m as usize].is_frame();
    let mapped = nodes[n as usize].mapped();
    mapped.is_some_and(|d| d.segments.len() == 1 && d.initial_parents().iter().all(no_frame))
}

/// The own scalar coordinate nodes along both chains below the root.
pub(super) fn coordinates(nodes: &[Node], chain: &JointLoop) -> Vec<u32> {
    let mut out = ancestors(nodes, &[chain.frame, chain.child], chain.root, |d| {
        std::slice::from_ref(&d.segments[d.map.segment()])
    });
    out.retain(|&n| {
        let node = &nodes[n as usize];
        node.is_own() && node.form != NodeForm::Frame
    });
    out
}

/// Whether the equations of a loop depend on the position of its root. They do not if the pose of
/// every joint is objective, as in nearly all cases.
pub(super) fn root_matters(
    nodes: &[Node],
    chain: &JointLoop,
    root: u32,
    setting: &Setting<'_>,
) -> bool {
    if nodes[root as usize].is_own() && setting.still(root as usize, 6) {
        return false;
    }
    let own = coordinates(nodes, chain);
    let nothing = Setting {
        functions: &[],
        ..*setting
    };
    let length = setting.length;
    let inputs = Inputs::new(nodes, &own, &[root], &nothing);
    let mut tree = set::tree(nodes, std::slice::from_ref(chain), &inputs);
    let at = |first: usize| inputs.all().find(|(_, f)| *f == first);
    debug_assert!(at(0).is_some_and(|(n, _)| inputs.read(n) == Read::Input(0)));
    let mut value = |y: &[f64]| {
        let mut h = [0.0; 6];
        let mut J = vec![0.0; 6 * y.len()];
        tree.evaluate(0.0, [y, &[], &[]], &mut [[&mut h, &mut J]]);
        h
    };
    let far = |k: usize, s: f64| 0.4 * (1.3 * k as f64 + s).sin();
    [0.3, 1.1, 2.9].iter().any(|&s| {
        let mut y: Vec<f64> = (0..inputs.count).map(|k| far(k, s)).collect();
        for (n, first) in inputs.all() {
            let quantities = (first..).zip(nodes[n as usize].quantities.iter());
            for (k, _) in quantities.filter(|(_, quantity)| **quantity == Quantity::Length) {
                y[k] *= length;
            }
        }
        let there = value(&y);
        y[..6].fill(0.0);
        let here = value(&y);
        // Equal to rounding; NaN counts as equal.
        there
            .iter()
            .zip(&here)
            .zip([length, length, length, 1.0, 1.0, 1.0])
            .any(|((a, b), size)| (a - b).abs() > 1e-9 * (size + b.abs()))
    })
}
