//! Joints of a program's own in model files: they do what those of the library do, and what is wrong
//! with them is refused with its place.

use crate::support::drawings::extremes;
use crate::support::*;
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

const INERTIA: &str = "inertia = [1, 1, 0.6]";

fn model() -> String {
    let bench = "first = [1, 0, 0]\nsecond = [0, 1, 0]\ncoordinates = { \
        left = { spring = { k = 50 }, value = 0.2 }, right = { prescribed = { proportional = 2 } }, \
        turn = { actuator = { constant = 0.3 }, rate = 1 } }";
    [
        GROUND,
        &joint("table", "bench", "ground", bench),
        &body_of("table", 2.0, INERTIA),
        &motion(1.0, 0.001),
        "scheme = { newmark = [0.25, 0.5] }\nrecord_every = 10\ncheckpoint_every = 300\n\
         [output]\nparaview_every = 0\n",
        &angle("table left"),
        &angle("table turn"),
        &probe("position", "position", "table"),
    ]
    .concat()
}

fn program(registry: &Registry, command: &str, arguments: &[&Path]) -> u8 {
    let words = ["mine", command].map(OsString::from).into_iter();
    pullback::cli::run(registry, words.chain(arguments.iter().map(OsString::from)))
}

#[test]
fn springs_drives_motors_and_probes_act_on_its_coordinates() {
    let directory = directory("registry_run");
    let path = write(&directory, &model());
    assert_eq!(program(&registry(), "run", &[&path]), 0);
    let out = directory.join("model.out");
    let rows = history(&out);
    assert_eq!(rows.len(), 101);
    for row in &rows {
        let t = number(row, "t");
        // A mass on a spring, a turntable under a moment, and a way that is driven.
        let left = 0.2 * (5.0 * t).cos();
        for (column, exact, within) in [
            ("table left", left, 1e-5),
            ("position.x", left, 1e-5),
            ("position.y", 2.0 * t, 1e-12),
            ("table turn", t + 0.25 * t * t, 1e-9),
        ] {
            assert_close(number(row, column), exact, within, column);
        }
    }
    // It is drawn as everything is.
    let drawn = read(out.join("history.svg"));
    assert!(drawn.contains("joint coordinate"));
    // A curve is read to half a unit of 0.7e-3.
    for (panel, known) in [[-0.2, 0.2], [0.0, 1.25]].iter().enumerate() {
        let [found] = extremes(&drawn, panel)[..] else {
            panic!("a length and an angle have panels of their own");
        };
        let off = [0, 1].map(|k| (found[k] - known[k]).abs());
        assert!(off[0].max(off[1]) < 2e-3, "{found:?}");
    }
    // And a longer run goes on from where this one has ended.
    let whole = read(out.join("history.csv"));
    write(&directory, &changed(&model(), "to = 1 => to = 1.2"));
    let resume = [&path, Path::new("--resume")];
    assert_eq!(program(&registry(), "run", &resume), 0);
    let resumed = read(out.join("history.csv"));
    assert!(resumed.starts_with(&whole) && resumed.len() > whole.len());
    // The program without this joint refuses the file.
    let said = ended(&program_in(&directory, "run model.toml"), 2);
    assert_says(&said, &["no type of joint named \"bench\""]);
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
        let (b, name) = (&mut *at.builder, format!("{} angle", at.name));
        let angle = b.coordinates(name, &[Quantity::Angle])?;
        let position = b.position(at.parent).into();
        let map = Box::new(Halved(JointMap::new(pin).between_charts()));
        let frame = b.mapped_node(at.name, position, map, &[at.parent, angle])?;
        let coordinates = vec![angle];
        Ok::<_, BoxedError>(JointNodes { frame, coordinates })
    });
    let text = [
        GROUND,
        &joint("pivot", "revolute", "ground", "axis = [0, 1, 0]"),
        &arm("arm", "pivot", [1.0, 0.0, 0.0]),
        &joint("wrong", "pin", "arm", ""),
        &body_of("wrong", 2.0, INERTIA),
        &motion(1.0, 0.001),
    ]
    .concat();
    let path = write(&directory("registry_check"), &text);
    assert_eq!(program(&registry, "check", &[&path]), 1);
    let mut job = registry.assemble_text("model.toml", &text).unwrap();
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
        &model(),
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

/// Springs, drives and probes act on nodes of one coordinate.
#[test]
fn a_node_of_several_coordinates_is_not_one_of_a_name() {
    let registry = Registry::standard().joint("pair", |at, bench: Bench| {
        let kinds = bench.coordinates().map(|(_, kind)| kind);
        let b = &mut *at.builder;
        let ways = b.coordinates(format!("{} ways", at.name), &kinds)?;
        let frame = b.add_joint_frame(at.name, at.parent, bench, &[ways])?;
        let coordinates = vec![ways];
        Ok::<_, BoxedError>(JointNodes { frame, coordinates })
    });
    let joint = "type = \"pair\"\nfirst = [1, 0, 0]\nsecond = [0, 1, 0]";
    let text = on_joint(joint, INERTIA, &angle("joint"));
    let error = registry.assemble_text("model.toml", &text).err().unwrap();
    let expected =
        "there is no joint with a released coordinate (a node of one coordinate) named \"joint\"";
    assert_says(&error.to_string(), &[expected]);
}

#[test]
fn the_schema_has_its_keys() {
    let schema = registry().schema();
    let joints = schema["$defs"]["Joint"]["oneOf"].as_array().unwrap();
    assert_eq!(joints.len(), 16);
    let of = |name: &str| {
        let mut joints = joints.iter();
        joints
            .find(|j| j["properties"]["type"]["const"] == name)
            .unwrap()
    };
    let bench = of("bench");
    let second = &bench["properties"]["second"];
    assert_eq!(second["description"], "Direction of the second way.");
    let required = serde_json::json!(["name", "type", "parent", "first", "second"]);
    assert_eq!(bench["required"], required);
    assert_eq!(bench["additionalProperties"], false);
    let bead = of("bead");
    assert!(bead["properties"]["lines"].is_object() && bead["properties"]["parent"].is_null());
}
