//! The laws of a whole model: of each component where the model uses it, and of the assembled system.

mod inside;
mod joint;
mod segments;
mod states;
mod transport;
mod view;

use crate::elements::{Component, InCharts, Request, element_at, evaluate, invariance};
use crate::forces::{parts, system_at};
use crate::{Forces, Layout, Random, Report, TestState};
use pullback_elements::model::Context;
use pullback_manifold::system::System;
use states::{Size, beside, moving};

/// The states at which a model is checked.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelOptions {
    /// Seed of the random generator: the same seed gives the same report.
    pub seed: u64,
    /// Time, or load parameter; not a kink of a function of time, where there are no derivatives.
    pub t: f64,
    /// Coordinates of the first state, around which others are drawn; the reference configuration if empty.
    pub q: Vec<f64>,
    /// Number of random states besides the first; a few suffice for large models.
    pub states: usize,
}

impl Default for ModelOptions {
    fn default() -> Self {
        Self {
            seed: 0,
            t: 0.37,
            q: Vec::new(),
            states: 3,
        }
    }
}

/// Checks a model: every element and load, every joint, and the assembled system; at `options.q` and at random states
/// around it, at rest and in motion. The report has one row for each component and law, that of the state with the
/// largest [`Measure::strain`](crate::Measure::strain).
///
/// - elements and loads: the laws of [`element`](super::element); internal forces and energies are invariant under a
///   superposed rigid motion, and all under a change of chart. Both hold to round-off, or in the limit of small
///   relative motions of the nodes if an element interpolates total rotation vectors: the name of the law says which;
/// - joints: B, ẋ, ẍ, Ḃ, B̈ and K_σ are derivatives of φ, frames move rigidly with their parents; motion and forces are
///   continuous between the pieces of a map and the segments of a chain;
/// - the system: K, C, M block row by block row, their symmetry, the combined tangent; a change of the charts of nodes
///   and back preserves positions, velocities, forces and energies; d(T + U)/dt is the power supplied less the power
///   dissipated.
///
/// Errors are relative to the lengths, stiffnesses and frequencies of each component. Maps that reparametrize
/// ([`Reparametrization`]) do so once, at the end, and the model keeps these coordinates.
///
/// Maps that consist of several pieces keep the one that holds at each state, also beyond its ends
/// ([`MapState::freeze_piece`]): the third derivative of a curve through points is smooth only between them.
///
/// Joints at the boundary of their domain, such as a slide at the end of its chain, are checked a little inside.
///
/// The report on a model that cannot be evaluated at `options.q` is one failure with the reason. In a formulation by spins
/// ([`Formulation`](pullback_elements::model::Formulation)) a context is checked before a run: rates are spins after it, of which M is no
/// second derivative of T.
///
/// [`MapState::freeze_piece`]: pullback_manifold::map::MapState::freeze_piece
/// [`Reparametrization`]: pullback_manifold::map::Reparametrization
pub fn model(context: &mut Context, options: &ModelOptions) -> Report {
    // Random states violate the equations of multipliers.
    context.watch_equations(false);
    let report = all(context, options);
    context.watch_equations(true);
    report
}

