//! One line per element and load.

use crate::support::*;

const INTERPOLATIONS: [Interpolation; 2] = [Interpolation::Total, Interpolation::Geodesic];

#[test]
fn beams() {
    for nodes in 2..=4 {
        for section in sections() {
            for interpolation in INTERPOLATIONS {
                let beam = interpolation.beam(&helix(nodes), &along_helix, &section);
                let beam = beam.unwrap();
                assert_eq!(beam.dim(), 6 * nodes);
                check::element(&*beam).assert();
            }
        }
    }
}

#[test]
fn nodal_loads() {
    for which in [
        LoadKind::DeadForce,
        LoadKind::FollowerForce,
        LoadKind::SpatialMoment,
        LoadKind::FollowerMoment,
    ] {
        check::element(&NodalLoad::new(which, [0.8, -1.4, 2.2], sine(1.7))).assert();
    }
}

#[test]
fn line_loads() {
    for nodes in 2..=4 {
        for follower in [false, true] {
            let amplitude = sine(1.7);
            let load = LineLoad::new(&helix(nodes), [0.8, -1.4, 2.2], follower, amplitude);
            let mut load = load.unwrap();
            for interpolation in INTERPOLATIONS {
                load = load.with_interpolation(interpolation);
                check::element(&load).assert();
            }
        }
    }
}

/// An element with an error, to see that the kit looks.
struct Wrong {
    beam: Box<dyn Element>,
    error: Error,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Error {
    None,
    Tangent,
    Asymmetric,
    Rate,
    ResidualOfTangent,
    NeedsVelocity,
    OldResidual,
    OldStress,
}

impl Element for Wrong {
    fn dim(&self) -> usize {
        self.beam.dim()
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        self.beam.evaluate(at, out)?;
        if self.error == Error::Rate
            && let Some(r_t) = out.r_t.as_deref_mut()
        {
            r_t[2] += 0.01;
        }
        if self.error == Error::NeedsVelocity && !at.v.is_empty() {
            out.r[3] += 0.1;
        }
        let old = at.previous.map_or(0.0, |previous| at.x[0] - previous[0]);
        if self.error == Error::OldResidual {
            out.r[0] += 1e-3 * old;
        }
        let Some(K) = out.K.as_deref_mut() else {
            return Ok(());
        };
        match self.error {
            Error::OldStress => K[0] += old,
            Error::Tangent => K[7] *= 1.001,
            Error::Asymmetric => {
                out.r[0] -= 3.0 * at.x[5];
                K[5 * self.beam.dim()] += 3.0;
            }
            Error::ResidualOfTangent => out.r[1] += 1e-9,
            _ => {}
        }
        Ok(())
    }

    fn abilities(&self) -> Abilities<'_> {
        self.beam.abilities()
    }
}

/// Wrong energies are found in energy_wrong.rs.
#[test]
fn every_law_of_an_element_finds_its_error() {
    let failing = |error| {
        let beam = Interpolation::Total
            .beam(&helix(2), &along_helix, &section())
            .unwrap();
        check::element(&Wrong { beam, error }).failing_laws()
    };
    assert!(failing(Error::None).is_empty());
    let requests = "r does not depend on what else is requested";
    let previous = "r does not depend on the previous iterate";
    for (error, law) in [
        (Error::Tangent, "K = -dr/dx"),
        (Error::Asymmetric, "K symmetric"),
        (Error::Rate, "r_t = dr/dt"),
        (Error::ResidualOfTangent, requests),
        (Error::NeedsVelocity, "statics is the motion at rest"),
        (Error::OldResidual, previous),
        (Error::OldStress, "K from the previous iterate"),
    ] {
        let laws = failing(error);
        assert!(laws.iter().any(|l| l == law), "{error:?}: {laws:?}");
    }
}

#[test]
fn loads_are_those_of_their_definition() {
    let m = Vector3::new(0.8, -1.4, 2.2);
    let psi = Vector3::new(0.5, 1.1, -0.9);
    let x = [0.1, 0.2, 0.3, psi.x, psi.y, psi.z];
    let (R, T) = (so3::rotation(&psi), so3::tangent(&psi));
    for (which, first, expected) in [
        (LoadKind::DeadForce, 0, m),
        (LoadKind::FollowerForce, 0, R * m),
        (LoadKind::SpatialMoment, 3, T * m),
        (LoadKind::FollowerMoment, 3, T.transpose() * m),
    ] {
        let load = NodalLoad::new(which, m.into(), Constant(2.0));
        assert!(load.properties().load);
        let (r, _) = forces(&load, &moving(&x, &[], &[])).unwrap();
        let found = r.fixed_rows::<3>(first);
        assert!((found - expected * 2.0).norm() < 1e-14, "{which:?}");
        let sum: f64 = r.iter().map(|x| x.abs()).sum();
        assert!((sum - found.abs().sum()).abs() < 1e-15, "{which:?}: {r:?}");
    }
}

#[test]
fn impossible_beams_are_refused_with_their_reason() {
    let refused = |positions: &[Vector3<f64>], frame: &dyn Fn(f64) -> Matrix3<f64>| {
        let beam = Interpolation::Total.beam(positions, frame, &section());
        beam.err().expect("an error")
    };
    let x = |x: f64| Vector3::new(x, 0.0, 0.0);
    let straight = |_: f64| Matrix3::identity();
    assert_eq!(refused(&[x(0.0)], &straight), BeamError::Nodes(1));
    let five = [1.0, 2.0, 3.0, 4.0, 5.0].map(x);
    assert_eq!(refused(&five, &straight), BeamError::Nodes(5));
    for positions in [
        vec![x(1.0), x(1.0)],
        vec![x(1.0), x(1.0), x(2.0)],
        vec![x(0.0), x(1.0), x(0.0)],
        vec![x(0.0), x(1.0), x(1.0), x(2.0)],
    ] {
        let error = refused(&positions, &straight).to_string();
        assert!(error.contains("its length is zero"), "{error}");
    }
    let backwards = |_: f64| Matrix3::from_diagonal(&Vector3::new(-1.0, -1.0, 1.0));
    let left_handed = |_: f64| Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0));
    let stretched = |_: f64| Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 1.0));
    let undefined = |_: f64| Matrix3::from_element(f64::NAN);
    let frames: [&dyn Fn(f64) -> Matrix3<f64>; 4] =
        [&backwards, &left_handed, &stretched, &undefined];
    for frame in frames {
        let error = refused(&[x(0.0), x(1.0)], frame);
        assert!(matches!(error, BeamError::Orientation { .. }), "{error:?}");
    }
}
