//! From a model file to a model: read, parse, check, assemble.
//!
//! Every refusal is an [`InputError`] with the problem, its line and column, and a suggestion.

mod advice;
mod assemble;
mod eigenvalues;
mod error;
mod file;
mod imperfection;
mod initial;
mod joints;
mod location;
mod names;
mod parameters;
mod parts;
mod probes;
mod schema;
mod settings;

pub use assemble::{BodyGeometry, Geometry, Job, LineGeometry};
pub use eigenvalues::EigenvaluePlan;
pub use error::{InputError, InputProblem};
pub use file::*;
pub use initial::Start;
pub use joints::{BoxedError, Registry, Site};
pub use parameters::with_parameters;
pub use settings::{DynamicPlan, Plan};

pub(crate) use imperfection::lagrange;
pub(crate) use names::closest;

use location::{Location, Text};
use pullback_elements::model::Formulation;
use std::path::Path;

impl Registry {
    /// Reads a model file and assembles what it describes.
    ///
    /// # Errors
    /// [`InputError`] for anything that is wrong with it.
    pub fn load(&self, path: &Path) -> Result<Job, InputError> {
        let text = read(path)?;
        self.assemble_text(&path.display().to_string(), &text)
    }

    /// Parses and assembles a text; messages refer to it as `name`.
    ///
    /// # Errors
    /// As [`Registry::load`].
    pub fn assemble_text(&self, name: &str, text: &str) -> Result<Job, InputError> {
        let source = Text::new(name, text);
        let file = parse_text(&source)?;
        assemble::assemble(&source.root(), self, file, None)
    }

    /// Assembles a parsed file, with a formulation of rotations other than that of its scheme, if given.
    ///
    /// # Errors
    /// As [`Registry::load`], without positions.
    pub fn job(
        &self,
        name: &str,
        file: &ModelFile,
        formulation: Option<Formulation>,
    ) -> Result<Job, InputError> {
        assemble::assemble(&Text::new(name, "").root(), self, file.clone(), formulation)
    }
}

/// Reads a model file with joints of the library and assembles what it describes.
///
/// # Errors
/// [`InputError`] for anything that is wrong with it.
pub fn load(path: &Path) -> Result<Job, InputError> {
    Registry::standard().load(path)
}

/// Parses and assembles a text; messages refer to it as `name`.
///
/// # Errors
/// As [`load`].
pub fn assemble_text(name: &str, text: &str) -> Result<Job, InputError> {
    Registry::standard().assemble_text(name, text)
}

/// Parses the text of a model file; messages refer to it as `name`.
///
/// # Errors
/// [`InputError`] for invalid TOML and unknown keys. References between parts are checked by the assembly.
pub fn parse(name: &str, text: &str) -> Result<ModelFile, InputError> {
    parse_text(&Text::new(name, text))
}

/// Assembles a parsed file, with a formulation of rotations other than that of its scheme, if given.
///
/// # Errors
/// As [`load`], without positions.
pub fn job(
    name: &str,
    file: &ModelFile,
    formulation: Option<Formulation>,
) -> Result<Job, InputError> {
    Registry::standard().job(name, file, formulation)
}

/// The text of a file.
pub(crate) fn read(path: &Path) -> Result<String, InputError> {
    let bytes = std::fs::read(path).map_err(|source| {
        InputError::whole(InputProblem::Unreadable {
            path: path.to_owned(),
            source,
        })
    })?;
    String::from_utf8(bytes).map_err(|error| {
        let byte = error.utf8_error().valid_up_to();
        let before = &error.as_bytes()[..byte];
        InputError::whole(InputProblem::NotUtf8 {
            path: path.to_owned(),
            byte,
            line: before.iter().filter(|&&b| b == b'\n').count() + 1,
        })
    })
}

fn parse_text(source: &Text<'_>) -> Result<ModelFile, InputError> {
    if source.is_empty() {
        return Err(InputError::whole(InputProblem::Empty));
    }
    if let Some((span, number)) = source.unusable_number() {
        return Err(source.refuse(InputProblem::Number { number }, Some(span)));
    }
    let file: ModelFile = toml::from_str(source.text).map_err(|error| {
        let message = error.message();
        let problem = unknown_key(message).unwrap_or_else(|| InputProblem::Toml(plain(message)));
        source.refuse(problem, error.span())
    })?;
    // Serde takes the first components of an array that has too many.
    let read = serde_json::to_value(&file).unwrap_or_default();
    if let Some((span, found, expected)) = source.surplus(&read) {
        let problem = InputProblem::Components { found, expected };
        return Err(source.refuse(problem, Some(span)));
    }
    Ok(file)
}

/// A parser message without the names of the program's types.
fn plain(message: &str) -> String {
    for (said, meant) in [
        (
            "wanted string or table",
            "expected a table with one key, such as { constant = 1.0 }",
        ),
        (
            "expected newtype variant",
            "expected a table with one key and its value, such as { hht = -0.1 } or { constant = 1.0 }",
        ),
        (
            "wanted exactly 1 element",
            "expected a table with exactly one key",
        ),
        (
            "invalid type: map, expected a sequence",
            "expected a list of tables: write [[name]] with two brackets",
        ),
        (
            "invalid type: sequence, expected a map",
            "expected one table: write [name] with one bracket",
        ),
    ] {
        if message.contains(said) {
            return meant.to_owned();
        }
    }
    let mut out = message.replace("usize", "a whole number that is not negative");
    if let Some(start) = out.find("expected struct ") {
        out.replace_range(
            start..,
            "expected a table of its keys: { key = value, ... }",
        );
    }
    out
}

/// Parses serde's message about an unknown field or variant: names are in backticks, the unknown one first.
fn unknown_key(message: &str) -> Option<InputProblem> {
    if !message.starts_with("unknown field") && !message.starts_with("unknown variant") {
        return None;
    }
    let mut names = message.split('`').skip(1).step_by(2).map(str::to_owned);
    Some(InputProblem::UnknownKey {
        found: names.next()?,
        known: names.collect(),
    })
}
