//! Implicit constraints: exact derivatives, errors of them, and the branch of a solution.

use super::Planted;
use crate::support::*;

/// A four-bar linkage: absolute angles of crank, coupler, rocker; ground pivots `d` apart. The
/// ground pivot may move, and the length of the coupler may breathe.
#[derive(Clone, Copy, Debug)]
pub(super) struct FourBar {
    pub lengths: [f64; 3],
    pub d: f64,
    pub drive: f64,
}

pub(super) const GRASHOF: FourBar = FourBar {
    lengths: [1.0, 3.0, 2.5],
    d: 2.8,
    drive: 0.0,
};

impl Implicit<3, 2> for FourBar {
    fn h<S: Scalar>(&self, t: S, x: &SVector<S, 3>) -> SVector<S, 2> {
        let [a, b, c] = self.lengths;
        let b = (t * 2.0).sin() * (0.1 * self.drive) + b;
        Vector2::new(
            x[0].cos() * a + x[1].cos() * b - x[2].cos() * c - self.d,
            x[0].sin() * a + x[1].sin() * b - x[2].sin() * c + t * t * (0.2 * self.drive),
        )
    }

    fn coordinate(&self, k: usize) -> String {
        ["crank", "coupler", "rocker"][k].to_owned()
    }

    fn equation(&self, i: usize) -> String {
        ["closure along e1", "closure along e2"][i].to_owned()
    }
}

/// A point on two surfaces, in units of their own: the ellipsoid and a moving saddle.
#[derive(Clone, Copy, Debug)]
struct Curve;

impl Implicit<3, 2> for Curve {
    fn h<S: Scalar>(&self, t: S, x: &SVector<S, 3>) -> SVector<S, 2> {
        Vector2::new(
            (x[0] * x[0] + x[1] * x[1] * 0.5 + x[2] * x[2] * 2.0 - 2.0) * 1e3,
            x[2] - x[0] * x[1] * (t.cos() * 0.3) - 0.2,
        )
    }
}

#[test]
fn all_laws_hold() {
    for drive in [0.0, 1.0] {
        let linkage = FourBar { drive, ..GRASHOF };
        for choice in [Choice::Split, Choice::Fixed, Choice::Tangent] {
            for crank in [0.4, 2.0, 5.0] {
                let map = ImplicitMap::of(linkage, 1, 0.3, [crank, 0.5, 1.5], choice);
                check::implicit(&map.unwrap(), 0.3).assert();
            }
        }
    }
    let curve = ImplicitMap::of(Curve, 1, 0.2, [1.0, 0.5, 0.3], Choice::Split);
    check::implicit(&curve.unwrap(), 0.2).assert();
    check::map(&Linear::<4, 1>::pick(2, 0.5)).assert();
    check::map(&Linear::<1, 1>::sum([-2.5], 0.1)).assert();
    check::map(&Linear::<3, 1>::sum([1.0, 0.0, -2.0], 0.1)).assert();
}

/// A point on an ellipsoid that grows, two coordinates of its own: semi-axes in any unit of length.
#[derive(Clone, Copy, Debug)]
struct Ellipsoid(f64);

impl Implicit<3, 1> for Ellipsoid {
    fn h<S: Scalar>(&self, t: S, x: &SVector<S, 3>) -> SVector<S, 1> {
        let x = x.component_mul(&Vector3::new(1.0, 1.4, 2.0).map(S::constant));
        let (x, size) = (x * S::constant(1.0 / self.0), t.sin() * 0.1 + 1.0);
        SVector::<S, 1>::new(x.dot(&x) - size * size)
    }

    fn size(&self, _k: usize) -> f64 {
        self.0
    }
}

#[test]
fn laws_do_not_depend_on_the_unit_of_length() {
    for unit in [1e-6, 0.01, 0.5, 1.0, 1e3] {
        for choice in [Choice::Split, Choice::Tangent] {
            let guess = [0.5, -0.5, -0.25].map(|x| x * unit);
            let map = ImplicitMap::of(Ellipsoid(unit), 2, 0.5, guess, choice).unwrap();
            check::implicit(&map, 0.5).assert();
        }
    }
}

