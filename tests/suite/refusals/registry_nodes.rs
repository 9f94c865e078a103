//! Nodes that a program's own joints release, where they are not of one coordinate each.

use pullback::elements::joint::JointNodes;
use pullback::input::BoxedError;
use pullback::input::Registry;
use pullback::manifold::system::Quantity;
use pullback::prelude::*;

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

/// No keys.
#[derive(serde::Deserialize, schemars::JsonSchema)]
struct Empty {}

const MODEL: &str = r#"
[nodes]
ground = [0, 0, 0]

[[joints]]
name = "table"
type = "pair"
parent = "ground"

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

[[probes]]
name = "way"
quantity = "joint_coordinate"
joint = "table"
"#;

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
    let Err(error) = registry.assemble_text("model.toml", MODEL) else {
        panic!("this was accepted");
    };
    let expected = "there is no joint with a released coordinate (a node of one coordinate) named \
                    \"table\"";
    assert!(error.to_string().contains(expected), "{error}");
}
