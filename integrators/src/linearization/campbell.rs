//! Modes over the speed of a rotation: the Campbell diagram.
//!
//! At each speed a relative equilibrium is found and linearised. Modes of successive speeds are one line where their
//! shapes agree best by the modal assurance criterion with the inner product of M (Allemang & Brown 1982),
//!
//! ```text
//! MAC = |φᴴ M χ|² / (φᴴ M φ · χᴴ M χ)
//! ```
//!
//! which follows them through crossings; speeds in between are added where shapes change fast, as in veerings. The
//! criterion is applied to shapes with their velocities, (s φ, λ φ) with a frequency s of the modes, and to both modes
//! of a conjugate pair: a whirl whose frequency passes through zero goes on as the conjugate mode.
//!
//! Coordinates of parts that rotate are relative to them. Their equations may be periodic, as those of blades on a tower; those of
//! an isotropic rotor are constant in multi-blade coordinates.

mod lines;
mod multi_blade;

use super::finish::ROUNDING;
use super::modes::{Mode, ModeOptions, ModesError, modes_while};
use super::{
    LinearizationError, Linearized, SteadyMotion, check_count, equations, inner_product,
    is_balanced, linearize,
};
use crate::significant;
use crate::statics::{StaticOptions, StaticsError, StepParameter, equilibrium_from};
use lines::{Lines, conjugate, continued, groups};
use multi_blade::{TURN, motion, pulled_back};
use num_complex::Complex64;
use pullback_manifold::system::{CyclicSymmetry, Point, System};
use std::ops::ControlFlow;
use thiserror::Error;

/// What a Campbell diagram shows.
#[derive(Clone, Debug, PartialEq)]
pub struct CampbellOptions {
    /// Time, at which frames have turned by zero: that of loads which depend on it.
    pub t: f64,
    /// Speeds Ω, in an order in which each follows from the one before.
    pub speeds: Vec<f64>,
    /// Number of modes at the first speed; the last one with all that have the same eigenvalue.
    pub count: usize,
    /// Newton's method for equilibria, and the smallest step between two of them as a part of the change of Ω.
    pub statics: StaticOptions,
    /// A turn that maps all that rotates on itself, for multi-blade coordinates of it.
    pub rotor: Option<CyclicSymmetry>,
}

/// Modes over the speed.
#[derive(Clone, Debug)]
pub struct CampbellDiagram {
    /// Speeds.
    pub speeds: Vec<f64>,
    /// The modes of the first speed, by growing |λ|, each with its continuation: `None` where it is not among the
    /// lowest modes, or with another eigenvalue at that speed, any more.
    pub lines: Vec<Vec<Option<Mode>>>,
    /// The linear equations at the last speed, those of the modes; `None` without speeds.
    pub last: Option<Linearized>,
    /// Whether coordinates of rotating parts are multi-blade ones: frequencies are then those seen from parts that do not
    /// rotate.
    pub multi_blade: bool,
}

/// Error of [`campbell`].
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CampbellError {
    /// No relative equilibrium at a speed.
    #[error("no relative equilibrium is found at a speed of {}: {source}", significant(*.speed))]
    Equilibrium {
        /// The speed.
        speed: f64,
        /// The reason.
        source: StaticsError,
    },
    /// The equations depend on the angle.
    #[error(
        "at a speed of {} the equations of {name} change as the frame turns: coordinates of rotating parts that are not \
         relative to them, a second rotor of another speed, bent beams of total rotation vectors (take geodesic \
         interpolation), loads that are fixed in space or depend on time, or a rotor that is not isotropic, as one of less than three equal blades, on parts that do not \
         rotate. The coefficients of the latter two are periodic, and stability needs Floquet theory",
        significant(*.speed)
    )]
    Periodic {
        /// The speed.
        speed: f64,
        /// A coordinate whose equation changes.
        name: String,
    },
    /// The equilibrium cannot be linearised.
    #[error("at a speed of {}: {source}", significant(*.speed))]
    Linearization {
        /// The speed.
        speed: f64,
        /// The reason.
        source: LinearizationError,
    },
    /// The search for modes failed.
    #[error("at a speed of {}: {source}", significant(*.speed))]
    Modes {
        /// The speed.
        speed: f64,
        /// The reason.
        source: ModesError,
    },
}

/// Modes beyond those of the lines that are found at each speed, so that lines may cross.
const SPARE: usize = 6;
/// Least agreement of shapes at successive speeds.
const SIMILAR: f64 = 0.8;
/// Largest number of times that a step in speed is halved where shapes change fast.
const HALVINGS: usize = 5;
/// Largest change of the generalised stiffness of modes during a turn that counts as none, relative to that of the modes, and
/// largest displacement by forces that turn, relative to the sizes of coordinates.
const STEADY: f64 = 1e-5;

