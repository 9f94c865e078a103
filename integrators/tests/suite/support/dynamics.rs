//! Systems of one coordinate that are known exactly, and runs of them.

use super::*;
pub use pullback_integrators::dynamics::scheme::{SchemeProperties, Stage};

/// m ẍ + c ẋ + k x = p(t): r and its tangents for one coordinate.
#[derive(Clone)]
pub struct Oscillator {
    pub pattern: BlockPattern,
    pub m: f64,
    pub c: f64,
    pub k: f64,
    /// Stiffness after t = 1, if it is another one.
    pub later: Option<f64>,
    /// Constant load.
    pub force: f64,
    /// Hat load: peak at t = 0.5, ends at t = 1.
    pub hat: f64,
    pub kinks: Vec<f64>,
}

impl Oscillator {
    pub fn new(m: f64, k: f64) -> Self {
        Self {
            pattern: BlockPattern::dense(1),
            m,
            c: 0.0,
            k,
            later: None,
            force: 0.0,
            hat: 0.0,
            kinks: vec![0.0, 1.0, 0.5, 0.5],
        }
    }

    /// A unit mass under a constant force: the schemes are exact.
    pub fn mass(force: f64) -> Self {
        Self {
            force,
            kinks: Vec::new(),
            ..Self::new(1.0, 0.0)
        }
    }

    fn stiffness(&self, t: f64) -> f64 {
        self.later.filter(|_| t > 1.0).unwrap_or(self.k)
    }

    pub fn load(&self, t: f64) -> f64 {
        self.force + self.hat * (1.0 - (2.0 * t - 1.0).abs()).max(0.0)
    }
}

impl System for Oscillator {
    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        let k = self.stiffness(at.t);
        out.r[0] = self.load(at.t) - k * at.q[0] - self.c * at.v[0] - self.m * at.a[0];
        if let Some((w, S)) = out.S {
            S[0] = w.K * k + w.C * self.c + w.M * self.m;
        }
        Ok(())
    }

    fn name(&self, _: usize) -> String {
        "the mass".to_owned()
    }

    fn energetics(&mut self) -> Option<&mut dyn Energetics> {
        Some(self)
    }

    fn events(&mut self) -> Option<&mut dyn Events> {
        Some(self)
    }
}

impl Energetics for Oscillator {
    fn energies(&mut self, at: Point<'_>) -> Result<Energies, SystemError> {
        Ok(Energies {
            kinetic: 0.5 * self.m * at.v[0] * at.v[0],
            stored: 0.5 * self.stiffness(at.t) * at.q[0] * at.q[0],
            supplied: self.load(at.t) * at.v[0],
            dissipated: self.c * at.v[0] * at.v[0],
            ..Energies::default()
        })
    }
}

impl Events for Oscillator {
    fn kinks(&self) -> Vec<f64> {
        self.kinks.clone()
    }
}

/// φ̈ = −(g/L) sin φ: a planar pendulum, φ from the lowest point.
#[derive(Clone)]
pub struct Pendulum {
    pub pattern: BlockPattern,
    pub g: f64,
}

impl Pendulum {
    pub fn new() -> Self {
        Self {
            pattern: BlockPattern::dense(1).with_coordinates(|_| CoordinateInfo {
                quantity: Quantity::Angle,
                ..CoordinateInfo::default()
            }),
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
}

pub fn onward<Y: ?Sized>(_: &mut Y, _: &StepReport<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Equal steps of a scheme.
pub fn steps_of(scheme: Scheme, to: f64, step: f64) -> DynamicOptions {
    DynamicOptions {
        scheme,
        ..DynamicOptions::new(to, step)
    }
}

/// The same with steps that follow a tolerance, none longer than `max_step`.
pub fn adaptive(equal: DynamicOptions, tolerance: f64, max_step: f64) -> DynamicOptions {
    DynamicOptions {
        adaptivity: Some(Adaptivity {
            tolerance,
            max_step,
        }),
        ..equal
    }
}

/// A run that may fail.
pub fn attempt<Y: System>(
    system: &mut Y,
    [q, v]: [&[f64]; 2],
    options: &DynamicOptions,
) -> Result<Progress, DynamicsError> {
    let mut progress = Progress::new(start(system, 0.0, q, v)?);
    integrate(system, &mut progress, options, &mut onward)?;
    Ok(progress)
}

/// A run from a position and a velocity.
pub fn run<Y: System>(system: Y, q: f64, v: f64, options: &DynamicOptions) -> Progress {
    observed(system, q, v, options, |_| ()).1
}

/// A run, with what a function takes from each of its steps.
pub fn observed<Y: System, T>(
    mut system: Y,
    q: f64,
    v: f64,
    options: &DynamicOptions,
    of: impl Fn(&StepReport<'_>) -> T,
) -> (Vec<T>, Progress) {
    let mut progress = Progress::new(start(&system, 0.0, &[q], &[v]).unwrap());
    let mut seen = Vec::new();
    integrate(&mut system, &mut progress, options, &mut |_, step| {
        seen.push(of(step));
        ControlFlow::Continue(())
    })
    .unwrap();
    (seen, progress)
}

/// Properties of a scheme of an order that is stable at every step, and not symmetric.
pub fn stable(order: usize) -> SchemeProperties {
    SchemeProperties {
        order,
        limit: None,
        symmetric: false,
    }
}

pub fn schemes() -> Vec<Scheme> {
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
pub fn slopes(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect()
}
