//! Lines of beam elements along an axis.

use crate::beam::{Interpolation, Section};
use crate::memory;
use crate::model::build::builder::{ElementId, ModelBuilder, NodeId};
use crate::model::{ModelError, ReferenceCurve};
use nalgebra::{Matrix3, Vector3};

/// Discretisation of an axis: elements, their order and section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeamLine {
    /// Number of elements, at least one.
    pub elements: usize,
    /// Polynomial order of an element: 1, 2 or 3 (two, three or four nodes).
    pub order: usize,
    /// Section in its own axes.
    pub section: Section,
    /// Interpolation of rotations.
    pub interpolation: Interpolation,
    /// The frame to which the coordinates of inner nodes are relative, if any: [`ModelBuilder::relative_node`].
    pub relative_to: Option<NodeId>,
}

impl BeamLine {
    /// Elements with two nodes, total rotation vectors and coordinates of their own.
    pub fn new(elements: usize, section: Section) -> Self {
        Self {
            elements,
            order: 1,
            section,
            interpolation: Interpolation::Total,
            relative_to: None,
        }
    }

    /// Parameter u ∈ \[0, 1\] of the axis at ξ ∈ \[−1, 1\] of element `e`, the first being 0.
    pub fn parameter(&self, e: usize, xi: f64) -> f64 {
        let order = self.order as f64;
        let first = (e * self.order) as f64;
        (first + 0.5 * (1.0 + xi) * order) / (self.elements * self.order) as f64
    }
}

/// Nodes and elements of a line, from its start to its end.
#[derive(Clone, Debug, PartialEq)]
pub struct BeamLineNodes {
    /// All nodes, ends included.
    pub nodes: Vec<NodeId>,
    /// All elements.
    pub elements: Vec<ElementId>,
}

impl ModelBuilder {
    /// Adds beam elements along `axis`, between two existing nodes.
    ///
    /// Inner nodes are named `name/1`, `name/2`, ...; elements `name:1`, `name:2`, .... The end
    /// nodes must be at the ends of the axis.
    ///
    /// # Errors
    /// [`ModelError`] with the name of the line or the element.
    pub fn line(
        &mut self,
        name: &str,
        axis: &dyn ReferenceCurve,
        [from, to]: [NodeId; 2],
        line: &BeamLine,
    ) -> Result<BeamLineNodes, ModelError> {
        let fail = |problem: String| ModelError::Line {
            line: name.to_owned(),
            problem,
        };
        if line.elements == 0 {
            return Err(fail("needs at least one element".to_owned()));
        }
        if !(1..=3).contains(&line.order) {
            return Err(fail(format!(
                "elements of order {} do not exist; choose 1, 2 or 3",
                line.order
            )));
        }
        let count = self.elements.len() as f64 + line.elements as f64 * line.order as f64;
        memory::elements(count).map_err(|[needs, free]| {
            fail(format!(
                "its {} elements need about {needs:.1} GB of memory, and {free:.1} GB are free",
                line.elements
            ))
        })?;
        self.check_own(&[from, to], || format!("line {name}"))?;
        let size = (self.position(to) - self.position(from)).norm().max(1e-300);
        for (node, u) in [(from, 0.0), (to, 1.0)] {
            let gap = (axis.at(u).0 - self.position(node)).norm();
            let length = (axis.at(0.5).0 - axis.at(0.0).0).norm().max(size);
            if gap.is_nan() || gap > 1e-6 * length {
                return Err(fail(format!(
                    "its {} is {:?}, but node {} stands {gap:.3e} away at {:?}",
                    if u == 0.0 { "start" } else { "end" },
                    axis.at(u).0.as_slice(),
                    self.node_name(node),
                    self.position(node).as_slice()
                )));
            }
        }
        let intervals = line.elements * line.order;
        let mut nodes = vec![from];
        for k in 1..intervals {
            let (position, _) = axis.at(k as f64 / intervals as f64);
            let (inner, position) = (format!("{name}/{k}"), position.into());
            nodes.push(match line.relative_to {
                None => self.node(inner, position)?,
                Some(parent) => self.relative_node(inner, parent, position)?.frame,
            });
        }
        nodes.push(to);
        let elements = self.line_through(name, axis, &nodes, line)?;
        Ok(BeamLineNodes { nodes, elements })
    }

    /// Adds beam elements along `axis` through existing nodes, from its start to its end.
    ///
    /// # Errors
    /// [`ModelError`] with the name of the line or the element.
    pub fn line_through(
        &mut self,
        name: &str,
        axis: &dyn ReferenceCurve,
        nodes: &[NodeId],
        line: &BeamLine,
    ) -> Result<Vec<ElementId>, ModelError> {
        if nodes.len() != line.elements * line.order + 1 {
            return Err(ModelError::Line {
                line: name.to_owned(),
                problem: format!(
                    "{} elements of order {} need {} nodes, and have {}",
                    line.elements,
                    line.order,
                    line.elements * line.order + 1,
                    nodes.len()
                ),
            });
        }
        self.check_own(nodes, || format!("line {name}"))?;
        let mut elements = Vec::with_capacity(line.elements);
        for e in 0..line.elements {
            let first = e * line.order;
            let own = &nodes[first..=first + line.order];
            let positions: Vec<Vector3<f64>> = own.iter().map(|&n| self.position(n)).collect();
            let frame = |xi: f64| -> Matrix3<f64> { axis.at(line.parameter(e, xi)).1 };
            let element_name = format!("{name}:{}", e + 1);
            let beam = (line.interpolation)
                .beam(&positions, &frame, &line.section)
                .map_err(|source| ModelError::Beam {
                    element: element_name.clone(),
                    source,
                })?;
            elements.push(self.element(element_name, beam, own)?);
        }
        Ok(elements)
    }
}
