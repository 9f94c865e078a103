//! Joints of a program's own in model files: they do what those of the library do, and what is wrong
//! with them is refused with its place.

#![allow(clippy::unwrap_used, non_snake_case)]

use crate::support::closures::{angle, on_joint};
use crate::support::program::{check_table, directory, ended, history, number, write};
use pullback::check;
use pullback::elements::beam::Interpolation;
use pullback::elements::joint::{JointMap, JointNodes, Revolute};
use pullback::input::{BoxedError, Registry};
use pullback::manifold::map::{MapGraph, Order, Parametrization};
use pullback::manifold::system::Quantity;
use pullback::prelude::*;
use std::ffi::OsString;
use std::path::Path;

/// A frame on a bench: two ways along given directions and a turn about their normal.
#[derive(Clone, serde::Deserialize, schemars::JsonSchema)]
struct Bench {
    /// Direction of the first way.
    first: [f64; 3],
    /// Direction of the second way.
    second: [f64; 3],
    /// How it is used.
    #[serde(default)]
    used: Use,
}

#[derive(Clone, Default, serde::Deserialize, schemars::JsonSchema)]
struct Use {
    /// Scale of both ways.
    scale: Option<f64>,
}

impl Joint<3> for Bench {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 3>) -> Pose<S> {
        let along = |e: [f64; 3]| Vector3::from(e).map(S::constant);
        let way = along(self.first) * q[0] + along(self.second) * q[1];
        let normal = Vector3::from(self.first).cross(&Vector3::from(self.second));
        let way = way * S::constant(self.used.scale.unwrap_or(1.0));
        let turn = Quaternion::about(&normal.normalize(), q[2]);
        Pose::identity().translated(&way).rotated(&turn)
    }

    fn coordinates(&self) -> [JointCoordinate; 3] {
        [
            ("left", Quantity::Length),
            ("right", Quantity::Length),
            ("turn", Quantity::Angle),
        ]
    }
}

fn registry() -> Registry {
    Registry::standard()
        .joint("bench", |at, keys: Bench| {
            if keys.first == keys.second {
                return Err("its two ways are one".into());
            }
            at.join(keys)
        })
        .joint_along("bead", |at, _: Empty| {
            at.builder
                .slide(at.name, at.chain, 0.25, Interpolation::Total)
        })
}

/// No keys.
#[derive(serde::Deserialize, schemars::JsonSchema)]
struct Empty {}

const MODEL: &str = r#"
[nodes]
ground = [0, 0, 0]

[[joints]]
name = "table"
type = "bench"
parent = "ground"
first = [1, 0, 0]
second = [0, 1, 0]
coordinates = { left = { spring = { k = 50 }, value = 0.2 }, right = { prescribed = { proportional = 2 } }, turn = { actuator = { constant = 0.3 }, rate = 1 } }

[[bodies]]
name = "body"
node = "table"
mass = 2.0
inertia = [1, 1, 0.6]

[[supports]]
node = "ground"
fix = "all"

[analysis.dynamic]
to = 1.0
step = 0.001
scheme = { newmark = [0.25, 0.5] }
record_every = 10
checkpoint_every = 300

[output]
paraview_every = 0

[[probes]]
name = "left"
quantity = "joint_coordinate"
joint = "table left"

[[probes]]
name = "turn"
quantity = "joint_coordinate"
joint = "table turn"

[[probes]]
name = "position"
quantity = "position"
node = "table"
"#;

fn program(arguments: &[&Path]) -> u8 {
    let words = [OsString::from("mine"), OsString::from("run")];
    let all = words
        .into_iter()
        .chain(arguments.iter().map(OsString::from));
    pullback::cli::run(&registry(), all)
}

