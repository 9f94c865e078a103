//! The joint library: every law of the maps, and poses against what the joints mean.

use crate::support::*;
use nalgebra::{Rotation3, UnitQuaternion};
use pullback_manifold::so3::Quaternion;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Points that a curve leads through.
const POINTS: [[f64; 3]; 4] = [
    [1.0, 0.0, 0.0],
    [2.0, 0.3, 0.0],
    [2.4, 1.2, -0.5],
    [1.2, 1.5, 0.4],
];

fn curve() -> Spline {
    Spline::through(&POINTS, false, 0.0).unwrap()
}

/// The displacement and the rotation of the child of a joint on a parent.
fn pose<J: Joint<D>, const D: usize>(joint: &J, parent: &[f64], own: &[f64]) -> Pose<f64> {
    let parent = Pose::of(&SVector::<f64, 6>::from_column_slice(parent), 0);
    let own = joint.pose(0.0, &SVector::<f64, D>::from_column_slice(own));
    let start = joint.pose(0.0, &SVector::<f64, D>::zeros()).d;
    let child = parent.translated(&own.d).rotated(&own.rotation);
    Pose {
        d: child.d - start,
        ..child
    }
}

#[test]
fn every_joint_obeys_the_laws_of_a_map() {
    let axis = [1.0, -2.0, 0.5];
    check::joint(&Revolute::new(axis).unwrap()).assert();
    check::joint(&Universal::new([axis, [0.3, 1.0, 0.0]]).unwrap()).assert();
    check::joint(&ConstantVelocity::new([axis, [0.3, -1.0, 0.9]]).unwrap()).assert();
    check::joint(&Cylindrical::new(axis).unwrap()).assert();
    check::joint(&Prismatic::new(axis).unwrap()).assert();
    check::joint(&Planar::new(axis, [1.0, 1.0, 1.0]).unwrap()).assert();
    let c = Vector3::new(0.3, -0.2, 0.5);
    check::joint(&Offset { c }).assert();
    check::joint(&Free { c }).assert();
    check::joint(&Helical::new(axis, 0.7).unwrap()).assert();
    check::joint(&Rheonomic).assert();
    let c = Vector3::zeros();
    check::parametrization(&JointMap::turning_freely(Offset { c }).between_charts()).assert();
    check::parametrization(&JointMap::turning_freely(Rheonomic).between_charts()).assert();
    let positions = [[0.0; 3], [1.0, 0.2, 0.0], [2.0, 0.0, 0.5]].map(Vector3::from);
    for interpolation in [Interpolation::Total, Interpolation::Geodesic] {
        let chain = Chain::new(&positions, 1.2).unwrap();
        check::map(&Slide::new(chain, interpolation)).assert();
    }
}

/// A table that is moved by a function of time, on which something slides and turns.
#[derive(Clone)]
struct Rheonomic;

impl Joint<2> for Rheonomic {
    fn pose<S: Scalar>(&self, t: S, q: &SVector<S, 2>) -> Pose<S> {
        let (x, z) = (Vector3::x(), Vector3::z());
        Pose::identity()
            .translated(&Vector3::new((t * 2.0).sin(), t * t, q[0]))
            .rotated(&Quaternion::about(&z, t * 1.3 + q[0] * q[1]))
            .translated(&x.map(S::constant))
            .rotated(&Quaternion::about(&x, q[1]))
    }

    fn coordinates(&self) -> [JointCoordinate; 2] {
        [("u", Quantity::Length), ("a", Quantity::Angle)]
    }
}

#[test]
fn laws_hold_on_the_other_branch_too() {
    let mut map = JointMap::new(Revolute::new([1.0, -2.0, 0.5]).unwrap()).between_charts();
    let q = [0.1, 0.2, 0.3, 0.5, -0.4, 0.8, 3.4];
    let psi =
        |map: &MapGraph| Vector3::from_column_slice(&check::motion(map, 0.0, [&q; 3])[0][3..]);
    let before = psi(&map);
    assert!(map.change_charts(0.0, &q).charts == 1);
    assert!((so3::complement(&before) - psi(&map)).norm() < 1e-14);
    check::parametrization(&map).assert();
}

#[test]
#[should_panic(expected = "a graph reads one segment")]
fn a_graph_refuses_a_slide() {
    let chain = Chain::new(&[Vector3::zeros(), Vector3::x()], 0.5).unwrap();
    let slide = Slide::new(chain, Interpolation::Total);
    MapGraph::new(13).add(Box::new(slide), vec![(Read::Input(0), 13)]);
}

