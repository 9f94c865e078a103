//! Loops of rigid bars that are closed by h(t, x) = 0, against the same mechanisms described in
//! another way: closed-form kinematics, multipliers, a pendulum; integrated here.

#![allow(non_snake_case, clippy::unwrap_used)]

mod dynamics_support;

use dynamics_support::*;
use nalgebra::{Matrix3, SMatrix, SVector, Vector2, Vector3};
use pullback::elements::body::{PointMass, RigidBody};
use pullback::elements::joint::{Joint, Pose, Revolute, offset};
use pullback::elements::model::{Dof, Model, ModelBuilder, ModelError, NodeId};
use pullback::elements::spring::{CoordinateLaw, CoordinateSpring};
use pullback::elements::time::Constant;
use pullback::integrators::dynamics::{Progress, Scheme};
use pullback::manifold::check;
use pullback::manifold::implicit::{Choice, Implicit, Solved};
use pullback::manifold::jet::Taylor;
use pullback::manifold::map::{Linear, Map};
use pullback::manifold::scalar::Scalar;
use pullback::manifold::so3::Quaternion;
use pullback::manifold::system::{Kind, Point, System};

const G: f64 = 9.81;

fn ground(b: &mut ModelBuilder) -> NodeId {
    let ground = b.node("ground", [0.0; 3]).unwrap();
    b.support(ground, &Dof::ALL);
    ground
}

/// Weight along −e2 of whatever can be weighed.
const DOWN: [f64; 3] = [0.0, -G, 0.0];

/// A uniform bar of length l along e1 where its angle is zero, on a pin at `place`.
fn bar(b: &mut ModelBuilder, on: NodeId, place: [f64; 3], angle: NodeId, l: f64, m: f64) -> NodeId {
    let name = format!("bar at {}", b.node_name(angle));
    let pin = offset(b, &format!("pin of {name}"), on, place).unwrap();
    let hinge = Revolute::new([0.0, 0.0, 1.0]).unwrap();
    let frame = b.hang(name.clone(), place, hinge, &[pin, angle]).unwrap();
    let J = Matrix3::from_diagonal(&Vector3::new(0.0, 1.0, 1.0)) * (m * l * l / 12.0);
    let body = RigidBody::new(m, J, Vector3::new(0.5 * l, 0.0, 0.0)).unwrap();
    let weight = body.weight(DOWN, Box::new(Constant(1.0)));
    b.element(name.clone(), body, &[frame]).unwrap();
    b.element(format!("weight of {name}"), weight, &[frame])
        .unwrap();
    frame
}

fn pick<const X: usize>(b: &mut ModelBuilder, x: NodeId, k: usize, kind: Kind) -> NodeId {
    let map = Linear::<X, 1>::pick(k, 0.0).boxed();
    b.mapped_coordinates(format!("x{k}"), &[kind], map, &[x])
        .unwrap()
}

/// What a run leaves behind.
struct Run {
    /// x and ẋ at the end.
    end: Vec<f64>,
    /// Largest change of the energy.
    drift: f64,
    /// Largest residual of the constraint on the way.
    residual: f64,
    /// What the map said of itself, and from when on.
    notes: Vec<(f64, String)>,
    progress: Progress,
}

/// Runs a model whose loop coordinates are those of the node `x`.
fn run<const X: usize>(
    mut model: Model,
    x: NodeId,
    velocity: &[f64],
    h: &dyn Fn(&SVector<f64, X>) -> f64,
    [to, step]: [f64; 2],
) -> Run {
    let zero = vec![0.0; model.pattern().dim()];
    let mut options = tight(Scheme::default(), to, step);
    options.newton.absolute = 1e-13;
    let mut notes: Vec<(f64, String)> = model.note(x).map(|n| (0.0, n)).into_iter().collect();
    let (mut end, mut residual, mut drift) = (Vec::new(), 0.0_f64, 0.0_f64);
    let mut start = None;
    let progress = observed(
        &mut model,
        [&zero, velocity],
        &options,
        &mut |model, step| {
            let both: [[f64; 2]; X] = std::array::from_fn(|k| model.coordinate(x, k).unwrap());
            residual = residual.max(h(&SVector::from_fn(|k, _| both[k][0])));
            end = (0..2 * X).map(|k| both[k % X][k / X]).collect();
            let note = model.note(x).unwrap();
            if notes.last().is_none_or(|last| last.1 != note) {
                notes.push((step.progress.state.t, note));
            }
            let state = &step.progress.state;
            let at = Point {
                t: state.t,
                q: &state.q,
                v: &state.v,
                a: &state.a,
            };
            let audit = model.audit(at).unwrap();
            let energy = audit.energies.kinetic + audit.energies.stored + audit.load_potential;
            drift = drift.max((energy - *start.get_or_insert(energy)).abs());
        },
    );
    Run {
        end,
        drift,
        residual,
        notes,
        progress,
    }
}

