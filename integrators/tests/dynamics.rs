//! Integration in time of systems small enough to be known exactly: no beam is known here.

#![allow(non_snake_case)]

use nalgebra::{Matrix3, Vector3};
use pullback_integrators::dynamics::scheme::Coefficients;
use pullback_integrators::dynamics::{
    Adaptivity, DynamicOptions, DynamicsError, NewtonOptions, Progress, Scheme, State, StepReport,
    Tangent, integrate, start,
};
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::{Energies, Evaluation, Kind, Point, System, SystemError};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// m ẍ + c ẋ + k x = p(t): r and its tangents for one coordinate.
struct Oscillator {
    pattern: BlockPattern,
    m: f64,
    k: f64,
    /// Hat load: peak at t = 0.5, ends at t = 1.
    hat: f64,
}

impl Oscillator {
    fn new(m: f64, k: f64) -> Self {
        Self {
            pattern: BlockPattern::dense(1),
            m,
            k,
            hat: 0.0,
        }
    }

    fn load(&self, t: f64) -> f64 {
        self.hat * (1.0 - (2.0 * t - 1.0).abs()).max(0.0)
    }
}

impl System for Oscillator {
    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        out.r[0] = self.load(at.t) - self.k * at.q[0] - self.m * at.a[0];
        if let Some((w, S)) = out.S {
            S[0] = w.K * self.k + w.M * self.m;
        }
        Ok(())
    }

    fn kinks(&self) -> Vec<f64> {
        vec![0.0, 1.0, 0.5, 0.5]
    }

    fn energies(&mut self, at: Point<'_>) -> Result<Option<Energies>, SystemError> {
        Ok(Some(Energies {
            kinetic: 0.5 * self.m * at.v[0] * at.v[0],
            stored: 0.5 * self.k * at.q[0] * at.q[0],
            supplied: self.load(at.t) * at.v[0],
            dissipated: 0.0,
            ..Energies::default()
        }))
    }

    fn name(&self, _: usize) -> String {
        "the mass".to_owned()
    }
}

/// φ̈ = −(g/L) sin φ: a planar pendulum, φ from the lowest point.
struct Pendulum {
    pattern: BlockPattern,
    g: f64,
}

impl Pendulum {
    fn new() -> Self {
        Self {
            pattern: BlockPattern::dense(1),
            g: 9.81,
        }
    }
}

impl System for Pendulum {
    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        out.r[0] = -self.g * at.q[0].sin() - at.a[0];
        if let Some((w, S)) = out.S {
            S[0] = w.K * self.g * at.q[0].cos() + w.M;
        }
        Ok(())
    }

    fn kind(&self, _: usize) -> Kind {
        Kind::Angle
    }
}

