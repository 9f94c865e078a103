//! What is told of a state that was accepted is told in the charts in which it was balanced.

use crate::support::*;

#[test]
fn forces_of_an_accepted_state_do_not_depend_on_the_charts_to_come() {
    // Between rotations about two axes the interpolated one depends on the chart, and with it strains
    // and energy: by the square of the angle between the nodes, 0.1.
    let mut b = ModelBuilder::new();
    let ends = [0.0, 0.5].map(|x| b.node(format!("{x}"), [x, 0.0, 0.0]).unwrap());
    lay(&mut b, "beam", ends, 1, 1, coupled());
    let mut m = Context::new(b.build().unwrap());
    let turned = |angle: f64| {
        let mut q = vec![0.0; 12];
        for (node, axis) in [(ends[0], [0.0, 0.0, 1.0]), (ends[1], [0.0, 0.1, 1.0])] {
            let psi = Vector3::from(axis).normalize() * angle;
            for i in 0..3 {
                q[m.unknown(node, Dof::ROTATIONS[i]).unwrap()] = psi[i];
            }
        }
        q
    };
    let (mut before, mut now) = (turned(3.0), turned(3.3));
    fn at(q: &[f64]) -> Point<'_> {
        Point::statics(0.0, q)
    }
    m.start(0.0, &before);
    assert_eq!(
        m.change_charts(0.0, &mut before, &mut [], &mut []).charts,
        0
    );
    let mut r = [0.0; 12];
    m.evaluate(at(&now), Evaluation::residual(&mut r)).unwrap();
    let stored = m.energies_and_momentum(at(&now)).unwrap().energies.stored;
    let sections = m.section_states(0.0);
    let changes = m.change_charts(0.0, &mut now, &mut [], &mut []);
    assert_eq!((changes.charts, changes.residual), (2, true));
    let told = m.energies_and_momentum(at(&now)).unwrap().energies.stored;
    assert!((told / stored - 1.0).abs() < 1e-12, "{told}, not {stored}");
    for ((_, a), (_, b)) in m.section_states(0.0).iter().zip(&sections) {
        let gap = (a.N - b.N).norm() / b.N.norm() + (a.M - b.M).norm() / b.M.norm();
        assert!(gap < 1e-12, "{gap:e}");
    }
    // The next step begins in the other chart.
    m.evaluate(at(&now), Evaluation::residual(&mut r)).unwrap();
    let other = m.energies_and_momentum(at(&now)).unwrap().energies.stored;
    assert!((other / stored - 1.0).abs() > 1e-6, "{other}, {stored}");
}
