//! Spectra of schemes, for `pullback spectrum`.
//!
//! [`run`] measures them from the steps of the integrator and adds the closed forms of theory
//! ([`pullback_integrators::spectrum`]); [`table`], [`csv()`] and [`figures`] format them, and
//! [`write()`] writes them to a directory.

mod figures;

pub use figures::figures;

use crate::method::PREFIXES;
use crate::output::{Directory, OutputError, drawing};
use crate::studies::general;
use crate::terminal::longest;
use pullback_integrators::dynamics::{DynamicsError, Scheme};
use pullback_integrators::significant;
use pullback_integrators::spectrum::{self as integrator, closed_form, expansion, logarithmic};
use serde::{Serialize, Serializer};
use std::f64::consts::TAU;
use std::path::Path;

/// Names of all files that are written.
pub const FILES: [&str; 4] = [
    "spectrum.json",
    "spectrum.csv",
    "spectrum.svg",
    "overshoot.svg",
];

/// Default schemes.
pub const SCHEMES: &str = "newmark,hht:-0.1,wbz:0.5,ga:0.5,bathe,radau,central-difference";

/// Allowed range of Ω: beyond it no digits are left.
const RANGE: [f64; 2] = [1e-12, 1e12];

/// Errors of spectra.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "each message says what its variant is")]
#[non_exhaustive]
pub enum SpectrumError {
    /// A scheme or a position is refused.
    #[error("{0}")]
    Scheme(#[from] DynamicsError),
    #[error(
        "Ω from {} to {} is not a range: both must lie between {:e} and {:e}, the second one larger",
        significant(*from), significant(*to), RANGE[0], RANGE[1]
    )]
    Range { from: f64, to: f64 },
    #[error(
        "scheme `{word}`: formulations of rotations do not affect a linear vibration: leave the prefix \
         out, `{scheme}`"
    )]
    Prefix { word: String, scheme: String },
    #[error(
        "scheme `{word}`: its projection is not a linear map and gives back what the step takes, so that it has no \
         spectrum; that of its step is the one of `{step}`"
    )]
    Projection { word: String, step: String },
    #[error(
        "`{word}` is a general solver, which chooses its own steps: it has no spectrum over Ω = ω h"
    )]
    Solver { word: String },
    #[error("scheme `{name}` is given twice: name it once")]
    Twice { name: String },
    #[error("{0}")]
    Output(#[from] OutputError),
}

/// The spectrum of a scheme.
#[derive(Clone, Debug, Serialize)]
pub struct Spectrum {
    /// The name from which the scheme is parsed.
    pub scheme: String,
    /// Its name.
    pub name: &'static str,
    /// Order of accuracy.
    pub order: usize,
    /// Largest Ω at which it is stable; null where it always is.
    pub limit: Option<f64>,
    /// Largest difference between the coefficients of the characteristic polynomials by steps and in
    /// closed form, up to the limit; null where there is no closed form.
    pub defect: Option<f64>,
    /// κ and σ of the period elongation κ Ω² and the damping ratio σ Ω³ at small Ω in theory; null
    /// where there is no such formula.
    pub expansion: Option<[f64; 2]>,
    /// Its numbers at each Ω, ascending.
    pub points: Vec<SpectrumPoint>,
}

/// The accuracy of a scheme at one Ω. Beyond the limit of a scheme there is no vibration, and neither damping nor
/// elongation. In files names of numbers in closed form begin with `closed_`, and those at small Ω are
/// `expanded_damping` and `expanded_elongation`; unknown numbers are null or empty.
#[derive(Clone, Copy, Debug)]
pub struct SpectrumPoint {
    /// By the steps of the integrator.
    pub steps: integrator::Accuracy,
    /// In closed form, where there is one.
    pub closed: Option<integrator::Accuracy>,
    /// κ Ω² and σ Ω³, the limits of period elongation and damping ratio at small Ω.
    pub expansion: Option<[f64; 2]>,
}

/// A number at one Ω, where it exists.
type Number = fn(&integrator::Accuracy) -> Option<f64>;

/// Those of the eigenvalues, and of the first step from rest and from the origin.
const NUMBERS: [(&str, Number); 7] = [
    ("radius", |p| Some(p.numbers.radius)),
    ("damping", |p| p.numbers.damping),
    ("elongation", |p| p.numbers.elongation),
    ("rest_position", |p| Some(p.first_step.from_rest[0])),
    ("rest_velocity", |p| Some(p.first_step.from_rest[1])),
    ("origin_position", |p| Some(p.first_step.from_origin[0])),
    ("origin_velocity", |p| Some(p.first_step.from_origin[1])),
];

