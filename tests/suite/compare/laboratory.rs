//! The laboratory of integrators on models of the gallery: how loops hold, and momenta that are zero.

use crate::support::laboratory::{compared, model, options, until};
use crate::support::program::example;
use pullback::input;

#[test]
fn residuals_of_loops_are_tabulated() {
    let linkage = |closure: &str| {
        let text = example("four_bar").replace("child = ", &format!("{closure}\nchild = "));
        let file = until(input::parse("four_bar.toml", &text).unwrap(), 0.2);
        let comparison = compared(&file, &options(&["ga:0.8", "radau"], &[0.02, 0.01])).unwrap();
        let violations = comparison.rows.iter().map(|row| {
            assert_eq!(row.failure, None, "{closure}, {}", row.scheme);
            row.drift.violation.unwrap()
        });
        violations.fold(0.0, f64::max)
    };
    // What Newton's method leaves, and the compliance of the penalty, with forces of order 10.
    assert!(linkage("") < 1e-11);
    assert!(linkage("closure = \"multipliers\"") < 1e-9);
    let [soft, stiff] =
        ["1e5", "1e6"].map(|p| linkage(&format!("closure = \"penalty\"\npenalty = {p}")));
    assert!((0.05..0.2).contains(&(stiff / soft)), "{soft:e} {stiff:e}");
    // A model without loops has none.
    let file = until(model("pendulum.toml"), 0.1);
    let comparison = compared(&file, &options(&["newmark"], &[0.02, 0.01])).unwrap();
    let mut violations = comparison.rows.iter().map(|row| row.drift.violation);
    assert!(violations.all(|violation| violation.is_none()));
}

#[test]
fn momenta_that_are_zero_in_a_plane_are_no_merit() {
    // The pendulum swings about e2: its momentum has no component there, its angular momentum no other one.
    let file = until(model("pendulum.toml"), 0.5);
    let both = options(&["newmark", "projected-newmark"], &[0.02, 0.01]);
    let comparison = compared(&file, &both).unwrap();
    let zero = [[false, true, false], [true, false, true]];
    assert_eq!(comparison.zero_momenta, zero);
    let kept = comparison.reference.as_ref().unwrap().conserved;
    assert!(kept.momentum[1] && kept.angular_momentum[0]);
    for row in &comparison.rows {
        let drift = &row.drift;
        assert_eq!([drift.momentum, drift.angular_momentum], [None; 2]);
        assert!(drift.energy.is_some());
    }
    // A free body in space has no such component.
    let file = until(model("free_body.toml"), 0.1);
    let comparison = compared(&file, &options(&["newmark"], &[0.004, 0.002])).unwrap();
    assert_eq!(comparison.zero_momenta, [[true; 3], [false; 3]]);
    assert!(comparison.rows[0].drift.angular_momentum.is_some());
}
