//! First-order form with outputs: A, B, C, D.

use super::differences::{by_input, derivative_of, step};
use super::{Linearized, events};
use nalgebra::DMatrix;
use pullback_manifold::system::{Evaluation, Point, System, SystemError};
use thiserror::Error;

/// Derivatives of outputs y(q, v, a, u) about a state; one row for each output.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputDerivatives {
    /// ∂y/∂q.
    pub q: DMatrix<f64>,
    /// ∂y/∂q̇.
    pub v: DMatrix<f64>,
    /// ∂y/∂q̈.
    pub a: DMatrix<f64>,
    /// ∂y/∂u of the inputs.
    pub u: DMatrix<f64>,
}

/// ẋ = A x + B δu, δy = C x + D δu.
#[derive(Clone, Debug, PartialEq)]
pub struct StateSpace {
    /// Of x by x.
    pub A: DMatrix<f64>,
    /// Of x by inputs.
    pub B: DMatrix<f64>,
    /// Of outputs by x.
    pub C: DMatrix<f64>,
    /// Of outputs by inputs.
    pub D: DMatrix<f64>,
    /// δq = N z with x = (z, ż): the identity without multipliers, otherwise a basis of the null space of h_x.
    pub N: DMatrix<f64>,
}

/// Why there is no first-order form.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum StateSpaceError {
    /// M is singular.
    #[error(
        "{0} moves without inertia, so that there is no first-order form: give every body and node that moves mass and, \
         where it rotates, inertia. A joint that is closed by a penalty has none: close the loop by a map or multipliers"
    )]
    Massless(String),
    /// Inputs move equations of multipliers.
    #[error(
        "an input moves {0}, an equation with a multiplier, so that its derivatives act as well; close \
         the loop by a map"
    )]
    Driven(String),
    /// Derivatives of outputs of another system.
    #[error(
        "derivatives of outputs by {found:?} coordinates and inputs; the system has {expected:?}"
    )]
    Outputs {
        /// Numbers of coordinates and inputs of the outputs.
        found: [usize; 2],
        /// Those of the system.
        expected: [usize; 2],
    },
    /// Outputs read multipliers.
    #[error("output {0} depends on a multiplier; close the loop by a map")]
    Reaction(usize),
}

/// Derivatives of outputs by coordinates, velocities, accelerations and inputs, by central differences of order four with steps
/// that become smaller until two agree.
///
/// `outputs` evaluates y at a point of the system, which has been evaluated there.
///
/// # Errors
/// Those of `outputs`, of a point at which the system cannot be evaluated, and of a number of outputs that changes.
pub fn output_derivatives<Y: System>(
    system: &mut Y,
    at: Point<'_>,
    mut outputs: impl FnMut(&mut Y, Point<'_>) -> Result<Vec<f64>, SystemError>,
) -> Result<OutputDerivatives, SystemError> {
    let n = system.pattern().dim();
    let (mut r, zeros) = (vec![0.0; n], vec![0.0; n]);
    let mut count = None;
    let mut outputs = |system: &mut Y, at: Point<'_>| {
        system.evaluate(at, Evaluation::residual(&mut r))?;
        let y = outputs(system, at)?;
        match *count.get_or_insert(y.len()) {
            count if count == y.len() => Ok(y),
            count => Err(SystemError::Request {
                what: "outputs",
                expected: format!("{count}, as before"),
                found: y.len().to_string(),
            }),
        }
    };
    let count = outputs(system, at)?.len();
    let coordinates = match count {
        0 => Vec::new(),
        _ => system.pattern().coordinates().to_vec(),
    };
    let full = |x: &[f64]| [x, &zeros[x.len()..]].concat();
    let mut state = [at.q.to_vec(), full(at.v), full(at.a)];
    let mut by_state = Vec::new();
    for k in 0..state.len() {
        let mut columns = Vec::new();
        for (i, info) in coordinates.iter().enumerate() {
            let value = state[k][i];
            let column = derivative_of(step(value, info.size), |dx| {
                state[k][i] = value + dx;
                let [q, v, a] = state.each_ref().map(Vec::as_slice);
                outputs(system, Point { t: at.t, q, v, a })
            });
            state[k][i] = value;
            columns.extend(column?);
        }
        by_state.push(columns);
    }
    let [q, v, a] = state.each_ref().map(Vec::as_slice);
    let at = Point { t: at.t, q, v, a };
    let inputs = events(system).inputs().to_vec();
    let mut by_inputs = Vec::new();
    for input in inputs.iter().copied().enumerate() {
        by_inputs.extend(by_input(system, input, &mut |system| outputs(system, at))?);
    }
    // Leaves the system at the state.
    outputs(system, at)?;
    let mut matrices = by_state.into_iter();
    let mut next = || DMatrix::from_vec(count, n, matrices.next().unwrap_or_default());
    Ok(OutputDerivatives {
        q: next(),
        v: next(),
        a: next(),
        u: DMatrix::from_vec(count, inputs.len(), by_inputs),
    })
}

