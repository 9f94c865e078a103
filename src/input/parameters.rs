//! Parameters of a model: the values of its file, by path.

use super::{InputError, InputProblem};
use toml_edit::{DocumentMut, InlineTable, Item, Key, TableLike, Value};

/// Tables whose keys are names: a name that is missing is a mistake.
const NAMED: [&str; 3] = ["sections", "nodes", "inputs"];

/// The text of a model file with other values, each with its path: keys, numbers from 0 in lists, and names of parts, as
/// `loads.0.force.2` and `lines.blade.elements`. A value that is no TOML is a string. A key that
/// is missing is added; whether it exists, and whether its value fits, is seen when the text is assembled.
///
/// # Errors
/// [`InputProblem::Path`], [`InputProblem::Parameter`].
pub fn with_parameters<P: AsRef<str>, V: AsRef<str>>(
    text: &str,
    parameters: impl IntoIterator<Item = (P, V)>,
) -> Result<String, InputError> {
    let Ok(mut document) = text.parse::<DocumentMut>() else {
        // It is refused at its position when it is assembled.
        return Ok(text.to_owned());
    };
    for (path, value) in parameters {
        let (path, value) = (path.as_ref(), value.as_ref().trim());
        let keys = Key::parse(path).map_err(|_| {
            let path = path.to_owned();
            InputError::whole(InputProblem::Path { path })
        })?;
        let keys: Vec<&str> = keys.iter().map(Key::get).collect();
        let value = value.parse().unwrap_or_else(|_| Value::from(value));
        let path = Path { text: path, keys };
        path.set_in_table(document.as_table_mut(), 0, value)?;
    }
    Ok(document.to_string())
}

/// The path of a parameter.
struct Path<'a> {
    text: &'a str,
    keys: Vec<&'a str>,
}

impl Path<'_> {
    fn set_in_table(
        &self,
        table: &mut dyn TableLike,
        depth: usize,
        value: Value,
    ) -> Result<(), InputError> {
        let key = self.keys[depth];
        let last = depth + 1 == self.keys.len();
        if !table.contains_key(key) {
            if depth == 1 && NAMED.contains(&self.keys[0]) {
                let known = table.iter().map(|(key, _)| key.to_owned());
                return Err(self.unknown(depth, known.collect()));
            }
            table.insert(key, Item::Value(InlineTable::new().into()));
        }
        match table.get_mut(key) {
            Some(Item::Value(old)) if last => replace(old, value),
            Some(item) if last => *item = Item::Value(value),
            Some(Item::ArrayOfTables(list)) => {
                let names = list.iter().map(|table| name(table));
                let k = self.number(depth + 1, list.len(), names.collect())?;
                match list.get_mut(k) {
                    Some(table) if depth + 2 < self.keys.len() => {
                        self.set_in_table(table, depth + 2, value)?;
                    }
                    _ => return Err(self.unknown(depth + 2, Vec::new())),
                }
            }
            Some(Item::Table(table)) => self.set_in_table(table, depth + 1, value)?,
            Some(Item::Value(old)) => self.set_in_value(old, depth + 1, value)?,
            _ => return Err(self.unknown(depth, Vec::new())),
        }
        Ok(())
    }

    fn set_in_value(&self, old: &mut Value, depth: usize, value: Value) -> Result<(), InputError> {
        match old {
            Value::InlineTable(table) => self.set_in_table(table, depth, value),
            Value::Array(array) => {
                let tables = array.iter().map(|item| name(item.as_inline_table()?));
                let k = self.number(depth, array.len(), tables.collect())?;
                match array.get_mut(k) {
                    Some(old) if depth + 1 == self.keys.len() => {
                        replace(old, value);
                        Ok(())
                    }
                    Some(old) => self.set_in_value(old, depth + 1, value),
                    None => Err(self.unknown(depth, Vec::new())),
                }
            }
            _ => Err(self.unknown(depth, Vec::new())),
        }
    }

    /// The number of an entry of a list, by its number or its name.
    fn number(
        &self,
        depth: usize,
        len: usize,
        names: Vec<Option<String>>,
    ) -> Result<usize, InputError> {
        let key = self.keys.get(depth).copied().unwrap_or_default();
        let number = key.parse().ok().filter(|k| *k < len);
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

fn name(table: &dyn TableLike) -> Option<String> {
    table.get("name")?.as_str().map(str::to_owned)
}
