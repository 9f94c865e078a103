//! How far Newton's method goes along a correction, and where it stops: springs solved by hand.

use crate::support::statics::*;
use crate::support::*;

/// The load from one value to another in a single step, from the equilibrium w: where it ends, and the
/// iterations of the step.
fn in_one_step(
    spring: &mut Scalar,
    w: f64,
    [from, to]: [f64; 2],
    newton: StaticNewtonOptions,
) -> Result<(f64, Vec<Iteration>), StaticsError> {
    let options = StaticOptions {
        from,
        to,
        first_step: 1.0,
        min_step: 1.0,
        max_step: 1.0,
        newton,
    };
    let (mut q, mut history) = (vec![w], Vec::new());
    solve_statics(spring, &mut q, &options, &mut |_, step| {
        history = step.residuals.to_vec();
        ControlFlow::Continue(())
    })?;
    Ok((q[0], history))
}

/// From w = 3, where the load is taken away, to w = 0: plain corrections −(1 + w²) atan w grow without
/// bounds from |w| = 1.3917 on (where (1 + w²) atan w = 2w).
fn released(
    full_corrections: usize,
    smallest_damping: f64,
) -> Result<(f64, Vec<Iteration>), StaticsError> {
    let mut spring = Scalar::new(3.0_f64.atan(), |w| [w.atan(), 1.0 / (1.0 + w * w)]);
    let newton = StaticNewtonOptions {
        full_corrections,
        smallest_damping,
        ..TIGHT
    };
    in_one_step(&mut spring, 3.0, [1.0, 0.0], newton)
}

#[test]
fn damping_finds_what_full_corrections_miss() {
    let (w, history) = released(0, 0.1).unwrap();
    assert!(w.abs() < 1e-15, "{w:e}");
    // By hand: the prediction goes to −9.490, the corrections to 7.196, −2.256, 1.257, −1.062 and so on.
    let dampings: Vec<f64> = history.iter().map(|i| i.damping).collect();
    assert_eq!(dampings[..5], [1.0, 0.125, 0.125, 0.5, 1.0], "{dampings:?}");
    let ends = [
        3.0_f64, -9.490_458, 7.195_788, -2.256_407, 1.257_176, -1.062_289,
    ];
    for (w, iteration) in ends.iter().zip(&history) {
        let residual = iteration.residual[0];
        assert!((residual - w.atan().abs()).abs() < 1e-6, "{w}: {residual}");
    }

    let failed = failed_step(released(20, 0.1));
    let made = failed.history.iter().filter(|i| i.damping > 0.0);
    let corrections: Vec<f64> = made
        .inspect(|i| assert_eq!(i.damping, 1.0))
        .map(|i| i.correction)
        .collect();
    // By hand 12.49, 133.5, 24 030.
    assert!(corrections.len() > 4, "{failed}");
    let growing = corrections.windows(2).all(|c| c[1] > 2.0 * c[0]);
    assert!(growing, "{failed}");
}

#[test]
fn a_damping_that_is_too_small_is_given_up() {
    // From −9.49 an eighth is the largest part of the correction that comes nearer.
    let failed = failed_step(released(0, 0.2));
    assert_eq!(failed.cause, Cause::Diverged, "{failed}");
}

#[test]
fn the_absolute_floor_decides_where_it_is_the_larger() {
    // 2 = w + w³ by hand: residuals 8, 2.0391, 0.35137, 0.01919, 6.828e-5, 8.7e-10 and rounding.
    let end = |absolute: f64| {
        let mut spring = Scalar::new(2.0, |w| [w + w * w * w, 1.0 + 3.0 * w * w]);
        let newton = StaticNewtonOptions { absolute, ..TIGHT };
        let (w, history) = in_one_step(&mut spring, 0.0, [0.0, 1.0], newton).unwrap();
        let iterations = history.iter().filter(|i| i.damping > 0.0).count();
        let last = history.last().map(|i| [i.residual[0], i.ratio]);
        (w, iterations, last.unwrap())
    };
    let (w, iterations, [residual, ratio]) = end(1e-3);
    assert_eq!(iterations, 5);
    assert!((residual - 6.828e-5).abs() < 1e-8, "{residual:e}");
    assert!((ratio - 6.828e-2).abs() < 1e-5, "{ratio}");
    assert!((w - 1.000_017_070_7).abs() < 1e-10, "{w}");
    // Just below that residual the floor asks for one correction more; without it, for rounding.
    assert_eq!(end(6.8e-5).1, 6);
    let (w, iterations, _) = end(0.0);
    assert_eq!(iterations, 7);
    assert!((w - 1.0).abs() < 1e-15, "{w}");
}

/// The spring λ P = atan w, whose discretisation puts w at 5 more once it is beyond 1.
struct Shifting(Scalar, f64);

impl System for Shifting {
    fn pattern(&self) -> &BlockPattern {
        self.0.pattern()
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        let q = [at.q[0] + self.1];
        self.0.evaluate(Point { q: &q, ..at }, out)
    }

    fn charts(&mut self) -> Option<&mut dyn Charts> {
        Some(self)
    }
}

impl Charts for Shifting {
    fn change_charts(
        &mut self,
        _: f64,
        q: &mut [f64],
        _: &mut [f64],
        _: &mut [&mut [f64]],
    ) -> ChartChanges {
        let residual = self.1 == 0.0 && q[0] > 1.0;
        if residual {
            self.1 = 5.0;
        }
        ChartChanges {
            charts: usize::from(residual),
            residual,
        }
    }
}

/// Full corrections from w = 6 and more back to 1 overshoot to −17 and beyond, so the jump is taken in parts; the load
/// stays where it was.
#[test]
fn a_path_goes_on_behind_charts_that_move_the_equilibrium_far() {
    let mut spring = Shifting(Scalar::new(1.0, |w| [w.atan(), 1.0 / (1.0 + w * w)]), 0.0);
    let options = ArcLengthOptions {
        first_step: 0.02,
        max_step: 0.02,
        max_steps: 120,
        newton: TIGHT,
        ..ArcLengthOptions::default()
    };
    let (mut before, mut changes, mut shift) = (0.0, 0, 0.0);
    trace_path(&mut spring, &mut Vec::new(), &options, &mut |_, step| {
        changes += step.chart_changes;
        shift = if changes > 0 { 5.0 } else { 0.0 };
        let w: f64 = step.q[0] + shift;
        assert!((step.t - w.atan()).abs() < 1e-12, "{w}: {}", step.t);
        assert!((0.0..0.03).contains(&(step.t - before)), "{w}: {}", step.t);
        before = step.t;
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(changes, 1);
    assert!(before > 1.0_f64.atan() + 0.1, "{before}");
}
