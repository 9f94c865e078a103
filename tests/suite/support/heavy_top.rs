//! The heavy top of R01 in any method.

use super::dynamics::*;
use super::program::{changed, example};
use nalgebra::Vector3;
use pullback::method::Method;

/// Changes of the heavy top of the examples: a free body that multipliers hold at its foot, equations of index 3.
pub const HELD: &str = r#"[nodes] => &\ntop = [0, 0, 0]
name = "top" => name = "ball"
parent = "ground" => &\nchild = "top"\nclosure = "multipliers"
"joint_force" => "position""#;

/// The order of each method and the position of the centre of mass at t = 1.
pub fn assert_heavy_top(changes: &str, methods: &[(&str, i32)]) {
    // R01: order-8 Runge-Kutta in extended precision.
    let exact = Vector3::new(0.1733439640984, 0.6400885920706, -0.7484907911336);
    let text = changed(&example("heavy_top"), changes);
    for &(method, order) in methods {
        let method: Method = method.parse().unwrap();
        let position = |h: f64| -> Vector3<f64> {
            let mut job = formulated(&text, method.formulation());
            let top = job.context.find("top").unwrap();
            let options = tight(method.scheme(), 1.0, h);
            let start = [&job.start.q[..], &job.start.v];
            observed(&mut job.context, start, &options, &mut |_, _| ());
            job.context.node_state(top).R.column(1).into()
        };
        let runs = [4e-4, 2e-4, 1e-4].map(position);
        let errors = runs.map(|x| (x - exact).norm());
        assert_order(method, &errors, f64::from(order), 0.1);
        let extrapolated = runs[2] + (runs[2] - runs[1]) / (2.0_f64.powi(order) - 1.0);
        let gap = (extrapolated - exact).norm();
        assert!(gap < 1e-5, "{method}: {extrapolated}");
    }
}
