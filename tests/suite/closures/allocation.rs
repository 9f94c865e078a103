//! A step in time with multipliers or a penalty allocates nothing.

use crate::support::dynamics::{grounded, revolute, weighed};
use crate::support::loops::DOWN;
use crate::support::prelude::*;
use allocation_counter::measure;
use pullback::elements::constraint::PenaltyStiffness;

/// Allocations of a run of so many steps: a double pendulum whose second body flies freely but for a
/// joint, and is closed to a third one, which is redundant in part. It does not get far: which
/// equations are left out is chosen anew on longer ways, as charts are.
fn allocations(steps: u32, by: Closure) -> u64 {
    let (mut b, ground) = grounded();
    let e3 = [0.0, 0.0, 1.0];
    let first = revolute(&mut b, "A", ground, e3);
    let arm = b.offset("arm", first.frame, [1.0, 0.0, 0.0]).unwrap();
    let pin = revolute(&mut b, "P", arm, e3);
    let free = b.node("free", [1.0, 0.0, 0.0]).unwrap();
    let foot = b.offset("foot", ground, [2.0, 0.5, 0.0]).unwrap();
    let rocker = revolute(&mut b, "D", foot, e3);
    let end = b.offset("end", rocker.frame, [2.0, 0.0, 0.0]).unwrap();
    let tip = b.offset("tip", free, [2.0, 0.0, 0.0]).unwrap();
    let last = revolute(&mut b, "Q", tip, e3);
    for (name, node) in [("1", first.frame), ("2", free), ("3", rocker.frame)] {
        let body = RigidBody::new(1.0, Matrix3::identity() * 0.1, Vector3::x() * 0.1).unwrap();
        weighed(&mut b, name, node, body, DOWN);
    }
    b.close_by(pin.frame, free, by).unwrap();
    b.close_by(last.frame, end, by).unwrap();
    let mut context = Context::new(b.build().unwrap());
    let options = DynamicOptions {
        scheme: Scheme::chung_hulbert(0.8).unwrap(),
        ..DynamicOptions::new(f64::from(steps) * 1e-4, 1e-4)
    };
    let zero = vec![0.0; context.initial().len()];
    let mut progress = Progress::new(start(&context, 0.0, context.initial(), &zero).unwrap());
    let counted = measure(|| {
        let mut observer = |_: &mut Context, _: &StepReport<'_>| ControlFlow::Continue(());
        integrate(&mut context, &mut progress, &options, &mut observer).unwrap();
    });
    assert_eq!(progress.summary.steps, steps as usize);
    counted.count_total
}

#[test]
fn twice_as_many_steps_allocate_no_more() {
    let stiffness = PenaltyStiffness { p: 1e6, tau: 1e-3 };
    for by in [Closure::Multipliers, Closure::Penalty(stiffness)] {
        allocations(100, by);
        let [few, many] = [100, 200].map(|steps| allocations(steps, by));
        assert!(few > 0, "the counter counts");
        assert_eq!(few, many, "{by:?}");
    }
}