#[test]
fn springs_drives_motors_and_probes_act_on_its_coordinates() {
    let directory = directory("registry_run");
    let model = write(&directory, MODEL);
    assert_eq!(program(&[&model]), 0);
    let out = directory.join("model.out");
    let rows = history(&out);
    assert_eq!(rows.len(), 101);
    for row in &rows {
        let t = number(row, "t");
        // A mass on a spring, a turntable under a moment, and a way that is driven.
        let left = 0.2 * (5.0 * t).cos();
        assert!((number(row, "left") - left).abs() < 1e-5);
        assert!((number(row, "position.x") - left).abs() < 1e-5);
        assert!((number(row, "position.y") - 2.0 * t).abs() < 1e-12);
        assert!((number(row, "turn") - (t + 0.25 * t * t)).abs() < 1e-9);
    }
    // It is drawn as everything is.
    let drawn = std::fs::read_to_string(out.join("history.svg")).unwrap();
    assert!(drawn.contains("joint coordinate"));
    // A curve is read to half a unit of 0.7e-3.
    for (panel, known) in [[-0.2, 0.2], [0.0, 1.25]].iter().enumerate() {
        let [found] = crate::support::drawings::extremes(&drawn, panel)[..] else {
            panic!("a length and an angle have panels of their own");
        };
        let off = [0, 1].map(|k| (found[k] - known[k]).abs());
        assert!(off[0].max(off[1]) < 2e-3, "{found:?}");
    }
    // And a longer run goes on from where this one has ended.
    let whole = std::fs::read(out.join("history.csv")).unwrap();
    let longer = MODEL.replace("to = 1.0", "to = 1.2");
    write(&directory, &longer);
    assert_eq!(program(&[&model, Path::new("--resume")]), 0);
    let resumed = std::fs::read(out.join("history.csv")).unwrap();
    assert!(resumed.starts_with(&whole) && resumed.len() > whole.len());
    // The program without this joint refuses the file.
    let standard = crate::support::program::program(&[&model]);
    let said = ended(&standard, 2);
    assert!(said.contains("no type of joint named \"bench\""), "{said}");
}

/// A map of a program's own, whose author has lost a factor 2 in Ḃ.
#[derive(Clone)]
struct Halved(MapGraph);

impl Parametrization for Halved {
    fn dims(&self) -> (usize, usize) {
        self.0.dims()
    }

    fn evaluate(&mut self, t: f64, motion: [&[f64]; 3], out: &mut [Order<'_>]) {
        self.0.evaluate(t, motion, out);
        if let [_, [_, B_dot], _] = out {
            B_dot.iter_mut().for_each(|b| *b *= 0.5);
        }
    }

    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        self.0.geometric_stiffness(t, q, f, K);
    }
}

#[test]
fn check_fails_on_a_wrong_joint_and_blames_its_block() {
    let pin = Revolute::new([0.0, 0.0, 1.0]).unwrap();
    let registry = Registry::standard().joint("pin", move |at, _: Empty| {
        let angle = at
            .builder
            .coordinates(format!("{} angle", at.name), &[Quantity::Angle])?;
        let (position, map) = (
            at.builder.position(at.parent),
            Halved(JointMap::new(pin).between_charts()),
        );
        let nodes = [at.parent, angle];
        let frame = (at.builder).mapped_node(at.name, position.into(), Box::new(map), &nodes)?;
        let coordinates = vec![angle];
        Ok::<_, BoxedError>(JointNodes { frame, coordinates })
    });
    let text = r#"
[nodes]
ground = [0, 0, 0]

[[joints]]
name = "pivot"
type = "revolute"
parent = "ground"
axis = [0, 1, 0]

[[joints]]
name = "arm"
type = "offset"
parent = "pivot"
position = [1, 0, 0]

[[joints]]
name = "wrong"
type = "pin"
parent = "arm"

[[bodies]]
name = "body"
node = "wrong"
mass = 2.0
inertia = [1, 1, 0.6]

[[supports]]
node = "ground"
fix = "all"

[analysis.dynamic]
to = 1.0
step = 0.001
"#;
    let model = write(&directory("registry_check"), text);
    let words = ["mine", "check"].map(OsString::from).into_iter();
    let code = pullback::cli::run(&registry, words.chain([model.into()]));
    assert_eq!(code, 1);
    let mut job = registry.assemble_text("model.toml", text).unwrap();
    let report = check::job(&mut job, 0);
    assert!(!report.is_ok());
    let table = check::table(&report);
    let blame = "it is 0.500 times what is right";
    let of_it = |line: &str| line.starts_with("FAIL joint wrong") && line.contains("B_dot");
    assert!(table.contains(blame) && table.lines().any(of_it), "{table}");
}

