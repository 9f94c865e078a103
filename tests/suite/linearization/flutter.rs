//! Flutter of a column under a follower load; that of Ziegler's double pendulum is in examples/critical_loads.rs.

use super::assert_near;
use crate::support::beams::line;
use crate::support::closures::fixed;
use pullback::input::assemble_text;
use pullback::integrators::linearization::{StabilityError, stability_limit};
use pullback::integrators::statics::StaticOptions;

/// Beck's column, a cantilever under a force that follows its tip: flutter at P L²/EI = 20.0509536 with
/// ω L² √(m/EI) = 11.0155576 (Beck 1952; roots of the characteristic equation with 9 digits).
#[test]
fn a_column_flutters_under_a_follower_force() {
    let stiffness = "EA = 1e7, GA = [1e7, 1e7], GJ = 1.0, EI = [4.0, 1.0]";
    let rest = "[sections.main.mass]\nA_rho = 1.0\nJ = [2e-8, 1e-8, 1e-8]\n".to_owned()
        + &fixed("A")
        + "[[loads]]\nnode = \"B\"\nforce = [-1, 0, 0]\nfollower = true\ntime = { proportional = 1 }\n[analysis.modes]\n";
    let job = assemble_text("model.toml", &line(stiffness, 6, 3, &rest));
    let mut context = job.unwrap().context;
    let q = vec![0.0; context.initial().len()];
    let options = StaticOptions::default();
    let mut limit = |range| stability_limit(&mut context, &q, range, 6, &options);
    let found = limit([0.0, 30.0]).unwrap();
    assert_near(found.t, 20.0509536, 1e-5);
    assert_near(found.mode.omega(), 11.0155576, 1e-5);
    assert!(matches!(limit([0.0, 10.0]), Err(StabilityError::Stable(_))));
    assert!(matches!(limit([25.0; 2]), Err(StabilityError::Unstable(_))));
}
