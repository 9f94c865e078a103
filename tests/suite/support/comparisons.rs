//! Models that comparisons of schemes and of formulations run, and the comparison of a text.

use super::closures::{GROUND, beam_line, body_of, fixed, joint};
use super::laboratory;
use nalgebra::{UnitQuaternion, Vector3};
use pullback::input;
use pullback::studies::compare::{CompareError, Comparison, ComparisonOptions, ErrorQuantity};

/// A free symmetrical body: moments of inertia 2, 2 and 1.
pub const BODY: &str = r#"
title = "Free symmetrical body"
[nodes]
O = [0, 0, 0]
[[bodies]]
name = "body"
node = "O"
mass = 1
inertia = [2, 2, 1]
[[initial]]
node = "O"
body_angular_velocity = [3, 0, 4]
[analysis.dynamic]
to = 2
step = 0.01
scheme = { newmark = [0.25, 0.5] }
"#;

/// The exact rotation of its axis about its fixed angular momentum J ω₀, with |L|/J₁, and that of itself, which turns
/// about its axis with Ω₃ (1 − J₃/J₁) (Landau & Lifshitz, Mechanics, section 33).
pub fn precession(t: f64) -> [UnitQuaternion<f64>; 2] {
    let [about, spin] = [[6.0, 0.0, 4.0], [0.0, 0.0, 4.0]].map(|twice| Vector3::from(twice) / 2.0);
    let [turned, spun] = [about, spin].map(|rate| UnitQuaternion::from_scaled_axis(rate * t));
    [turned, turned * spun]
}

/// A mass of 1 on a spring of stiffness 4, let go at 0.3: x = 0.3 cos 2t.
pub fn oscillator() -> String {
    let spring = "axis = [1, 0, 0]\nspring = { k = 4 }\nvalue = 0.3";
    [
        GROUND,
        &joint("slider", "prismatic", "ground", spring),
        &body_of("slider", 1.0, ""),
        "[analysis.dynamic]\nto = 8\nstep = 0.01\nscheme = { newmark = [0.25, 0.5] }\n",
    ]
    .concat()
}

/// A rod of two elements on a ball joint, on its way round at an angular velocity; then what else the model has.
pub fn rod(spin: &str, more: &str) -> String {
    let initial = format!("angular_velocity = {spin}\nabout = [0, 0, 0]\n");
    [
        "[sections.rod]\nstiffness = { EA = 400, GA = [400, 400], GJ = 4, EI = [4, 4] }\n\
         mass = { A_rho = 1, J = [0.1, 0.05, 0.05] }\n\
         [nodes]\nground = [0, 0, 0]\ntip = [1, 0, 0]\n",
        &fixed("ground"),
        &joint("ball", "spherical", "ground", ""),
        "[[initial]]\nline = \"rod\"\n",
        &initial,
        &beam_line("rod", ["ball", "tip"], 2, "rod"),
        more,
    ]
    .concat()
}

/// The order of an error that the runs of a scheme show.
#[track_caller]
pub fn assert_observed(
    comparison: &Comparison,
    scheme: &str,
    quantity: ErrorQuantity,
    order: f64,
    within: f64,
) {
    let mut all = comparison.orders.iter();
    let found = all.find(|o| o.scheme == scheme).unwrap().of(quantity);
    let near = found.is_some_and(|found| (found.order - order).abs() < within);
    assert!(near, "{scheme}, {}: {found:?}", quantity.name());
}

/// The comparison of a model of this text.
pub fn compared(text: &str, options: &ComparisonOptions) -> Result<Comparison, CompareError> {
    laboratory::compared(&input::parse("model.toml", text).unwrap(), options)
}
