//! Positions of keys and values in the text of a model file.

use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Largest magnitude of a number in a model: squares and products of two stay finite.
pub const LARGEST: f64 = 1e100;

/// Finds the text of a key or value by its path, such as `["loads", "2", "node"]`.
pub struct Locator<'a> {
    root: Option<Spanned<DeTable<'a>>>,
}

impl<'a> Locator<'a> {
    /// Reads the structure of a text; invalid TOML has no positions.
    pub fn new(text: &'a str) -> Self {
        Self {
            root: DeTable::parse(text).ok(),
        }
    }

    /// Span of the value at `path`, or of its closest existing ancestor.
    pub fn value(&self, path: &[impl AsRef<str>]) -> Option<Range<usize>> {
        self.find(path).map(|found| found.1)
    }

    /// Span of the last key of `path`, or of its closest existing ancestor.
    pub fn key(&self, path: &[impl AsRef<str>]) -> Option<Range<usize>> {
        self.find(path).map(|found| found.0)
    }

    /// Spans of the key (or, in an array, of the value) and of the value.
    fn find(&self, path: &[impl AsRef<str>]) -> Option<(Range<usize>, Range<usize>)> {
        let root = self.root.as_ref()?;
        let (first, rest) = path.split_first()?;
        let (key, mut value) = root.get_ref().get_key_value(first.as_ref())?;
        let mut spans = (key.span(), value.span());
        for part in rest.iter().map(AsRef::as_ref) {
            let next = match value.get_ref() {
                DeValue::Table(table) => table
                    .get_key_value(part)
                    .map(|(key, value)| (key.span(), value)),
                DeValue::Array(array) => part
                    .parse::<usize>()
                    .ok()
                    .and_then(|k| array.get(k))
                    .map(|value| (value.span(), value)),
                _ => None,
            };
            let Some((span, inner)) = next else { break };
            spans = (span, inner.span());
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
