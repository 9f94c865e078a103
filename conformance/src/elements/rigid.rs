//! Superposed rigid motions and changes of chart, under which forces and energies stay the same.

use crate::TestState;
use nalgebra::{DMatrix, DVector, SVector, Vector3};
use pullback_manifold::map::Map;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::{complement, log_quaternion, quaternion};

/// A frame among the coordinates of a component.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameAt {
    /// The first of its six coordinates (d, Ψ).
    pub first: usize,
    /// Its position in the reference configuration.
    pub position: Vector3<f64>,
}

/// A change of the six coordinates of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Carrier {
    /// A rigid motion: x ↦ c + R(θ + ω t)(x − c) + u + w t.
    Rigid {
        /// c.
        about: Vector3<f64>,
        /// θ, the rotation vector.
        turn: Vector3<f64>,
        /// ω.
        spin: Vector3<f64>,
        /// u.
        shift: Vector3<f64>,
        /// w.
        drift: Vector3<f64>,
    },
    /// The other chart of the rotation.
    Chart,
}

impl Carrier {
    /// A constant rigid motion.
    pub(crate) fn still(about: Vector3<f64>, turn: Vector3<f64>, shift: Vector3<f64>) -> Self {
        let (spin, drift) = (Vector3::zeros(), Vector3::zeros());
        Self::Rigid {
            about,
            turn,
            spin,
            shift,
            drift,
        }
    }
}

/// A carrier for the frame of a position.
struct Carried {
    by: Carrier,
    position: Vector3<f64>,
}

impl Map<6, 6> for Carried {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 6>) -> SVector<S, 6> {
        let three = |k: usize| Vector3::new(q[k], q[k + 1], q[k + 2]);
        let (d, psi) = match self.by {
            Carrier::Rigid {
                about,
                turn,
                spin,
                shift,
                drift,
            } => {
                let path = |from: Vector3<f64>, rate: Vector3<f64>| {
                    Vector3::from_fn(|i, _| t * rate[i] + from[i])
                };
                let Q = quaternion(&path(turn, spin));
                let arm = (self.position - about).map(S::constant) + three(0);
                let d = Q.rotate(&arm) + path(about - self.position + shift, drift);
                (d, log_quaternion(&Q.product(&quaternion(&three(3)))))
            }
            Carrier::Chart => (three(0), complement(&three(3))),
        };
        SVector::<S, 6>::new(d.x, d.y, d.z, psi.x, psi.y, psi.z)
    }
}

/// A changed state, and the derivative B of its coordinates with respect to those before.
pub(crate) struct Moved {
    pub state: TestState,
    pub B: DMatrix<f64>,
}

/// Changes all frames of a state, at the time zero of the carrier; other coordinates stay.
pub(crate) fn carry(by: Carrier, frames: &[FrameAt], s: &TestState) -> Moved {
    let n = s.x.len();
    let mut out = Moved {
        state: s.clone(),
        B: DMatrix::identity(n, n),
    };
    let six = |x: &DVector<f64>, first: usize| match x.is_empty() {
        true => SVector::<f64, 6>::zeros(),
        false => x.fixed_rows::<6>(first).into_owned(),
    };
    for &FrameAt { first, position } in frames {
        let map = Carried { by, position };
        let k = map.kinematics(0.0, &six(&s.x, first), &six(&s.v, first), &six(&s.a, first));
        let put = |to: &mut DVector<f64>, x: &SVector<f64, 6>| {
            if !to.is_empty() {
                to.fixed_rows_mut::<6>(first).copy_from(x);
            }
        };
        put(&mut out.state.x, &k.x);
        put(&mut out.state.v, &k.x_dot);
        put(&mut out.state.a, &k.x_ddot);
        out.B.fixed_view_mut::<6, 6>(first, first).copy_from(&k.B);
    }
    out
}

/// The largest and smallest rotation angle of the frames.
pub(crate) fn angles(frames: &[FrameAt], x: &DVector<f64>) -> [f64; 2] {
    let angles = frames.iter().map(|f| x.fixed_rows::<3>(f.first + 3).norm());
    angles.fold([0.0, f64::INFINITY], |[most, least], psi| {
        [f64::max(most, psi), f64::min(least, psi)]
    })
}