#[test]
fn what_is_wrong_with_its_keys_is_pointed_at() {
    let refusal = |text: &str| (registry().assemble_text("model.toml", text).err()).expect(text);
    check_table(
        MODEL,
        refusal,
        r#"
"bench" => "bensh" | "bensh" | no type of joint | did you mean `bench`
 => "screw" | "screw" | no type of joint | `revolute`
first = => frist = | frist | no use for frist | did you mean `first`
second = [0, 1, 0]\n => | [[joints]] | needs second
second = [0, 1, 0] => second = [0, 1] | [0, 1] | length 2
 => second = [0, 1, 0, 0] | [0, 1, 0, 0] | length 4
 => second = [0, "1", 0] | "1" | invalid type
 => &\nused = { scael = 2 } | scael | no use for used.scael
 => &\nused = { scale = "big" } | "big" | invalid type
 => second = [1, 0, 0] | [[joints]] | its two ways are one
 => &\nlines = ["a"] | lines | no use for lines
 => &\nspring = { k = 1 } | spring | no use for spring
{ left = => { lef = | lef | no coordinate of the joint named "lef" | did you mean `left`
parent = "ground"\n => | [[joints]] | needs parent
"#,
    );
}

/// Two ways of one node: springs, drives and probes act on nodes of one coordinate.
#[derive(Clone)]
struct Pair;

impl Joint<2> for Pair {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 2>) -> Pose<S> {
        Pose::identity().translated(&Vector3::new(q[0], q[1], S::zero()))
    }

    fn coordinates(&self) -> [JointCoordinate; 2] {
        [("x", Quantity::Length), ("y", Quantity::Length)]
    }
}

#[test]
fn a_node_of_two_coordinates_is_not_one_of_a_name() {
    let registry = Registry::standard().joint("pair", |at, _: Empty| {
        let ways = format!("{} ways", at.name);
        let ways = at.builder.coordinates(ways, &[Quantity::Length; 2])?;
        let frame = at
            .builder
            .add_joint_frame(at.name, at.parent, Pair, &[ways])?;
        let coordinates = vec![ways];
        Ok::<_, BoxedError>(JointNodes { frame, coordinates })
    });
    let text = on_joint("type = \"pair\"", "inertia = [1, 1, 0.6]", &angle("joint"));
    let error = registry.assemble_text("model.toml", &text).err().unwrap();
    let expected = "there is no joint with a released coordinate (a node of one coordinate) named \
                    \"joint\"";
    assert!(error.to_string().contains(expected), "{error}");
}

#[test]
fn the_schema_has_its_keys() {
    let schema = registry().schema();
    let joints = schema["$defs"]["Joint"]["oneOf"].as_array().unwrap();
    assert_eq!(joints.len(), 16);
    let of = |name: &str| {
        let found = joints
            .iter()
            .find(|j| j["properties"]["type"]["const"] == name);
        found.unwrap().clone()
    };
    let bench = of("bench");
    assert_eq!(
        bench["properties"]["second"]["description"],
        "Direction of the second way."
    );
    assert_eq!(
        bench["required"],
        serde_json::json!(["name", "type", "parent", "first", "second"])
    );
    assert_eq!(bench["additionalProperties"], false);
    let bead = of("bead");
    assert!(bead["properties"]["lines"].is_object() && bead["properties"]["parent"].is_null());
}