fn gap(found: &[f64], exact: &[f64]) -> f64 {
    assert_eq!(found.len(), exact.len());
    let gaps = found.iter().zip(exact).map(|(a, b)| (a - b).abs());
    gaps.fold(0.0, f64::max)
}

/// Accelerations of one coordinate: M θ̈ + ½ M′ θ̇² + V′ = 0.
fn one_freedom(M: Taylor<f64>, V: Taylor<f64>, rate: f64) -> f64 {
    -(0.5 * M.d * rate * rate + V.d) / M.v
}

// Slider-crank ---------------------------------------------------------------------------------

const CRANK: f64 = 0.4;
const ROD: f64 = 1.0;

/// Crank pin (x, y) and slider s: coordinates that all turn back in every revolution.
#[derive(Clone, Copy, Debug)]
struct SliderCrank;

impl Implicit<3, 2> for SliderCrank {
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, 3>) -> SVector<S, 2> {
        let along = x[2] - x[0];
        Vector2::new(
            x[0] * x[0] + x[1] * x[1] - CRANK * CRANK,
            along * along + x[1] * x[1] - ROD * ROD,
        )
    }

    fn coordinate(&self, k: usize) -> String {
        ["x", "y", "s"][k].to_owned()
    }
}

/// A point with two coordinates in the plane.
#[derive(Clone, Copy)]
struct InPlane;

impl Joint<2> for InPlane {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 2>) -> Pose<S> {
        Pose {
            d: Vector3::new(q[0], q[1], S::zero()),
            turn: Quaternion::about(&Vector3::z(), S::zero()),
        }
    }
}

const PIN: f64 = 1.5;
const SLIDER: f64 = 0.8;
const STIFF: f64 = 6.0;

fn slider_crank(choice: Choice) -> (Model, NodeId, Vec<f64>) {
    let mut b = ModelBuilder::new();
    let map = Solved::<_, 1, 3, 2>::with(SliderCrank, 0.0, [0.4, 0.0, 1.4], choice).unwrap();
    // The crank turns with 12 rad/s at the start.
    let rate = map.rates(&Vector3::new(0.0, 12.0 * CRANK, 0.0));
    let q = b.coordinates("q", &[Kind::Length]).unwrap();
    let x = b
        .mapped_coordinates("x", &[Kind::Length; 3], map.boxed(), &[q])
        .unwrap();
    let [px, py, s] = [0, 1, 2].map(|k| pick::<3>(&mut b, x, k, Kind::Length));
    let zero = Linear::<1, 1>::ratio(0.0, 0.0).boxed();
    let height = b
        .mapped_coordinates("0", &[Kind::Length], zero, &[s])
        .unwrap();
    for (name, at, m) in [("pin", [px, py], PIN), ("slider", [s, height], SLIDER)] {
        let frame = b.hang(name, [0.0; 3], InPlane, &at).unwrap();
        let mass = PointMass::new(m).unwrap();
        let weight = mass.weight(DOWN, Box::new(Constant(1.0)));
        b.element(name, mass, &[frame]).unwrap();
        b.element(format!("weight of {name}"), weight, &[frame])
            .unwrap();
    }
    let law = CoordinateLaw {
        k: STIFF,
        x0: 1.0,
        ..CoordinateLaw::default()
    };
    b.element("spring", CoordinateSpring::new(law).unwrap(), &[s])
        .unwrap();
    (b.build().unwrap(), x, rate.as_slice().to_vec())
}

