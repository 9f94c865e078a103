//! A model of everything at once.

use super::polynomial_spring::PolynomialSpring;
use super::strain_beam::{Reissner, strain_beam};
use super::*;

/// Everything at once: beams of two orders, a body on a revolute joint and a rigid link, a ball
/// joint, a slide, a frame that moves away from its parent with time and a beam between the two,
/// springs, a bushing, loads of all kinds, beams and loads of the other interpolation, elements by
/// their energies, and supports that are driven in part.
pub fn everything() -> Context {
    let mut b = ModelBuilder::new();
    let J = Matrix3::from_diagonal(&Vector3::new(0.03, 0.02, 0.015));
    let inertia = Inertia::about_centre(0.7, Vector3::new(0.0, 0.02, 0.01), J);
    let [root, corner, tip] = frame_model(&mut b, Some(inertia));
    let hinge = Revolute::new([1.0, 2.0, -1.0]).unwrap();
    let hinge = b.attach("hinge", tip, hinge).unwrap();
    let far = b.offset("far", hinge.frame, [0.1, 0.2, 0.3]).unwrap();
    let J = Matrix3::from_diagonal(&Vector3::new(0.2, 0.3, 0.4));
    let body = RigidBody::new(2.0, J, Vector3::new(0.05, 0.0, 0.1)).unwrap();
    b.element("body", body, &[far]).unwrap();
    let weight = body.weight([0.0, 0.0, -9.81], Constant(1.0));
    b.element("weight", weight, &[far]).unwrap();
    let spring = CoordinateSpring::new(LAW).unwrap();
    b.element("torsion", spring, &[hinge.coordinates[0]])
        .unwrap();
    let ball = b.spherical("ball", corner).unwrap();
    b.element("ball body", body, &[ball.frame]).unwrap();
    let cross = Universal::new([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).unwrap();
    let cross = b.attach("cross", tip, cross).unwrap();
    b.element("cross body", body, &[cross.frame]).unwrap();
    let leg = b.find("leg/1").unwrap();
    let runner = b
        .slide("runner", &[corner, leg, tip], 0.3, Interpolation::Total)
        .unwrap();
    b.element("runner body", body, &[runner.frame]).unwrap();
    let offset = [0.0, 0.3, 0.4];
    let outer = b.position(corner) + Vector3::from(offset);
    let link = GrowingOffset(offset).boxed();
    let outer = b.mapped_node("outer", outer.into(), link, &[corner]);
    let damped = massive().with_damping(DAMPING).unwrap();
    lay(&mut b, "brace", [corner, outer.unwrap()], 1, 1, damped);
    let positions = [tip, root].map(|n| b.position(n));
    let rope = AxialSpring::new(&positions, 4.0, 0.3).unwrap();
    b.element("rope", rope, &[tip, root]).unwrap();
    let positions = [far, root].map(|n| b.position(n));
    let K = Matrix6::from_diagonal(&[5.0, 6.0, 7.0, 0.5, 0.6, 0.7].into());
    let mount = Bushing::new(&positions, &Matrix3::identity(), &K, &(K * 0.1)).unwrap();
    b.element("mount", mount, &[far, root]).unwrap();
    let nodes = [corner, leg, tip];
    let positions = nodes.map(|n| b.position(n));
    let frame = frame_along(&(positions[1] - positions[0]), None);
    for section in [massive(), damped] {
        for count in [2, 3] {
            let beam = Interpolation::Geodesic.beam(&positions[..count], &|_| frame, &section);
            let name = format!("geodesic {count} {}", section.damping.mass);
            b.element(name, beam.unwrap(), &nodes[..count]).unwrap();
        }
    }
    let ramp = Table::ramp(0.0, 1.0, 2.0).unwrap();
    let turning = LineLoad::new(&positions, [0.0, 1.0, 0.0], true, ramp).unwrap();
    let turning = turning.with_interpolation(Interpolation::Geodesic);
    b.element("geodesic wind", turning, &nodes).unwrap();
    let ends = [positions[0], positions[2]];
    let by_energy = PolynomialSpring {
        positions: ends,
        rest_length: 1.0,
        k: [3.0, 0.5, -0.2],
        c: 0.2,
    };
    b.element("energy", by_energy.into_element(), &[corner, tip])
        .unwrap();
    let beam = strain_beam(Reissner, &ends, &frame, &damped).unwrap();
    b.element("beam", beam, &[corner, tip]).unwrap();
    b.support(root, &[Dof::X, Dof::Y, Dof::RX, Dof::RY]);
    b.prescribe(root, Dof::Z, sine(0.2));
    b.prescribe(root, Dof::RZ, sine(0.5));
    b.prescribe(corner, Dof::Y, sine(0.3));
    Context::new(b.build().unwrap())
}
