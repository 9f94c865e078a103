//! Runs in time: failing and adaptive steps, copies that go on, what is refused.

use crate::support::dynamics::*;
use crate::support::*;
use std::f64::consts::TAU;

/// A system that cannot be evaluated where it would have moved far in one step.
struct Skittish(Pendulum, f64);

impl System for Skittish {
    fn pattern(&self) -> &BlockPattern {
        self.0.pattern()
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        if (at.q[0] - self.1).abs() > 0.2 {
            return Err(SystemError::Domain {
                what: "the pendulum".to_owned(),
                why: DomainError::Beyond {
                    limit: CHART_EDGE,
                    margin: 0.2 - (at.q[0] - self.1).abs(),
                },
            });
        }
        self.0.evaluate(at, out)
    }

    fn charts(&mut self) -> Option<&mut dyn Charts> {
        Some(self)
    }
}

impl Charts for Skittish {
    fn change_charts(
        &mut self,
        _: f64,
        q: &mut [f64],
        _: &mut [f64],
        _: &mut [&mut [f64]],
    ) -> ChartChanges {
        self.1 = q[0];
        ChartChanges::default()
    }
}

#[test]
fn failed_steps_are_halved_and_grow_back() {
    let system = Skittish(Pendulum::new(), 1.5);
    let options = DynamicOptions::new(2.0, 0.25);
    let (sizes, progress) = observed(system, 1.5, 0.0, &options, |step| step.step_size);
    assert_eq!(progress.state.t, 2.0);
    assert!(progress.summary.failed > 0);
    let smallest = sizes.iter().copied().fold(1.0, f64::min);
    let after = sizes.iter().position(|&s| s == smallest).unwrap();
    assert!(smallest < 0.1 && sizes[after..].iter().any(|&s| s > 1.5 * smallest));
    // Nowhere to go: the error names the step, the time and the cause.
    let mut stuck = Skittish(Pendulum::new(), 1.5);
    let mut progress = Progress::new(start(&stuck, 0.0, &[1.5], &[100.0]).unwrap());
    let options = DynamicOptions {
        min_step: 0.1,
        ..options
    };
    // Another attempt is not smaller.
    for _ in 0..2 {
        refused! {
            integrate(&mut stuck, &mut progress, &options, &mut onward) =>
                ["step 1 failed between time 0 (start) and 0.125", "the pendulum left the range"],
        }
    }
    // The state is that of the last accepted step.
    assert_eq!(progress.state.q, [1.5]);
}

/// A pendulum that cannot be evaluated at first after some time.
struct Stumbling(Pendulum, usize);

impl System for Stumbling {
    fn pattern(&self) -> &BlockPattern {
        self.0.pattern()
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        if at.t > 0.58 && self.1 > 0 {
            self.1 -= 1;
            let what = "the pendulum".to_owned();
            return Err(SystemError::NotFinite { what });
        }
        self.0.evaluate(at, out)
    }
}

#[test]
fn halved_steps_lead_back_to_round_times() {
    // 0.5 to 0.6 fails, then 0.55 to 0.6: steps of 0.025 up to 0.65, the fourth of them, and of 0.05
    // beyond 0.85, the fourth, as only from 0.9 on steps of 0.1 meet the end.
    let parts = [
        (1..=5, 10.0),
        (11..=11, 20.0),
        (23..=26, 40.0),
        (14..=18, 20.0),
        (10..=20, 10.0),
    ];
    let each =
        |(k, n): (std::ops::RangeInclusive<i32>, f64)| k.map(move |k| [f64::from(k) / n, 1.0 / n]);
    let expected: Vec<[f64; 2]> = parts.into_iter().flat_map(each).collect();
    let system = Stumbling(Pendulum::new(), 2);
    let options = DynamicOptions::new(2.0, 0.1);
    let ends = |step: &StepReport<'_>| [step.progress.state.t, step.step_size];
    let (found, progress) = observed(system, 1.0, 0.0, &options, ends);
    assert_eq!(progress.summary.failed, 2);
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for ([t, h], [end, size]) in found.iter().zip(&expected) {
        // To the last digit: they are counted.
        assert_eq!(t, end);
        assert!((h - size).abs() < 1e-14, "{h} up to {t}");
    }
}