/// (x, y, s) and their rates from the crank angle and its rate, in closed form.
fn slider_crank_exact(to: f64) -> Vec<f64> {
    let place = |angle: f64| {
        let angle = Taylor {
            v: angle,
            d: 1.0,
            dd: 0.0,
        };
        let (x, y) = (angle.cos() * CRANK, angle.sin() * CRANK);
        (x, y, x + (-(y * y) + ROD * ROD).sqrt())
    };
    let ode = |_: f64, z: &Vector2<f64>| {
        let (_, y, s) = place(z[0]);
        let M = Taylor {
            v: PIN * CRANK * CRANK + SLIDER * s.d * s.d,
            d: 2.0 * SLIDER * s.d * s.dd,
            dd: 0.0,
        };
        let V = y * (PIN * G) + (s - 1.0) * (s - 1.0) * (0.5 * STIFF);
        Vector2::new(z[1], one_freedom(M, V, z[1]))
    };
    let z = integrate_ode(&ode, Vector2::new(0.0, 12.0), to, 20_000);
    let (x, y, s) = place(z[0]);
    assert!(
        z[0] > 2.0 * std::f64::consts::TAU,
        "the crank went {}",
        z[0]
    );
    vec![x.v, y.v, s.v, x.d * z[1], y.d * z[1], s.d * z[1]]
}

#[test]
fn a_slider_crank_in_coordinates_that_turn_back() {
    let to = 4.0;
    let exact = slider_crank_exact(to);
    for choice in [Choice::Split, Choice::Tangent] {
        let runs = [2400, 4800, 9600].map(|n| {
            let (model, x, v) = slider_crank(choice);
            let h = |x: &Vector3<f64>| SliderCrank.h(0.0, x).amax();
            run(model, x, &v, &h, [to, to / f64::from(n)])
        });
        for run in &runs {
            let changes = run.progress.summary.chart_changes;
            println!(
                "{choice:?}: {changes} changes, gap {:.2e}, drift {:.2e}, residual {:.1e}",
                gap(&run.end, &exact),
                run.drift,
                run.residual
            );
            assert!(changes >= 6, "{changes} changes: {:?}", run.notes);
            assert!(run.residual < 1e-15, "{:e}", run.residual);
        }
        let errors: Vec<Vec<f64>> = runs
            .iter()
            .map(|r| vec![gap(&r.end, &exact), r.drift])
            .collect();
        assert_slopes("slider-crank", &["motion", "energy"], &errors, 2.0, 0.2);
    }
}

// Four-bar linkage -----------------------------------------------------------------------------

/// Crank, coupler, rocker: where the crank points along the base the others are nearly parallel, so
/// that its angle hardly determines theirs.
const BARS: [f64; 3] = [1.0, 1.6, 1.5];
const BASE: f64 = 1.3;
const MASSES: [f64; 3] = [2.0, 1.0, 1.2];

/// Angles of crank, coupler and rocker.
#[derive(Clone, Copy, Debug)]
struct FourBar;

impl Implicit<3, 2> for FourBar {
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, 3>) -> SVector<S, 2> {
        let [a, b, c] = BARS;
        Vector2::new(
            x[0].cos() * a + x[1].cos() * b - x[2].cos() * c - BASE,
            x[0].sin() * a + x[1].sin() * b - x[2].sin() * c,
        )
    }

    fn coordinate(&self, k: usize) -> String {
        ["crank", "coupler", "rocker"][k].to_owned()
    }
}

/// Angles of coupler and rocker from that of the crank: the circles of their ends meet.
fn closed_form<S: Scalar>(crank: S) -> [S; 2] {
    let [a, b, c] = BARS;
    let (px, py) = (crank.cos() * a, crank.sin() * a);
    let (ux, uy) = (-px + BASE, -py);
    let r = (ux * ux + uy * uy).sqrt();
    let cosine = (r * r + (b * b - c * c)) / (r * (2.0 * b));
    let opening = (-(cosine * cosine) + 1.0).sqrt().atan2(cosine);
    let coupler = uy.atan2(ux) + opening;
    let (ex, ey) = (px + coupler.cos() * b, py + coupler.sin() * b);
    [coupler, ey.atan2(ex - BASE)]
}

