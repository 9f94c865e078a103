//! Bodies and springs of the file.

#![allow(non_snake_case)]

use super::file::{Body, ModelFile, Six, Spring, Tensor};
use super::names::Names;
use super::{InputError, Problem, Text};
use nalgebra::{Matrix3, Matrix6, Vector3};
use pullback_elements::body::{BodyError, PointMass, RigidBody};
use pullback_elements::model::{ModelBuilder, NodeId};
use pullback_elements::spring::{AxialSpring, Bushing, SpringError};

/// A body with its node, for its weight.
pub(super) struct Placed {
    pub node: NodeId,
    pub matter: Matter,
}

/// A body as an element.
pub(super) enum Matter {
    Point(PointMass),
    Rigid(RigidBody),
}

/// Adds all bodies.
pub(super) fn bodies(
    source: &Text<'_>,
    builder: &mut ModelBuilder,
    nodes: &Names<NodeId>,
    file: &ModelFile,
) -> Result<Vec<Placed>, InputError> {
    let mut out = Vec::new();
    for (k, body) in file.bodies.iter().enumerate() {
        let index = k.to_string();
        let whole = ["bodies", index.as_str()];
        let node = nodes.find(source, &["bodies", &index, "node"], &body.node)?;
        let matter = matter(body).map_err(|error| {
            let problem = Problem::Body {
                body: body.name.clone(),
                source: error,
            };
            source.value(&whole, problem)
        })?;
        let name = format!("body {}", body.name);
        match &matter {
            Matter::Point(mass) => builder.element(name, *mass, &[node]),
            Matter::Rigid(rigid) => builder.element(name, *rigid, &[node]),
        }
        .map_err(|error| source.value(&whole, Problem::Model(error)))?;
        out.push(Placed { node, matter });
    }
    Ok(out)
}

fn matter(body: &Body) -> Result<Matter, BodyError> {
    let center = Vector3::from(body.center.unwrap_or_default());
    let J = match body.inertia {
        None if body.center.is_none() => return PointMass::new(body.mass).map(Matter::Point),
        None => Matrix3::zeros(),
        Some(Tensor::Diagonal(d)) => Matrix3::from_diagonal(&Vector3::from(d)),
        Some(Tensor::Full(rows)) => Matrix3::from_fn(|i, j| rows[i][j]),
    };
    RigidBody::new(body.mass, J, center).map(Matter::Rigid)
}

/// Adds all springs.
pub(super) fn springs(
    source: &Text<'_>,
    builder: &mut ModelBuilder,
    nodes: &Names<NodeId>,
    file: &ModelFile,
) -> Result<(), InputError> {
    for (k, spring) in file.springs.iter().enumerate() {
        let index = k.to_string();
        let whole = ["springs", index.as_str()];
        let path = ["springs", index.as_str(), "nodes"];
        let ends = [
            nodes.find(source, &path, &spring.nodes[0])?,
            nodes.find(source, &path, &spring.nodes[1])?,
        ];
        let positions = ends.map(|n| builder.position(n));
        let refuse = |error: SpringError| {
            let problem = Problem::Spring {
                spring: format!("\"{}\"", spring.name),
                source: error,
            };
            source.value(&whole, problem)
        };
        let axial = [
            spring.stiffness.is_some(),
            spring.damping.is_some(),
            spring.rest_length.is_some(),
        ];
        if spring.bushing.is_some() == axial.contains(&true) {
            let spring = spring.name.clone();
            return Err(source.value(&whole, Problem::SpringKind { spring }));
        }
        let name = format!("spring {}", spring.name);
        let made = match spring.bushing {
            Some(b) => {
                let damping = b.damping.map_or_else(Matrix6::zeros, matrix);
                let bushing = Bushing::new(
                    &positions,
                    &Matrix3::identity(),
                    &matrix(b.stiffness),
                    &damping,
                )
                .map_err(refuse)?;
                builder.element(name, bushing, &ends)
            }
            None => {
                let axial = axial_spring(spring, &positions).map_err(refuse)?;
                builder.element(name, axial, &ends)
            }
        };
        made.map_err(|error| source.value(&whole, Problem::Model(error)))?;
    }
    Ok(())
}

fn axial_spring(
    spring: &Spring,
    positions: &[Vector3<f64>; 2],
) -> Result<AxialSpring, SpringError> {
    let (k, c) = (
        spring.stiffness.unwrap_or(0.0),
        spring.damping.unwrap_or(0.0),
    );
    let made = AxialSpring::new(positions, k, c)?;
    match spring.rest_length {
        Some(length) => made.with_rest_length(length),
        None => Ok(made),
    }
}

fn matrix(six: Six) -> Matrix6<f64> {
    match six {
        Six::Diagonal(d) => Matrix6::from_diagonal(&d.into()),
        Six::Full(rows) => Matrix6::from_fn(|i, j| rows[i][j]),
    }
}
