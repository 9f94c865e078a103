//! Residual and tangents of energies in their own variables, by one evaluation of each over jets.

use super::EnergyElement;
use nalgebra::{SMatrix, SVector};
use pullback_manifold::jet::{Grad, Phase};
use pullback_manifold::scalar::Scalar;
use pullback_manifold::system::Weights;

/// A number with its derivative along the motion.
type Dual = Grad<f64, 1>;

fn dual(value: f64, rate: f64) -> Dual {
    Grad {
        v: value,
        g: [rate],
    }
}

/// r, K, C, M of energies in N variables.
pub(super) struct Local<const N: usize> {
    pub r: SVector<f64, N>,
    K: SMatrix<f64, N, N>,
    C: SMatrix<f64, N, N>,
    M: SMatrix<f64, N, N>,
}

impl<const N: usize> Local<N> {
    /// Evaluates at time, coordinates and, in motion, velocities and accelerations; with tangents
    /// if `wanted`.
    #[inline]
    pub(super) fn new<E: EnergyElement<N> + ?Sized>(
        e: &E,
        t: f64,
        x: &SVector<f64, N>,
        moving: Option<&(SVector<f64, N>, SVector<f64, N>)>,
        wanted: bool,
    ) -> Self {
        let mut out = Self {
            r: SVector::zeros(),
            K: SMatrix::zeros(),
            C: SMatrix::zeros(),
            M: SMatrix::zeros(),
        };
        if wanted {
            out.add::<E, N>(e, t, x, moving);
        } else {
            out.add::<E, 0>(e, t, x, moving);
        }
        out
    }

    /// Adds all terms; H is N for tangents, 0 for the residual alone.
    #[inline]
    fn add<E: EnergyElement<N> + ?Sized, const H: usize>(
        &mut self,
        e: &E,
        t: f64,
        x: &SVector<f64, N>,
        moving: Option<&(SVector<f64, N>, SVector<f64, N>)>,
    ) {
        self.add_potential(&potential::<f64, E, N, H>(e, t, x));
        let Some((v, a)) = moving else {
            return;
        };
        if E::KINETIC {
            let x_moving = SVector::<Dual, N>::from_fn(|i, _| dual(x[i], v[i]));
            let v_moving = SVector::<Dual, N>::from_fn(|i, _| dual(v[i], a[i]));
            let (x, v) = variables::<Dual, N, H>(&x_moving, &v_moving);
            self.add_kinetic(&e.kinetic(&x, &v));
        } else {
            debug_assert_eq!(
                e.kinetic(x, v),
                0.0,
                "an element without kinetic energy has some"
            );
        }
        if E::DISSIPATION {
            let (x, v) = variables::<f64, N, H>(x, v);
            self.add_dissipation(&e.dissipation(&x, &v));
        } else {
            debug_assert_eq!(
                e.dissipation(x, v),
                0.0,
                "an element without dissipation has some"
            );
        }
    }

    #[inline]
    fn add_potential<const H: usize>(&mut self, u: &Phase<f64, N, 0, H, 0>) {
        for i in 0..N {
            self.r[i] -= u.x[i];
        }
        for i in 0..H {
            for j in 0..=i {
                self.K[(i, j)] += u.xx[i][j];
                if j != i {
                    self.K[(j, i)] += u.xx[i][j];
                }
            }
        }
    }

    /// −d/dt ∂T/∂v + ∂T/∂x with its tangents.
    #[inline]
    fn add_kinetic<const H: usize>(&mut self, k: &Phase<Dual, N, N, H, H>) {
        for i in 0..N {
            self.r[i] += k.x[i].v - k.v[i].g[0];
        }
        for i in 0..H {
            for j in 0..H {
                let (low, high) = (i.max(j), i.min(j));
                let [vv, vv_dot] = [k.vv[low][high].v, k.vv[low][high].g[0]];
                self.M[(i, j)] += vv;
                self.C[(i, j)] += vv_dot + (k.vx[i][j].v - k.vx[j][i].v);
                self.K[(i, j)] += k.vx[i][j].g[0] - k.xx[low][high];
            }
        }
    }

    /// −∂D/∂v with its tangents.
    #[inline]
    fn add_dissipation<const H: usize>(&mut self, d: &Phase<f64, N, N, H, H>) {
        for i in 0..N {
            self.r[i] -= d.v[i];
        }
        for i in 0..H {
            for j in 0..H {
                self.C[(i, j)] += d.vv[i.max(j)][i.min(j)];
                self.K[(i, j)] += d.vx[i][j];
            }
        }
    }

    /// cK K + cC C + cM M.
    #[inline]
    pub(super) fn tangent(&self, weights: Weights) -> SMatrix<f64, N, N> {
        self.K * weights.K + self.C * weights.C + self.M * weights.M
    }
}

/// x and v as independent variables.
#[inline]
fn variables<S: Scalar, const N: usize, const H: usize>(
    x: &SVector<S, N>,
    v: &SVector<S, N>,
) -> (
    SVector<Phase<S, N, N, H, H>, N>,
    SVector<Phase<S, N, N, H, H>, N>,
) {
    (
        SVector::from_fn(|i, _| Phase::coordinate(x[i], i)),
        SVector::from_fn(|i, _| Phase::velocity(v[i], i)),
    )
}

/// U with its derivatives in x.
#[inline]
fn potential<S: Scalar, E: EnergyElement<N> + ?Sized, const N: usize, const H: usize>(
    e: &E,
    t: S,
    x: &SVector<S, N>,
) -> Phase<S, N, 0, H, 0> {
    let x = SVector::<Phase<S, N, 0, H, 0>, N>::from_fn(|i, _| Phase::coordinate(x[i], i));
    e.potential(Phase::given(t), &x)
}

/// ∂r/∂t = −∂²U/∂t∂x.
pub(super) fn load_rate<E: EnergyElement<N> + ?Sized, const N: usize>(
    e: &E,
    t: f64,
    x: &SVector<f64, N>,
) -> SVector<f64, N> {
    let x = SVector::<Dual, N>::from_fn(|i, _| dual(x[i], 0.0));
    let u = potential::<Dual, E, N, 0>(e, dual(t, 1.0), &x);
    SVector::from_fn(|i, _| -u.x[i].g[0])
}

/// v·∂D/∂v.
pub(super) fn power<E: EnergyElement<N> + ?Sized, const N: usize>(
    e: &E,
    x: &SVector<f64, N>,
    v: &SVector<f64, N>,
) -> f64 {
    let (x, jets) = variables::<f64, N, 0>(x, v);
    let d = e.dissipation(&x, &jets);
    v.iter().zip(&d.v).map(|(v, d)| v * d).sum()
}
