//! Forces per length along a beam element, and its self-weight.

#![allow(non_snake_case)]

use crate::beam::BeamError;
use crate::beam::shape::{gauss, lagrange};
use crate::element::{Element, ElementError, Motion, Response};
use crate::time::TimeFunction;
use nalgebra::Vector3;
use pullback_manifold::quotients::Quotients;
use pullback_manifold::so3;

/// A force per unit reference length on the nodes of a beam element, interpolated as the beam is.
///
/// Self-weight is the dead load Aρ g.
#[derive(Debug)]
pub struct LineLoad {
    /// Shape functions and weights at the integration points (one more than nodes).
    points: Vec<(Vec<f64>, f64)>,
    nodes: usize,
    /// What each node carries of a load that keeps its direction: ∫ Nᵢ.
    shares: Vec<f64>,
    follower: bool,
    force: Vector3<f64>,
    amplitude: Box<dyn TimeFunction>,
}

impl LineLoad {
    /// `force` per length times `amplitude` on an element through `places`; a follower load turns
    /// with the cross-sections.
    ///
    /// # Errors
    /// [`BeamError::Nodes`] unless there are two, three or four places.
    pub fn new(
        places: &[Vector3<f64>],
        force: [f64; 3],
        follower: bool,
        amplitude: Box<dyn TimeFunction>,
    ) -> Result<Self, BeamError> {
        let points = match places.len() {
            2 => integration_points::<2>(places),
            3 => integration_points::<3>(places),
            4 => integration_points::<4>(places),
            n => return Err(BeamError::Nodes(n)),
        };
        let share = |i: usize| points.iter().map(|(N, weight)| weight * N[i]).sum();
        Ok(Self {
            shares: (0..places.len()).map(share).collect(),
            points,
            nodes: places.len(),
            follower,
            force: force.into(),
            amplitude,
        })
    }
}

fn integration_points<const NN: usize>(places: &[Vector3<f64>]) -> Vec<(Vec<f64>, f64)> {
    gauss(NN)
        .into_iter()
        .map(|(xi, weight)| {
            let (N, dN) = lagrange::<NN>(xi);
            let slope: Vector3<f64> = places.iter().zip(dN).map(|(p, d)| p * d).sum();
            (N.to_vec(), weight * slope.norm())
        })
        .collect()
}

impl Element for LineLoad {
    fn dim(&self) -> usize {
        6 * self.nodes
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), ElementError> {
        let n = self.dim();
        let [amplitude, rate, _] = self.amplitude.at(at.t);
        if !self.follower {
            for (i, share) in self.shares.iter().enumerate() {
                for (k, f) in self.force.iter().enumerate() {
                    out.r[6 * i + k] += amplitude * share * f;
                    if let Some(r_t) = out.r_t.as_deref_mut() {
                        r_t[6 * i + k] += rate * share * f;
                    }
                }
            }
            return Ok(());
        }
        for (N, weight) in &self.points {
            let psi: Vector3<f64> =
                at.x.chunks_exact(6)
                    .zip(N)
                    .map(|(x, n)| Vector3::new(x[3], x[4], x[5]) * *n)
                    .sum();
            let c = Quotients::new(psi.norm()).tangent();
            let R = so3::R(&psi, &c);
            let f = R * self.force;
            let D = R * so3::skew(&self.force) * so3::T(&psi, &c) * -1.0;
            for i in 0..self.nodes {
                let w = weight * N[i];
                for k in 0..3 {
                    out.r[6 * i + k] += amplitude * w * f[k];
                    if let Some(r_t) = out.r_t.as_deref_mut() {
                        r_t[6 * i + k] += rate * w * f[k];
                    }
                }
                if let Some(K) = out.K.as_deref_mut() {
                    for j in 0..self.nodes {
                        for c in 0..3 {
                            for r in 0..3 {
                                K[6 * i + r + (6 * j + 3 + c) * n] -=
                                    amplitude * w * N[j] * D[(r, c)];
                            }
                        }
                    }
                }
            }
        }
        Ok(())
    }

    fn energy(&self, at: &Motion<'_>) -> f64 {
        if self.follower {
            return 0.0;
        }
        let nodes = at.x.chunks_exact(6).zip(&self.shares);
        let work: f64 = nodes
            .map(|(x, share)| share * self.force.dot(&Vector3::new(x[0], x[1], x[2])))
            .sum();
        -self.amplitude.at(at.t)[0] * work
    }

    fn is_symmetric(&self) -> bool {
        !self.follower
    }

    fn is_dead(&self) -> bool {
        !self.follower
    }

    fn is_load(&self) -> bool {
        true
    }

    fn kinks(&self) -> Vec<f64> {
        self.amplitude.kinks()
    }
}