const CRANK_START: f64 = 1.2;
const CRANK_RATE: f64 = 6.0;

fn four_bar() -> (Model, NodeId, Vec<f64>) {
    let [coupler, rocker] = closed_form(CRANK_START);
    let guess = [CRANK_START + 0.05, coupler - 0.05, rocker];
    let map = Solved::<_, 1, 3, 2>::new(FourBar, 0.0, guess).unwrap();
    // From the assembled configuration to the one that is wanted: the crank as q.
    let map = map.with_independent(0.0, [0]).unwrap();
    let x = map.phi(
        0.0,
        &SVector::<f64, 1>::new(CRANK_START - map.reference()[0]),
    );
    let map = Solved::<_, 1, 3, 2>::new(FourBar, 0.0, *x.as_ref()).unwrap();
    assert!((map.reference() - Vector3::new(CRANK_START, coupler, rocker)).norm() < 1e-15);
    let rate = map.tangent(0.0, &SVector::zeros()).B[0].recip() * CRANK_RATE;
    let mut b = ModelBuilder::new();
    let ground = ground(&mut b);
    let q = b.coordinates("q", &[Kind::Angle]).unwrap();
    let x = b
        .mapped_coordinates("x", &[Kind::Angle; 3], map.boxed(), &[q])
        .unwrap();
    let crank = pick::<3>(&mut b, x, 0, Kind::Angle);
    let relative = Linear::sum([-1.0, 1.0, 0.0], 0.0).boxed();
    let coupler = b
        .mapped_coordinates("relative", &[Kind::Angle], relative, &[x])
        .unwrap();
    let third = pick::<3>(&mut b, x, 2, Kind::Angle);
    let first = bar(&mut b, ground, [0.0; 3], crank, BARS[0], MASSES[0]);
    bar(
        &mut b,
        first,
        [BARS[0], 0.0, 0.0],
        coupler,
        BARS[1],
        MASSES[1],
    );
    bar(&mut b, ground, [BASE, 0.0, 0.0], third, BARS[2], MASSES[2]);
    (b.build().unwrap(), x, vec![rate])
}

fn four_bar_exact(to: f64) -> Vec<f64> {
    let ode = |_: f64, z: &Vector2<f64>| {
        let angle = Taylor {
            v: z[0],
            d: 1.0,
            dd: 0.0,
        };
        let [coupler, rocker] = closed_form(angle);
        let rate = |x: Taylor<f64>| Taylor {
            v: x.d,
            d: x.dd,
            dd: 0.0,
        };
        let (k2, k3) = (rate(coupler), rate(rocker));
        let ([a, b, c], [m1, m2, m3]) = (BARS, MASSES);
        let between = (angle - coupler).cos();
        let M = k2 * k2 * (m2 * b * b / 3.0)
            + k2 * between * (m2 * a * b)
            + k3 * k3 * (m3 * c * c / 3.0)
            + (m1 * a * a / 3.0 + m2 * a * a);
        let V = angle.sin() * ((0.5 * m1 + m2) * G * a)
            + coupler.sin() * (0.5 * m2 * G * b)
            + rocker.sin() * (0.5 * m3 * G * c);
        Vector2::new(z[1], one_freedom(M, V, z[1]))
    };
    let z = integrate_ode(&ode, Vector2::new(CRANK_START, CRANK_RATE), to, 40_000);
    assert!((z[0] - CRANK_START).abs() > std::f64::consts::TAU, "{z}");
    let angle = Taylor {
        v: z[0],
        d: z[1],
        dd: 0.0,
    };
    let [coupler, rocker] = closed_form(angle);
    vec![z[0], coupler.v, rocker.v, z[1], coupler.d, rocker.d]
}

