//! The inverse of a shifted pencil, whose largest eigenvalues belong to the modes nearest to the shift.

use super::Linearized;
use crate::linear_solver::{AutoSolver, LinearError, LinearSolver, MatrixSymmetry};
use crate::statics::enforced_equations;
use crate::vectors::add;

/// Order of an eigenvalue problem in its eigenvalue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    /// (K − σ M) x = 0 of the squares σ = ω², without C.
    Squares,
    /// (K + s C + s² M) x = 0, with vectors (x, s x).
    Quadratic,
}

/// The operator (K − σ M)⁻¹ M, or that of the companion form of K + s C + s² M, with eigenvalues
/// θ = 1/(λ − shift).
pub(super) struct ShiftInvert<'a> {
    lin: &'a Linearized,
    order: Order,
    shift: f64,
    solver: AutoSolver,
    values: Vec<f64>,
}

impl<'a> ShiftInvert<'a> {
    /// The operator before its factorisation.
    ///
    /// # Errors
    /// [`LinearError`] of the analysis of the pattern.
    pub fn new(lin: &'a Linearized, order: Order, symmetric: bool) -> Result<Self, LinearError> {
        let symmetry = match symmetric {
            true => MatrixSymmetry::Symmetric,
            false => MatrixSymmetry::General,
        };
        Ok(Self {
            lin,
            order,
            shift: 0.0,
            solver: AutoSolver::new(&lin.pattern, symmetry)?,
            values: Vec::new(),
        })
    }

    /// Factorises at a shift.
    ///
    /// # Errors
    /// [`LinearError`] if the shift is an eigenvalue.
    pub fn factorise(&mut self, shift: f64) -> Result<(), LinearError> {
        let (c, m) = match self.order {
            Order::Squares => (0.0, -shift),
            Order::Quadratic => (shift, shift * shift),
        };
        self.shift = shift;
        let matrices = self.lin.K.iter().zip(&self.lin.M);
        self.values.clear();
        self.values.extend(matrices.map(|(K, M)| K + m * M));
        if c != 0.0 {
            add(&mut self.values, c, &self.lin.C);
        }
        self.solver.factorise(&self.values)
    }

    /// Number of eigenvalues below the shift of the last factorisation, of a symmetric pencil with a mass
    /// matrix that is not negative; `None` if unknown.
    ///
    /// By Sylvester's law of inertia it is the number of negative eigenvalues of K − σ M, less one for each
    /// equation with a multiplier.
    pub fn below(&mut self) -> Option<usize> {
        let negative = self.solver.negative_pivots(&self.values)?;
        negative.checked_sub(self.equations())
    }

    /// Number of equations with multipliers.
    fn equations(&self) -> usize {
        enforced_equations(&self.lin.pattern, &self.values)
    }

    /// Number of coordinates that equations with multipliers leave free.
    pub fn free_coordinates(&self) -> usize {
        let coordinates = self.lin.pattern.coordinates().iter();
        let coordinates = coordinates.filter(|info| !info.is_multiplier).count();
        coordinates.saturating_sub(self.equations())
    }

    /// The shift.
    pub fn shift(&self) -> f64 {
        self.shift
    }

    /// The matrix of the last factorisation.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Removes the part of a vector that violates equations with multipliers, as no mode does.
    ///
    /// # Errors
    /// As [`ShiftInvert::apply`].
    pub fn constrain(&mut self, x: &mut [f64]) -> Result<(), LinearError> {
        let coordinates = self.lin.pattern.coordinates();
        for part in x.chunks_exact_mut(self.lin.dim()) {
            let mut h = self.lin.product(&self.values, part);
            let others = h
                .iter_mut()
                .zip(coordinates)
                .filter(|(_, info)| !info.is_multiplier);
            others.for_each(|(h, _)| *h = 0.0);
            if h.iter().any(|h| *h != 0.0) {
                self.solver.solve(Some(&self.values), &mut h)?;
                add(part, -1.0, &h);
            }
        }
        Ok(())
    }

    /// The product of the operator and a vector x; `Mx` is M x, if it is known.
    ///
    /// # Errors
    /// [`LinearError`] of a solution that is not accurate.
    pub fn apply(&mut self, x: &[f64], Mx: Option<&[f64]>) -> Result<Vec<f64>, LinearError> {
        let (lin, s, n) = (self.lin, self.shift, self.lin.dim());
        if self.order == Order::Squares {
            let mut y = Mx.map_or_else(|| lin.product(&lin.M, x), <[f64]>::to_vec);
            self.solver.solve(Some(&self.values), &mut y)?;
            return Ok(y);
        }
        // −(K + s C + s² M) x' = M v + (C + s M) x,  v' = x + s x'.
        let (x, v) = x.split_at(n);
        let mut y = vec![0.0; n];
        let sum: Vec<f64> = x.iter().zip(v).map(|(x, v)| v + s * x).collect();
        lin.pattern.multiply_add(-1.0, &lin.M, &sum, &mut y);
        lin.pattern.multiply_add(-1.0, &lin.C, x, &mut y);
        self.solver.solve(Some(&self.values), &mut y)?;
        let v: Vec<f64> = x.iter().zip(&y).map(|(x, y)| x + s * y).collect();
        y.extend(v);
        Ok(y)
    }
}
