//! Model files with other values of parameters.

use crate::input::{self, InputError, Job, Registry, with_parameters};
use std::path::PathBuf;

/// The model file of a command.
#[derive(clap::Args)]
pub(super) struct ModelArguments {
    /// Model file (TOML; see docs/model_file.md).
    pub model: PathBuf,
    /// Another value of a parameter, by its path in the file, as loads.0.force.2=-500; several by repetition.
    #[arg(long = "set", value_name = "PATH=VALUE", value_parser = assignment, allow_hyphen_values = true)]
    pub set: Vec<(String, String)>,
}

impl ModelArguments {
    /// Its text, with other values of parameters.
    pub fn text(&self) -> Result<String, InputError> {
        let set = self.set.iter().map(|(path, value)| (path, value));
        with_parameters(&input::read(&self.model)?, set)
    }

    /// Reads and assembles it.
    pub fn load(&self, registry: &Registry) -> Result<Job, InputError> {
        registry.assemble_text(&self.model.display().to_string(), &self.text()?)
    }
}

/// A path and a value.
fn assignment(text: &str) -> Result<(String, String), String> {
    let (path, value) = text
        .split_once('=')
        .ok_or("give PATH=VALUE, such as loads.0.force.2=-500")?;
    Ok((path.trim().to_owned(), value.to_owned()))
}
