//! The 45° bend of the README: a curved cantilever, bent out of its plane by a tip force.

#![allow(non_snake_case)]

use pullback::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut model = ModelBuilder::new();
    let EI = 1e7 / 12.0;
    let section = Section::diagonal(1e7, [5e6, 5e6], 7.05e5, [EI, EI])?;
    let arc = Arc {
        from: Vector3::zeros(),
        center: Vector3::new(0.0, 100.0, 0.0),
        axis: Vector3::z_axis(),
        angle: 45_f64.to_radians(),
        second: None,
    };
    let root = model.node("root", [0.0; 3])?;
    let tip = model.node("tip", arc.at(1.0).0.into())?;
    model.line(
        "arc",
        &arc,
        [root, tip],
        &Line {
            elements: 8,
            order: 1,
            section,
        },
    )?;
    model.support(root, &Dof::ALL);
    let force = NodalLoad::new(Which::DeadForce, [0.0, 0.0, 600.0], Proportional(1.0));
    model.element("tip force", force, &[tip])?;
    let mut model = model.build()?;

    let mut q = Vec::new();
    solve_statics(
        &mut model,
        &mut q,
        &StaticOptions::default(),
        &mut |model, step| {
            let d = model.node_state(tip).d;
            println!(
                "load {:.3}: tip moved by {:.3?} in {} iterations",
                step.t,
                d.as_slice(),
                step.iterations
            );
            ControlFlow::Continue(())
        },
    )?;

    // Published: Mäkinen 2004, section 4.2.
    let d = model.node_state(tip).d - Vector3::new(-23.696, -13.668, 53.497);
    assert!(d.amax() < 1e-3, "off by {d}");
    Ok(())
}
