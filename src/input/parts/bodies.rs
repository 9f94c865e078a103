//! Bodies and springs of the file.

use super::Assembly;
use crate::input::assemble::BodyGeometry;
use crate::input::file::{Body, Six, Spring, Tensor};
use crate::input::{InputError, InputProblem};
use nalgebra::{Matrix3, Matrix6, Vector3};
use pullback_elements::body::{PointMass, RigidBody};
use pullback_elements::element::Element;
use pullback_elements::inertia::InertiaError;
use pullback_elements::spring::{AxialSpring, Bushing, SpringError};

impl Assembly<'_> {
    /// Adds all bodies.
    pub(super) fn add_bodies(&mut self) -> Result<(), InputError> {
        for (k, body) in self.file.bodies.iter().enumerate() {
            let at = self.at("bodies").at(k);
            let node = self.nodes.find(&at.at("node"), &body.node)?;
            let element = element(body).map_err(|source| {
                let body = body.name.clone();
                at.refuse(InputProblem::Body { body, source })
            })?;
            let name = format!("body {}", body.name);
            let added = self.builder.element(name, element, &[node]);
            added.map_err(|error| at.refuse(error))?;
            let center = body.center.unwrap_or_default().into();
            self.geometry.bodies.push(BodyGeometry { node, center });
        }
        Ok(())
    }

    /// Adds all springs.
    pub(super) fn add_springs(&mut self) -> Result<(), InputError> {
        for (k, spring) in self.file.springs.iter().enumerate() {
            let at = self.at("springs").at(k);
            let [first, second] = &spring.nodes;
            let at_nodes = at.at("nodes");
            let ends = [
                self.nodes.find(&at_nodes, first)?,
                self.nodes.find(&at_nodes, second)?,
            ];
            let positions = ends.map(|n| self.builder.position(n));
            let refuse = |source: SpringError| {
                let spring = format!("\"{}\"", spring.name);
                at.refuse(InputProblem::Spring { spring, source })
            };
            let axial = [spring.stiffness, spring.damping, spring.rest_length];
            if spring.bushing.is_some() == axial.iter().any(Option::is_some) {
                let spring = spring.name.clone();
                return Err(at.refuse(InputProblem::SpringKind { spring }));
            }
            let name = format!("spring {}", spring.name);
            let made = match spring.bushing {
                Some(b) => {
                    let (axes, stiffness) = (Matrix3::identity(), matrix(b.stiffness));
                    let damping = b.damping.map_or_else(Matrix6::zeros, matrix);
                    let bushing = Bushing::new(&positions, &axes, &stiffness, &damping);
                    self.builder.element(name, bushing.map_err(refuse)?, &ends)
                }
                None => {
                    let axial = axial_spring(spring, &positions).map_err(refuse)?;
                    self.builder.element(name, axial, &ends)
                }
            };
            made.map_err(|error| at.refuse(error))?;
        }
        Ok(())
    }
}

fn element(body: &Body) -> Result<Box<dyn Element>, InertiaError> {
    let center = Vector3::from(body.center.unwrap_or_default());
    let J = match body.inertia {
        None if body.center.is_none() => return Ok(Box::new(PointMass::new(body.mass)?)),
        None => Matrix3::zeros(),
        Some(Tensor::Diagonal(d)) => Matrix3::from_diagonal(&Vector3::from(d)),
        Some(Tensor::Full(rows)) => Matrix3::from_fn(|i, j| rows[i][j]),
    };
    Ok(Box::new(RigidBody::new(body.mass, J, center)?))
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
