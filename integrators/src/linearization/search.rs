//! The search for modes by shift and invert in a Krylov subspace.

use super::Linearized;
use super::krylov::{Krylov, RitzPair};
use super::modes::{Mode, ModeOptions, ModesError, Selection};
use super::shift_invert::{Order, ShiftInvert};
use crate::linear_solver::LinearError;
use crate::random::Random;
use num_complex::Complex64;
use std::ops::ControlFlow;

mod counting;
mod selection;
mod start;

use selection::{BETWEEN, FINITE, WANDERING};

/// Up to this size of the operator all unit vectors are start vectors, a dense method.
const DENSE: usize = 120;
/// Steps between two looks at the eigenvalues; with damping, whose dense eigenvalues cost more than steps, as a part of the basis.
const LOOK: usize = 2;
const LOOK_DAMPED: usize = 3;
/// Steps after which another start vector shows a mode that is missing.
const CHECK: usize = 16;
/// Most changes of the shift.
const SHIFTS: usize = 12;
/// The radius that is counted, relative to the distance of the last mode from the shift.
const MARGIN: f64 = 1e-3;
/// Relative difference of eigenvalues that are one.
const EQUAL: f64 = 1e-6;

/// The search, with its operator and options.
pub(super) struct Search<'a> {
    lin: &'a Linearized,
    selection: Selection,
    order: Order,
    inner: Inner,
    operator: ShiftInvert<'a>,
    factorisations: usize,
    /// The first shift if it is not zero, or zero: without damping ω² of the modes selected.
    middle: f64,
    /// Whether rigid modes exclude a shift of zero.
    rigid: bool,
    /// They make the matrix of the first shift one of entries of order one.
    scales: Vec<f64>,
    /// Weights of the inner product where M is not used, and the factor of M with velocities.
    weights: Vec<f64>,
    balance: f64,
    random: Random,
}

impl<'a> Search<'a> {
    /// A search before its first factorisation. With damping, `undamped` are the modes without, if these can be counted.
    pub fn new(
        lin: &'a Linearized,
        options: &ModeOptions,
        undamped: &[Mode],
    ) -> Result<Self, ModesError> {
        let order = options.order(lin);
        let symmetric =
            order == Order::Squares && lin.is_symmetric(&lin.K) && lin.is_symmetric(&lin.M);
        let inner = match symmetric {
            true => Inner::Mass,
            false => Inner::Coordinates,
        };
        let mut search = Self::with(lin, options.selection, order, inner)?;
        if let [first, .., last] = undamped {
            search.middle = BETWEEN * last.omega();
            search.rigid = first.omega() == 0.0;
        }
        Ok(search)
    }

    /// A search for the eigenvalues σ of K − σ M nearest to zero, where K is positive definite and M may be indefinite.
    pub fn indefinite(lin: &'a Linearized, count: usize) -> Result<Self, ModesError> {
        let selection = Selection::Nearest { count, omega: 0.0 };
        Self::with(lin, selection, Order::Squares, Inner::Stiffness)
    }

    fn with(
        lin: &'a Linearized,
        selection: Selection,
        order: Order,
        inner: Inner,
    ) -> Result<Self, ModesError> {
        Ok(Self {
            lin,
            selection,
            order,
            inner,
            operator: ShiftInvert::new(lin, order, inner != Inner::Coordinates)?,
            factorisations: 0,
            middle: match selection {
                Selection::Nearest { omega, .. } if order == Order::Squares => omega * omega,
                _ => 0.0,
            },
            rigid: false,
            scales: vec![1.0; lin.dim()],
            weights: Vec::new(),
            balance: 1.0,
            random: Random(0),
        })
    }