#[test]
fn after_a_failed_step_the_system_is_at_the_last_accepted_one() {
    let mut system = Configured::new(Stumbling(Pendulum::new(), usize::MAX));
    let state = start(&system, 0.0, &[1.0], &[]).unwrap();
    let options = DynamicOptions {
        min_step: 0.06,
        ..DynamicOptions::new(2.0, 0.1)
    };
    let mut run = Simulation::new(&mut system, state, &options).unwrap();
    refused! { run.finish() => ["step 6 failed"] }
    assert_eq!((run.state().t, &run.system().q), (0.5, &run.state().q));
}

#[test]
fn steps_end_at_the_multiples_of_an_interval() {
    for (to, interval, count) in [(2.0, 0.1, 20), (1.0, 0.3, 3)] {
        let equal = DynamicOptions {
            interval: Some(interval),
            ..DynamicOptions::new(to, 0.04)
        };
        for options in [equal, adaptive(equal, 1e-4, 0.5)] {
            let time = |step: &StepReport<'_>| step.progress.state.t;
            let (times, _) = observed(Pendulum::new(), 1.0, 0.0, &options, time);
            for k in 1..=count {
                // Where intervals are equal parts of the run, with the digits of such a part.
                let exact = match to {
                    2.0 => 2.0 * f64::from(k) / 20.0,
                    _ => f64::from(k) * interval,
                };
                assert!(times.contains(&exact), "{exact} is not in {times:?}");
            }
        }
    }
}