fn onward<Y: ?Sized>(_: &mut Y, _: &StepReport<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// State after a run with equal steps.
fn run<Y: System>(mut system: Y, q: f64, v: f64, options: &DynamicOptions) -> Progress {
    let state = start(&system, 0.0, &[q], &[v]).unwrap();
    let mut progress = Progress::new(state);
    integrate(&mut system, &mut progress, options, &mut onward).unwrap();
    progress
}

fn schemes() -> Vec<Scheme> {
    vec![
        Scheme::default(),
        Scheme::hht(-0.1).unwrap(),
        Scheme::hht(-1.0 / 3.0).unwrap(),
        Scheme::wbz(0.8).unwrap(),
        Scheme::wbz(0.0).unwrap(),
        Scheme::chung_hulbert(0.8).unwrap(),
        Scheme::chung_hulbert(0.0).unwrap(),
        Scheme::chung_hulbert(1.0).unwrap(),
    ]
}

/// Slope of log error over log h from errors at h, h/2, h/4.
fn slopes(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect()
}

#[test]
fn the_pendulum_of_iftomm_with_order_two() {
    // published.json, R04: position (sin φ, −cos φ) at t = 1 and 5, start from (−1, 0) at rest.
    let exact: [(f64, [f64; 2]); 2] = [
        (1.0, [0.986_291_751_131_875, -0.165_010_853_125_541]),
        (5.0, [-0.942_305_435_043_757, -0.334_754_338_414_001]),
    ];
    for scheme in schemes() {
        assert_eq!(scheme.order(), 2, "{scheme:?}");
        for (t, [x, y]) in exact {
            let errors: Vec<[f64; 3]> = [1600.0, 3200.0, 6400.0]
                .into_iter()
                .map(|n| {
                    let options = DynamicOptions {
                        scheme,
                        newton: NewtonOptions {
                            relative: 1e-12,
                            ..NewtonOptions::default()
                        },
                        ..DynamicOptions::new(t, t / n)
                    };
                    let end = run(Pendulum::new(), -TAU / 4.0, 0.0, &options).state;
                    let phi = x.atan2(-y);
                    // Energy gives the velocity, the equation of motion the acceleration.
                    let v = (2.0 * 9.81 * -y).sqrt();
                    [
                        (end.q[0] - phi).abs(),
                        (end.v[0].abs() - v).abs(),
                        (end.a[0] + 9.81 * x).abs(),
                    ]
                })
                .collect();
            for k in 0..3 {
                let e: Vec<f64> = errors.iter().map(|e| e[k]).collect();
                for slope in slopes(&e) {
                    assert!((slope - 2.0).abs() < 0.1, "{scheme:?} at {t}: {e:?}");
                }
            }
        }
    }
}

#[test]
fn many_turns_of_the_pendulum() {
    // Thrown over the top: energy e = v²/2 − g cos φ fixes the velocity at the top at once.
    let v: f64 = 8.0;
    let options = DynamicOptions::new(10.0, 1e-3);
    let end = run(Pendulum::new(), 0.0, v, &options).state;
    assert!(end.q[0] > 8.0 * TAU);
    let e = 0.5 * v * v - 9.81;
    let found = 0.5 * end.v[0] * end.v[0] - 9.81 * end.q[0].cos();
    assert!((found - e).abs() < 1e-4, "{found} {e}");
}

#[test]
fn newmark_with_gamma_above_one_half_has_order_one() {
    let scheme = Scheme::newmark(0.3025, 0.6).unwrap();
    assert_eq!(scheme.order(), 1);
    let omega = 3.0_f64;
    let errors: Vec<f64> = [1600.0, 3200.0, 6400.0]
        .into_iter()
        .map(|n| {
            let options = DynamicOptions {
                scheme,
                ..DynamicOptions::new(2.0, 2.0 / n)
            };
            let end = run(Oscillator::new(1.0, omega * omega), 1.0, 0.0, &options).state;
            (end.q[0] - (2.0 * omega).cos()).abs()
        })
        .collect();
    for slope in slopes(&errors) {
        assert!((slope - 1.0).abs() < 0.1, "{errors:?}");
    }
}

/// Amplification matrix of (q, h q̇, h² a) at Ω = ω h, columns by unit states.
fn amplification(scheme: Scheme, Omega: f64) -> Matrix3<f64> {
    let h = 0.5;
    let mut A = Matrix3::zeros();
    for k in 0..3 {
        let unit = |i: usize| if i == k { 1.0 } else { 0.0 };
        let mut system = Oscillator::new(1.0, (Omega / h).powi(2));
        // The true acceleration is that of the equation of motion.
        let state = State {
            t: 2.0,
            q: vec![unit(0)],
            v: vec![unit(1) / h],
            a: vec![-(Omega / h).powi(2) * unit(0)],
            algorithmic: vec![unit(2) / (h * h)],
        };
        let mut progress = Progress::new(state);
        let options = DynamicOptions {
            scheme,
            newton: NewtonOptions {
                relative: 1e-14,
                absolute: 1e-14,
                ..NewtonOptions::default()
            },
            ..DynamicOptions::new(2.0 + h, h)
        };
        integrate(&mut system, &mut progress, &options, &mut onward).unwrap();
        let end = progress.state;
        A.set_column(
            k,
            &Vector3::new(end.q[0], h * end.v[0], h * h * end.algorithmic[0]),
        );
    }
    A
}

#[test]
fn amplification_matrices_have_the_characteristic_polynomials_of_theory() {
    // integrators.json, "char_poly_general": undamped, W = Ω².
    for s in schemes() {
        for Omega in [0.1, 1.0, 3.0, 10.0] {
            let W: f64 = Omega * Omega;
            let Coefficients {
                alpha_m: m,
                alpha_f: f,
                beta: b,
                gamma: g,
            } = s.coefficients().unwrap();
            let p = [
                1.0 - m + b * (1.0 - f) * W,
                3.0 * m - 2.0 + W * (3.0 * f * b - f * g - 0.5 * f - 2.0 * b + g + 0.5),
                1.0 - 3.0 * m + W * (-3.0 * f * b + 2.0 * f * g + b - g + 0.5),
                m + W * (f * b - f * g + 0.5 * f),
            ];
            let A = amplification(s, Omega);
            let minors = A[(0, 0)] * A[(1, 1)] - A[(0, 1)] * A[(1, 0)] + A[(0, 0)] * A[(2, 2)]
                - A[(0, 2)] * A[(2, 0)]
                + A[(1, 1)] * A[(2, 2)]
                - A[(1, 2)] * A[(2, 1)];
            let found = [-A.trace(), minors, -A.determinant()];
            for k in 0..3 {
                let gap = (found[k] - p[k + 1] / p[0]).abs();
                assert!(gap < 1e-12 * (1.0 + W), "{s:?} at {Omega}: {gap:e}");
            }
        }
    }
}

#[test]
fn the_trapezoidal_rule_keeps_the_energy_of_an_oscillator() {
    let options = DynamicOptions::new(100.0, 0.1);
    let energy = run(Oscillator::new(2.0, 50.0), 0.3, 1.0, &options)
        .summary
        .energy
        .unwrap();
    assert!((energy.start - (0.5 * 50.0 * 0.09 + 1.0)).abs() < 1e-14);
    assert!(energy.largest_defect < 1e-10 * energy.start, "{energy:?}");
}

#[test]
fn kinks_of_a_load_are_ends_of_steps() {
    // ẍ + ω² x = hat: exact by superposition of three ramps, x = (2/ω²)(τ − sin ωτ/ω) each.
    let omega = 2.5_f64;
    let ramp = |t: f64, from: f64| {
        let tau = (t - from).max(0.0);
        2.0 / (omega * omega) * (tau - (omega * tau).sin() / omega)
    };
    let exact = |t: f64| ramp(t, 0.0) - 2.0 * ramp(t, 0.5) + ramp(t, 1.0);
    for scheme in [Scheme::default(), Scheme::chung_hulbert(0.6).unwrap()] {
        let mut errors = Vec::new();
        // No step divides 0.5: the steps are shortened to end there.
        for h in [0.03, 0.015, 0.0075] {
            let mut system = Oscillator::new(1.0, omega * omega);
            system.hat = 1.0;
            let options = DynamicOptions {
                scheme,
                ..DynamicOptions::new(2.2, h)
            };
            let mut times = Vec::new();
            let mut observe = |_: &mut Oscillator, step: &StepReport<'_>| {
                times.push(step.progress.state.t);
                ControlFlow::Continue(())
            };
            let mut progress = Progress::new(start(&system, 0.0, &[], &[]).unwrap());
            integrate(&mut system, &mut progress, &options, &mut observe).unwrap();
            assert!(times.contains(&0.5) && times.contains(&1.0) && times.contains(&2.2));
            assert_eq!(times.len(), progress.summary.steps);
            errors.push((progress.state.q[0] - exact(2.2)).abs());
            // The work of the load closes to the order of the scheme.
            let energy = progress.summary.energy.unwrap();
            assert!(energy.largest_defect < 2.0 * h * h, "{energy:?}");
        }
        for slope in slopes(&errors) {
            assert!((slope - 2.0).abs() < 0.15, "{scheme:?}: {errors:?}");
        }
    }
}

