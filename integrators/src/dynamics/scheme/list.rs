//! The list of schemes, and their words.

use super::Scheme;
use crate::dynamics::DynamicsError;
use num_complex::Complex;
use std::str::FromStr;

/// The stability function R(z) of a scheme.
pub type Stability = fn(&Scheme, Complex<f64>) -> Complex<f64>;

/// A family of schemes with numbers, written `word`, `word:number` ...
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// The word on command lines and in model files.
    pub word: &'static str,
    /// The same word written in full.
    pub long: &'static str,
    /// Usage, with the ranges of the numbers.
    pub usage: &'static str,
    /// The published stability function R(z) of a Runge-Kutta method, z = λh for ẏ = λy; the
    /// generalised-α family has its characteristic polynomial instead.
    pub stability: Option<Stability>,
    /// The scheme with these numbers; `None` if there are too many or too few.
    pub make: fn(&[f64]) -> Option<Result<Scheme, DynamicsError>>,
}

/// All schemes of the library. A new scheme is a file and an entry here.
pub static SCHEMES: &[Family] = &[
    super::generalised_alpha::NEWMARK,
    super::generalised_alpha::HHT,
    super::generalised_alpha::WBZ,
    super::generalised_alpha::CHUNG_HULBERT,
    super::projected_newmark::PROJECTED_NEWMARK,
    super::bathe::BATHE,
    super::radau::RADAU,
    super::central_difference::CENTRAL_DIFFERENCE,
    super::tsitouras::TSITOURAS,
];

/// Names of earlier versions and the present ones.
const RENAMED: [(&str, &str); 3] = [
    ("em", "projected-newmark"),
    ("energy-momentum", "projected-newmark"),
    ("svq-newmark", "lie-newmark"),
];

impl Scheme {
    /// Entry in the list; `None` for a scheme that is not in it.
    pub fn family(&self) -> Option<&'static Family> {
        SCHEMES.iter().find(|family| family.word == self.word)
    }

    /// The scheme of a word of [`SCHEMES`] (either one) with these numbers.
    ///
    /// # Errors
    /// [`DynamicsError::Word`] for an unknown word or a wrong number of numbers,
    /// [`DynamicsError::Parameter`] for a number outside its range.
    pub fn named(word: &str, numbers: &[f64]) -> Result<Self, DynamicsError> {
        let refuse = |problem: String| DynamicsError::Word {
            word: word.to_owned(),
            problem,
        };
        // Accepts "generalized-alpha" as well.
        let long = word.replace("ized", "ised");
        let family = SCHEMES.iter().find(|f| f.word == word || f.long == long);
        if let Some((_, now)) = RENAMED.iter().find(|(was, _)| *was == word) {
            return Err(refuse(format!("it is now called {now}")));
        }
        let Some(family) = family else {
            let known: Vec<&str> = SCHEMES.iter().map(|f| f.usage).collect();
            let text = format!(
                "no scheme has this name; there are\n  {}",
                known.join("\n  ")
            );
            return Err(refuse(text));
        };
        let made = (family.make)(numbers);
        made.unwrap_or_else(|| {
            let given = match numbers.len() {
                1 => "one number is".to_owned(),
                n => format!("{n} numbers are"),
            };
            Err(refuse(format!(
                "{given} given; it is used as {}",
                family.usage
            )))
        })
    }
}

impl FromStr for Scheme {
    type Err = DynamicsError;

    /// `word`, `word:number` or `word:number:number`, see [`SCHEMES`].
    fn from_str(text: &str) -> Result<Self, DynamicsError> {
        let mut parts = text.trim().split(':');
        let word = parts.next().unwrap_or_default();
        let mut numbers = Vec::new();
        for part in parts {
            let number = part.trim().parse().map_err(|_| DynamicsError::Word {
                word: text.to_owned(),
                problem: format!("`{part}` is not a number"),
            });
            numbers.push(number?);
        }
        Self::named(word, &numbers)
    }
}
