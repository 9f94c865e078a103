//! A joint that follows a function of time, and one that it moves.

use crate::support::dynamics::{assert_slopes, grounded, observed, point, revolute, tight};
use crate::support::prelude::*;

const MASS: f64 = 2.0;

#[test]
fn a_carriage_on_a_driven_boom_is_flung_and_pulls_at_the_drive() {
    let (omega, first, to) = (2.5, 0.4, 0.8);
    let errors: Vec<Vec<f64>> = [100, 200, 400]
        .map(|steps| {
            let (mut b, ground) = grounded();
            let hub = revolute(&mut b, "hub", ground, [0.0, 0.0, 1.0]);
            b.prescribe_coordinate(hub.coordinates[0], 0, Proportional(omega));
            let rail = Prismatic::new([1.0, 0.0, 0.0]).unwrap();
            let boom = b.attach("boom", hub.frame, rail).unwrap();
            b.element("mass", PointMass::new(MASS).unwrap(), &[boom.frame])
                .unwrap();
            let mut context = Context::new(b.build().unwrap());
            let options = tight(Scheme::default(), to, to / steps as f64);
            let run = observed(&mut context, [&[first], &[0.0]], &options, &mut |_, _| ());
            // r̈ = Ω² r, and the moment of the drive is the rate of m r² Ω.
            let (cosh, sinh) = ((omega * to).cosh(), (omega * to).sinh());
            let (r, rate) = (first * cosh, first * omega * sinh);
            let state = &run.state;
            let at = point(state);
            context
                .evaluate(at, Evaluation::residual(&mut [0.0]))
                .unwrap();
            let [_, moment] = context.joint_force(hub.frame).unwrap();
            let exact = 2.0 * MASS * r * rate * omega;
            vec![
                (state.q[0] - r).abs(),
                (state.v[0] - rate).abs(),
                (moment.z - exact).abs(),
            ]
        })
        .into();
    let names = ["way", "rate", "moment"];
    assert_slopes("boom", &names, &errors, 2.0, 0.1);
    assert!(errors[2].iter().all(|e| *e < 1e-2), "{errors:?}");
}
