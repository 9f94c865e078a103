//! Critical points, found directly, of systems whose paths are known in closed form.

use crate::support::statics::*;
use crate::support::*;

/// A load t that shortens a column by x and bends it by y beyond t = 1:
///
/// ```text
/// t = x − c y²/2,      (1 − x + ε/y) y + α y² + β y³ = 0
/// ```
///
/// K is symmetric for c = 1. Besides y = 0 there is the path t = 1 + α y + (β − c/2) y², both for ε = 0.
struct Column {
    pattern: BlockPattern,
    alpha: f64,
    beta: f64,
    coupling: f64,
    imperfection: f64,
}

impl Column {
    fn new(alpha: f64, beta: f64, coupling: f64) -> Self {
        Self {
            pattern: BlockPattern::dense(2),
            alpha,
            beta,
            coupling,
            imperfection: 0.0,
        }
    }
}

impl System for Column {
    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        let (x, y) = (at.q[0], at.q[1]);
        out.r[0] = at.t - x + 0.5 * self.coupling * y * y;
        out.r[1] = -(1.0 - x) * y - self.alpha * y * y - self.beta * y * y * y - self.imperfection;
        if let Some((weights, S)) = out.S {
            let slope = 1.0 - x + 2.0 * self.alpha * y + 3.0 * self.beta * y * y;
            let K = [1.0, -y, -self.coupling * y, slope];
            S.iter_mut().zip(K).for_each(|(S, K)| *S = weights.K * K);
        }
        if let Some(r_t) = out.r_t {
            r_t.copy_from_slice(&[1.0, 0.0]);
        }
        Ok(())
    }

    fn is_symmetric(&self) -> bool {
        self.coupling == 1.0
    }

    fn name(&self, i: usize) -> String {
        ["shortening", "deflection"][i].to_owned()
    }
}

fn find(system: &mut dyn System, q: &[f64], t: f64) -> Result<CriticalPoint, StaticsError> {
    critical_point(system, Point::statics(t, q), None, &TIGHT)
}

/// Each correction is at most a multiple of the square of the one before, but for the small part that differences
/// of tangents leave.
fn assert_quadratic(point: &CriticalPoint) {
    let pairs = point.corrections.windows(2);
    for pair in pairs.filter(|pair| pair[0] < 0.1) {
        let most = 10.0 * pair[0] * pair[0] + 1e-7 * pair[0] + 1e-15;
        assert!(pair[1] <= most, "{:?}", point.corrections);
    }
}

#[test]
fn limit_points_of_the_truss() {
    let root = 1.0 / 3.0_f64.sqrt();
    for (start, w, load) in [(0.3, 1.0 - root, LIMIT), (1.7, 1.0 + root, -LIMIT)] {
        let point = find(&mut truss(), &[start], 0.9 * load).unwrap();
        assert_eq!(point.kind, CriticalKind::Limit);
        assert!((point.t - load).abs() < 1e-14, "{}", point.t);
        assert!((point.q[0] - w).abs() < 1e-12, "{}", point.q[0]);
        assert!(point.corrections.len() <= 6, "{:?}", point.corrections);
        assert_quadratic(&point);
    }
}

/// An electrode on a spring before a gap of 1e-4 of the coordinate's size: t = (27/4) s (1 − s)² of s = w over the gap, and no
/// force beyond it. It snaps at s = 1/3, t = 1.
#[test]
fn the_limit_point_of_a_small_gap() {
    const GAP: f64 = 1e-4;
    let mut electrode = crate::support::statics::Scalar::new(1.0, |w| match w / GAP {
        s if s < 1.0 => {
            let rest = 1.0 - s;
            [6.75 * s * rest * rest, 6.75 * rest * (1.0 - 3.0 * s) / GAP]
        }
        _ => [f64::NAN; 2],
    });
    let point = find(&mut electrode, &[0.3 * GAP], 0.992_25).unwrap();
    assert_eq!(point.kind, CriticalKind::Limit);
    assert!((point.t - 1.0).abs() < 1e-12, "{}", point.t);
    assert!(
        (point.q[0] / GAP - 1.0 / 3.0).abs() < 1e-6,
        "{}",
        point.q[0]
    );
}

