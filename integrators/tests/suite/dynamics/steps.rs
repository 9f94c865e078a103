//! Integration in time of systems small enough to be known exactly: no beam is known here.

use crate::support::dynamics::*;
use crate::support::*;
use nalgebra::{Matrix4, Vector2, Vector3, Vector4};

#[test]
fn steps_that_change_their_size_keep_the_order() {
    // x = cos t by steps h, 2h, h, 2h, ...: the algorithmic acceleration goes along.
    for scheme in schemes() {
        let error = |parts: u32| {
            let h = 1.0 / f64::from(3 * parts);
            let mut system = Oscillator::new(1.0, 1.0);
            let mut progress = Progress::new(start(&system, 0.0, &[1.0], &[]).unwrap());
            for k in 1..=parts {
                let end = f64::from(k) / f64::from(parts);
                for (to, step) in [(end - 2.0 * h, h), (end, 2.0 * h)] {
                    progress.next_step = step;
                    let options = steps_of(scheme, to, step);
                    integrate(&mut system, &mut progress, &options, &mut onward).unwrap();
                }
            }
            assert_eq!(progress.summary.steps, 2 * parts as usize);
            (progress.state.q[0] - 1.0_f64.cos()).abs()
        };
        for slope in slopes(&[error(40), error(80), error(160)]) {
            assert!((slope - 2.0).abs() < 0.1, "{scheme:?}: {slope}");
        }
    }
}

#[test]
fn the_trapezoidal_rule_keeps_the_energy_of_an_oscillator() {
    let options = DynamicOptions::new(100.0, 0.1);
    let end = run(Oscillator::new(2.0, 50.0), 0.3, 1.0, &options);
    let energy = end.summary.energy.unwrap();
    assert!((energy.start - (0.5 * 50.0 * 0.09 + 1.0)).abs() < 1e-14);
    assert!(energy.largest_defect < 1e-10 * energy.start, "{energy:?}");
}

#[test]
fn kinks_of_a_load_are_ends_of_steps() {
    // ẍ + ω² x = hat: exact by superposition of three ramps, x = (2/ω²)(τ − sin ωτ/ω) each.
    let omega = 2.5_f64;
    let ramp = |from: f64| {
        let tau = 2.2 - from;
        let (sin, cos) = (omega * tau).sin_cos();
        Vector2::new(tau - sin / omega, 1.0 - cos) * (2.0 / (omega * omega))
    };
    let exact = ramp(0.0) - ramp(0.5) * 2.0 + ramp(1.0);
    let error = |state: &State| (Vector2::new(state.q[0], state.v[0]) - exact).amax();
    let mut system = Oscillator::new(1.0, omega * omega);
    system.hat = 1.0;
    for (scheme, h, order, within) in [
        (Scheme::default(), 0.03, 2.0, 0.15),
        (Scheme::chung_hulbert(0.6).unwrap(), 0.03, 2.0, 0.15),
        (Scheme::tsitouras(), 0.09, 5.0, 0.2),
    ] {
        // No step divides 0.5: the steps are shortened to end there.
        let errors = [h, 0.5 * h, 0.25 * h].map(|h| {
            let options = steps_of(scheme, 2.2, h);
            let time = |step: &StepReport<'_>| step.progress.state.t;
            let (times, progress) = observed(system.clone(), 0.0, 0.0, &options, time);
            assert!(times.contains(&0.5) && times.contains(&1.0) && times.contains(&2.2));
            assert_eq!(times.len(), progress.summary.steps);
            // The work of the load closes to the order of the scheme.
            let energy = progress.summary.energy.unwrap();
            assert!(energy.largest_defect < 2.0 * h * h, "{energy:?}");
            error(&progress.state)
        });
        for slope in slopes(&errors) {
            assert!((slope - order).abs() < within, "{scheme:?}: {errors:?}");
        }
    }
    let options = adaptive(steps_of(Scheme::tsitouras(), 2.2, 0.3), 1e-9, 1.0);
    let end = run(system, 0.0, 0.0, &options).state;
    assert!(error(&end) < 1e-8, "{end:?}");
}

/// A mass x on a spring k and, beside it, a Maxwell element: a spring e and a dashpot c, which a force
/// pushes from t = 0.5 on, with z its length; and the state w of a controller that is driven to sin t,
/// with ẇ + ẇ³. Neither z nor w has mass. A spring alone holds a fourth coordinate.
struct Maxwell(BlockPattern);

impl Maxwell {
    const M: f64 = 1.0;
    const K: f64 = 9.0;
    const E: f64 = 4.0;
    const C: f64 = 2.0;
    const PUSH: f64 = 3.0;

    fn push(t: f64) -> f64 {
        if t < 0.5 { 0.0 } else { Self::PUSH }
    }