/// A system that cannot be evaluated where it would have moved far in one step.
struct Skittish(Pendulum, f64);

impl System for Skittish {
    fn pattern(&self) -> &BlockPattern {
        self.0.pattern()
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        if (at.q[0] - self.1).abs() > 0.2 {
            return Err(SystemError::OutsideChart {
                edge: pullback_manifold::system::CHART_EDGE,
                what: "the pendulum".to_owned(),
                margin: 0.2 - (at.q[0] - self.1).abs(),
            });
        }
        self.0.evaluate(at, out)
    }

    fn change_charts(
        &mut self,
        _: f64,
        q: &mut [f64],
        _: &mut [f64],
        _: &mut [&mut [f64]],
    ) -> pullback_manifold::system::ChartChanges {
        self.1 = q[0];
        Default::default()
    }
}

#[test]
fn failed_steps_are_halved_and_grow_back() {
    let mut system = Skittish(Pendulum::new(), 1.5);
    let mut progress = Progress::new(start(&system, 0.0, &[1.5], &[]).unwrap());
    let options = DynamicOptions::new(2.0, 0.25);
    let mut sizes = Vec::new();
    let mut observe = |_: &mut Skittish, step: &StepReport<'_>| {
        sizes.push(step.step_size);
        ControlFlow::Continue(())
    };
    integrate(&mut system, &mut progress, &options, &mut observe).unwrap();
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
    let error = integrate(&mut stuck, &mut progress, &options, &mut onward).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("step 1 failed between time 0.000000"),
        "{text}"
    );
    assert!(text.contains("the pendulum left the domain"), "{text}");
    assert_eq!(
        progress.state.q,
        [1.5],
        "the state is that of the last accepted step"
    );
}