/// From states before and beyond it, on and off the path, with symmetric and with other tangents.
#[test]
fn bifurcations_and_their_paths() {
    for (alpha, beta, coupling) in [(0.0, 1.0, 1.0), (0.5, 1.0, 1.0), (-0.7, 0.2, 0.0)] {
        for (q, t) in [
            ([0.3, 0.0], 0.3),
            ([0.7, 0.0], 0.7),
            ([0.8, 0.0], 0.8),
            ([1.2, 1e-3], 1.2),
            ([1.3, 0.0], 1.3),
            ([0.9, 0.02], 0.91),
        ] {
            let point = find(&mut Column::new(alpha, beta, coupling), &q, t).unwrap();
            assert_eq!(point.kind, CriticalKind::Bifurcation, "{alpha} {q:?}");
            let found = [point.t - 1.0, point.q[0] - 1.0, point.q[1]];
            assert!(found.iter().all(|x| x.abs() < 1e-12), "{found:?}");
            assert_quadratic(&point);
            // (dx, dy, dt) = (1, 0, 1) and (α, 1, α).
            let [primary, other] = &point.paths[..] else {
                panic!("{:?}", point.paths);
            };
            assert!((primary.dq[1] / primary.dt).abs() < 1e-6, "{primary:?}");
            for component in [other.dt, other.dq[0]] {
                assert!((component / other.dq[1] - alpha).abs() < 1e-6, "{other:?}");
            }
        }
    }
}

/// Paths that rise on both sides, rise on one side, and fall on both.
#[test]
fn branches_are_followed() {
    for (alpha, beta) in [(0.0, 1.0), (0.3, 1.0), (-0.3, 1.0), (0.0, 0.2)] {
        let mut system = Column::new(alpha, beta, 1.0);
        let options = ArcLengthOptions {
            switch_branch: true,
            max_steps: 40,
            events: vec![(Event::Bifurcation, false)],
            newton: TIGHT,
            ..ArcLengthOptions::default()
        };
        let (mut found, mut largest) = (0, 0.0_f64);
        trace_path(&mut system, &mut Vec::new(), &options, &mut |_, step| {
            let (x, y) = (step.q[0], step.q[1]);
            if step.event.is_some() {
                found += 1;
                assert!((step.t - 1.0).abs() < 1e-12, "{}", step.t);
            }
            let path = match found {
                0 => x,
                _ => 1.0 + alpha * y + (beta - 0.5) * y * y,
            };
            assert!((step.t - path).abs() < 1e-12, "{} {path}", step.t);
            if found > 0 && (alpha, beta) == (0.3, 1.0) {
                assert!(y >= 0.0, "towards growing loads");
            }
            largest = largest.max(y.abs());
            ControlFlow::Continue(())
        })
        .unwrap();
        assert_eq!(found, 1);
        assert!(largest > 0.5, "{largest}");
    }
}

#[test]
fn bifurcations_need_a_potential() {
    let options = ArcLengthOptions {
        events: vec![(Event::Bifurcation, true)],
        ..ArcLengthOptions::default()
    };
    let mut system = Column::new(0.0, 1.0, 0.0);
    let refused = trace_path(&mut system, &mut Vec::new(), &options, &mut |_, _| {
        ControlFlow::Continue(())
    });
    assert!(matches!(refused, Err(StaticsError::Asymmetric)));
}

/// x = t + y²/2 and (1 − t) y ∓ y³/2 = 10⁻²: the load has an extremum of 1 ∓ (3/2) 10^(−4/3) at y = ±10^(−2/3).
#[test]
fn an_imperfection_leaves_limit_points() {
    for (beta, sign) in [(0.0, 1.0), (1.0, -1.0)] {
        let mut column = Column::new(0.0, beta, 1.0);
        column.imperfection = -1e-2;
        let near = [1.0 - 0.05 * sign, 0.1 * sign];
        let point = find(&mut column, &near, 1.0 - 0.1 * sign).unwrap();
        assert_eq!(point.kind, CriticalKind::Limit);
        let exact = 1.0 - sign * 1.5 * 10_f64.powf(-4.0 / 3.0);
        assert!((point.t - exact).abs() < 1e-12, "{} {exact}", point.t);
        let y = sign * 10_f64.powf(-2.0 / 3.0);
        assert!((point.q[1] - y).abs() < 1e-10, "{} {y}", point.q[1]);
        assert_quadratic(&point);
    }
}

