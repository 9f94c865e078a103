//! Cross-sections of the file as sections of the model.

#![allow(non_snake_case)]

use super::file::Section as Described;
use super::{InputError, Problem, Text};
use nalgebra::{Matrix3, Matrix6, Vector3};
use pullback_elements::beam::{Damping, Material, Section, SectionError};
use pullback_elements::inertia::Inertia;

/// Dotted path, below the section, of the number that an error is about; the shape if it is about no single number.
fn number(shape: &str, error: &SectionError) -> String {
    match error {
        SectionError::NotPositive { quantity, .. } => {
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
        _ => shape.to_owned(),
    }
}

pub(super) fn section(
    source: &Text<'_>,
    name: &str,
    described: &Described,
) -> Result<Section, InputError> {
    let path = ["sections", name];
    let given: Vec<&'static str> = [
        ("stiffness", described.stiffness.is_some()),
        ("matrix", described.matrix.is_some()),
        ("rectangle", described.rectangle.is_some()),
        ("circle", described.circle.is_some()),
        ("tube", described.tube.is_some()),
    ]
    .into_iter()
    .filter_map(|(key, given)| given.then_some(key))
    .collect();
    let &[shape] = given.as_slice() else {
        let section = name.to_owned();
        return Err(source.key(&path, Problem::SectionKind { section, given }));
    };
    let refuse = |problem: Problem| source.value(&["sections", name, shape], problem);
    let material = || {
        described
            .material
            .map(|m| Material {
                E: m.E,
                nu: m.nu,
                rho: m.rho,
            })
            .ok_or_else(|| {
                refuse(Problem::NoMaterial {
                    section: name.to_owned(),
                    shape,
                })
            })
    };
    let made = if let Some(s) = described.stiffness {
        Section::diagonal(s.EA, s.GA, s.GJ, s.EI)
    } else if let Some(rows) = described.matrix {
        Section::new(Matrix6::from_fn(|i, j| rows[i][j]))
    } else if let Some(r) = described.rectangle {
        Section::rectangle(material()?, r.width, r.height)
    } else if let Some(c) = described.circle {
        Section::circle(material()?, c.radius)
    } else if let Some(t) = described.tube {
        Section::tube(material()?, t.inner, t.outer)
    } else {
        let section = name.to_owned();
        return Err(source.key(&path, Problem::SectionKind { section, given }));
    };
    if described.material.is_some() && matches!(shape, "stiffness" | "matrix") {
        let section = name.to_owned();
        let path = ["sections", name, "material"];
        return Err(source.key(&path, Problem::UselessMaterial { section }));
    }
    let made = made.map_err(|error| {
        let keys = number(shape, &error);
        let path: Vec<&str> = path.into_iter().chain(keys.split('.')).collect();
        let problem = Problem::Section {
            section: name.to_owned(),
            source: error,
        };
        source.value(&path, problem)
    })?;
    let made = match described.damping {
        None => made,
        Some(d) => made
            .with_damping(Damping {
                mass: d.mass,
                stiffness: d.stiffness,
            })
            .map_err(|error| {
                let problem = Problem::Section {
                    section: name.to_owned(),
                    source: error,
                };
                source.value(&["sections", name, "damping"], problem)
            })?,
    };
    let Some(mass) = described.mass else {
        return Ok(made);
    };
    let numbers = [
        ("A_rho", mass.A_rho),
        ("J[1]", mass.J[0]),
        ("J[2]", mass.J[1]),
        ("J[3]", mass.J[2]),
    ];
    for (key, value) in numbers {
        if !(value >= 0.0 && value.is_finite()) {
            let problem = Problem::NegativeMass {
                section: name.to_owned(),
                key,
                value,
            };
            return Err(source.value(&["sections", name, "mass"], problem));
        }
    }
    let J = Matrix3::from_diagonal(&mass.J.into());
    let Some([c2, c3]) = mass.center else {
        return Ok(made.with_mass(mass.A_rho, J));
    };
    let inertia = Inertia::about_centre(mass.A_rho, Vector3::new(0.0, c2, c3), J);
    made.with_inertia(inertia).map_err(|error| {
        let problem = Problem::Section {
            section: name.to_owned(),
            source: error,
        };
        source.value(&["sections", name, "mass"], problem)
    })
}
