//! Tangents of an assembled model behind a whole turn of a support, and from the previous iterate.

use crate::support::*;

#[test]
fn a_rotation_driven_past_a_turn() {
    // About an axis that wanders, so that taking off a turn changes the rates too; at t = 0.6 the
    // tip has turned by 7.1 rad.
    let mut b = ModelBuilder::new();
    let [root, _, tip] = frame_model(&mut b, None);
    b.support(root, &Dof::ALL);
    b.prescribe(tip, Dof::RX, Proportional(8.0));
    b.prescribe(tip, Dof::RY, sine(3.0));
    b.prescribe(tip, Dof::RZ, Proportional(7.0));
    let psi = |t: f64| Vector3::new(8.0 * t, sine(3.0).at(t, &[])[0], 7.0 * t);
    let mut context = Context::new(b.build().unwrap());
    let mut q = vec![0.0; context.pattern().dim()];
    context.start(0.6, &q);
    let changes = context.change_charts(0.6, &mut q, &mut [], &mut []);
    assert_eq!(changes.charts, 0, "the start has done it");
    let options = ModelOptions {
        t: 0.6,
        q: q.clone(),
        ..ModelOptions::default()
    };
    check::model(&mut context, &options).assert();
    context.configure(Point::statics(0.6, &q)).unwrap();
    let found = context.node_state(tip);
    let expected = nalgebra::Rotation3::new(psi(0.6));
    assert!((found.R - expected.matrix()).norm() < 1e-13);
    assert!((found.psi.norm() - (psi(0.6).norm() - 2.0 * PI)).abs() < 1e-14);
    // Back: 4.2 rad is nearer to one turn than to none, 2.2 rad is not. And forth.
    for (t, charts) in [(0.3, 0), (0.1, 1), (0.3, 1)] {
        let changes = context.change_charts(t, &mut q, &mut [], &mut []);
        assert_eq!(changes.charts, charts, "{} rad", psi(t).norm());
    }
}

#[test]
fn a_tangent_from_the_previous_iterate_differs_by_the_square_of_the_step() {
    let mut b = ModelBuilder::new();
    let ends = [0.0, 2.0].map(|x| b.node(format!("{x}"), [x, 0.0, 0.0]).unwrap());
    let nodes = lay(&mut b, "line", ends, 2, 1, coupled());
    let mut context = Context::new(b.build().unwrap());
    let mut q = DVector::zeros(context.pattern().dim());
    let e = Vector3::new(0.36, 0.48, -0.8);
    for (node, angle) in nodes.into_iter().zip([2.9, 3.1, 3.3]) {
        for i in 0..3 {
            context.set(q.as_mut_slice(), node, 3 + i, e[i] * angle);
        }
    }
    context.start(0.6, q.as_slice());
    context.change_charts(0.6, q.as_mut_slice(), &mut [], &mut []);
    let mut random = Random::new(2);
    let n = q.len();
    let mut d = DVector::zeros(n);
    random.direction(1.0, d.as_mut_slice());
    // Near the start: the charts of elements follow their nodes from there.
    let mut near = DVector::zeros(n);
    random.fill(near.as_mut_slice());
    q += near * 0.5;
    let mut tangent = |previous: Option<&DVector<f64>>| {
        let at = |q| Point::statics(0.6, q);
        let (mut r, mut S) = (vec![0.0; n], vec![0.0; context.pattern().len()]);
        let out = Evaluation {
            previous: previous.map(|from| at(from.as_slice())),
            ..Evaluation::with_tangent(&mut r, Weights::STATIC, &mut S)
        };
        context.evaluate(at(q.as_slice()), out).unwrap();
        (r, context.pattern().matrix(&S))
    };
    let (r, K) = tangent(None);
    let mut report = check::Report::new("previous iterate");
    report.slope("K", "chain", 2.0, 0.05, K.norm(), |step| {
        let (same, from) = tangent(Some(&(&q - &d * step)));
        assert_eq!(same, r);
        (from - &K).norm()
    });
    report.assert();
    let (_, K_again) = tangent(None);
    assert_eq!(K, K_again, "the previous iterate is forgotten");
}
