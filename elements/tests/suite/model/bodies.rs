//! Dampers and bodies in a model.

use crate::support::*;

#[test]
fn a_new_context_knows_the_power_of_dampers() {
    let mut b = ModelBuilder::new();
    let ends = [0.0, 1.0].map(|x| b.node(format!("{x}"), [x, 0.0, 0.0]).unwrap());
    let (one, D) = (Matrix6::identity(), Matrix6::identity() * 0.3);
    let positions = ends.map(|n| b.position(n));
    let bushing = Bushing::new(&positions, &Matrix3::identity(), &one, &D).unwrap();
    b.element("bushing", bushing, &ends).unwrap();
    let mut context = Context::new(b.build().unwrap());
    let (rest, mut v) = ([0.0; 12], [0.0; 12]);
    v[0] = 2.0;
    let at = point(0.0, [&rest, &v, &rest]);
    // ẋᵀ D ẋ of the bushing with D = 0.3.
    assert!((context.dissipation(at).unwrap() - 1.2).abs() < 1e-14);
    assert!((context.energies(at).unwrap().dissipated - 1.2).abs() < 1e-14);
}

/// A fixed frame: name, parent and position.
type Fix = dyn Fn(&mut ModelBuilder, &str, NodeId, [f64; 3]) -> NodeId;

/// A four-bar linkage with a body that hangs from its crank by a ball joint; its frames at a distance are made by `fix`.
fn linkage(fix: &Fix) -> Context {
    let mut b = ModelBuilder::new();
    let [p, q] = [[0.3, 1.0, 0.0], [2.2, 1.4, 0.0]];
    let ground = b.node("ground", [0.0; 3]).unwrap();
    b.support(ground, &Dof::ALL);
    let revolute = |b: &mut ModelBuilder, name: &str, parent: NodeId| {
        let joint = Revolute::new([0.0, 0.0, 1.0]).unwrap();
        b.attach(name, parent, joint).unwrap()
    };
    let crank = revolute(&mut b, "crank", ground);
    b.prefer(crank.coordinates[0]);
    let tip = fix(&mut b, "tip of the crank", crank.frame, p);
    let hook = fix(&mut b, "hook", tip, [0.3, 1.2, 0.1]);
    let ball = b.spherical("ball", hook).unwrap().frame;
    let coupler = revolute(&mut b, "coupler", tip).frame;
    let end = fix(&mut b, "end of the coupler", coupler, q);
    let bearing = fix(&mut b, "bearing", ground, [2.0, 0.0, 0.0]);
    let rocker = revolute(&mut b, "rocker", bearing).frame;
    let other = fix(&mut b, "tip of the rocker", rocker, q);
    let pin = revolute(&mut b, "pin", end).frame;
    b.close(pin, other).unwrap();
    let J = Matrix3::new(2.0, 0.1, 0.2, 0.1, 2.5, -0.3, 0.2, -0.3, 3.0);
    for (name, node) in [("rod", coupler), ("bob", ball), ("plate", rocker)] {
        let body = RigidBody::new(1.3, J, Vector3::new(0.4, -0.2, 0.1)).unwrap();
        let weight = body.weight([0.0, -9.81, 1.0], Constant(1.0));
        b.element(name, body, &[node]).unwrap();
        b.element(format!("weight of {name}"), weight, &[node])
            .unwrap();
    }
    Context::new(b.build().unwrap())
}

#[test]
fn joints_at_a_frame_fixed_to_another_one_are_joints_of_that_one() {
    let mut context = linkage(&|b, name, parent, at| b.offset(name, parent, at).unwrap());
    // A joint without coordinates, as any other.
    let mut other = linkage(&|b, name, parent, at| {
        let c = Vector3::from(at) - b.position(parent);
        b.attach(name, parent, Offset { c }).unwrap().frame
    });
    let states = [&mut context, &mut other].map(|context| {
        let n = context.pattern().dim();
        let names: Vec<String> = (0..n).map(|u| context.name(u)).collect();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by_key(|u| &names[*u]);
        let mut random = Random::new(5);
        let mut state = [0.3, 1.0, 1.0, 1.0].map(|size| {
            let mut x = vec![0.0; n];
            order.iter().for_each(|&u| x[u] = random.range(-size, size));
            x
        });
        let [q, v, a, w] = &mut state;
        let (mut r, mut S) = (vec![0.0; n], vec![0.0; context.pattern().len()]);
        let out = Evaluation::with_tangent(&mut r, weights(1.0, 0.7, 0.4), &mut S);
        context.evaluate(Point { t: 0.0, q, v, a }, out).unwrap();
        let mut Sw = vec![0.0; n];
        context.pattern().multiply_add(1.0, &S, w, &mut Sw);
        let mut out: Vec<Vec<f64>> = order.iter().map(|&u| vec![r[u], Sw[u]]).collect();
        for name in [
            "tip of the crank",
            "hook",
            "ball",
            "bearing",
            "rocker",
            "end of the coupler",
            "pin",
        ] {
            let node = context.find(name).unwrap();
            let state = context.node_state(node);
            let motion = [
                state.position,
                state.velocity,
                state.acceleration,
                state.omega_dot,
            ];
            let [force, moment] = context.last_forces().joint_force(node).unwrap();
            assert!(force.norm() > 1.0, "{name}");
            let of_node = motion.into_iter().chain([force, moment]);
            out.push(of_node.flat_map(|x| [x.x, x.y, x.z]).collect());
        }
        out
    });
    let [found, expected] = states.map(|state| state.concat());
    assert_eq!(found.len(), expected.len());
    for (k, (a, b)) in found.iter().zip(&expected).enumerate() {
        assert!((a - b).abs() < 1e-11 * (1.0 + b.abs()), "{k}: {a} {b}");
    }
}
