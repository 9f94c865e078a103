//! Linear buckling: critical loads by linear extrapolation of the tangent.

use super::differences::derivative_of;
use super::modes::ModesError;
use super::search::Search;
use super::{Linearized, check_count, linearize};
use crate::abilities::events;
use crate::failure::{find_mechanism, unresisted};
use crate::linear_solver::{AutoSolver, LinearError, LinearSolver, MatrixSymmetry, max_abs};
use crate::vectors::dot;
use pullback_manifold::system::{Evaluation, Point, System, SystemError, Weights};
use std::ops::ControlFlow;
use thiserror::Error;

/// A critical point of the linear extrapolation.
#[derive(Clone, Debug, PartialEq)]
pub struct BucklingMode {
    /// Critical value of the load parameter.
    pub load: f64,
    /// Buckling shape ψ, with ψᵀ K ψ = 1 for the tangent K at the state.
    pub shape: Vec<f64>,
    /// |ψᵀ K ψ| for the tangent K at this load and the coordinates extrapolated to it: zero where the tangent is
    /// linear in the load, and infinite at coordinates without a tangent; or the relative change of the rate at which loads
    /// grow, on the mean up to this load or at it, if that is larger. Where it is small, the load is off by about this share of
    /// its distance from the state.
    pub error: f64,
}

/// Error of [`buckling`].
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BucklingError {
    /// The state cannot be linearised.
    #[error(transparent)]
    Linearization(#[from] super::LinearizationError),
    /// The tangent is not symmetric, at the state or at loads beside it.
    #[error(
        "the tangent is not symmetric, so that no potential decides on stability: moments and follower loads may \
         lead to flutter, which `modes` finds"
    )]
    Asymmetric,
    /// The state is unstable, or a mechanism.
    #[error(
        "the equilibrium from which critical loads are extrapolated is not stable; begin at a smaller load"
    )]
    Unstable,
    /// The tangent does not change.
    #[error(
        "no load or prescribed motion that changes with the load parameter changes the tangent: nothing buckles"
    )]
    NoLoad,
    /// The tangent cannot be solved with.
    #[error(
        "{}",
        unresisted(
            source,
            mechanism,
            "hold it by a support or a spring, or begin at a smaller load"
        )
    )]
    Singular {
        /// The error of the solver.
        source: LinearError,
        /// Components of what moves without resistance by name, largest first.
        mechanism: Vec<(String, f64)>,
    },
    /// The search failed.
    #[error(transparent)]
    Search(#[from] ModesError),
}

impl From<SystemError> for BucklingError {
    fn from(error: SystemError) -> Self {
        super::LinearizationError::from(error).into()
    }
}

/// Largest change of a coordinate, relative to its scale, in the differences of tangents.
const CHANGE: f64 = 1e-3;

/// The critical loads nearest to that of a stable equilibrium, by growing distance from it; below it as well.
///
/// K(t) ≈ K + (t − t₀) K_t is singular there, where K_t is the derivative of the tangent along the equilibrium path, behind a
/// kink at t₀, from differences of the fourth order. The loads are exact where the tangent is linear in the load, as with a
/// straight column, and an estimate elsewhere.
///
/// # Errors
/// [`BucklingError`].
pub fn buckling(
    system: &mut dyn System,
    at: Point<'_>,
    count: usize,
) -> Result<Vec<BucklingMode>, BucklingError> {
    buckling_while(system, at, count, &mut |_| ControlFlow::Continue(()))
}

