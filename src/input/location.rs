//! The text of a model file, and locations in it for refusals.

use super::{InputError, InputProblem};
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Largest magnitude of a number in a model: squares and products of two stay finite.
const LARGEST: f64 = 1e100;

/// The text of a model file and its structure.
pub(super) struct Text<'a> {
    name: &'a str,
    pub text: &'a str,
    /// None for invalid TOML, which has no locations.
    root: Option<Spanned<DeTable<'a>>>,
}

impl<'a> Text<'a> {
    pub fn new(name: &'a str, text: &'a str) -> Self {
        Self {
            name,
            text,
            root: DeTable::parse(text).ok(),
        }
    }

    /// The file as a whole.
    pub fn root(&self) -> Location<'_> {
        Location {
            text: self,
            path: Vec::new(),
        }
    }

    /// A refusal of a part of the text.
    pub fn refuse(&self, problem: InputProblem, span: Option<Range<usize>>) -> InputError {
        InputError::at(problem, span, self.name, self.text)
    }

    /// Spans of the key (in an array, of the value) and of the value at a path, or of its closest existing ancestor.
    fn find(&self, path: &[String]) -> Option<[Range<usize>; 2]> {
        let root = self.root.as_ref()?;
        let (first, rest) = path.split_first()?;
        let (key, mut value) = root.get_ref().get_key_value(first.as_str())?;
        let mut spans = [key.span(), value.span()];
        for part in rest {
            let next = match value.get_ref() {
                DeValue::Table(table) => table
                    .get_key_value(part.as_str())
                    .map(|(key, value)| (key.span(), value)),
                DeValue::Array(array) => part
                    .parse::<usize>()
                    .ok()
                    .and_then(|k| array.get(k))
                    .map(|value| (value.span(), value)),
                _ => None,
            };
            let Some((span, inner)) = next else { break };
            spans = [span, inner.span()];
            value = inner;
        }
        Some(spans)
    }

    /// Whether the file is empty.
    pub fn is_empty(&self) -> bool {
        self.root.as_ref().is_some_and(|r| r.get_ref().is_empty())
    }

    /// The first array whose components differ from those parsed, when the file is parsed
    /// again as `read`: span, components found and parsed.
    pub fn surplus(&self, read: &serde_json::Value) -> Option<(Range<usize>, usize, usize)> {
        let root = self.root.as_ref()?.get_ref();
        let found = root
            .iter()
            .filter_map(|(key, value)| surplus(value, read.get(key.get_ref().as_ref())?));
        found.min_by_key(|(span, ..)| span.start)
    }

    /// The first number that is infinite, not a number, or beyond [`LARGEST`]: span and text.
    pub fn unusable_number(&self) -> Option<(Range<usize>, String)> {
        let root = self.root.as_ref()?;
        let found = root.get_ref().values().filter_map(unusable);
        found.min_by_key(|(span, _)| span.start)
    }
}

/// A key and its value in a model file, by their path.
#[derive(Clone)]
pub(super) struct Location<'a> {
    text: &'a Text<'a>,
    /// Keys and indices, such as `loads`, `2`, `node`.
    path: Vec<String>,
}

impl Location<'_> {
    /// The location of a key of this table, or of an index of this array.
    pub fn at(&self, key: impl ToString) -> Self {
        let mut location = self.clone();
        location.path.push(key.to_string());
        location
    }

    /// A refusal of the value.
    pub fn refuse(&self, problem: impl Into<InputProblem>) -> InputError {
        let spans = self.text.find(&self.path);
        self.text
            .refuse(problem.into(), spans.map(|[_, value]| value))
    }

    /// A refusal of the key.
    pub fn refuse_key(&self, problem: impl Into<InputProblem>) -> InputError {
        let spans = self.text.find(&self.path);
        self.text.refuse(problem.into(), spans.map(|[key, _]| key))
    }

    /// A refusal of a key of this table beside another one.
    pub fn exclude(&self, key: &'static str, other: &str) -> InputError {
        let message = format!("{key} and {other} exclude each other: keep one of them");
        self.at(key).refuse_key(InputProblem::Toml(message))
    }

    /// A refusal of a key of this table, whose value is out of range.
    pub fn range(
        &self,
        key: &'static str,
        value: impl ToString,
        expected: &'static str,
    ) -> InputError {
        let value = value.to_string();
        self.at(key).refuse(InputProblem::Range {
            key,
            value,
            expected,
        })
    }

    /// Refuses a number of this table if it is out of range.
    pub fn refuse_if(
        &self,
        out_of_range: bool,
        key: &'static str,
        value: f64,
        expected: &'static str,
    ) -> Result<(), InputError> {
        match out_of_range {
            true => Err(self.range(key, value, expected)),
            false => Ok(()),
        }
    }

    /// Refuses a number of this table that is negative (or not finite).
    pub fn not_negative(&self, key: &'static str, value: f64) -> Result<(), InputError> {
        let usable = value >= 0.0 && value.is_finite();
        self.refuse_if(!usable, key, value, "zero or a positive number")
    }

    /// Refuses a number of this table that is not positive (or not finite).
    pub fn positive(&self, key: &'static str, value: f64) -> Result<(), InputError> {
        let usable = value > 0.0 && value.is_finite();
        self.refuse_if(!usable, key, value, "a positive number")
    }

    /// The directory of the file.
    pub fn directory(&self) -> &Path {
        Path::new(self.text.name).parent().unwrap_or(Path::new(""))
    }

    /// Position of the key in the text, in bytes.
    pub fn start(&self) -> Option<usize> {
        self.text.find(&self.path).map(|[key, _]| key.start)
    }
}

fn surplus(
    value: &Spanned<DeValue<'_>>,
    read: &serde_json::Value,
) -> Option<(Range<usize>, usize, usize)> {
    match value.get_ref() {
        DeValue::Array(array) => {
            let taken = read.as_array()?;
            if taken.len() != array.len() {
                return Some((value.span(), array.len(), taken.len()));
            }
            array.iter().zip(taken).find_map(|(v, r)| surplus(v, r))
        }
        DeValue::Table(table) => table
            .iter()
            .find_map(|(key, v)| surplus(v, read.get(key.get_ref().as_ref())?)),
        _ => None,
    }
}

fn unusable(value: &Spanned<DeValue<'_>>) -> Option<(Range<usize>, String)> {
    let bad = |text: &str| {
        let number = text.replace('_', "").parse::<f64>();
        let usable = number.is_ok_and(|x| x.abs() <= LARGEST);
        (!usable).then(|| (value.span(), text.to_owned()))
    };
    match value.get_ref() {
        DeValue::Float(f) => bad(f.as_str()),
        DeValue::Array(array) => array.iter().find_map(unusable),
        DeValue::Table(table) => table.values().find_map(unusable),
        _ => None,
    }
}