#[test]
fn a_kink_where_a_run_starts_is_behind_it() {
    // By a rounding error after the start, as sums of times are.
    let mut system = Oscillator::new(1.0, 1.0);
    system.kinks = vec![0.1 + 0.2];
    assert!(system.kinks[0] > 0.3);
    let mut progress = Progress::new(start(&system, 0.3, &[1.0], &[]).unwrap());
    let mut sizes = Vec::new();
    let options = DynamicOptions::new(0.7, 0.1);
    integrate(&mut system, &mut progress, &options, &mut |_, step| {
        sizes.push(step.step_size);
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(sizes.len(), 4, "{sizes:?}");
    assert!(sizes.iter().all(|h| (h - 0.1).abs() < 1e-14), "{sizes:?}");
}

#[test]
fn newton_converges_quadratically_and_a_kept_tangent_linearly() {
    // Nothing measures the forces of this system: it is solved down to rounding errors, by a kept
    // tangent with a contraction of 0.091 in log(ε)/log(0.091) = 15 corrections.
    for (tangent, most) in [(TangentUpdate::Every, 5), (TangentUpdate::Once, 15)] {
        let mut options = DynamicOptions::new(0.3, 0.3);
        options.newton.tangent = tangent;
        options.newton.relative = 1e-13;
        let moments = |step: &StepReport<'_>| -> Vec<f64> {
            step.residuals.iter().map(|i| i.residual[1]).collect()
        };
        let (steps, progress) = observed(Pendulum::new(), 2.0, 1.0, &options, moments);
        let history = &steps[0];
        let summary = progress.summary;
        assert!(summary.iterations <= most, "{history:?}");
        let first = history[0];
        let scaled: Vec<f64> = history.iter().map(|r| r / first).collect();
        if tangent == TangentUpdate::Every {
            // rₖ₊₁ ≤ c rₖ² with a moderate c until rounding.
            for pair in scaled.windows(2).filter(|p| p[1] > 1e-14) {
                assert!(pair[1] < 2.0 * pair[0] * pair[0], "{scaled:?}");
            }
            assert_eq!(summary.factorisations, 1 + summary.iterations);
        } else {
            assert_eq!(summary.factorisations, 2);
        }
    }
}

#[test]
fn adaptive_steps_follow_the_error() {
    let exact = [0.986_291_751_131_875_f64, -0.165_010_853_125_541];
    let mut last = f64::INFINITY;
    for tolerance in [1e-4, 1e-5, 1e-6, 1e-7] {
        let options = adaptive(DynamicOptions::new(1.0, 0.3), tolerance, 0.5);
        let end = run(Pendulum::new(), -TAU / 4.0, 0.0, &options);
        assert!(end.summary.inaccurate > 0, "the first step is too large");
        let error = (end.state.q[0] - exact[0].atan2(-exact[1])).abs();
        // Global errors go like the power 2/3 of local ones.
        let most = 20.0 * tolerance.powf(2.0 / 3.0);
        assert!(error < most && error < last, "{error}");
        last = error;
    }
}

#[test]
fn no_step_is_longer_than_the_longest() {
    let options = adaptive(DynamicOptions::new(1.0, 0.3), 1.0, 0.05);
    let size = |step: &StepReport<'_>| step.step_size;
    let (sizes, _) = observed(Oscillator::mass(0.0), 0.0, 1.0, &options, size);
    assert!(sizes.iter().all(|h| *h < 0.05 + 1e-14), "{sizes:?}");
}

#[test]
fn options_are_refused_with_their_range() {
    let pendulum = |to: f64, step: f64| {
        let options = DynamicOptions::new(to, step);
        attempt(&mut Pendulum::new(), [&[]; 2], &options)
    };
    refused! {
        pendulum(1.0, 0.0) => ["option step = 0.0 is not usable"],
        pendulum(1.0, f64::NAN) => ["option step = NaN"],
        pendulum(1.0, f64::INFINITY) => ["option step = inf"],
        pendulum(-1.0, 0.1) => ["option to = -1.0"],
        pendulum(f64::INFINITY, 0.1) => ["option to = inf"],
        pendulum(f64::MAX, 0.1) => ["option to = ", "a finite number of steps"],
    }
    refused! {
        start(&Pendulum::new(), 0.0, &[1.0, 2.0], &[]) =>
            ["coordinates to begin with: 2 given where the system has 1 coordinates"],
        start(&Oscillator::new(1.0, 1.0), 0.0, &[], &[f64::NAN]) =>
            ["velocities to begin with: the mass is NaN"],
    }
    // A pattern of one's own: no coordinates, or one without a size.
    let patterned = |n: usize, size: f64| {
        let info = CoordinateInfo {
            size,
            ..CoordinateInfo::default()
        };
        let pattern = BlockPattern::dense(n).with_coordinates(|_| info);
        start(&Patterned(pattern), 0.0, &[], &[])
    };
    refused! {
        patterned(0, 1.0) => ["coordinates to begin with: the system has none"],
        patterned(2, f64::NAN) => ["the size of coordinate 0 is NaN: give its positive unit"],
        patterned(2, 0.0) => ["the size of coordinate 0 is 0: give its positive unit"],
    }
}

/// A system of which only the coordinates matter.
struct Patterned(BlockPattern);

impl System for Patterned {
    fn pattern(&self) -> &BlockPattern {
        &self.0
    }

    fn evaluate(&mut self, _: Point<'_>, _: Evaluation<'_>) -> Result<(), SystemError> {
        Ok(())
    }
}

#[test]
fn a_coordinate_without_mass_is_found_by_its_stiffness_or_named() {
    // Without mass the coordinate follows its load: x = p/k at once.
    let mut system = Oscillator::new(0.0, 4.0);
    system.hat = 1.0;
    let options = DynamicOptions::new(0.5, 0.05);
    let progress = run(system, 0.0, 0.0, &options);
    assert!((progress.state.q[0] - 0.25).abs() < 1e-12);
    let mut nothing = Oscillator::new(0.0, 0.0);
    refused! {
        attempt(&mut nothing, [&[]; 2], &options) => ["no consistent accelerations at time 0:"],
        attempt(&mut Oscillator::new(f64::NAN, 4.0), [&[1.0]; 2], &options) =>
            ["at time 0: the mass gives a value that is not finite"],
    }
}

#[test]
fn a_motion_whose_energy_grows_without_bounds_is_unstable() {
    let ends = |k: f64, h: f64, scheme: Scheme| {
        let mut system = Oscillator {
            later: Some(k),
            kinks: Vec::new(),
            ..Oscillator::new(1.0, 1.0)
        };
        attempt(&mut system, [&[1.0], &[]], &steps_of(scheme, 5.0, h))
    };
    // ω h = 1.99 swings more widely than before, and stays there.
    let (h, explicit) = (0.1_f64, Scheme::central_difference());
    ends((1.99 / h).powi(2), h, explicit).unwrap();
    // Energy that is 3000 times as large at once, by the trapezoidal rule, which keeps it.
    ends(1e4, 1e-3, Scheme::newmark(0.25, 0.5).unwrap()).unwrap();
    // ω h = 2.2: the central difference by hand, whose energy is absurd from 1000 times the first on, and
    // boundless when it has been so for 16 steps.
    let k = (2.2_f64 / h).powi(2);
    let error = ends(k, h, explicit).unwrap_err();
    let DynamicsError::Unstable { t, energy, known } = error else {
        panic!("{error}");
    };
    let (mut q, mut v, mut a) = (1.0_f64, 0.0_f64, -1.0_f64);
    let mut energies = vec![0.5];
    while energies.iter().filter(|e| **e > 500.0).count() < 16 {
        let n = energies.len();
        let k = if n as f64 * h > 1.0 + 1e-9 { k } else { 1.0 };
        q += h * v + 0.5 * h * h * a;
        v += 0.5 * h * (a - k * q);
        a = -k * q;
        energies.push(0.5 * (v * v + k * q * q));
    }
    let n = energies.len() - 1;
    assert!((t - n as f64 * h).abs() < 1e-12, "{t} instead of {n} steps");
    assert!((energy / energies[n] - 1.0).abs() < 1e-9, "{energy:e}");
    assert_eq!(known, 0.5);
}

#[test]
fn kinks_are_found_however_far_the_end_is() {
    // A load of the impulse ½, linear between kinks at 0, 0.5 and 1; an event ends the run.
    for to in [3.0, 1e13, 1e300] {
        let mut system = Oscillator::new(1.0, 0.0);
        system.hat = 1.0;
        let state = start(&system, 0.0, &[0.0], &[0.0]).unwrap();
        let options = DynamicOptions::new(to, 0.3);
        let mut run = Simulation::new(&mut system, state, &options).unwrap();
        run.add_event(|_, state| state.t - 2.0, |_, _| ControlFlow::Break(()));
        run.finish().unwrap();
        let state = run.state();
        assert!((state.v[0] - 0.5).abs() < 1e-12, "{to}: {state:?}");
        // It has ended, whatever the step.
        run.set_step(0.1).unwrap();
        assert!(run.step().unwrap().is_none(), "{to}");
    }
}

#[test]
fn a_motion_that_has_died_out_goes_on() {
    // x = e^(−t) is below the smallest normal number from t = 708 on.
    let mut system = Oscillator::new(1.0, 1.0);
    system.c = 2.0;
    let end = run(system, 1.0, -1.0, &DynamicOptions::new(800.0, 0.1));
    assert_eq!(end.summary.failed, 0);
    assert!(end.state.q[0].abs() < f64::MIN_POSITIVE, "{:?}", end.state);
}

#[test]
fn accelerations_that_are_cleared_are_computed_anew() {
    let mut system = Oscillator::new(1.0, 4.0);
    let options = DynamicOptions::new(1.0, 0.1);
    let state = start(&system, 0.0, &[1.0], &[0.0]).unwrap();
    let run = Simulation::new(&mut system, state, &options).unwrap();
    let mut state = run.state().clone();
    state.q[0] = 0.5;
    state.a.clear();
    let run = Simulation::new(&mut system, state, &options).unwrap();
    // ẍ = −4 x.
    assert_eq!(run.state().a, [-2.0]);
}