/// Part of a derivative, relative to the largest, that counts as rounding of differences.
const ROUNDING: f64 = 1e-8;
/// Diagonal entries of R below this part of the largest belong to redundant equations.
const REDUNDANT: f64 = 1e-10;

impl Linearized {
    /// The first-order form in independent coordinates z, of which the state is x = (z, ż); with multipliers about a state at rest.
    ///
    /// Inputs are piecewise constant: their derivatives do not act.
    ///
    /// # Errors
    /// [`StateSpaceError`].
    pub fn state_space(&self, outputs: &OutputDerivatives) -> Result<StateSpace, StateSpaceError> {
        let n = self.dim();
        let inputs = self.r_u.len();
        let (found, expected) = ([outputs.q.ncols(), outputs.u.ncols()], [n, inputs]);
        if found != expected {
            return Err(StateSpaceError::Outputs { found, expected });
        }
        let r_u = DMatrix::from_iterator(n, inputs, self.r_u.iter().flatten().copied());
        let [K, C, M] = [&self.K, &self.C, &self.M].map(|values| self.pattern.matrix(values));
        let N = self.null_space(&K);
        for i in (0..n).filter(|&i| self.pattern.coordinates()[i].is_multiplier) {
            if r_u.row(i).amax() > ROUNDING * r_u.amax() {
                return Err(StateSpaceError::Driven(self.names[i].clone()));
            }
            for y in [&outputs.q, &outputs.v, &outputs.a] {
                let reads = |&k: &usize| y[(k, i)].abs() > ROUNDING * y.amax();
                if let Some(output) = (0..y.nrows()).find(reads) {
                    return Err(StateSpaceError::Reaction(output + 1));
                }
            }
        }
        let reduced = |A: &DMatrix<f64>| N.tr_mul(&(A * &N));
        let mass = reduced(&M);
        let massless = || {
            let eigen = mass.clone().symmetric_eigen();
            let motion = &N * eigen.eigenvectors.column(eigen.eigenvalues.imin());
            StateSpaceError::Massless(self.names[motion.iamax()].clone())
        };
        let factors = mass.clone().cholesky().ok_or_else(massless)?;
        let solve = |b: DMatrix<f64>| -> Result<DMatrix<f64>, StateSpaceError> {
            let x = factors.solve(&b);
            let residual = (&mass * &x - &b).amax();
            let size = mass.amax() * x.amax() + b.amax();
            match residual <= ROUNDING * size {
                true => Ok(x),
                false => Err(massless()),
            }
        };
        let [stiffness, damping] = [solve(reduced(&K))?, solve(reduced(&C))?];
        let forces = solve(N.tr_mul(&r_u))?;
        let (z, y) = (N.ncols(), outputs.q.nrows());
        let [y_q, y_v, y_a] = [&outputs.q, &outputs.v, &outputs.a].map(|y| y * &N);
        let mut out = StateSpace {
            A: DMatrix::zeros(2 * z, 2 * z),
            B: DMatrix::zeros(2 * z, inputs),
            C: DMatrix::zeros(y, 2 * z),
            D: &outputs.u + &y_a * &forces,
            N,
        };
        out.A.view_mut((0, z), (z, z)).fill_with_identity();
        out.A.view_mut((z, 0), (z, z)).copy_from(&-&stiffness);
        out.A.view_mut((z, z), (z, z)).copy_from(&-&damping);
        out.B.view_mut((z, 0), (z, inputs)).copy_from(&forces);
        let positions = y_q - &y_a * stiffness;
        out.C.view_mut((0, 0), (y, z)).copy_from(&positions);
        out.C
            .view_mut((0, z), (y, z))
            .copy_from(&(y_v - y_a * damping));
        Ok(out)
    }

    /// A basis of the displacements that the equations with multipliers, rows of K, leave free.
    fn null_space(&self, K: &DMatrix<f64>) -> DMatrix<f64> {
        let n = self.dim();
        let (held, free): (Vec<usize>, Vec<usize>) =
            (0..n).partition(|&i| self.pattern.coordinates()[i].is_multiplier);
        let equations = DMatrix::from_fn(free.len(), held.len(), |i, j| K[(held[j], free[i])]);
        let mut Qt = DMatrix::identity(free.len(), free.len());
        let mut rank = 0;
        if !held.is_empty() && !free.is_empty() {
            let qr = equations.col_piv_qr();
            qr.q_tr_mul(&mut Qt);
            let R = qr.r();
            let diagonal = |k: usize| R[(k, k)].abs();
            let pivots = R.nrows().min(R.ncols());
            rank = (0..pivots)
                .filter(|k| diagonal(*k) > REDUNDANT * diagonal(0))
                .count();
        }
        let mut N = DMatrix::zeros(n, free.len() - rank);
        for (row, &i) in free.iter().enumerate() {
            for k in rank..free.len() {
                N[(i, k - rank)] = Qt[(k, row)];
            }
        }
        N
    }
}
