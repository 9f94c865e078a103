//! The optional abilities of a system, each with the default for a system without it.

use pullback_manifold::system::{
    ChartChanges, Energetics, Energies, Events, Point, System, SystemError,
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

/// A system without energies, momenta and symmetries.
struct Silent;

impl Energetics for Silent {
    fn energies(&mut self, _: Point<'_>) -> Result<Energies, SystemError> {
        Ok(Energies::default())
    }
}

/// The momenta and symmetries of a system, none by default.
pub(crate) fn energetics(system: &mut dyn System) -> &mut dyn Energetics {
    // Of no size: nothing is allocated.
    system
        .energetics()
        .unwrap_or_else(|| Box::leak(Box::new(Silent)))
}
