//! Names of parts in a file: valid, unique, known, and the closest of the known ones.

use super::parts::Assembly;
use super::{InputError, InputProblem, Location};
use std::collections::{HashMap, HashSet};
use strsim::osa_distance;

/// Named items.
pub(super) struct Names<T> {
    what: &'static str,
    order: Vec<String>,
    things: HashMap<String, T>,
}

impl<T: Copy> Names<T> {
    pub(super) fn new(what: &'static str) -> Self {
        Self {
            what,
            order: Vec::new(),
            things: HashMap::new(),
        }
    }

    pub(super) fn of(what: &'static str, all: impl IntoIterator<Item = (String, T)>) -> Self {
        let mut names = Self::new(what);
        all.into_iter()
            .for_each(|(name, thing)| names.add(name, thing));
        names
    }

    pub(super) fn knows(&self, name: &str) -> bool {
        self.things.contains_key(name)
    }

    pub(super) fn get(&self, name: &str) -> Option<T> {
        self.things.get(name).copied()
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &String> {
        self.order.iter()
    }

    pub(super) fn add(&mut self, name: String, thing: T) {
        self.order.push(name.clone());
        self.things.insert(name, thing);
    }

    /// The item of the name that stands at a location.
    pub(super) fn find(&self, at: &Location<'_>, name: &str) -> Result<T, InputError> {
        self.get(name).ok_or_else(|| {
            at.refuse(InputProblem::UnknownName {
                what: self.what,
                name: name.to_owned(),
                known: self.order.clone(),
            })
        })
    }
}

/// Whether a name is allowed in messages, columns and composed names.
pub(super) fn usable_name(name: &str) -> bool {
    let forbidden = |c: char| c.is_control() || "/:,\"'".contains(c);
    !name.trim().is_empty() && !name.contains(forbidden)
}

/// Refuses unusable and duplicate names in a list of tables, the items of which are called `what`.
pub(super) fn distinct<'a>(
    assembly: &Assembly<'_>,
    table: &'static str,
    what: &'static str,
    names: impl Iterator<Item = &'a String>,
) -> Result<(), InputError> {
    let mut seen = HashSet::new();
    for (k, name) in names.enumerate() {
        let at = assembly.at(table).at(k).at("name");
        if !usable_name(name) {
            let name = name.clone();
            return Err(at.refuse(InputProblem::Name { what, name }));
        }
        if !seen.insert(name) {
            let (what, name) = (table, name.clone());
            return Err(at.refuse(InputProblem::Duplicate { what, name }));
        }
    }
    Ok(())
}

/// Checks that names of lines, bodies, springs and joints are valid and unique.
pub(super) fn check_names(of: &Assembly<'_>) -> Result<(), InputError> {
    let file = of.file;
    distinct(of, "lines", "line", file.lines.iter().map(|l| &l.name))?;
    distinct(of, "bodies", "body", file.bodies.iter().map(|b| &b.name))?;
    let springs = file.springs.iter().map(|s| &s.name);
    distinct(of, "springs", "spring", springs)?;
    distinct(of, "joints", "joint", file.joints.iter().map(|j| &j.name))
}

/// The name closest to `given`, if it is close enough for a typing error.
pub fn closest<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let allowed = 1 + given.chars().count() / 3;
    let distance = |name: &str| osa_distance(&given.to_lowercase(), &name.to_lowercase());
    let near = known.into_iter().map(|name| (distance(name), name));
    let near = near.filter(|(d, _)| *d <= allowed).min_by_key(|(d, _)| *d);
    near.map(|(_, name)| name.to_owned())
}