#[test]
fn a_four_bar_linkage_goes_around() {
    let to = 3.0;
    let exact = four_bar_exact(to);
    let runs = [2400, 4800, 9600].map(|n| {
        let (model, x, v) = four_bar();
        let h = |x: &Vector3<f64>| FourBar.h(0.0, x).amax();
        run(model, x, &v, &h, [to, to / f64::from(n)])
    });
    for run in &runs {
        println!(
            "gap {:.2e}, drift {:.2e}, residual {:.1e}, {:?}",
            gap(&run.end, &exact),
            run.drift,
            run.residual,
            run.notes
        );
        // Not before the first step, but on the way.
        let changed = run.notes.iter().any(|(t, _)| *t > 0.01 * to);
        assert!(changed, "no change: {:?}", run.notes);
        assert!(run.residual < 1e-14, "{:e}", run.residual);
    }
    let errors: Vec<Vec<f64>> = runs
        .iter()
        .map(|r| vec![gap(&r.end, &exact), r.drift])
        .collect();
    assert_slopes("four-bar", &["motion", "energy"], &errors, 2.0, 0.2);
}

#[test]
fn the_residual_stays_at_round_off_for_long() {
    // 20 000 steps, some hundred revolutions.
    let (model, x, v) = slider_crank(Choice::Split);
    let h = |x: &Vector3<f64>| SliderCrank.h(0.0, x).amax();
    let run = run(model, x, &v, &h, [100.0, 5e-3]);
    println!(
        "long: {} changes, residual {:.1e}, drift {:.1e}",
        run.progress.summary.chart_changes, run.residual, run.drift
    );
    assert!(run.progress.summary.chart_changes > 100);
    assert!(run.residual < 1e-15, "{:e}", run.residual);
}

// A chain of five bars -------------------------------------------------------------------------

const LINKS: usize = 5;
const SPAN: f64 = 3.0;

/// A chain of bars of length and mass one between two points of the ceiling.
#[derive(Clone, Copy, Debug)]
struct Chain;

impl Implicit<LINKS, 2> for Chain {
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, LINKS>) -> SVector<S, 2> {
        let mut end = Vector2::new(S::constant(-SPAN), S::zero());
        for x in x.iter() {
            end[0] += x.cos();
            end[1] += x.sin();
        }
        end
    }
}

/// Angles and rates by multipliers: M ẍ + Jᵀλ = f, J ẍ = −J̇ ẋ.
fn chain_exact(from: &SVector<f64, LINKS>, v: &SVector<f64, LINKS>, to: f64) -> Vec<f64> {
    const N: usize = LINKS;
    let weight = |i: usize, k: usize| match k.cmp(&i) {
        std::cmp::Ordering::Less => 1.0,
        std::cmp::Ordering::Equal => 0.5,
        std::cmp::Ordering::Greater => 0.0,
    };
    let ode = |_: f64, z: &SVector<f64, 10>| {
        let mut A = SMatrix::<f64, 7, 7>::zeros();
        let mut b = SVector::<f64, 7>::zeros();
        for k in 0..N {
            for j in 0..N {
                let w: f64 = (0..N).map(|i| weight(i, k) * weight(i, j)).sum();
                A[(k, j)] = w * (z[k] - z[j]).cos();
                b[k] -= w * (z[k] - z[j]).sin() * z[N + j].powi(2);
            }
            A[(k, k)] += 1.0 / 12.0;
            b[k] -= G * z[k].cos() * (0..N).map(|i| weight(i, k)).sum::<f64>();
            for (row, d) in [(N, -z[k].sin()), (N + 1, z[k].cos())] {
                A[(row, k)] = d;
                A[(k, row)] = d;
            }
            b[N] += z[k].cos() * z[N + k].powi(2);
            b[N + 1] += z[k].sin() * z[N + k].powi(2);
        }
        let solution = A.lu().solve(&b).unwrap();
        SVector::<f64, 10>::from_fn(|k, _| if k < N { z[N + k] } else { solution[k - N] })
    };
    let start = SVector::<f64, 10>::from_fn(|k, _| if k < N { from[k] } else { v[k - N] });
    let z = integrate_ode(&ode, start, to, 20_000);
    z.as_slice().to_vec()
}