#[test]
fn poses_are_what_the_joints_mean() {
    let (d, psi) = ([0.3, -0.2, 0.5], [0.4, 0.9, -0.7]);
    let parent = [d, psi].concat();
    let (d, R) = (Vector3::from(d), so3::rotation(&Vector3::from(psi)));
    let axis = Vector3::new(1.0, -2.0, 0.5).normalize();
    let turn = |angle: f64| so3::rotation(&(axis * angle));
    let rotation = |p: &Pose<f64>| so3::rotation(&so3::log_quaternion(&p.rotation));
    let is = |p: &Pose<f64>, displacement: Vector3<f64>, turn: Matrix3<f64>, within: f64| {
        assert!((p.d - d - displacement).norm() < 1e-14, "{p:?}");
        assert!((rotation(p) - R * turn).norm() < within, "{p:?}");
    };
    let (along, one) = (R * axis, Matrix3::identity());

    let c = Vector3::new(0.3, -0.2, 0.5);
    is(&pose(&Offset { c }, &parent, &[]), R * c - c, one, 1e-14);

    let hinge = Revolute::new(axis.into()).unwrap();
    let p = pose(&hinge, &parent, &[1.9]);
    is(&p, Vector3::zeros(), turn(1.9), 1e-14);

    let screw = Helical::new(axis.into(), 0.7).unwrap();
    // Three and a quarter turns.
    let p = pose(&screw, &parent, &[3.25 * TAU]);
    is(&p, along * (3.25 * 0.7), turn(3.25 * TAU), 1e-13);

    let both = Cylindrical::new(axis.into()).unwrap();
    let p = pose(&both, &parent, &[0.6, 1.9]);
    is(&p, along * 0.6, turn(1.9), 1e-14);

    let slide = Prismatic::new(axis.into()).unwrap();
    is(&pose(&slide, &parent, &[0.6]), along * 0.6, one, 1e-14);

    let plane = Planar::new(axis.into(), [1.0, 0.0, 0.0]).unwrap();
    let p = pose(&plane, &parent, &[0.6, -0.4, 1.2]);
    let first = (Vector3::x() - axis * axis.x).normalize();
    let within = first * 0.6 - axis.cross(&first) * 0.4;
    is(&p, R * within, turn(1.2), 1e-14);

    // Tilted shafts meet in a plane that mirrors one into the other: the relative rotation takes
    // the axis a to b, and its vector is along a × b.
    let coupling = ConstantVelocity::new([axis.into(); 2]).unwrap();
    let p = pose(&coupling, &parent, &[0.5, -0.8]);
    let relative = UnitQuaternion::from(Rotation3::from_matrix_unchecked(R.tr_mul(&rotation(&p))))
        .scaled_axis();
    assert!(relative.dot(&axis).abs() < 1e-14);
    assert!((relative.norm() - 0.5_f64.hypot(0.8)).abs() < 1e-14);

    let cross = Universal::new([axis.into(), [0.0, 0.0, 1.0]]).unwrap();
    let second = so3::rotation(&(Vector3::z() * -2.0));
    let p = pose(&cross, &parent, &[0.7, -2.0]);
    is(&p, Vector3::zeros(), turn(0.7) * second, 1e-14);

    let curve = curve();
    let [start, end] = [0.0, 2.0].map(|s| curve.at(s));
    let p = pose(&OnCurve::new(curve), &parent, &[2.0]);
    is(&p, R * end - start, one, 1e-14);
}

#[test]
fn curves_through_points_and_quadrics_obey_the_laws_of_a_map() {
    for closed in [false, true] {
        let curve = Spline::through(&POINTS, closed, 0.7).unwrap();
        let mut s = -0.7;
        for (k, point) in POINTS.iter().enumerate() {
            if k > 0 {
                s += (Vector3::from(*point) - Vector3::from(POINTS[k - 1])).norm();
            }
            assert!((curve.at(s) - Vector3::from(*point)).norm() < 1e-14);
        }
        check::joint(&OnCurve::new(curve)).assert();
    }
    // At a point its third derivative jumps: the laws are those of one of the pieces.
    let from_a_point = Spline::through(&POINTS, true, 0.0).unwrap();
    check::joint(&OnCurve::new(from_a_point)).assert();
    let (start, centre, axis) = ([1.0, 0.2, 0.0], [0.1, -0.3, 0.5], [0.3, 0.1, 2.0]);
    for surface in [
        Quadric::plane(start, axis).unwrap(),
        Quadric::cylinder(start, centre, axis).unwrap(),
        Quadric::sphere(start, centre).unwrap(),
    ] {
        assert!((surface.at(0.0, 0.0) - Vector3::from(start)).norm() < 1e-15);
        check::joint(&OnSurface::new(surface)).assert();
    }
}

