//! An element that reads poses, in the charts of its frames.

use crate::maps::motion;
use crate::vectors::add;
use nalgebra::{Matrix6, Vector6};
use pullback_elements::element::{
    Abilities, Element, ElementEnergies, Motion, Properties, Response,
};
use pullback_manifold::domain::DomainError;
use pullback_manifold::map::{Parametrization, ToPose};
use pullback_manifold::pullback::tangents;

/// An element that [reads poses](Properties::reads_poses), as an element of the coordinates (d, Ψ) of its frames, as in a
/// model.
pub struct InCharts<'a>(pub &'a dyn Element);

impl InCharts<'_> {
    /// This element if the given one reads poses, or else the given one.
    pub(crate) fn element(&self) -> &dyn Element {
        match self.0.properties().reads_poses {
            true => self,
            false => self.0,
        }
    }
}

/// Number of coordinates of a frame.
pub(super) const FRAME: usize = 6;

/// The poses of all frames and their rates, and the operators of each frame.
struct Poses {
    x: [Vec<f64>; 3],
    B: Vec<[Matrix6<f64>; 3]>,
}

impl Poses {
    fn of(at: &Motion<'_>) -> Self {
        let (mut x, mut B) = ([Vec::new(), Vec::new(), Vec::new()], Vec::new());
        for first in (0..at.x.len()).step_by(FRAME) {
            let own = |x: &'_ [f64]| x.get(first..first + FRAME).unwrap_or_default().to_vec();
            let [q, v, a] = [at.x, at.v, at.a].map(own);
            let [pose, rate, change, operators @ ..] = motion(&ToPose, at.t, [&q, &v, &a]);
            x.iter_mut()
                .zip([pose, rate, change])
                .for_each(|(x, own)| x.extend(own));
            B.push(operators.map(|B| Matrix6::from_column_slice(&B)));
        }
        Self { x, B }
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
        for (first, B) in (0..n).step_by(FRAME).zip(&poses.B) {
            let own = first..first + FRAME;
            let mut K_sigma = Matrix6::zeros();
            let (x, f) = (&at.x[own.clone()], &r[own.clone()]);
            ToPose.geometric_stiffness(at.t, x, f, K_sigma.as_mut_slice());
            tangents(parts, n, first, B, &K_sigma);
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
