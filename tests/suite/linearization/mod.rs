//! Linearised equations of motion and their modes.

mod beams;
mod buckling;
mod campbell;
mod flutter;
mod inputs;
mod linkages;
mod rotors;
mod small;
mod state_space;

#[track_caller]
fn assert_near(found: f64, exact: f64, tolerance: f64) {
    assert!((found / exact - 1.0).abs() < tolerance, "{found} {exact}");
}