/// A dense matrix of so many points would have 80 GB.
#[test]
fn a_curve_may_have_many_points() {
    let count = 100_000;
    let at = |k: f64| {
        let (s, c) = (k * TAU / count as f64).sin_cos();
        [c, s, 0.1 * s * s]
    };
    let points: Vec<[f64; 3]> = (0..count).map(|k| at(k as f64)).collect();
    let curve = Spline::through(&points, true, 0.0).unwrap();
    let chord = (Vector3::from(points[1]) - Vector3::from(points[0])).norm();
    // The second derivative of a cubic spline of step h is off by h^2, here below rounding errors.
    let middle = Moving::<0>::given([0.5 * chord, 1.0, 0.0]);
    let bend = curve.at(middle).map(|x| x.x[2]);
    let off = (bend - Vector3::new(-1.0, 0.0, 0.2)).norm();
    assert!(off < 1e-3, "{bend}");
}

/// Attaches joints one behind the other, and compares the names of their coordinates.
macro_rules! attached {
    ($b:ident, $frame:ident: $($attach:ident $name:literal, $joint:expr => $names:expr;)*) => {$(
        let made = $b.$attach($name, $frame, $joint).unwrap();
        let names: Vec<&str> = made.coordinates.iter().map(|&n| $b.node_name(n)).collect();
        assert_eq!(names, $names);
        $frame = made.frame;
    )*};
}

#[test]
fn released_coordinates_are_nodes_with_names() {
    let mut b = ModelBuilder::new();
    let mut frame = b.node("A", [1.0, 2.0, 3.0]).unwrap();
    let (x, z) = ([1.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    attached! { b, frame:
        attach "u", Universal::new([z, x]).unwrap() => ["u angle 1", "u angle 2"];
        attach "c", Cylindrical::new(z).unwrap() => ["c displacement", "c angle"];
        attach "p", Prismatic::new(z).unwrap() => ["p displacement"];
        attach "q", Planar::new(z, x).unwrap() => ["q displacement 1", "q displacement 2", "q angle"];
        attach "h", Helical::new(z, 1.0).unwrap() => ["h angle"];
        attach "v", ConstantVelocity::new([z; 2]).unwrap() => ["v tilt 1", "v tilt 2"];
        attach_free "o", OnCurve::new(curve()) => ["o parameter", "o rotation"];
    }
    assert_eq!(b.position(frame), Vector3::new(2.0, 2.0, 3.0));
    let plane = Quadric::plane([0.0; 3], z).unwrap();
    attached! { b, frame:
        attach_free "s", OnSurface::new(plane) => ["s parameter 1", "s parameter 2", "s rotation"];
    }
    let welded = b.offset("w", frame, b.position(frame).into()).unwrap();
    assert_eq!(b.position(welded), b.position(frame));
}

#[test]
fn axes_without_a_direction_or_along_each_other_are_refused() {
    let z = [0.0, 0.0, 1.0];
    let none = Err(AxisError::Direction([0.0; 3]));
    assert_eq!(Prismatic::new([0.0; 3]), none);
    assert_eq!(Quadric::sphere(z, z), Err(AxisError::Radius));
    assert_eq!(Quadric::cylinder(z, [0.0; 3], z), Err(AxisError::Radius));
    let error = Helical::new([f64::NAN, 0.0, 1.0], 1.0).unwrap_err();
    assert!(matches!(error, AxisError::Direction(_)), "{error}");
    let parallel = "its two axes are parallel; give two directions";
    refused! { Universal::new([z, [0.0, 0.0, -3.0]]) => parallel }
    assert_eq!(Planar::new(z, z), Err(AxisError::Parallel));
}

/// What is no joint: lists, what all joints share, and what joints are led along.
const SHARED: [&str; 6] = ["mod", "nodes", "axes", "shape", "link", "map"];
/// What joints are led along: data that a curve or a surface is made of, and for the slide, the one exception,
/// the beams below it: which of them it is on, and how they interpolate rotations. Nothing else may go there.
const LED_ALONG: [&str; 4] = ["between", "chain", "quadric", "spline"];
/// Lines of code in a file.
fn lines(path: &Path) -> usize {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let code = text.lines().map(str::trim);
    // Pictures are documents too.
    let text = |l: &&str| l.is_empty() || l.starts_with("//") || l.starts_with("#[doc");
    code.filter(|l| !text(l)).count()
}

#[test]
fn every_joint_is_data_and_a_map_in_under_sixty_lines() {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/joint");
    let entries = std::fs::read_dir(&directory).unwrap();
    let stem = |p: PathBuf| p.file_stem().unwrap().to_str().unwrap().to_owned();
    let mut joints: BTreeSet<String> = entries.map(|e| stem(e.unwrap().path())).collect();
    let shapes = std::fs::read_dir(directory.join("shape")).unwrap();
    let shapes: BTreeSet<String> = shapes.map(|e| stem(e.unwrap().path())).collect();
    assert_eq!(shapes, LED_ALONG.map(str::to_owned).into());
    joints.retain(|name| !SHARED.contains(&name.as_str()));
    assert_eq!(joints.len(), 13);
    for name in joints {
        let lines = lines(&directory.join(format!("{name}.rs")));
        assert!(lines > 0 && lines < 60, "{name} has {lines} lines");
    }
}