#[test]
fn a_chain_of_bars_closes() {
    let to = 2.0;
    let guess = [-1.2, -0.6, 0.3, 0.5, 1.0];
    for choice in [Choice::Split, Choice::Tangent] {
        let map = Solved::<_, 3, LINKS, 2>::with(Chain, 0.0, guess, choice).unwrap();
        check::implicit(&map, 0.0).assert();
        let start = map.reference();
        let v = SVector::<f64, 3>::new(1.0, -2.0, 1.5);
        let v = map.rates(&(map.tangent(0.0, &SVector::zeros()).B * v));
        let x_dot = map.tangent(0.0, &SVector::zeros()).B * v;
        let exact = chain_exact(&start, &x_dot, to);
        let runs = [1000, 2000, 4000].map(|n| {
            let mut b = ModelBuilder::new();
            let ground = ground(&mut b);
            let q = b.coordinates("q", &[Kind::Angle; 3]).unwrap();
            let x = b
                .mapped_coordinates("x", &[Kind::Angle; 5], map.boxed(), &[q])
                .unwrap();
            let mut frame = ground;
            for k in 0..LINKS {
                let mut factors = [0.0; LINKS];
                factors[k] = 1.0;
                if k > 0 {
                    factors[k - 1] = -1.0;
                }
                let turn = Linear::sum(factors, 0.0).boxed();
                let turn = b.mapped_coordinates(format!("turn {k}"), &[Kind::Angle], turn, &[x]);
                frame = bar(&mut b, frame, [k as f64, 0.0, 0.0], turn.unwrap(), 1.0, 1.0);
            }
            let h = |x: &SVector<f64, LINKS>| Chain.h(0.0, x).amax();
            run(
                b.build().unwrap(),
                x,
                v.as_slice(),
                &h,
                [to, to / f64::from(n)],
            )
        });
        for run in &runs {
            println!(
                "{choice:?}: {} changes, gap {:.2e}, drift {:.2e}, residual {:.1e}",
                run.progress.summary.chart_changes,
                gap(&run.end, &exact),
                run.drift,
                run.residual
            );
            let changes = run.progress.summary.chart_changes;
            assert!(changes > 0 || choice == Choice::Tangent, "{:?}", run.notes);
            assert!(run.residual < 1e-14, "{:e}", run.residual);
        }
        let errors: Vec<Vec<f64>> = runs
            .iter()
            .map(|r| vec![gap(&r.end, &exact), r.drift])
            .collect();
        assert_slopes("chain", &["motion", "energy"], &errors, 2.0, 0.25);
    }
}

// Redundant equations --------------------------------------------------------------------------

/// A plate on three parallel cranks of the same length: the third one only fits. `length` is that
/// of the third crank.
#[derive(Clone, Copy, Debug)]
struct Parallelogram {
    length: f64,
}

impl Implicit<4, 4> for Parallelogram {
    /// x: angles of the three cranks and of the plate.
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, 4>) -> SVector<S, 4> {
        let pin = |k: usize, l: f64, at: f64| {
            [
                x[0].cos() + x[3].cos() * at - x[k].cos() * l - at,
                x[0].sin() + x[3].sin() * at - x[k].sin() * l,
            ]
        };
        let ([a, b], [c, d]) = (pin(1, 1.0, 2.0), pin(2, self.length, 1.0));
        SVector::<S, 4>::new(a, b, c, d)
    }

    fn equation(&self, i: usize) -> String {
        [
            "second pin, e1",
            "second pin, e2",
            "third pin, e1",
            "third pin, e2",
        ][i]
            .to_owned()
    }
}

