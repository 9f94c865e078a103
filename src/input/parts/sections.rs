//! Cross-sections of the file as sections of the model.

use super::Assembly;
use crate::input::file;
use crate::input::{InputError, InputProblem, Location};
use nalgebra::{Matrix3, Matrix6, Vector3};
use pullback_elements::beam::{self, Section, SectionError};
use pullback_elements::inertia::{Inertia, InertiaError};

/// Dotted path, below the section, of the number that an error is about; the shape if it is about no single number.
fn number(shape: &str, error: &SectionError) -> String {
    match error {
        SectionError::NotPositive { quantity, .. } | SectionError::Negative { quantity, .. } => {
            let symbol = quantity.rsplit(' ').next().unwrap_or_default();
            match symbol {
                "E" | "rho" => format!("material.{symbol}"),
                "GA2" => format!("{shape}.GA.0"),
                "GA3" => format!("{shape}.GA.1"),
                "EI2" => format!("{shape}.EI.0"),
                "EI3" => format!("{shape}.EI.1"),
                _ => format!("{shape}.{symbol}"),
            }
        }
        SectionError::PoissonRatio(_) => "material.nu".to_owned(),
        SectionError::NotPositiveDefinite { diagonal } => {
            match diagonal.iter().position(|&c| c <= 0.0) {
                Some(k) => format!("{shape}.{k}.{k}"),
                None => shape.to_owned(),
            }
        }
        SectionError::Inertia { source } => match source {
            InertiaError::Mass { .. } => "mass.A_rho".to_owned(),
            InertiaError::Negative { .. } => "mass.J".to_owned(),
            _ => "mass".to_owned(),
        },
        _ => shape.to_owned(),
    }
}

impl Assembly<'_> {
    pub(super) fn add_sections(&mut self) -> Result<(), InputError> {
        for (name, described) in &self.file.sections {
            let at = self.at("sections").at(name);
            self.sections
                .add(name.clone(), section(&at, name, described)?);
        }
        Ok(())
    }
}

/// The keys of a section of which it has exactly one.
const SHAPES: [&str; 5] = ["stiffness", "matrix", "rectangle", "circle", "tube"];

fn section(
    at: &Location<'_>,
    name: &str,
    described: &file::Section,
) -> Result<Section, InputError> {
    let refuse = |keys: &str, source: SectionError| {
        let at = keys.split('.').fold(at.clone(), |at, key| at.at(key));
        let section = name.to_owned();
        at.refuse(InputProblem::Section { section, source })
    };
    let (shape, made) = shape(at, name, described)?;
    let made = made.map_err(|error| refuse(&number(shape, &error), error))?;
    let made = match described.damping {
        None => made,
        Some(file::Damping { mass, stiffness }) => made
            .with_damping(beam::Damping { mass, stiffness })
            .map_err(|error| refuse("damping", error))?,
    };
    let Some(mass) = described.mass else {
        return Ok(made);
    };
    let [c2, c3] = mass.center.unwrap_or_default();
    let J = (mass.J).map_or(made.inertia.J, |J| Matrix3::from_diagonal(&J.into()));
    let inertia = Inertia::about_centre(mass.A_rho, Vector3::new(0.0, c2, c3), J);
    made.with_inertia(inertia)
        .map_err(|error| refuse(&number(shape, &error), error))
}

/// The only shape that is given, and the section with this shape.
fn shape(
    at: &Location<'_>,
    name: &str,
    d: &file::Section,
) -> Result<(&'static str, Result<Section, SectionError>), InputError> {
    let section = name.to_owned();
    let material = (d.material).map(|file::Material { E, nu, rho }| beam::Material { E, nu, rho });
    // None is the section of a shape that lacks a material.
    let made = [
        (d.stiffness).map(|s| Some(Section::diagonal(s.EA, s.GA, s.GJ, s.EI))),
        (d.matrix).map(|rows| Some(Section::new(Matrix6::from_fn(|i, j| rows[i][j])))),
        (d.rectangle).map(|r| material.map(|m| Section::rectangle(m, r.width, r.height))),
        (d.circle).map(|c| material.map(|m| Section::circle(m, c.radius))),
        (d.tube).map(|t| material.map(|m| Section::tube(m, t.inner, t.outer))),
    ];
    let given = (SHAPES.into_iter().zip(made)).filter_map(|(key, made)| Some((key, made?)));
    let (shape, made) = match <[_; 1]>::try_from(given.collect::<Vec<_>>()) {
        Ok([one]) => one,
        Err(given) => {
            let given = given.into_iter().map(|(key, _)| key).collect();
            return Err(at.refuse_key(InputProblem::SectionKind {
                section,
                keys: given,
            }));
        }
    };
    let Some(made) = made else {
        return Err(at
            .at(shape)
            .refuse(InputProblem::NoMaterial { section, shape }));
    };
    if material.is_some() && matches!(shape, "stiffness" | "matrix") {
        return Err((at.at("material")).refuse_key(InputProblem::UselessMaterial { section }));
    }
    Ok((shape, made))
}