/// As [`buckling`], with an observer as that of [`modes_while`](super::modes_while).
///
/// # Errors
/// [`BucklingError`].
pub fn buckling_while(
    system: &mut dyn System,
    at: Point<'_>,
    count: usize,
    observer: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<Vec<BucklingMode>, BucklingError> {
    check_count(count)?;
    let mut lin = linearize(system, Point::statics(at.t, at.q))?;
    if !lin.is_symmetric(&lin.K) {
        return Err(BucklingError::Asymmetric);
    }
    let (_, load_rate) = loads(system, at)?;
    let rate = path_rate(system, &lin, &load_rate)?;
    let kinks = events(system).kinks();
    let mut tangent = |t: f64, s: f64| {
        let q: Vec<f64> = at.q.iter().zip(&rate).map(|(q, x)| q + s * x).collect();
        let (mut r, mut K) = (vec![0.0; q.len()], vec![0.0; lin.pattern.len()]);
        let out = Evaluation::with_tangent(&mut r, Weights::STATIC, &mut K);
        system.evaluate(Point::statics(t, &q), out)?;
        Ok(K)
    };
    let change = tangent_rate(&lin, at.t, step(&lin, &rate), &kinks, &mut tangent)?;
    lin.M = change.iter().map(|K| -K).collect();
    if lin.M.iter().all(|K| *K == 0.0) {
        return Err(BucklingError::NoLoad);
    }
    let mut search = Search::indefinite(&lin, count)?;
    if search.is_unstable()? {
        return Err(BucklingError::Unstable);
    }
    let found = search.run(observer)?;
    let mut modes = Vec::new();
    for (shape, _) in found.vectors {
        let shape: Vec<f64> = shape.iter().map(|x| x.re).collect();
        let form = |values: &[f64]| dot(&shape, &lin.product(values, &shape));
        let (stiffness, change) = (form(&lin.K), form(&lin.M));
        let distance = stiffness / change;
        let there = tangent(at.t + distance, distance)
            .map_or(f64::INFINITY, |K| (form(&K) / stiffness).abs());
        modes.push(BucklingMode {
            load: at.t + distance,
            shape: shape.iter().map(|x| x / stiffness.sqrt()).collect(),
            error: if there.is_nan() { f64::INFINITY } else { there },
        });
    }
    for mode in &mut modes {
        mode.error = change_of_growth(system, at, mode.load, &load_rate).max(mode.error);
    }
    Ok(modes)
}

/// The derivative of the tangent along the path, from tangents at (load parameter, distance along the path): by the coordinates
/// with a step h, and by what is prescribed.
fn tangent_rate(
    lin: &Linearized,
    t: f64,
    h: f64,
    kinks: &[f64],
    tangent: &mut dyn FnMut(f64, f64) -> Result<Vec<f64>, SystemError>,
) -> Result<Vec<f64>, BucklingError> {
    let mut symmetric = true;
    let mut checked = |t: f64, s: f64| {
        let K = tangent(t, s)?;
        symmetric &= lin.is_symmetric(&K);
        Ok(K)
    };
    let along = derivative_of(h, |s| checked(t, s))?;
    let (beside, reach) = smooth(kinks, t);
    let by_itself = derivative_of(reach, |s| checked(beside + s, 0.0))?;
    match symmetric {
        true => Ok(along.iter().zip(by_itself).map(|(a, b)| a + b).collect()),
        false => Err(BucklingError::Asymmetric),
    }
}

/// Relative change of the rate at which loads grow, on the mean up to another load parameter or there, such as that of loads that
/// have stopped growing.
fn change_of_growth(system: &mut dyn System, at: Point<'_>, to: f64, rate: &[f64]) -> f64 {
    let (Ok((before, _)), Ok((after, there))) =
        (loads(system, at), loads(system, Point { t: to, ..at }))
    else {
        return f64::INFINITY;
    };
    let mean = after.iter().zip(before).map(|(b, a)| (b - a) / (to - at.t));
    let rates = mean.chain(there).zip(rate.iter().chain(rate));
    rates.fold(0.0, |most, (x, rate)| (x - rate).abs().max(most)) / max_abs(rate)
}

/// Part of the distance to the next kink in which a derivative behind a kink is taken.
const BEHIND: f64 = 1e-4;

/// A load parameter at t or just behind it, and a step of differences there that reach over no kink.
fn smooth(kinks: &[f64], t: f64) -> (f64, f64) {
    let ahead = (kinks.iter().map(|k| k - t)).filter(|x| *x > 0.0);
    let ahead = ahead.fold(1.0, f64::min);
    let since = (kinks.iter().map(|k| t - k)).filter(|x| *x >= 0.0);
    let since = since.fold(1.0, f64::min);
    match since < BEHIND * ahead {
        true => (t + BEHIND * ahead, 0.5 * BEHIND * ahead),
        false => (t, 0.5 * since.min(ahead)),
    }
}

/// Step of the load parameter for differences of tangents along the path.
fn step(lin: &Linearized, rate: &[f64]) -> f64 {
    let all = lin.pattern.coordinates().iter().zip(rate);
    let sizes = all
        .filter(|(info, _)| !info.is_multiplier)
        .map(|(info, x)| (x / info.size).abs());
    let fastest = sizes.fold(0.0, f64::max);
    if fastest > 0.0 { CHANGE / fastest } else { 1.0 }
}

/// r and ∂r/∂t of a static state.
fn loads(system: &mut dyn System, at: Point<'_>) -> Result<(Vec<f64>, Vec<f64>), SystemError> {
    let (mut r, mut rate) = (vec![0.0; at.q.len()], vec![0.0; at.q.len()]);
    let out = Evaluation {
        r_t: Some(&mut rate),
        ..Evaluation::residual(&mut r)
    };
    system.evaluate(Point::statics(at.t, at.q), out)?;
    Ok((r, rate))
}

/// dq/dt along the equilibrium path: K dq/dt = ∂r/∂t.
fn path_rate(
    system: &dyn System,
    lin: &Linearized,
    load_rate: &[f64],
) -> Result<Vec<f64>, BucklingError> {
    let mut rate = load_rate.to_vec();
    let solved = AutoSolver::new(&lin.pattern, MatrixSymmetry::Symmetric)
        .and_then(|mut solver| solver.factorise_and_solve(&lin.K, &mut rate));
    solved.map_err(|source| BucklingError::Singular {
        source,
        mechanism: find_mechanism(system, &lin.K),
    })?;
    Ok(rate)
}