#[test]
fn a_redundant_crank_is_named_and_carried_along() {
    let start = -1.0_f64;
    let guess = [start, start, start, 0.0];
    let map = Solved::<_, 1, 4, 4>::new(Parallelogram { length: 1.0 }, 0.0, guess).unwrap();
    assert_eq!(map.redundant().len(), 1, "{:?}", map.redundant());
    let error = Solved::<_, 1, 4, 4>::new(Parallelogram { length: 0.95 }, 0.0, guess).unwrap_err();
    assert!(error.to_string().contains("pin"), "{error}");
    // The plate only translates: a pendulum, (Σ m/3 + m_p) θ̈ = −g (Σ m/2 + m_p) cos θ.
    let mut b = ModelBuilder::new();
    let ground = ground(&mut b);
    let q = b.coordinates("q", &[Kind::Angle]).unwrap();
    let x = b
        .mapped_coordinates("x", &[Kind::Angle; 4], map.boxed(), &[q])
        .unwrap();
    let cranks = [0, 1, 2].map(|k| pick::<4>(&mut b, x, k, Kind::Angle));
    let first = bar(&mut b, ground, [0.0; 3], cranks[0], 1.0, 1.0);
    bar(&mut b, ground, [2.0, 0.0, 0.0], cranks[1], 1.0, 2.0);
    bar(&mut b, ground, [1.0, 0.0, 0.0], cranks[2], 1.0, 3.0);
    let turn = Linear::sum([-1.0, 0.0, 0.0, 1.0], 0.0).boxed();
    let turn = b
        .mapped_coordinates("turn", &[Kind::Angle], turn, &[x])
        .unwrap();
    bar(&mut b, first, [1.0, 0.0, 0.0], turn, 2.0, 4.0);
    let model = b.build().unwrap();
    let ode = |_: f64, z: &Vector2<f64>| Vector2::new(z[1], -G * z[0].cos() * 7.0 / 6.0);
    let to = 1.0;
    let z = integrate_ode(&ode, Vector2::new(start, 0.0), to, 4000);
    let exact = [z[0], z[0], z[0], 0.0, z[1], z[1], z[1], 0.0];
    let h = |x: &SVector<f64, 4>| Parallelogram { length: 1.0 }.h(0.0, x).amax();
    let run = run(model, x, &[0.0], &h, [to, 1e-3]);
    println!(
        "parallelogram: gap {:.1e}, {:?}",
        gap(&run.end, &exact),
        run.notes
    );
    assert!(gap(&run.end, &exact) < 1e-4, "{:?}", run.end);
    assert!(run.residual < 1e-14);
    assert!(run.notes[0].1.contains("redundant: "), "{:?}", run.notes);
}

// What cannot be built -------------------------------------------------------------------------

#[test]
fn coordinates_that_change_their_meaning_are_nobody_elses() {
    let build = |choice: Choice| {
        let map = Solved::<_, 1, 3, 2>::with(SliderCrank, 0.0, [0.4, 0.0, 1.4], choice).unwrap();
        let mut b = ModelBuilder::new();
        let q = b.coordinates("q", &[Kind::Length]).unwrap();
        let x = b
            .mapped_coordinates("x", &[Kind::Length; 3], map.boxed(), &[q])
            .unwrap();
        pick::<3>(&mut b, x, 0, Kind::Length);
        let law = CoordinateLaw {
            k: 1.0,
            ..CoordinateLaw::default()
        };
        b.element("spring", CoordinateSpring::new(law).unwrap(), &[q])
            .unwrap();
        b.build().map(|_| ())
    };
    let error = build(Choice::Split).unwrap_err();
    assert!(matches!(error, ModelError::Rewritten { .. }), "{error}");
    assert!(error.to_string().contains("element spring"), "{error}");
    assert_eq!(build(Choice::Fixed), Ok(()));
}

#[test]
fn a_singular_configuration_ends_the_run_with_names() {
    // The parallelogram cannot pass its flat position: there the plate may turn.
    let map = Solved::<_, 1, 4, 4>::new(Parallelogram { length: 1.0 }, 0.0, [0.3, 0.3, 0.3, 0.0]);
    let map = map.unwrap().with_independent(0.0, [0]).unwrap();
    let words = map
        .trouble(0.0, &SVector::<f64, 1>::new(-map.reference()[0]))
        .unwrap();
    assert!(
        words.contains("singular") && words.contains("pin"),
        "{words}"
    );
}