#[test]
fn newton_converges_quadratically_and_a_kept_tangent_linearly() {
    let mut system = Pendulum::new();
    for (tangent, most) in [(Tangent::Every, 5), (Tangent::Once, 14)] {
        let options = DynamicOptions {
            newton: NewtonOptions {
                tangent,
                relative: 1e-13,
                ..NewtonOptions::default()
            },
            ..DynamicOptions::new(0.3, 0.3)
        };
        let mut progress = Progress::new(start(&system, 0.0, &[2.0], &[1.0]).unwrap());
        let mut history = Vec::new();
        let mut observe = |_: &mut Pendulum, step: &StepReport<'_>| {
            history = step.residuals.iter().map(|i| i.residual[1]).collect();
            ControlFlow::Continue(())
        };
        integrate(&mut system, &mut progress, &options, &mut observe).unwrap();
        assert!(progress.summary.iterations <= most, "{history:?}");
        let first = history[0];
        let scaled: Vec<f64> = history.iter().map(|r| r / first).collect();
        if tangent == Tangent::Every {
            // rₖ₊₁ ≤ c rₖ² with a moderate c until rounding.
            for pair in scaled.windows(2).filter(|p| p[1] > 1e-14) {
                assert!(pair[1] < 2.0 * pair[0] * pair[0], "{scaled:?}");
            }
            assert_eq!(
                progress.summary.factorisations,
                1 + progress.summary.iterations
            );
        } else {
            assert_eq!(progress.summary.factorisations, 2);
        }
    }
}

#[test]
fn a_run_goes_on_from_a_copy_to_the_last_bit() {
    for scheme in [Scheme::default(), Scheme::chung_hulbert(0.5).unwrap()] {
        for adaptivity in [
            None,
            Some(Adaptivity {
                tolerance: 1e-5,
                max_step: 0.2,
            }),
        ] {
            let options = DynamicOptions {
                scheme,
                adaptivity,
                ..DynamicOptions::new(3.0, 0.07)
            };
            let mut system = Pendulum::new();
            let mut whole = Progress::new(start(&system, 0.0, &[1.0], &[2.0]).unwrap());
            let mut copy = None;
            let mut observe = |_: &mut Pendulum, step: &StepReport<'_>| {
                if step.progress.summary.steps == 17 {
                    copy = Some(step.progress.clone());
                }
                ControlFlow::Continue(())
            };
            integrate(&mut system, &mut whole, &options, &mut observe).unwrap();
            let mut rest = copy.unwrap();
            integrate(&mut Pendulum::new(), &mut rest, &options, &mut onward).unwrap();
            assert_eq!(whole, rest);
        }
    }
}

