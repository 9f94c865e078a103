//! The 45° bend of the README: a curved cantilever, bent out of its plane by a tip force.

use pullback::elements::model::{CircularArc, ReferenceCurve};
use pullback::prelude::*;

fn main() -> Result<(), pullback::Failure> {
    let arc = CircularArc {
        from: Vector3::zeros(),
        center: Vector3::new(0.0, 100.0, 0.0),
        axis: Vector3::z_axis(),
        angle: 45_f64.to_radians(),
        second: None,
    };
    let section = Section::diagonal(1e7, [5e6; 2], 7.05e5, [1e7 / 12.0; 2])?;
    let mut builder = ModelBuilder::new();
    let root = builder.node("root", [0.0; 3])?;
    let tip = builder.node("tip", arc.at(1.0).0.into())?;
    builder.line("arc", &arc, [root, tip], &BeamLine::new(8, section))?;
    builder.support(root, &Dof::ALL);
    let force = NodalLoad::new(LoadKind::DeadForce, [0.0, 0.0, 600.0], Proportional(1.0));
    builder.element("tip force", force, &[tip])?;
    let mut context = Context::new(builder.build()?);

    equilibrium(&mut context, &StaticOptions::default())?;
    let moved = context.node_state(tip).d;
    println!("the tip moved by {:.3?}", moved.as_slice());

    // Published: Mäkinen 2004, section 4.2.
    let gap = moved - Vector3::new(-23.696, -13.668, 53.497);
    assert!(gap.amax() < 1e-3, "off by {gap}");
    Ok(())
}