impl SpectrumPoint {
    /// All numbers with their names, in the order of the columns of `spectrum.csv`.
    fn columns(&self) -> Vec<(String, Option<f64>)> {
        let both = |numbers: &[(&str, Number)]| -> Vec<(String, Option<f64>)> {
            let mut columns = Vec::new();
            for (prefix, side) in [("", Some(&self.steps)), ("closed_", self.closed.as_ref())] {
                let column =
                    |(name, of): &(&str, Number)| (format!("{prefix}{name}"), side.and_then(of));
                columns.extend(numbers.iter().map(column));
            }
            columns
        };
        let [elongation, damping] = [0, 1].map(|k| self.expansion.map(|all| all[k]));
        [
            vec![("Omega".to_owned(), Some(self.steps.Omega))],
            both(&NUMBERS[..3]),
            vec![("expanded_damping".to_owned(), damping)],
            vec![("expanded_elongation".to_owned(), elongation)],
            both(&NUMBERS[3..5]),
            both(&NUMBERS[5..]),
        ]
        .concat()
    }
}

impl Serialize for SpectrumPoint {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.columns())
    }
}

/// Measures the spectrum of a scheme at these Ω.
///
/// # Errors
/// [`DynamicsError::Option`] for an Ω that is not positive and finite.
pub fn run(scheme: &Scheme, Omegas: &[f64]) -> Result<Spectrum, DynamicsError> {
    let limit = scheme.properties().limit;
    let expansion = expansion(scheme);
    let mut defect = closed_form(scheme, 1.0).map(|_| 0.0_f64);
    let mut points = Vec::with_capacity(Omegas.len());
    for &Omega in Omegas {
        let mut point = SpectrumPoint {
            steps: integrator::accuracy(scheme, Omega)?,
            closed: closed_form(scheme, Omega),
            expansion: expansion
                .map(|[kappa, sigma]| [kappa * Omega.powi(2), sigma * Omega.powi(3)]),
        };
        let vibrates = limit.is_none_or(|limit| Omega <= limit);
        if !vibrates {
            for side in std::iter::once(&mut point.steps).chain(&mut point.closed) {
                (side.numbers.damping, side.numbers.elongation) = (None, None);
            }
        } else if let Some(closed) = &point.closed {
            let pairs = point.steps.polynomial.iter().zip(closed.polynomial);
            let gaps = pairs.map(|(a, b)| (a - b).abs());
            defect = defect.map(|d| gaps.fold(d, f64::max));
        }
        points.push(point);
    }
    Ok(Spectrum {
        scheme: scheme.to_string(),
        name: scheme.name,
        order: scheme.order(),
        limit,
        defect,
        expansion,
        points,
    })
}

/// Spectra of schemes by name, at many Ω of a range.
///
/// # Errors
/// [`SpectrumError`].
pub fn all(
    words: &[String],
    [from, to]: [f64; 2],
) -> Result<Vec<(Scheme, Spectrum)>, SpectrumError> {
    if !(from >= RANGE[0] && to > from && to <= RANGE[1]) {
        return Err(SpectrumError::Range { from, to });
    }
    let Omegas = grid(from, to);
    let schemes = words.iter().map(|word| parse_scheme(word));
    let schemes = schemes.collect::<Result<Vec<_>, _>>()?;
    for (k, scheme) in schemes.iter().enumerate() {
        if schemes[..k].contains(scheme) {
            let name = scheme.to_string();
            return Err(SpectrumError::Twice { name });
        }
    }
    let spectrum = |scheme: Scheme| Ok((scheme, run(&scheme, &Omegas)?));
    schemes.into_iter().map(spectrum).collect()
}

/// The scheme of a name; names for `compare` only are refused with the reason.
fn parse_scheme(word: &str) -> Result<Scheme, SpectrumError> {
    let word = word.trim();
    if word.starts_with(general::PREFIX) {
        let word = word.to_owned();
        return Err(SpectrumError::Solver { word });
    }
    match PREFIXES[1..].iter().find_map(|p| word.strip_prefix(p.word)) {
        Some(scheme) => Err(SpectrumError::Prefix {
            word: word.to_owned(),
            scheme: scheme.to_owned(),
        }),
        None => plain(word.parse()?),
    }
}

