//! Cross-sections of the file as sections of the model.

#![allow(non_snake_case)]

use super::file::{Damping, Material, Section as Described};
use super::{InputError, Problem, Text};
use nalgebra::{Matrix3, Matrix6, Vector3};
use pullback_elements::beam::{self, Section, SectionError};
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
    let section = || name.to_owned();
    let Described {
        stiffness,
        matrix,
        rectangle,
        circle,
        tube,
        ..
    } = *described;
    let given: Vec<&'static str> = [
        ("stiffness", stiffness.is_some()),
        ("matrix", matrix.is_some()),
        ("rectangle", rectangle.is_some()),
        ("circle", circle.is_some()),
        ("tube", tube.is_some()),
    ]
    .into_iter()
    .filter_map(|(key, given)| given.then_some(key))
    .collect();
    let shape = given.first().copied().unwrap_or_default();
    let material = || match described.material {
        Some(Material { E, nu, rho }) => Ok(beam::Material { E, nu, rho }),
        None => {
            let section = section();
            let problem = Problem::NoMaterial { section, shape };
            Err(source.value(&["sections", name, shape], problem))
        }
    };
    let made = match (stiffness, matrix, rectangle, circle, tube) {
        (Some(s), None, None, None, None) => Section::diagonal(s.EA, s.GA, s.GJ, s.EI),
        (None, Some(rows), None, None, None) => Section::new(Matrix6::from_fn(|i, j| rows[i][j])),
        (None, None, Some(r), None, None) => Section::rectangle(material()?, r.width, r.height),
        (None, None, None, Some(c), None) => Section::circle(material()?, c.radius),
        (None, None, None, None, Some(t)) => Section::tube(material()?, t.inner, t.outer),
        _ => {
            let section = section();
            return Err(source.key(&["sections", name], Problem::SectionKind { section, given }));
        }
    };
    if described.material.is_some() && matches!(shape, "stiffness" | "matrix") {
        let section = section();
        let path = ["sections", name, "material"];
        return Err(source.key(&path, Problem::UselessMaterial { section }));
    }
    let refuse = |keys: &str, error: SectionError| {
        let path: Vec<&str> = ["sections", name]
            .into_iter()
            .chain(keys.split('.'))
            .collect();
        let problem = Problem::Section {
            section: section(),
            source: error,
        };
        source.value(&path, problem)
    };
    let made = made.map_err(|error| refuse(&number(shape, &error), error))?;
    let made = match described.damping {
        None => made,
        Some(Damping { mass, stiffness }) => made
            .with_damping(beam::Damping { mass, stiffness })
            .map_err(|error| refuse("damping", error))?,
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
                section: section(),
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
    made.with_inertia(inertia)
        .map_err(|error| refuse("mass", error))
}
