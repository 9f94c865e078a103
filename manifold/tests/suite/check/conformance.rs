//! One line per leaf.

use crate::support::*;

/// q ↦ a pendulum on a driven cart: a map that knows the time.
#[derive(Clone)]
struct Driven;

impl Map<2, 3> for Driven {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 2>) -> SVector<S, 3> {
        let cart = (t * 2.0).sin() * q[0];
        Vector3::new(
            cart + q[1].sin(),
            q[1].cos() * (t + 1.0),
            q[0] * q[1] * t * t,
        )
    }
}

/// Parent node and angle ↦ the dependent's frame: a revolute joint after an offset.
#[derive(Clone)]
struct HingeAtEnd;

impl Map<7, 6> for HingeAtEnd {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 7>) -> SVector<S, 6> {
        let offset = Offset([0.4, -0.2, 0.7]).phi(t, &q.fixed_rows::<6>(0).into_owned());
        let revolute = Revolute {
            axis: Vector3::new(0.6, 0.0, 0.8),
        };
        let psi = revolute.phi(t, &SVector::<S, 4>::new(q[3], q[4], q[5], q[6]));
        SVector::<S, 6>::new(offset[0], offset[1], offset[2], psi[0], psi[1], psi[2])
    }
}

#[test]
fn charts() {
    check::chart(&RotationVector).assert();
    check::chart(&WienerMilenkovic).assert();
}

#[test]
fn maps() {
    check::map(&Complement).assert();
    check::map(&Driven).assert();
    let turn = Vector3::new(0.4, -1.1, 0.7);
    check::map(&Increment::<6>::from(&turn)).assert();
    check::map(&Increment::<3>::from(&turn)).assert();
    check::map(&HingeAtEnd).assert();
}
