//! Straight lines of beam elements between nodes.

use super::closures::beam_line;
use pullback::elements::beam::Interpolation;
use pullback::prelude::*;

/// The straight line between two nodes.
pub fn straight(b: &ModelBuilder, ends: [NodeId; 2]) -> StraightLine {
    StraightLine::new(b.position(ends[0]), b.position(ends[1]))
}

/// Elements of order one in a straight line between two nodes; the nodes of the line.
pub fn beam(
    b: &mut ModelBuilder,
    name: &str,
    ends: [NodeId; 2],
    elements: usize,
    section: Section,
) -> Vec<NodeId> {
    beam_with(b, name, ends, elements, section, Interpolation::Total)
}

/// As [`beam`], with another interpolation of rotations.
pub fn beam_with(
    b: &mut ModelBuilder,
    name: &str,
    ends: [NodeId; 2],
    elements: usize,
    section: Section,
    interpolation: Interpolation,
) -> Vec<NodeId> {
    let axis = straight(b, ends);
    let line = BeamLine {
        interpolation,
        ..BeamLine::new(elements, section)
    };
    b.line(name, &axis, ends, &line).unwrap().nodes
}

/// A model file with a line from A to B, of length one along e1, and more of the file.
pub fn line(stiffness: &str, elements: usize, order: usize, rest: &str) -> String {
    let line = beam_line("line", ["A", "B"], elements, "main");
    format!(
        "[sections.main]\nstiffness = {{ {stiffness} }}\n\
         [nodes]\nA = [0, 0, 0]\nB = [1, 0, 0]\n{line}order = {order}\n{rest}\n"
    )
}

/// Stiffness of a column whose critical loads are Euler's, as EA = GA.
pub const COLUMN: &str = "EA = 1e4, GA = [1e4, 1e4], GJ = 10.0, EI = [3.0, 1.0]";

/// Supports of a line pinned about both cross axes, with a compressive force of 1 at B.
pub const PINNED: &str = r#"
[[supports]]
node = "A"
fix = ["x", "y", "z"]
[[supports]]
node = "B"
fix = ["y", "z", "rx"]
[[loads]]
node = "B"
force = [-1, 0, 0]
"#;