    /// Finds the modes.
    pub fn run(
        mut self,
        observer: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Found, ModesError> {
        let mut expected = self.number_in_range()?;
        if expected == Some(0) {
            return Ok(self.report(Vec::new(), expected, false));
        }
        let mut shift = self.first_shift()?;
        let mut krylov = self.krylov()?;
        let (mut shifts, mut steps, mut starts) = (0, None, 1);
        let (mut converged, mut limit) = (0, usize::MAX);
        loop {
            if krylov.len() > limit {
                return Err(not_converged(converged, &krylov));
            }
            let pairs = self.advance(&mut krylov, steps.take(), observer)?;
            if let Some(other) = self.better_shift(&pairs).filter(|_| shifts < SHIFTS) {
                shifts += 1;
                if let Ok(near) = self.factorise_near(other) {
                    shift = near;
                    (krylov, starts) = (self.krylov()?, 1);
                    continue;
                }
                self.factorise(shift)?;
                shifts = SHIFTS;
            }
            converged = self.converged(&pairs);
            let enough = self.wanted(&pairs[..converged], expected);
            limit = 200 + CHECK * starts + 8 * enough.unwrap_or(converged);
            let Some(wanted) = enough.or_else(|| krylov.is_exhausted().then_some(converged)) else {
                continue;
            };
            // Of a repeated frequency, a Krylov subspace holds one mode for each start vector.
            if wanted > 0
                && !self.is_symmetric()
                && self.is_missing(&krylov, &pairs[..wanted], enough.is_some(), observer)?
                && self.add_starts(&mut krylov, 1)?
            {
                starts += 1;
                steps = Some(CHECK);
                continue;
            }
            let complete = krylov.is_exhausted() && converged == pairs.len();
            let vectors = self.vectors(&krylov, &pairs[..converged])?;
            let missing = self.missing(&pairs, converged, wanted, &mut expected);
            if missing == 0 {
                return Ok(self.report(vectors, expected, complete));
            }
            if self.operator.shift() != shift {
                self.factorise(shift)?;
            }
            starts += missing;
            if !self.add_starts(&mut krylov, missing)? {
                return Err(not_converged(converged, &krylov));
            }
        }
    }

    fn report(
        self,
        vectors: Vec<(Vec<Complex64>, Complex64)>,
        counted: Option<usize>,
        complete: bool,
    ) -> Found {
        Found {
            complete: complete && vectors.len() < self.selection.most(),
            vectors,
            counted,
            factorisations: self.factorisations,
            scales: self.scales,
        }
    }

    /// Whether K is known to have negative eigenvalues.
    pub fn is_unstable(&mut self) -> Result<bool, ModesError> {
        Ok(self.below(0.0)?.is_some_and(|n| n > 0))
    }

    /// Whether the operator is self-adjoint in the inner product.
    pub fn is_symmetric(&self) -> bool {
        self.inner != Inner::Coordinates
    }

    fn factorise(&mut self, shift: f64) -> Result<(), LinearError> {
        self.factorisations += 1;
        self.operator.factorise(shift)
    }

    /// Factorises at a shift, or beside it if it is an eigenvalue; returns the shift.
    fn factorise_near(&mut self, shift: f64) -> Result<f64, ModesError> {
        let mut error = LinearError::NotReady;
        for part in [0.0, 1e-9, 1e-6, 1e-3] {
            let near = shift * (1.0 + part);
            match self.factorise(near) {
                Ok(()) => return Ok(near),
                Err(error @ LinearError::NonFinite { .. }) => return Err(error.into()),
                Err(other) => error = other,
            }
        }
        let name = match &error {
            LinearError::ZeroRow { unknown }
            | LinearError::VanishingPivot { unknown, .. }
            | LinearError::Singular { unknown, .. } => self.lin.names[*unknown].clone(),
            _ => "unknown".to_owned(),
        };
        Err(ModesError::Singular { error, name })
    }

    /// This many more steps or some, all if the method is dense; returns the eigenvalues of the operator.
    fn advance(
        &mut self,
        krylov: &mut Krylov<'_>,
        steps: Option<usize>,
        observer: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<RitzPair>, ModesError> {
        let count = match self.selection {
            Selection::Nearest { count, .. } => count,
            Selection::Range(_) => 0,
        };
        let (first, some) = match self.is_symmetric() {
            true => (count + 8, LOOK),
            false => (4 * count + 8, krylov.len() / LOOK_DAMPED),
        };
        let end = match self.weights.len() {
            size if size <= DENSE => usize::MAX,
            _ => (krylov.len() + steps.unwrap_or(some)).max(first),
        };
        while krylov.len() < end {
            let Some((v, Gv)) = krylov.next() else {
                break;
            };
            let Mv = (self.inner == Inner::Mass).then_some(Gv);
            let product = self.operator.apply(v, Mv)?;
            krylov.take(product);
            if observer(krylov.len()).is_break() {
                return Err(ModesError::Interrupted);
            }
        }
        let pairs = krylov.ritz().ok_or_else(|| not_converged(0, krylov))?;
        Ok(self.without_wandering(pairs))
    }

    /// Whether an eigenvalue of the operator is not among these, where none are counted: the largest one that a start vector
    /// without their part finds, as it is the first to converge. If they are enough it is larger than the last of them.
    fn is_missing(
        &mut self,
        krylov: &Krylov<'_>,
        pairs: &[RitzPair],
        enough: bool,
        observer: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<bool, ModesError> {
        let [first, last] =
            [pairs.first(), pairs.last()].map(|p| p.map_or(0.0, |p| p.theta.norm()));
        let least = if enough { last } else { FINITE * first };
        let mut others = self.empty();
        let upper = pairs.iter().filter(|p| self.is_upper(p));
        for x in krylov.combine(&parts(upper)) {
            others.add(x);
        }
        others.lock();
        self.add_starts(&mut others, 1)?;
        while others.len() < krylov.len()
            && let Some((v, _)) = others.next()
        {
            let product = self.operator.apply(v, None)?;
            others.take(product);
            if observer(krylov.len()).is_break() {
                return Err(ModesError::Interrupted);
            }
            if others.len().is_multiple_of(LOOK) || others.is_exhausted() {
                let pairs = others.ritz().ok_or_else(|| not_converged(0, &others))?;
                let near = |p: &&RitzPair| p.residual <= WANDERING * p.theta.norm();
                if let Some(first) = pairs.iter().find(near)
                    && first.residual <= EQUAL * first.theta.norm()
                {
                    return Ok(first.theta.norm() > least * (1.0 + EQUAL));
                }
            }
        }
        Ok(false)
    }

    /// The eigenvectors of converged pairs, as selected, and their eigenvalues.
    fn vectors(
        &mut self,
        krylov: &Krylov<'_>,
        pairs: &[RitzPair],
    ) -> Result<Vec<(Vec<Complex64>, Complex64)>, ModesError> {
        let mut chosen: Vec<&RitzPair> = pairs
            .iter()
            .filter(|p| self.is_upper(p) && self.is_in_range(p))
            .collect();
        if let Selection::Nearest { count, omega } = self.selection {
            if self.order == Order::Quadratic || omega != 0.0 {
                let distance = |p: &RitzPair| self.distance(p, omega);
                chosen.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
            }
            chosen.truncate(count);
        }
        let parts = parts(chosen.iter().copied());
        // One product more reduces the error, and leaves no part without mass or velocity.
        let mut images = match krylov.images(&parts) {
            Some(images) => images,
            None => {
                let vectors = krylov.combine(&parts).into_iter();
                let images = vectors.map(|x| self.operator.apply(&x, None));
                images.collect::<Result<_, _>>()?
            }
        };
        let dim = self.lin.dim();
        images.iter_mut().for_each(|x| x.truncate(dim));
        let mut images = images.into_iter();
        let mut vectors = Vec::with_capacity(chosen.len());
        for pair in chosen {
            let re = images.next().unwrap_or_default();
            let im = match is_real(pair) {
                true => vec![0.0; dim],
                false => images.next().unwrap_or_default(),
            };
            let parts = re.into_iter().zip(im);
            let vector = parts.map(|(re, im)| Complex64::new(re, im)).collect();
            vectors.push((vector, self.eigenvalue(pair)));
        }
        Ok(vectors)
    }
}

fn is_real(pair: &RitzPair) -> bool {
    pair.vector.iter().all(|x| x.im == 0.0)
}

/// The real and imaginary parts of eigenvectors.
fn parts<'a>(pairs: impl Iterator<Item = &'a RitzPair>) -> Vec<Vec<f64>> {
    let mut parts: Vec<Vec<f64>> = Vec::new();
    for pair in pairs {
        parts.push(pair.vector.iter().map(|x| x.re).collect());
        if !is_real(pair) {
            parts.push(pair.vector.iter().map(|x| x.im).collect());
        }
    }
    parts
}

fn not_converged(converged: usize, krylov: &Krylov<'_>) -> ModesError {
    ModesError::NotConverged {
        converged,
        dimension: krylov.len(),
    }
}

/// The inner product of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Inner {
    /// M, if the problem is symmetric.
    Mass,
    /// K, if M is indefinite.
    Stiffness,
    /// A sum over scaled coordinates.
    Coordinates,
}

/// Eigenvectors of any length, and their eigenvalues ω² or λ.
pub(super) struct Found {
    pub vectors: Vec<(Vec<Complex64>, Complex64)>,
    /// See [`Modes`](super::Modes).
    pub counted: Option<usize>,
    /// Whether there are no others.
    pub complete: bool,
    /// Number of factorisations.
    pub factorisations: usize,
    /// See [`Search`].
    pub scales: Vec<f64>,
}