#[test]
fn adaptive_steps_follow_the_error() {
    let exact = [0.986_291_751_131_875_f64, -0.165_010_853_125_541];
    let mut last = f64::INFINITY;
    for tolerance in [1e-4, 1e-5, 1e-6, 1e-7] {
        let options = DynamicOptions {
            adaptivity: Some(Adaptivity {
                tolerance,
                max_step: 0.5,
            }),
            ..DynamicOptions::new(1.0, 0.3)
        };
        let end = run(Pendulum::new(), -TAU / 4.0, 0.0, &options);
        assert!(end.summary.inaccurate > 0, "the first step is too large");
        let error = (end.state.q[0] - exact[0].atan2(-exact[1])).abs();
        // Global errors go like the power 2/3 of local ones.
        assert!(
            error < 20.0 * tolerance.powf(2.0 / 3.0) && error < last,
            "{error}"
        );
        last = error;
    }
}

#[test]
fn parameters_and_options_are_refused_with_their_range() {
    let says = |r: Result<Scheme, DynamicsError>, text: &str| {
        let error = r.unwrap_err().to_string();
        assert!(error.contains(text), "{error}");
    };
    says(
        Scheme::newmark(0.25, 0.4),
        "Newmark's gamma = 0.4 is outside its range [0.500000, 1.000000]",
    );
    says(
        Scheme::newmark(0.2, 0.5),
        "Newmark's beta (at least gamma/2) = 0.2",
    );
    says(
        Scheme::hht(-0.4),
        "alpha of HHT = -0.4 is outside its range [-0.333333, 0.000000]",
    );
    says(Scheme::hht(f64::NAN), "alpha of HHT = NaN");
    says(Scheme::wbz(1.1), "rho of WBZ = 1.1");
    says(Scheme::chung_hulbert(-0.1), "rho of Chung-Hulbert = -0.1");
    let try_run = |options: DynamicOptions| {
        let mut system = Pendulum::new();
        let mut progress = Progress::new(start(&system, 0.0, &[], &[]).unwrap());
        integrate(&mut system, &mut progress, &options, &mut onward)
            .unwrap_err()
            .to_string()
    };
    for (step, to, text) in [
        (0.0, 1.0, "option step = 0.0 is not usable"),
        (f64::NAN, 1.0, "option step = NaN"),
        (0.1, -1.0, "option to = -1.0"),
        (0.1, f64::INFINITY, "option to = inf"),
    ] {
        let found = try_run(DynamicOptions::new(to, step));
        assert!(found.contains(text), "{found}");
    }
    let error = start(&Pendulum::new(), 0.0, &[1.0, 2.0], &[]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "initial coordinates: 2 given where the system has 1 coordinates"
    );
    let error = start(&Oscillator::new(1.0, 1.0), 0.0, &[], &[f64::NAN]).unwrap_err();
    assert_eq!(error.to_string(), "initial velocities: the mass is NaN");
}

#[test]
fn a_coordinate_without_mass_is_found_by_its_stiffness_or_named() {
    // Without mass the coordinate follows its load: x = p/k at once.
    let mut system = Oscillator::new(0.0, 4.0);
    system.hat = 1.0;
    let mut progress = Progress::new(start(&system, 0.0, &[], &[]).unwrap());
    let options = DynamicOptions::new(0.5, 0.05);
    integrate(&mut system, &mut progress, &options, &mut onward).unwrap();
    assert!((progress.state.q[0] - 0.25).abs() < 1e-12);
    let mut nothing = Oscillator::new(0.0, 0.0);
    let mut progress = Progress::new(start(&nothing, 0.0, &[], &[]).unwrap());
    let error = integrate(&mut nothing, &mut progress, &options, &mut onward).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("no consistent accelerations at time 0.000000"),
        "{text}"
    );
}
