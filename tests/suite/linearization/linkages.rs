//! Modes of linkages do not depend on how their loops are closed.

use crate::support::program::example;
use pullback::input::{Analysis, Closure, JointSpring, ModelFile, job, parse};
use pullback::integrators::linearization::{ModeOptions, Modes, linearize, modes};
use pullback::manifold::system::Point;

/// A linkage of the gallery without its loads, with a spring in each joint of one coordinate.
pub(super) fn sprung(name: &str) -> ModelFile {
    let mut file = parse(name, &example(name)).unwrap();
    file.loads.clear();
    file.probes.clear();
    file.initial.clear();
    file.analysis = Analysis::Modes(Default::default());
    for (i, joint) in file.joints.iter_mut().enumerate() {
        (joint.value, joint.rate, joint.actuator, joint.prescribed) = (None, None, None, None);
        if ["revolute", "prismatic"].contains(&joint.kind.as_str()) {
            joint.spring = Some(JointSpring {
                k: 2.0 + i as f64,
                ..JointSpring::default()
            });
        }
    }
    file
}

/// The linkage with its loops closed so.
pub(super) fn closed_by(
    file: &ModelFile,
    closure: Option<Closure>,
    penalty: Option<f64>,
) -> ModelFile {
    let mut file = file.clone();
    for joint in file.joints.iter_mut().filter(|j| j.child.is_some()) {
        (joint.closure, joint.penalty) = (closure, penalty);
    }
    file
}

fn closed(file: &ModelFile, closure: Option<Closure>, penalty: Option<f64>) -> Modes {
    let mut job = job("linkage", &closed_by(file, closure, penalty), None).unwrap();
    let q = job.context.initial().to_vec();
    let lin = linearize(&mut job.context, Point::statics(0.0, &q)).unwrap();
    let found = modes(&lin, &ModeOptions::lowest(4)).unwrap();
    assert!(found.modes.iter().all(|mode| mode.residual < 1e-8));
    found
}

#[test]
fn modes_by_maps_multipliers_and_penalties() {
    for name in "four_bar slider_crank bricard four_bar_flexible parallelograms".split(' ') {
        let file = sprung(name);
        let by_map = closed(&file, None, None);
        let by_multipliers = closed(&file, Some(Closure::Multipliers), None);
        assert!(!by_map.modes.is_empty(), "{name}");
        assert_eq!(by_map.counted, by_multipliers.counted, "{name}");
        assert_eq!(by_map.modes.len(), by_multipliers.modes.len(), "{name}");
        // The error of a penalty is proportional to its flexibility.
        let errors = [1e5, 1e6].map(|penalty| {
            let soft = closed(&file, Some(Closure::Penalty), Some(penalty));
            soft.modes[0].omega() / by_map.modes[0].omega() - 1.0
        });
        let order = (errors[0] / errors[1]).log10();
        assert!((order - 1.0).abs() < 0.1, "{name}: {errors:?}");
        for (a, b) in by_map.modes.iter().zip(&by_multipliers.modes) {
            let error = a.omega() / b.omega() - 1.0;
            assert!(error.abs() < 1e-8, "{name}: {a:?} {b:?}");
        }
    }
}
