//! What docs/adding_an_integrator.md adds stands in the sources, and its scheme from outside has its
//! stated properties.

use crate::support::included::blocks;
use pullback::check;
use pullback::integrators::dynamics::DynamicsError;
use pullback::integrators::dynamics::scheme::{Scheme, SchemeProperties, Stage};

const PAGE: &str = include_str!("../../../docs/adding_an_integrator.md");

#[test]
fn its_lines_stand_where_it_says() {
    let sources = [
        include_str!("../../../integrators/src/dynamics/scheme/list.rs"),
        include_str!("../../../integrators/src/dynamics/scheme/mod.rs"),
        include_str!("../../../integrators/tests/suite/schemes/mod.rs"),
        include_str!("../../../integrators/tests/suite/schemes/conformance.rs"),
        include_str!("adding_an_integrator.rs"),
    ];
    let lines = blocks(PAGE, "```rs\n");
    assert_eq!(lines.len(), 5);
    for (text, source) in lines.into_iter().zip(sources) {
        assert!(source.contains(text), "{text}");
    }
}

/// Alexander's SDIRK of two stages (1977): order 2, L-stable, both stages with the same tangent. Under
/// multipliers its first stage is a backward difference of positions, which leaves velocities of order 1, and by them
/// positions of order 1.
fn alexander() -> Result<Scheme, DynamicsError> {
    let gamma = 1.0 - 0.5 * 2.0_f64.sqrt();
    let rows = [[0.0, gamma, 0.0], [0.0, 1.0 - gamma, gamma]];
    let properties = SchemeProperties {
        order: 2,
        limit: None,
        symmetric: false,
    };
    let scheme = Scheme::new(
        "Alexander",
        &Stage::runge_kutta([gamma, 1.0], rows),
        properties,
    )?;
    Ok(scheme.under_multipliers([1, 1]))
}

#[test]
fn a_scheme_from_outside_does_what_it_claims() {
    check::scheme(&alexander().unwrap()).assert();
}