/// From far off the path, too, a bifurcation is no limit point: ψᵀ ∂r/∂t = 0.
#[test]
fn a_bifurcation_is_not_taken_for_a_limit_point() {
    for i in 0..20 {
        for j in 0..10 {
            let (t, y) = (0.4 + 0.06 * f64::from(i), 0.01 + 0.08 * f64::from(j));
            let q = [t, y];
            let at = Point::statics(t, &q);
            let shape = Some(&[0.0, 1.0][..]);
            let point = critical_point(&mut Column::new(0.0, 1.0, 1.0), at, shape, &TIGHT);
            assert!(
                point.is_ok_and(|p| p.kind == CriticalKind::Bifurcation),
                "{t} {y}"
            );
        }
    }
}

/// A load t = w (2 − w) with a turning point at w = 1, beside a coordinate of the stiffness w − 0.97: its bifurcation on the
/// path just before leaves the number of unstable directions as it was.
struct Beside {
    pattern: BlockPattern,
}

impl System for Beside {
    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        let (w, z) = (at.q[0], at.q[1]);
        out.r[0] = at.t - w * (2.0 - w) - 0.5 * z * z;
        out.r[1] = -(w - 0.97) * z - z * z * z;
        if let Some((weights, S)) = out.S {
            let K = [2.0 - 2.0 * w, z, z, w - 0.97 + 3.0 * z * z];
            S.iter_mut().zip(K).for_each(|(S, K)| *S = weights.K * K);
        }
        if let Some(r_t) = out.r_t {
            r_t.copy_from_slice(&[1.0, 0.0]);
        }
        Ok(())
    }

    fn is_symmetric(&self) -> bool {
        true
    }

    fn name(&self, i: usize) -> String {
        ["w", "z"][i].to_owned()
    }
}

#[test]
fn a_bifurcation_beside_a_turning_point_is_found() {
    for max_step in [0.1, 0.02] {
        let options = ArcLengthOptions {
            events: vec![
                (Event::Bifurcation, false),
                (Event::TurningPoint, false),
                (
                    Event::Coordinate {
                        unknown: 0,
                        value: 1.5,
                    },
                    true,
                ),
            ],
            max_step,
            ..ArcLengthOptions::default()
        };
        let mut system = Beside {
            pattern: BlockPattern::dense(2),
        };
        let mut found = Vec::new();
        trace_path(&mut system, &mut Vec::new(), &options, &mut |_, step| {
            found.extend(step.event.map(|event| (event, step.t)));
            ControlFlow::Continue(())
        })
        .unwrap();
        let exact = [(0, 0.97 * 1.03), (1, 1.0), (2, 0.75)];
        assert_eq!(found.len(), exact.len(), "{found:?}");
        for (found, exact) in found.iter().zip(exact) {
            assert_eq!(found.0, exact.0);
            assert!((found.1 - exact.1).abs() < 1e-10, "{found:?}");
        }
    }
}

#[test]
fn a_system_without_critical_points_says_so() {
    let mut options = StaticNewtonOptions::default();
    let at = Point::statics(0.0, &[0.0]);
    let mut spring = crate::support::statics::Scalar::new(1.0, |w| [w, 1.0]);
    let none = critical_point(&mut spring, at, None, &options);
    assert!(matches!(none, Err(StaticsError::NoCriticalPoint { .. })));
    options.relative = 0.0;
    let refused = critical_point(&mut spring, at, None, &options);
    assert!(matches!(refused, Err(StaticsError::Option { .. })));
}
