//! An integration method: a formulation of rotations and a scheme, from one name.

use pullback_elements::model::Formulation;
use pullback_integrators::dynamics::{DynamicsError, Scheme};
use std::fmt;
use std::str::FromStr;

/// A formulation of rotations and its prefix to the name of a scheme.
#[derive(Debug, PartialEq, Eq)]
pub struct Prefix {
    /// The prefix, such as `lie-`.
    pub word: &'static str,
    /// The formulation.
    pub formulation: Formulation,
    /// Description with reference, for reports.
    pub about: &'static str,
    /// The only scheme that it supports, if there is one.
    only: Option<&'static str>,
}

/// All of them.
pub static PREFIXES: [Prefix; 6] = [
    Prefix {
        word: "",
        formulation: Formulation::Total,
        about: "total Lagrangian: rotation vectors from the reference orientation ([M04] ch. 3)",
        only: None,
    },
    Prefix {
        word: "ul-",
        formulation: Formulation::Updated,
        about: "updated Lagrangian: rotation vectors since the last step (Cardona & Géradin 1988, \
                [M04] 3.3)",
        only: None,
    },
    Prefix {
        word: "lie-",
        formulation: Formulation::LieGroup,
        about: "Lie group: exponentials of sums of angular velocities and their rates (Brüls, \
                Cardona & Arnold 2012; lie-newmark is the spin-vector Newmark of Simo & Vu-Quoc 1988)",
        only: None,
    },
    Prefix {
        word: "spin-",
        formulation: Formulation::SpatialSpins,
        about: "spin vectors in the fixed frame (a variant of Simo & Vu-Quoc 1988): angular velocities and their \
                rates of both ends of a step, vectors of different tangent spaces, are added as \
                they stand in the fixed frame, which [M04] 3.3 calls inconsistent with the manifold",
        only: Some("newmark"),
    },
    Prefix {
        word: "mixed-",
        formulation: Formulation::MixedSpins,
        about: "spin vectors in the fixed frame with rates in the body (not a published method): components \
                of different frames are added without transport, and an order is lost",
        only: Some("newmark"),
    },
    Prefix {
        word: "wm-",
        formulation: Formulation::WienerMilenkovic,
        about: "total Lagrangian: parameters of Wiener and Milenković, 4 tan(ψ/4) e, instead of rotation vectors",
        only: None,
    },
];

/// A formulation of rotations and a time integration scheme, from a name such as `ga:0.8`,
/// `ul-ga:0.8`, `lie-hht:-0.1` or `spin-newmark`:
///
/// ```
/// # use pullback::method::Method;
/// # use pullback::elements::model::Formulation;
/// let method: Method = "lie-ga:0.8".parse()?;
/// assert_eq!(method.formulation(), Formulation::LieGroup);
/// assert_eq!(method.scheme().to_string(), "ga:0.8");
/// assert_eq!(method.to_string(), "lie-ga:0.8");
/// // Other schemes would lose their order with this formulation.
/// assert!("lie-radau".parse::<Method>().is_err());
/// # Ok::<(), pullback::integrators::dynamics::DynamicsError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    prefix: &'static Prefix,
    scheme: Scheme,
}

impl Method {
    /// A prefix of [`PREFIXES`] with a scheme.
    ///
    /// # Errors
    /// [`DynamicsError::Word`] for a scheme that the formulation does not support: spins need
    /// schemes with one stage, at the end of the step, like the generalised-α family.
    pub fn new(prefix: &'static Prefix, scheme: Scheme) -> Result<Self, DynamicsError> {
        let refuse = |problem: String| DynamicsError::Word {
            word: format!("{}{scheme}", prefix.word),
            problem,
        };
        if let Some(only) = prefix.only
            && scheme.family().is_none_or(|f| f.word != only)
        {
            return Err(refuse(format!(
                "`{0}` goes with `{only}` alone: {0}{only}, or {0}{only}:beta:gamma",
                prefix.word
            )));
        }
        let spins = matches!(
            prefix.formulation,
            Formulation::LieGroup | Formulation::SpatialSpins | Formulation::MixedSpins
        );
        if spins && scheme.stages().len() > 1 {
            return Err(refuse(
                "spins are added up by schemes with one stage (newmark, hht, wbz, ga, projected-newmark, \
                 central-difference); for this \
                 scheme take it without prefix, or with `ul-`"
                    .to_owned(),
            ));
        }
        Ok(Self { prefix, scheme })
    }

    /// The formulation of rotations.
    pub fn formulation(&self) -> Formulation {
        self.prefix.formulation
    }

    /// The order of the scheme in this formulation.
    pub fn order(&self) -> usize {
        match self.prefix.formulation {
            Formulation::MixedSpins => 1,
            _ => self.scheme.order(),
        }
    }

    /// The orders of positions and velocities in this formulation on models with multipliers.
    pub fn orders_with_multipliers(&self) -> [usize; 2] {
        let most = self.order();
        self.scheme.orders_with_multipliers().map(|p| p.min(most))
    }

    /// Description of the formulation with reference.
    pub fn about(&self) -> &'static str {
        self.prefix.about
    }

    /// The scheme.
    pub fn scheme(&self) -> Scheme {
        self.scheme
    }
}

impl From<Scheme> for Method {
    /// In the total formulation.
    fn from(scheme: Scheme) -> Self {
        Self {
            prefix: &PREFIXES[0],
            scheme,
        }
    }
}

impl FromStr for Method {
    type Err = DynamicsError;

    /// A name in [`SCHEMES`](pullback_integrators::dynamics::scheme::SCHEMES) with its parameters,
    /// behind a prefix of [`PREFIXES`].
    fn from_str(text: &str) -> Result<Self, DynamicsError> {
        let text = text.trim();
        let found = PREFIXES[1..].iter().find(|p| text.starts_with(p.word));
        let prefix = found.unwrap_or(&PREFIXES[0]);
        let scheme = text[prefix.word.len()..].parse();
        let scheme = scheme.map_err(|error| match error {
            DynamicsError::Word { word, problem } => DynamicsError::Word {
                word: format!("{}{word}", prefix.word),
                problem,
            },
            other => other,
        });
        Self::new(prefix, scheme?)
    }
}

impl fmt::Display for Method {
    /// The name from which it is parsed.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.prefix.word, self.scheme)
    }
}