/// Modes over the speeds of an input Ω, from coordinates `q` near the equilibrium of the first speed; `q` ends as that of the last
/// speed.
///
/// Frames turn by the angle Ω (t − `options.t`). The observer is called before each speed and may end the search.
///
/// # Errors
/// [`CampbellError`], with the speed.
///
/// # Panics
/// If the system has no such input, or `options.rotor` is of another system.
pub fn campbell(
    system: &mut dyn System,
    input: impl Into<usize>,
    q: &mut Vec<f64>,
    options: &CampbellOptions,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<CampbellDiagram, CampbellError> {
    let mut sweep = Sweep {
        system,
        input: input.into(),
        q,
        options,
        observer,
        speed: options.speeds.first().copied().unwrap_or_default(),
        lines: Lines::default(),
        last: None,
    };
    sweep.run()
}

/// A sweep over speeds.
struct Sweep<'a> {
    system: &'a mut dyn System,
    input: usize,
    q: &'a mut Vec<f64>,
    options: &'a CampbellOptions,
    observer: &'a mut dyn FnMut(f64) -> ControlFlow<()>,
    /// The present speed.
    speed: f64,
    /// The lines there.
    lines: Lines,
    /// The equations there.
    last: Option<Linearized>,
}

impl Sweep<'_> {
    /// The lines over all speeds.
    fn run(&mut self) -> Result<CampbellDiagram, CampbellError> {
        let options = self.options;
        let mut rows = Vec::new();
        for &speed in &options.speeds {
            match rows.is_empty() {
                true => self.begin(speed)?,
                false => self.advance(speed, HALVINGS)?,
            }
            let upper = |mode: &Mode| match mode.eigenvalue.im < 0.0 {
                true => conjugate(mode),
                false => mode.clone(),
            };
            rows.push((self.lines.modes.iter().map(|line| line.as_ref().map(upper))).collect());
        }
        let line = |k: usize| {
            rows.iter()
                .map(|row: &Vec<_>| row.get(k).cloned().flatten())
                .collect()
        };
        Ok(CampbellDiagram {
            speeds: options.speeds.clone(),
            // Not those that began and ended between two speeds.
            lines: (0..self.lines.modes.len())
                .map(line)
                .filter(|line: &Vec<Option<Mode>>| line.iter().any(Option::is_some))
                .collect(),
            last: self.last.take(),
            multi_blade: options.rotor.is_some(),
        })
    }

    /// Begins the lines at the first speed.
    fn begin(&mut self, speed: f64) -> Result<(), CampbellError> {
        check_count(self.options.count).map_err(|source| CampbellError::Modes { speed, source })?;
        let (found, lin) = self.modes_at(speed)?;
        // A group of repeated eigenvalues is not cut.
        let last = found.len().min(self.options.count).saturating_sub(1);
        let repeated = groups(&found);
        let count = repeated.get(last).and_then(|group| group.last());
        let count = count.map_or(0, |k| k + 1);
        self.lines = Lines::default().next(found.into_iter().take(count).map(Some).collect());
        self.last = Some(lin);
        Ok(())
    }

    /// Continues all lines to a speed, over speeds in between where shapes change fast.
    fn advance(&mut self, to: f64, halvings: usize) -> Result<(), CampbellError> {
        let (from, q) = (self.speed, self.q.clone());
        let (found, lin) = self.modes_at(to)?;
        let (lines, least) = continued(&self.lines, found, &lin);
        if least >= SIMILAR || halvings == 0 {
            (self.lines, self.last) = (lines, Some(lin));
            return Ok(());
        }
        (self.speed, *self.q) = (from, q);
        self.advance(0.5 * (from + to), halvings - 1)?;
        self.advance(to, halvings - 1)
    }

    /// The modes about the relative equilibrium of a speed.
    fn modes_at(&mut self, speed: f64) -> Result<(Vec<Mode>, Linearized), CampbellError> {
        let failed = |source| CampbellError::Modes { speed, source };
        if (self.observer)(speed).is_break() {
            return Err(failed(ModesError::Interrupted));
        }
        let t = self.options.t;
        // At the first speed there is no change.
        let change = (speed - self.speed).abs().max(f64::MIN_POSITIVE);
        let statics = StaticOptions {
            from: self.speed,
            to: speed,
            first_step: change,
            min_step: self.options.statics.min_step * change,
            max_step: f64::MAX,
            ..self.options.statics
        };
        let mut steady = SteadyMotion::new(&mut *self.system, t, self.input);
        if !is_balanced(&mut steady, Point::statics(speed, self.q)) {
            let found = equilibrium_from(&mut steady, std::mem::take(self.q), &statics);
            *self.q = found.map_err(|source| CampbellError::Equilibrium {
                speed,
                source: source.of(StepParameter::Speed),
            })?;
        }
        self.speed = speed;
        let zeros = vec![0.0; self.q.len()];
        let at = Point {
            t,
            q: self.q,
            v: &zeros,
            a: &zeros,
        };
        let lin = linearize(&mut *self.system, at)
            .map_err(|source| CampbellError::Linearization { speed, source })?;
        let lin = match &self.options.rotor {
            Some(rotor) => lin.in_multi_blade_coordinates(rotor, speed),
            None => lin,
        };
        let lines = (self.lines.modes.len().max(self.options.count)).min(2 * lin.dim());
        let mut sought = lines + SPARE + 1;
        loop {
            let options = ModeOptions::lowest(sought);
            let search = modes_while(&lin, &options, &mut |_| (self.observer)(speed));
            let mut found = search.map_err(failed)?;
            let all = found.modes.len();
            lin.retain_vibrations(&mut found.modes);
            let mut enough = found.modes.len() > lines + SPARE;
            if !found.complete {
                // Others may repeat the last eigenvalue, and shapes of a part of them are any ones.
                let last = groups(&found.modes).pop();
                let whole = last.and_then(|last| last.first().copied()).unwrap_or(0);
                found.modes.truncate(whole);
                enough &= whole > lines;
            }
            if enough || found.complete || all < sought {
                self.check_steady(&lin, &found.modes, speed)?;
                return Ok((found.modes, lin));
            }
            sought *= 2;
        }
    }

    /// Refuses equations that are other ones after a turn by [`TURN`].
    fn check_steady(
        &mut self,
        lin: &Linearized,
        modes: &[Mode],
        speed: f64,
    ) -> Result<(), CampbellError> {
        if speed == 0.0 {
            return Ok(());
        }
        let zeros = vec![0.0; self.q.len()];
        let at = Point {
            t: self.options.t + TURN / speed,
            q: self.q,
            v: &zeros,
            a: &zeros,
        };
        let failed = |source| CampbellError::Linearization { speed, source };
        let rotor = self.options.rotor.as_ref();
        let (other, r) = equations(&mut *self.system, at).map_err(failed)?;
        let r: Vec<Complex64> = r.into_iter().map(Complex64::from).collect();
        let pushed = lin.displaced(&pulled_back(rotor, &r), modes, speed);
        let changed = pushed.or_else(|| lin.change(&other, rotor, modes, speed));
        changed.map_or(Ok(()), |name| Err(CampbellError::Periodic { speed, name }))
    }
}