fn all(context: &mut Context, options: &ModelOptions) -> Report {
    let mut report = Report::new("model");
    let n = context.pattern().dim();
    let mut q = options.q.clone();
    q.resize(n, 0.0);
    let mut random = Random::new(options.seed);
    let units = view::node_units(context);
    let mut layout = view::layout(context, &units);
    inside::step_inside(context, options.t, &mut q, &units);

    let mut plan = vec![("start".to_owned(), Size::NONE)];
    for k in 0..options.states {
        let size = if k % 2 == 0 { Size::FAR } else { Size::NEAR };
        plan.push((format!("random {}", k + 1), size));
    }
    let mut seen: Vec<(String, Vec<TestState>)> = Vec::new();
    let (at_start, first) = ((options.t, q.as_slice()), context.state().clone());
    let mut last = None;
    for (k, (at, size)) in plan.iter().enumerate() {
        context.freeze_pieces(None);
        let rest = match beside(context, at_start, &first, *size, &units, &mut random) {
            Ok(rest) => rest,
            Err(error) => {
                report.impossible("domain", at, error.to_string());
                return report;
            }
        };
        context.freeze_pieces(Some((rest.t, rest.x.as_slice())));
        if k == 0 {
            layout.rate = own_rate(context, &rest, &layout.units()).unwrap_or(1.0);
        }
        let motion = moving(&rest, &layout.units(), layout.rate, &mut random);
        let states = [
            (format!("{at}, at rest"), rest),
            (format!("{at}, moving"), motion),
        ];
        report.extend(system_at("model", &layout, context, &states));
        transport::laws(&mut report, context, &layout, &states[1], &mut random);
        joint::laws(&mut report, context, &units, &states[1], &mut random);
        if k + 1 == plan.len() && view::reparametrizes(context) {
            last = Some(states[1].clone());
        }
        let elements = 0..context.elements().len();
        let own = elements.map(|k| view::element_state(context, k, options.t));
        seen.push((at.clone(), own.collect()));
    }
    for k in 0..context.elements().len() {
        let positions = seen.iter().map(|(at, states)| (at.as_str(), &states[k]));
        let own = component(context, k, &units, layout.rate, positions, &mut random);
        report.extend(own);
    }
    if let Some(state) = last {
        transport::rewriting(&mut report, context, &layout, &state);
    }
    context.freeze_pieces(None);
    report.worst()
}

/// The laws of one element or load at its states in the model.
fn component<'a>(
    context: &Context,
    k: usize,
    units: &[f64],
    rate: f64,
    positions: impl Iterator<Item = (&'a str, &'a TestState)>,
    random: &mut Random,
) -> Report {
    let own = view::element(context, k, units);
    let charts = InCharts(own.thing);
    let element = charts.element();
    let mut own = Component {
        thing: element,
        ..own
    };
    own.layout.rate = rate;
    let mut states = Vec::new();
    for (at, rest) in positions {
        if states.is_empty() {
            let all = evaluate(element, &rest.still(), Request::All);
            let own_rate = all.and_then(|f| element_rate(&own.layout, &f));
            own.layout.rate = own_rate.unwrap_or(rate);
        }
        states.push((format!("{at}, at rest"), rest.clone()));
        let motion = moving(rest, &own.layout.units(), own.layout.rate, random);
        states.push((format!("{at}, moving"), motion));
    }
    let mut report = element_at(&own.name, &own.layout, &states, element);
    invariance::laws(&mut report, &own, &states, random);
    report.worst()
}

/// A typical frequency: the geometric mean of √(K/M) over the diagonal, where there are both.
fn mean_rate(pairs: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let both = pairs.filter(|&(K, M)| K != 0.0 && M > 0.0);
    let logs = both.map(|(K, M)| 0.5 * (K.abs() / M).ln());
    let logs: Vec<f64> = logs.filter(|log| log.is_finite()).collect();
    let mean = logs.iter().sum::<f64>() / logs.len() as f64;
    mean.exp().is_normal().then(|| mean.exp())
}

fn element_rate(layout: &Layout, f: &Forces) -> Option<f64> {
    // The largest stiffness and the largest mass: others may be small by chance.
    let units = layout.units();
    let most = |A: &nalgebra::DMatrix<f64>| {
        let diagonal = A.diagonal();
        let scaled = diagonal.iter().zip(&units).map(|(a, u)| a.abs() * u * u);
        scaled.fold(0.0, f64::max)
    };
    mean_rate(std::iter::once((most(&f.K), most(&f.M))))
}

/// Smallest stiffness, as an energy, over the largest: below it is the rounding error of a coordinate without
/// stiffness.
const NONE: f64 = 1e-12;

/// The model's rate at a state.
fn own_rate(context: &mut Context, s: &TestState, units: &[f64]) -> Option<f64> {
    let (_, [K, _, M]) = parts(context, &s.still())?;
    let diagonal = |values: Vec<f64>| -> Vec<f64> {
        let own = context.pattern().diagonal();
        own.map(|k| values[k]).collect()
    };
    let [K, M] = [K, M].map(diagonal);
    let energy = |(K, u): (&f64, &f64)| K.abs() * u * u;
    let most = K.iter().zip(units).map(energy).fold(0.0, f64::max);
    let all = K.iter().zip(M).zip(units);
    let resists = all.filter(|((K, _), u)| energy((K, u)) > NONE * most);
    mean_rate(resists.map(|((K, M), _)| (*K, M)))
}