/// A scheme without a projection.
fn plain(scheme: Scheme) -> Result<Scheme, SpectrumError> {
    if !scheme.keeps_energy() {
        return Ok(scheme);
    }
    let word = scheme.to_string();
    let step = match word.split_once(':') {
        Some((_, rho)) => format!("ga:{rho}"),
        None => "newmark".to_owned(),
    };
    Err(SpectrumError::Projection { word, step })
}

/// The table for a terminal: each scheme at a few Ω.
///
/// # Errors
/// [`DynamicsError`], as [`run`].
pub fn table(spectra: &[(Scheme, Spectrum)]) -> Result<String, DynamicsError> {
    let width = longest(spectra.iter().map(|(_, s)| &*s.scheme)).max("scheme".len());
    let mut out = format!(
        "{:width$}  {:>8}  {:>11}  {:>11}  {:>11}  {:>10}  {:>12}\n",
        "scheme", "Ω", "radius", "damping", "elongation", "|q₁/q₀|", "|q̇₁/(ω q₀)|"
    );
    let number = |x: Option<f64>| match x {
        None => "-".to_owned(),
        // Rounding errors have a sign, zero has none.
        Some(x) if x.abs() < 5e-7 => format!("{:.6}", 0.0),
        Some(x) => format!("{x:.6}"),
    };
    for (scheme, spectrum) in spectra {
        let positions = [TAU / 10.0, 1.0, 10.0, 100.0];
        for p in run(scheme, &positions)?.points {
            out += &format!(
                "{:width$}  {:>8.4}  {:>11.6}  {:>11}  {:>11}  {:>10.4}  {:>12.4}\n",
                spectrum.scheme,
                p.steps.Omega,
                p.steps.numbers.radius,
                number(p.steps.numbers.damping),
                number(p.steps.numbers.elongation),
                p.steps.first_step.from_rest[0].abs(),
                p.steps.first_step.from_rest[1].abs()
            );
        }
    }
    out += "radius: largest |λ| of a step; damping: algorithmic damping ratio; elongation: of the \
            period, T̄/T − 1;\nlast two: the first step from rest, exact motion stays below 1\n";
    if let Some(largest) = spectra
        .iter()
        .filter_map(|(_, s)| s.defect)
        .reduce(f64::max)
    {
        out += &format!(
            "characteristic polynomials by steps and in closed form differ by at most {largest:.1e}\n"
        );
    }
    Ok(out)
}

/// All numbers as comma-separated values: one line per scheme and Ω; unknown ones are empty.
pub fn csv(spectra: &[(Scheme, Spectrum)]) -> String {
    let mut out = "scheme".to_owned();
    let all = || {
        spectra
            .iter()
            .flat_map(|(_, s)| s.points.iter().map(move |p| (s, p.columns())))
    };
    if let Some((_, columns)) = all().next() {
        columns
            .iter()
            .for_each(|(name, _)| out += &format!(",{name}"));
    }
    for (spectrum, columns) in all() {
        out += &format!("\n{}", spectrum.scheme);
        for (_, number) in columns {
            // Zero has no sign.
            out += &number.map_or_else(|| ",".to_owned(), |x| format!(",{}", x + 0.0));
        }
    }
    out + "\n"
}

/// Ω up to which vibrations are resolved, about π steps in a period.
const RESOLVED: f64 = 2.0;

/// Values of Ω for figures: logarithmic, denser where vibrations are resolved.
fn grid(from: f64, to: f64) -> Vec<f64> {
    let mut all = logarithmic(from, to, 161);
    let fine = (1..=40).map(|k| RESOLVED * f64::from(k) / 40.0);
    all.extend(fine.filter(|Omega| (from..=to).contains(Omega)));
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// Writes the files of [`FILES`] into a directory; `command` is the command line, for the report.
///
/// # Errors
/// [`OutputError`].
pub fn write(
    spectra: &[(Scheme, Spectrum)],
    command: Option<&str>,
    directory: &Path,
) -> Result<(), OutputError> {
    let drawn = figures(spectra).map_err(drawing("the figures"))?;
    let all: Vec<&Spectrum> = spectra.iter().map(|(_, s)| s).collect();
    let value = serde_json::json!({ "command": command, "schemes": all });
    let mut directory = Directory::open_for(directory, &FILES)?;
    directory.write("spectrum.csv", &csv(spectra))?;
    for (name, svg) in &drawn {
        directory.write(name, svg)?;
    }
    directory.write_json(FILES[0], &value)
}
