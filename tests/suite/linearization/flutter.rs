//! Limits of stability: flutter under follower loads, and divergence; see also examples/critical_loads.rs.

use super::{X, assert_near};
use crate::support::beams::line;
use crate::support::closures::fixed;
use crate::support::*;
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

/// Two rods with springs under a dead load lose their stability by divergence at (3 − √5)/2, with or without dampers.
#[test]
fn divergence_is_a_stability_limit() {
    for c in [0.0, 0.1] {
        let spring = format!("spring = {{ k = 1, c = {c:?} }}");
        let text = [
            GROUND,
            "[analysis.modes]\n",
            &hinge("A", "ground", &spring),
            &arm("a", "A", X.map(f64::from)),
            &hinge("B", "a", &spring),
            &arm("b", "B", [2.0, 0.0, 0.0]),
            &body_of("a", 1.0, ""),
            &body_of("b", 1.0, ""),
            "[[loads]]\nnode = \"b\"\nforce = [-1, 0, 0]\ntime = { proportional = 1 }\n",
        ]
        .concat();
        let mut context = started(&text).context;
        let options = StaticOptions::default();
        for range in [[0.1, 1.0], [0.2, 0.5], [0.0, 0.7]] {
            let found = stability_limit(&mut context, &[0.0; 2], range, 2, &options).unwrap();
            assert_near(found.t, 0.5 * (3.0 - 5.0_f64.sqrt()), 1e-10);
        }
    }
}

/// Ziegler's double pendulum without damping flutters at 7/2 − √2 (Ziegler 1952), also beside a pendulum with a damper that has
/// nothing to do with it.
#[test]
fn a_damper_elsewhere_leaves_flutter_as_it_is() {
    for c in [0.0, 0.1] {
        let text = [
            GROUND,
            "[analysis.modes]\n",
            &hinge("A", "ground", "spring = { k = 1 }"),
            &arm("a", "A", X.map(f64::from)),
            &hinge("B", "a", "spring = { k = 1 }"),
            &arm("b", "B", [2.0, 0.0, 0.0]),
            &hinge("C", "ground", &format!("spring = {{ k = 30, c = {c:?} }}")),
            &arm("c", "C", X.map(f64::from)),
            &body_of("a", 2.0, ""),
            &body_of("b", 1.0, ""),
            &body_of("c", 1.0, ""),
            "[[loads]]\nnode = \"b\"\nforce = [-1, 0, 0]\nfollower = true\ntime = { proportional = 1 }\n",
        ]
        .concat();
        let mut context = started(&text).context;
        let options = StaticOptions::default();
        for range in [[1.0, 3.0], [0.0, 2.6], [0.1, 2.2]] {
            let found = stability_limit(&mut context, &[0.0; 3], range, 3, &options).unwrap();
            assert_near(found.t, 3.5 - 2.0_f64.sqrt(), 1e-10);
        }
    }
}
