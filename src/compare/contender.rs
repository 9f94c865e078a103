//! Schemes by their names on the command line.

use super::CompareError;
use pullback_integrators::dynamics::Scheme;

/// Names of schemes with their parameters, as messages list them.
pub(super) const NAMES: [&str; 5] = [
    "newmark",
    "newmark:BETA:GAMMA",
    "hht:ALPHA",
    "wbz:RHO",
    "ga:RHO",
];

/// A scheme with the name it was asked for by.
#[derive(Clone, Debug, PartialEq)]
pub struct Contender {
    /// Name, such as `ga:0.8`.
    pub name: String,
    /// The scheme.
    pub scheme: Scheme,
}

impl Contender {
    /// Reads a name: `newmark` (the trapezoidal rule), `newmark:BETA:GAMMA`, `hht:ALPHA`, `wbz:RHO`
    /// or `ga:RHO` (Chung & Hulbert's generalised-α).
    ///
    /// # Errors
    /// [`CompareError::UnknownScheme`], [`CompareError::Scheme`] for a parameter out of its range.
    pub fn parse(name: &str) -> Result<Self, CompareError> {
        let name = name.trim();
        let unknown = || CompareError::UnknownScheme {
            found: name.to_owned(),
        };
        let mut parts = name.split(':');
        let kind = parts.next().unwrap_or_default();
        let parameters: Result<Vec<f64>, _> = parts.map(|p| p.trim().parse::<f64>()).collect();
        let parameters = parameters.map_err(|_| unknown())?;
        let scheme = match (kind, parameters.as_slice()) {
            ("newmark", []) => Ok(Scheme::default()),
            ("newmark", &[beta, gamma]) => Scheme::newmark(beta, gamma),
            ("hht", &[alpha]) => Scheme::hht(alpha),
            ("wbz", &[rho]) => Scheme::wbz(rho),
            ("ga", &[rho]) => Scheme::chung_hulbert(rho),
            _ => return Err(unknown()),
        };
        let scheme = scheme.map_err(|source| CompareError::Scheme {
            name: name.to_owned(),
            source,
        })?;
        Ok(Self {
            name: name.to_owned(),
            scheme,
        })
    }
}

impl Contender {
    /// The scheme of a model file, under the name that [`Contender::parse`] reads.
    pub(super) fn of_file(scheme: &crate::input::Scheme) -> Result<Self, CompareError> {
        let named = scheme.scheme().map_err(|source| CompareError::Scheme {
            name: scheme.word().to_owned(),
            source,
        })?;
        Ok(Self {
            name: named.to_string(),
            scheme: named,
        })
    }
}
