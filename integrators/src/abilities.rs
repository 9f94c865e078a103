//! The optional abilities of a system, each with the default for a system without it.

use pullback_manifold::system::{
    ChartChanges, Energies, Events, Point, RigidRates, Symmetry, System, SystemError,
};

/// See [`Charts::change_charts`](pullback_manifold::system::Charts::change_charts).
pub(crate) fn change_charts(
    system: &mut dyn System,
    t: f64,
    q: &mut [f64],
    v: &mut [f64],
    accelerations: &mut [&mut [f64]],
) -> ChartChanges {
    match system.charts() {
        Some(charts) => charts.change_charts(t, q, v, accelerations),
        None => ChartChanges::default(),
    }
}

/// See [`Charts::start`](pullback_manifold::system::Charts::start).
pub(crate) fn start(system: &mut dyn System, t: f64, q: &[f64]) {
    if let Some(charts) = system.charts() {
        charts.start(t, q);
    }
}

/// A system without discontinuities.
struct Smooth;

impl Events for Smooth {}

/// The discontinuities of a system; those of a smooth one by default.
pub(crate) fn events(system: &mut dyn System) -> &mut dyn Events {
    // Of no size: nothing is allocated.
    system
        .events()
        .unwrap_or_else(|| Box::leak(Box::new(Smooth)))
}

/// See [`Energetics::energies`](pullback_manifold::system::Energetics::energies).
pub(crate) fn energies(
    system: &mut dyn System,
    at: Point<'_>,
) -> Result<Option<Energies>, SystemError> {
    let energies = system.energetics().map(|system| system.energies(at));
    energies.transpose()
}

/// See [`Energetics::dissipation`](pullback_manifold::system::Energetics::dissipation).
pub(crate) fn dissipation(
    system: &mut dyn System,
    at: Point<'_>,
) -> Result<Option<f64>, SystemError> {
    let dissipation = system.energetics().map(|system| system.dissipation(at));
    dissipation.transpose()
}

/// See [`Energetics::momentum`](pullback_manifold::system::Energetics::momentum).
pub(crate) fn momentum(
    system: &mut dyn System,
    at: Point<'_>,
    p: &mut [f64],
) -> Result<bool, SystemError> {
    (system.energetics()).map_or(Ok(false), |system| system.momentum(at, p))
}

/// See [`Energetics::symmetries`](pullback_manifold::system::Energetics::symmetries).
pub(crate) fn symmetries(
    system: &mut dyn System,
    span: [f64; 2],
    q: &[f64],
    v: &[f64],
) -> Vec<Symmetry> {
    (system.energetics()).map_or_else(Vec::new, |system| system.symmetries(span, q, v))
}

/// See [`Energetics::rigid_rates`](pullback_manifold::system::Energetics::rigid_rates).
pub(crate) fn rigid_rates(
    system: &mut dyn System,
    q: &[f64],
    motion: &RigidRates,
    rates: &mut [f64],
) {
    match system.energetics() {
        Some(system) => system.rigid_rates(q, motion, rates),
        None => rates.fill(0.0),
    }
}