/// ∂x/∂q of lengths by lengths is the same in any unit, in the null space as well.
#[test]
fn coordinates_in_the_null_space_are_in_the_unit_of_x() {
    let B = |unit: f64| {
        let guess = [0.5, -0.5, -0.25].map(|x| x * unit);
        let of = ImplicitMap::of(Ellipsoid(unit), 2, 0.5, guess, Choice::Tangent);
        let (mut x, mut B) = ([0.0; 3], [0.0; 6]);
        let zeros = [0.0; 2];
        of.unwrap()
            .evaluate(0.5, [&zeros; 3].map(|x| &x[..]), &mut [[&mut x, &mut B]]);
        B
    };
    let one = B(1.0);
    assert!(one.iter().any(|b| b.abs() > 0.5), "{one:?}");
    for unit in [1e-6, 1e3] {
        for (b, one) in B(unit).iter().zip(one) {
            assert!((b - one).abs() < 1e-9, "{unit} {b} {one}");
        }
    }
}

#[test]
fn errors_in_a_change_of_coordinates_are_found() {
    let linkage = FourBar {
        drive: 1.0,
        ..GRASHOF
    };
    let t = 0.3;
    let map = ImplicitMap::of(linkage, 1, t, [0.4, 0.5, 1.5], Choice::Split).unwrap();
    let own = map.independent().unwrap();
    let other = [(own[0] + 1) % 3];
    let both = ["change and back", "change: x, x_dot, x_ddot stay"];
    let cases: [(&str, &[&str]); 7] = [
        ("nothing", &[]),
        ("half B_dot", &["changed: B_dot, B_ddot along the motion"]),
        ("sign of K", &["changed: K_sigma = d(B'f)/dq"]),
        ("q", &both),
        ("v", &both),
        ("no c", &both),
        ("B", &both),
    ];
    for (error, laws) in cases {
        let planted = Planted {
            map: map.clone(),
            B_dot: if error == "half B_dot" { 0.5 } else { 1.0 },
            K: if error == "sign of K" { -1.0 } else { 1.0 },
        };
        let change = |m: &mut Planted, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]| {
            let old: Vec<f64> = a.iter().map(|a| a[0]).collect();
            let done = m.map.switch(t, Some(&other), q, v, a);
            // New accelerations are B a + c.
            let B = (a[1][0] - a[0][0]) / (old[1] - old[0]);
            let c = a[0][0] - B * old[0];
            match error {
                "q" => q[0] += 1e-6,
                "v" => v[0] *= 1.0 + 1e-6,
                "no c" => a.iter_mut().for_each(|a| a[0] -= c),
                "B" => a.iter_mut().for_each(|a| a[0] = 2.0 * c - a[0]),
                _ => {}
            }
            done
        };
        let back = |m: &mut Planted, q: &mut [f64], v: &mut [f64], a: &mut [Vec<f64>]| {
            m.map.switch(t, Some(&own), q, v, a)
        };
        let report = check::rewriting(&planted, t, &[0.02], &change, Some(&back));
        assert_eq!(report.failing_laws(), laws, "{error}: {report}");
    }
}

/// Coupler and rocker of the linkage, by the circles of their ends, on the branch of its guess.
fn four_bar(crank: f64) -> Vector2<f64> {
    let FourBar {
        lengths: [a, b, c],
        d,
        ..
    } = GRASHOF;
    let (ux, uy) = (d - a * crank.cos(), -a * crank.sin());
    let r = ux.hypot(uy);
    let coupler = uy.atan2(ux) + ((r * r + b * b - c * c) / (2.0 * r * b)).acos();
    let end = [
        a * crank.cos() + b * coupler.cos() - d,
        a * crank.sin() + b * coupler.sin(),
    ];
    Vector2::new(coupler, end[1].atan2(end[0]))
}

#[test]
fn solutions_lie_on_the_branch_of_the_last_one() {
    let mut found = 0;
    for from in 0..12 {
        let crank = 0.5 * f64::from(from);
        let near = four_bar(crank);
        let guess = [crank, near[0], near[1]];
        let map = ImplicitMap::of(GRASHOF, 1, 0.0, guess, Choice::Fixed);
        let mut map = map.unwrap().with_independent(&[0]).unwrap();
        for k in -20..=20 {
            let q = [0.1 * f64::from(k)];
            found += usize::from(map.domain(0.0, &q).is_ok());
            let [x, _] = tangent(&map, 0.0, &q);
            let exact = four_bar(crank + q[0]);
            let off = [0, 1].map(|k| {
                (x[k + 1] - exact[k])
                    .sin()
                    .hypot((x[k + 1] - exact[k]).cos() - 1.0)
            });
            let most = off[0].max(off[1]);
            assert!(most < 1e-10, "from {crank} by {q:?}: {x:?}");
        }
    }
    // The crank goes around.
    assert_eq!(found, 12 * 41);
}
