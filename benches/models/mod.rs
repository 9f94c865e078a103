//! Models in motion with any number of elements.

use nalgebra::Matrix3;
use pullback::elements::beam::Material;
use pullback::elements::load::LineLoad;
use pullback::elements::model::BeamLineNodes;
use pullback::elements::time::Table;
use pullback::prelude::*;

/// A model with a beam between two nodes, and the nodes.
fn beam(
    elements: usize,
    [from, to]: [[f64; 3]; 2],
    section: Section,
) -> (ModelBuilder, BeamLineNodes) {
    let mut builder = ModelBuilder::new();
    let from = builder.node("from", from).expect("a new name");
    let to = builder.node("to", to).expect("a new name");
    let line = line(&mut builder, "beam", [from, to], elements, section);
    (builder, line)
}

fn line(
    b: &mut ModelBuilder,
    name: &str,
    ends: [NodeId; 2],
    elements: usize,
    section: Section,
) -> BeamLineNodes {
    let axis = StraightLine::new(b.position(ends[0]), b.position(ends[1]));
    b.line(name, &axis, ends, &BeamLine::new(elements, section))
        .expect("a straight line")
}

fn load(b: &mut ModelBuilder, name: &str, which: LoadKind, value: [f64; 3], node: NodeId) {
    let load = NodalLoad::new(which, value, Constant(1.0));
    b.element(name, load, &[node]).expect("one node");
}

/// The free beam of Simo & Vu-Quoc 1986 while a force and a moment at its
/// lower end throw it.
pub fn flying(elements: usize) -> Context {
    let section = Section::diagonal(1e4, [1e4, 1e4], 100.0, [100.0, 100.0]).expect("positive");
    let section = section
        .with_mass(1.0, Matrix3::from_diagonal(&Vector3::new(20.0, 10.0, 10.0)))
        .expect("positive");
    let ends = [[6.0, 0.0, 0.0], [0.0, 0.0, 8.0]];
    let (mut b, line) = beam(elements, ends, section);
    let lower = line.nodes[0];
    load(&mut b, "force", LoadKind::DeadForce, [8.0, 0.0, 0.0], lower);
    load(
        &mut b,
        "moment",
        LoadKind::SpatialMoment,
        [0.0, 80.0, 0.0],
        lower,
    );
    Context::new(b.build().expect("a valid model"))
}

/// A cantilever let go in the horizontal: steel, ten metres of a rod two centimetres thick.
pub fn falling(elements: usize) -> Context {
    let steel = Material {
        E: 2.1e11,
        nu: 0.3,
        rho: 7850.0,
    };
    let section = Section::circle(steel, 0.01).expect("positive");
    let (mut b, line) = beam(elements, [[0.0; 3], [10.0, 0.0, 0.0]], section);
    b.support(line.nodes[0], &Dof::ALL);
    let weight = [0.0, 0.0, -9.81 * section.inertia.mass];
    for (k, nodes) in line.nodes.windows(2).enumerate() {
        let positions = [b.position(nodes[0]), b.position(nodes[1])];
        let load = LineLoad::new(&positions, weight, false, Constant(1.0));
        let load = load.expect("two positions");
        b.element(format!("weight {k}"), load, nodes)
            .expect("two nodes");
    }
    Context::new(b.build().expect("a valid model"))
}

/// The robot arm of \[M04\] 4.2, case 6: driven base, two arms, a spherical joint between them.
pub fn robot_arm(elements: usize) -> Context {
    let section = Section::diagonal(1e6, [1e6, 1e6], 1e5, [1e5, 1e5]).expect("positive");
    let section = section
        .with_mass(1.0, Matrix3::from_diagonal(&Vector3::new(2.0, 1.0, 1.0)))
        .expect("positive");
    let ends = [[0.0; 3], [5.0, 0.0, 0.0]];
    let (mut b, first) = beam(elements / 2, ends, section);
    let (base, elbow) = (first.nodes[0], first.nodes[elements / 2]);
    let start = b.spherical("start", elbow).expect("a new name").frame;
    let tip = b.node("tip", [10.0, 0.0, 0.0]).expect("a new name");
    line(&mut b, "second", [start, tip], elements / 2, section);
    b.support(base, &[Dof::X, Dof::Y, Dof::RX, Dof::RY]);
    let ramp = |end: f64| Table::ramp(0.0, 0.5, end).expect("increasing");
    b.prescribe(base, Dof::RZ, ramp(1.5));
    b.prescribe(base, Dof::Z, ramp(3.0));
    Context::new(b.build().expect("a valid model"))
}

/// The right-angle cantilever of \[M04\] 4.2, case 5, with 20 elements.
pub fn struck() -> Context {
    let text = include_str!("../../examples/models/elbow.toml");
    let job = pullback::input::assemble_text("elbow", text);
    job.expect("a valid model").context
}
