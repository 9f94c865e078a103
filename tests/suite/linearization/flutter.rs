//! Flutter of Ziegler's double pendulum (Ziegler 1952; Herrmann & Jong 1965): masses 2m and m, equal springs, a
//! force that follows the second rod.

use super::assert_near;
use crate::support::beams::line;
use crate::support::closures::{GROUND, arm, body_of, fixed, hinge};
use pullback::input::assemble_text;
use pullback::integrators::linearization::{StabilityError, StabilityLimit, stability_limit};
use pullback::integrators::statics::StaticOptions;

/// Load and frequency at which it begins to flutter, with springs of stiffness 1, dampers, and rods of length 1.
fn flutter(damping: f64) -> StabilityLimit {
    let spring = format!("spring = {{ k = 1.0, c = {damping:?} }}");
    let text = [
        GROUND,
        "[analysis.modes]\n",
        &hinge("A", "ground", &spring),
        &arm("a", "A", [1.0, 0.0, 0.0]),
        &hinge("B", "a", &spring),
        &arm("b", "B", [2.0, 0.0, 0.0]),
        &body_of("a", 2.0, ""),
        &body_of("b", 1.0, ""),
        "[[loads]]\nnode = \"b\"\nforce = [-1, 0, 0]\nfollower = true\ntime = { proportional = 1 }\n",
    ]
    .concat();
    let mut context = assemble_text("model.toml", &text).unwrap().context;
    let options = StaticOptions::default();
    stability_limit(&mut context, &[0.0; 2], [1.0, 3.0], 2, &options).unwrap()
}

#[test]
fn two_frequencies_meet() {
    let found = flutter(0.0);
    let exact = 3.5 - 2.0_f64.sqrt();
    assert_near(found.t, exact, 1e-10);
    assert!(found.mode.frequency() > 0.0, "{:?}", found.mode.eigenvalue);
}

#[test]
fn small_dampers_destabilise() {
    assert_near(flutter(1e-4).t, 41.0 / 28.0, 1e-6);
}

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