    /// (x, ẋ, z) a time t > 0.5 after x = 1 at rest with z = 0, by the matrix exponential.
    fn exact(t: f64) -> Vector3<f64> {
        let rates = |push: f64| {
            let (k, e, c, m) = (Self::K, Self::E, Self::C, Self::M);
            let mut A = Matrix4::zeros();
            A[(0, 1)] = 1.0;
            (A[(1, 0)], A[(1, 2)]) = (-(k + e) / m, e / m);
            (A[(2, 0)], A[(2, 2)], A[(2, 3)]) = (e / c, -e / c, push / c);
            A
        };
        let start = Vector4::new(1.0, 0.0, 0.0, 1.0);
        let pushed = (rates(Self::PUSH) * (t - 0.5)).exp();
        (pushed * ((rates(0.0) * 0.5).exp() * start))
            .fixed_rows::<3>(0)
            .into_owned()
    }
}

impl System for Maxwell {
    fn pattern(&self) -> &BlockPattern {
        &self.0
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        let ([x, z, w], [_, z_dot, w_dot]) =
            ([0, 1, 2].map(|i| at.q[i]), [0, 1, 2].map(|i| at.v[i]));
        let stretch = Self::E * (x - z);
        out.r[0] = -Self::M * at.a[0] - Self::K * x - stretch;
        out.r[1] = stretch + Self::push(at.t) - Self::C * z_dot;
        let (s, c) = at.t.sin_cos();
        out.r[2] = s - w + c + c.powi(3) - w_dot - w_dot.powi(3);
        out.r[3] = -Self::K * at.q[3];
        if let Some((weights, S)) = out.S {
            let (k, e) = (Self::K, Self::E);
            let mut K = Matrix4::from_diagonal(&Vector4::new(k + e, e, 1.0, k));
            (K[(0, 1)], K[(1, 0)]) = (-e, -e);
            let C = Vector4::new(0.0, Self::C, 1.0 + 3.0 * w_dot * w_dot, 0.0);
            let M = Vector4::new(Self::M, 0.0, 0.0, 0.0);
            let [C, M] = [C, M].map(|x| Matrix4::from_diagonal(&x));
            S.copy_from_slice((K * weights.K + C * weights.C + M * weights.M).as_slice());
        }
        Ok(())
    }

    fn energetics(&mut self) -> Option<&mut dyn Energetics> {
        Some(self)
    }

    fn events(&mut self) -> Option<&mut dyn Events> {
        Some(self)
    }
}

impl Energetics for Maxwell {
    fn energies(&mut self, at: Point<'_>) -> Result<Energies, SystemError> {
        let [x, z] = [at.q[0], at.q[1]];
        Ok(Energies {
            kinetic: 0.5 * Self::M * at.v[0] * at.v[0],
            stored: 0.5 * (Self::K * x * x + Self::E * (x - z).powi(2)),
            supplied: Self::push(at.t) * at.v[1],
            dissipated: Self::C * at.v[1] * at.v[1],
            ..Energies::default()
        })
    }
}

impl Events for Maxwell {
    /// What is not a number is passed over.
    fn kinks(&self) -> Vec<f64> {
        vec![0.5, f64::NAN.copysign(-1.0)]
    }
}

#[test]
fn first_order_equations_among_those_of_motion_keep_the_order() {
    let to = 1.5;
    let exact = Maxwell::exact(to);
    let projected = ["projected-newmark", "projected-newmark:0.8"];
    let more = projected.into_iter().chain(["bathe", "bathe:0.5", "radau"]);
    let more = more.map(|word| word.parse::<Scheme>().unwrap());
    for scheme in schemes().into_iter().chain(more) {
        // Of order three: rounding errors come soon.
        let least = if scheme.order() == 2 { 800.0 } else { 100.0 };
        let errors = [1.0, 2.0, 4.0].map(|n| {
            let n = least * n;
            let mut options = steps_of(scheme, to, to / n);
            options.newton.relative = 1e-13;
            let mut system = Maxwell(BlockPattern::dense(4));
            let progress = attempt(&mut system, [&[1.0, 0.0, 0.0, 0.0], &[]], &options);
            let State { q, v, .. } = progress.unwrap().state;
            [
                q[0] - exact[0],
                v[0] - exact[1],
                q[1] - exact[2],
                q[2] - to.sin(),
                v[2] - to.cos(),
            ]
        });
        for k in 0..5 {
            let e = errors.map(|e| e[k].abs());
            for slope in slopes(&e) {
                let order = scheme.order() as f64;
                assert!((slope - order).abs() < 0.1, "{scheme}, {k}: {e:?}");
            }
        }
    }
}