impl Linearized {
    /// The name of the coordinate with the largest residual, if residuals would displace these modes.
    fn displaced(&self, r: &[Complex64], modes: &[Mode], omega: f64) -> Option<String> {
        let coordinates = self.pattern.coordinates();
        let moves = |mode: &Mode| {
            let work = inner_product(&mode.shape, r);
            let shape = mode.shape.iter().zip(coordinates);
            let sizes = shape.filter(|(_, info)| !info.is_multiplier);
            let largest = sizes.fold(0.0, |most: f64, (x, info)| most.max(x.norm() / info.size));
            work.norm() * largest > STEADY * mode.eigenvalue.norm_sqr().max(omega * omega)
        };
        let worst = (0..r.len()).max_by(|&i, &j| r[i].norm().total_cmp(&r[j].norm()))?;
        modes.iter().any(moves).then(|| self.names[worst].clone())
    }

    /// K q + C q̇ + M q̈.
    fn forces(&self, motion: &[Vec<Complex64>; 3]) -> Vec<Complex64> {
        let mut forces = vec![Complex64::ZERO; self.dim()];
        for (values, x) in [&self.K, &self.C, &self.M].into_iter().zip(motion) {
            self.pattern.multiply_add(1.0, values, x, &mut forces);
        }
        forces
    }

    /// The name of a coordinate whose equation in the motion of these modes is another one after a turn, if there is any.
    fn change(
        &self,
        other: &Self,
        rotor: Option<&CyclicSymmetry>,
        modes: &[Mode],
        omega: f64,
    ) -> Option<String> {
        // Forces of stiff parts are the same but for rounding errors.
        let whole = |mode: &Mode| -> f64 {
            let (x, size) = (&mode.shape, mode.omega());
            let parts = [(&self.K, 1.0), (&self.C, size), (&self.M, size * size)];
            let sum = |(values, factor): (&Vec<f64>, f64)| -> f64 {
                let entries = self.pattern.triplets(values);
                let sizes = entries.map(|(r, c, value)| value.abs() * x[r].norm() * x[c].norm());
                factor * sizes.sum::<f64>()
            };
            parts.map(sum).iter().sum()
        };
        let rounding = |a: &Mode, b: &Mode| ROUNDING * (whole(a) * whole(b)).sqrt();
        for mode in modes {
            let mut forces = other.forces(&motion(rotor, mode, omega));
            forces = pulled_back(rotor, &forces);
            let own = self.forces(&motion(None, mode, omega));
            forces.iter_mut().zip(own).for_each(|(f, own)| *f -= own);
            let least = STEADY * mode.eigenvalue.norm_sqr().max(omega * omega);
            // Of circular whirl, only the conjugate one may be changed.
            for other in modes {
                let work = forces.iter().zip(&other.shape).map(|(f, x)| f * x);
                let with_conjugate: Complex64 = work.clone().sum();
                let most = with_conjugate
                    .norm()
                    .max(inner_product(&other.shape, &forces).norm());
                if most > least && most > least + rounding(mode, other) {
                    let sizes = work.map(|work| work.norm()).enumerate();
                    let largest = sizes.max_by(|a, b| a.1.total_cmp(&b.1));
                    return largest.map(|(i, _)| self.names[i].clone());
                }
            }
        }
        None
    }
}
