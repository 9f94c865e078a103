//! The optional abilities of a system, each with the default for a system without it.

use pullback_manifold::system::{
    ChartChanges, Charts, Energetics, Energies, Events, Point, System, SystemError,
};

/// A system without charts that change, discontinuities, energies, momenta and symmetries.
struct Plain;

impl Charts for Plain {
    fn change_charts(
        &mut self,
        _: f64,
        _: &mut [f64],
        _: &mut [f64],
        _: &mut [&mut [f64]],
    ) -> ChartChanges {
        ChartChanges::default()
    }
}

impl Events for Plain {}

impl Energetics for Plain {
    fn energies(&mut self, _: Point<'_>) -> Result<Energies, SystemError> {
        Ok(Energies::default())
    }
}

/// A plain system; it has no size, so that nothing is allocated.
fn plain() -> &'static mut Plain {
    Box::leak(Box::new(Plain))
}

/// The charts of a system; those of a plain one by default.
pub(crate) fn charts(system: &mut dyn System) -> &mut dyn Charts {
    system.charts().unwrap_or_else(|| plain())
}

/// The discontinuities of a system; those of a plain one by default.
pub(crate) fn events(system: &mut dyn System) -> &mut dyn Events {
    system.events().unwrap_or_else(|| plain())
}

/// The momenta and symmetries of a system, none by default.
pub(crate) fn energetics(system: &mut dyn System) -> &mut dyn Energetics {
    system.energetics().unwrap_or_else(|| plain())
}

/// See [`Energetics::energies`]; `None` for a system without energies.
pub(crate) fn energies(
    system: &mut dyn System,
    at: Point<'_>,
) -> Result<Option<Energies>, SystemError> {
    let energies = system.energetics().map(|system| system.energies(at));
    energies.transpose()
}
