//! Parameters of a model: the values of its file, by path.

use super::{InputError, InputProblem};
use toml_edit::{DocumentMut, Item, Key, TableLike, Value};

/// Tables whose keys are names: a name that is missing is a mistake.
const NAMED: [&str; 3] = ["sections", "nodes", "inputs"];

/// The text of a model file with other values, each with its path: keys, numbers from 0 in lists, and names of parts, as
/// `loads.0.force.2` and `lines.blade.elements`. A value that is no TOML is a string. A key that
/// is missing is added; whether it exists, and whether its value fits, is seen when the text is assembled.
///
/// # Errors
/// [`InputProblem::Path`], [`InputProblem::Parameter`], and [`InputProblem::Repeated`] for a second value of a parameter or of
/// a part of it.
pub fn with_parameters<P: AsRef<str>, V: AsRef<str>>(
    text: &str,
    parameters: impl IntoIterator<Item = (P, V)>,
) -> Result<String, InputError> {
    let Ok(mut document) = text.parse::<DocumentMut>() else {
        // It is refused at its position when it is assembled.
        return Ok(text.to_owned());
    };
    let mut earlier: Vec<(String, Vec<String>)> = Vec::new();
    for (path, value) in parameters {
        let (path, value) = (path.as_ref(), value.as_ref().trim());
        let keys = Key::parse(path).map_err(|_| {
            let path = path.to_owned();
            InputError::whole(InputProblem::Path { path })
        })?;
        let keys: Vec<&str> = keys.iter().map(Key::get).collect();
        let value = value.parse().unwrap_or_else(|_| Value::from(value));
        let path = Path { text: path, keys };
        let keys = path.set(&mut document, value)?;
        let same = |(_, other): &&(String, Vec<String>)| {
            other.starts_with(&keys) || keys.starts_with(other)
        };
        if let Some((other, _)) = earlier.iter().find(same) {
            let paths = [other.clone(), path.text.to_owned()];
            return Err(InputError::whole(InputProblem::Repeated { paths }));
        }
        earlier.push((path.text.to_owned(), keys));
    }
    Ok(document.to_string())
}

/// The path of a parameter.
struct Path<'a> {
    text: &'a str,
    keys: Vec<&'a str>,
}

impl Path<'_> {
    /// Sets the value in a document; returns the keys, numbers for names.
    fn set(&self, document: &mut DocumentMut, value: Value) -> Result<Vec<String>, InputError> {
        let mut item = document.as_item_mut();
        let mut found = Vec::new();
        let mut listed = false;
        for (depth, &key) in self.keys.iter().enumerate() {
            let table = item.as_table_like();
            let named = depth == 1 && NAMED.contains(&self.keys[0]);
            if named && table.is_none_or(|table| !table.contains_key(key)) {
                let known = table.into_iter().flat_map(|table| table.iter());
                let known = known.map(|(key, _)| key.to_owned());
                return Err(self.unknown(depth, known.collect()));
            }
            let names = names(item);
            listed = names.is_some();
            let inner = match names {
                Some(names) => {
                    let number = self.number(depth, names)?;
                    found.push(number.to_string());
                    item.get_mut(number)
                }
                // What is missing is added.
                None => {
                    found.push(key.to_owned());
                    item.get_mut(key)
                }
            };
            item = inner.ok_or_else(|| self.unknown(depth, Vec::new()))?;
        }
        match item {
            Item::Table(_) if listed => return Err(self.unknown(self.keys.len(), Vec::new())),
            Item::Value(old) => replace(old, value),
            whole => *whole = Item::Value(value),
        }
        Ok(found)
    }

    /// The number of an entry of a list, by its number or its name.
    fn number(&self, depth: usize, names: Vec<Option<String>>) -> Result<usize, InputError> {
        let key = self.keys[depth];
        let number = key.parse().ok().filter(|k| *k < names.len());
        let named = || names.iter().position(|name| name.as_deref() == Some(key));
        number.or_else(named).ok_or_else(|| {
            let number = |(k, name): (usize, Option<String>)| name.unwrap_or(k.to_string());
            self.unknown(depth, names.into_iter().enumerate().map(number).collect())
        })
    }

    /// The refusal of the key at a depth.
    fn unknown(&self, depth: usize, known: Vec<String>) -> InputError {
        InputError::whole(InputProblem::Parameter {
            path: self.text.to_owned(),
            within: self.keys[..depth.min(self.keys.len())].join("."),
            found: self.keys.get(depth).copied().unwrap_or_default().to_owned(),
            known,
        })
    }
}

/// Replaces a value, and keeps the comments beside it.
fn replace(old: &mut Value, new: Value) {
    let decor = old.decor().clone();
    *old = new;
    *old.decor_mut() = decor;
}

/// The names of the entries of a list.
fn names(item: &Item) -> Option<Vec<Option<String>>> {
    Some(match item {
        Item::ArrayOfTables(list) => list.iter().map(|table| name(table)).collect(),
        Item::Value(Value::Array(list)) => {
            let tables = list.iter().map(|item| name(item.as_inline_table()?));
            tables.collect()
        }
        _ => return None,
    })
}

fn name(table: &dyn TableLike) -> Option<String> {
    table.get("name")?.as_str().map(str::to_owned)
}
