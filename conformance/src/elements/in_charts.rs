//! An element that reads poses, in the charts of its frames.

use crate::vectors::add;
use nalgebra::{Matrix6, Vector6};
use pullback_elements::element::{
    Abilities, Element, ElementEnergies, Motion, Properties, Response,
};
use pullback_manifold::domain::DomainError;
use pullback_manifold::map::{Parametrization, ToPose};
use pullback_manifold::pullback::tangents;

/// Calls `laws` with an element of chart coordinates.
pub(crate) fn in_charts<T>(element: &dyn Element, laws: impl FnOnce(&dyn Element) -> T) -> T {
    match element.properties().reads_poses {
        true => laws(&InCharts(element)),
        false => laws(element),
    }
}

/// An element that [reads poses](Properties::reads_poses), as an element of the coordinates (d, Ψ) of its frames, as in a
/// model.
pub struct InCharts<'a>(pub &'a dyn Element);

/// Number of coordinates of a frame, and of entries of its operator.
const FRAME: usize = 6;
const OPERATOR: usize = FRAME * FRAME;

/// The poses of all frames, with their operators frame by frame.
struct Poses {
    x: [Vec<f64>; 3],
    B: [Vec<f64>; 3],
}

impl Poses {
    fn of(at: &Motion<'_>) -> Self {
        let zero = vec![0.0; at.x.len()];
        let moving = |x| if at.v.is_empty() { &zero[..] } else { x };
        let (v, a) = (moving(at.v), moving(at.a));
        let mut out = Self {
            x: [zero.clone(), zero.clone(), zero.clone()],
            B: std::array::from_fn(|_| vec![0.0; FRAME * at.x.len()]),
        };
        for k in 0..at.x.len() / FRAME {
            let own = k * FRAME..(k + 1) * FRAME;
            let all = k * OPERATOR..(k + 1) * OPERATOR;
            let motion = [at.x, v, a].map(|x| &x[own.clone()]);
            let [x, x_dot, x_ddot] = out.x.each_mut().map(|x| &mut x[own.clone()]);
            let [B, B_dot, B_ddot] = out.B.each_mut().map(|B| &mut B[all.clone()]);
            ToPose.evaluate(
                at.t,
                motion,
                &mut [[x, B], [x_dot, B_dot], [x_ddot, B_ddot]],
            );
        }
        out
    }

    fn motion<'a>(&'a self, at: &Motion<'a>) -> Motion<'a> {
        let end = at.v.len();
        Motion {
            t: at.t,
            inputs: at.inputs,
            x: &self.x[0],
            v: &self.x[1][..end],
            a: &self.x[2][..end],
            previous: None,
        }
    }
}

/// Refuses rotation vectors outside of their charts.
fn inside(at: &Motion<'_>) -> Result<(), DomainError> {
    for x in at.x.chunks_exact(FRAME) {
        ToPose.domain(at.t, x)?;
    }
    Ok(())
}

impl Element for InCharts<'_> {
    fn dim(&self) -> usize {
        self.0.dim()
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        inside(at)?;
        let (n, poses) = (self.dim(), Poses::of(at));
        let (mut r, mut r_t) = (vec![0.0; n], vec![0.0; n]);
        let [mut K, mut C, mut M] = [(); 3].map(|()| vec![0.0; n * n]);
        let moving = !at.v.is_empty();
        let mut own = Response {
            r: &mut r,
            K: Some(&mut K),
            C: moving.then_some(&mut C),
            M: moving.then_some(&mut M),
            r_t: Some(&mut r_t),
        };
        self.0.evaluate(&poses.motion(at), &mut own)?;
        let mut parts = [&mut K[..], &mut C, &mut M];
        let parts = &mut parts[..if moving { 3 } else { 1 }];
        for first in (0..n).step_by(FRAME) {
            let own = first..first + FRAME;
            let operator =
                |B: &Vec<f64>| Matrix6::from_column_slice(&B[first * FRAME..][..OPERATOR]);
            let B = poses.B.each_ref().map(operator);
            let mut K_sigma = Matrix6::zeros();
            let (x, f) = (&at.x[own.clone()], &r[own.clone()]);
            ToPose.geometric_stiffness(at.t, x, f, K_sigma.as_mut_slice());
            tangents(parts, n, first, &B, &K_sigma);
            for covector in [&mut r, &mut r_t] {
                let own = &mut covector[own.clone()];
                let pulled = B[0].tr_mul(&Vector6::from_column_slice(own));
                own.copy_from_slice(pulled.as_slice());
            }
        }
        for (to, pulled) in [&mut out.K, &mut out.C, &mut out.M].into_iter().zip(parts) {
            if let Some(to) = to {
                add(to, pulled, 1.0);
            }
        }
        add(out.r, &r, 1.0);
        add(out.r_t.as_deref_mut().unwrap_or_default(), &r_t, 1.0);
        Ok(())
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            combined: None,
            energies: self.0.abilities().energies.is_some().then_some(self),
            enforced: None,
            sections: None,
        }
    }

    fn kinks(&self) -> Vec<f64> {
        self.0.kinks()
    }

    fn properties(&self) -> Properties {
        Properties {
            reads_poses: false,
            ..self.0.properties()
        }
    }

    fn kind(&self) -> &'static str {
        self.0.kind()
    }
}

impl ElementEnergies for InCharts<'_> {
    fn energy(&self, at: &Motion<'_>) -> f64 {
        self.0.abilities().energy(&Poses::of(at).motion(at))
    }

    fn kinetic_energy(&self, at: &Motion<'_>) -> Option<f64> {
        self.0.abilities().kinetic_energy(&Poses::of(at).motion(at))
    }

    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        self.0.abilities().dissipation(&Poses::of(at).motion(at))
    }
}
