//! The laws of an implicit constraint that is solved: a map whose coordinates change their meaning.

use super::map::{CLOSED_FORM, agree, laws, relative, short_name};
use crate::report::Report;
use crate::sample::Random;
use nalgebra::SVector;
use pullback_manifold::implicit::{Equations, Implicit, Solved};
use pullback_manifold::map::{Map, Reparametrized, derived};

/// Residual of the equations, over the size of their derivatives and coordinates.
const RESIDUAL: f64 = 1e-12;
/// Charts with a larger condition number lose digits that are not theirs.
const REGULAR: f64 = 100.0;
/// Largest distance of the positions from q = 0, relative to the sizes of the coordinates.
const REACH: f64 = 0.1;

/// Checks every law of a solved constraint around the configuration that it is at, at time `t`:
/// that of its equations, those of a [`Map`], and those of a change of its coordinates to others
/// and to the tangent space.
pub fn implicit<H, const D: usize, const X: usize, const M: usize>(
    map: &Solved<H, D, X, M>,
    t: f64,
) -> Report
where
    H: Implicit<X, M> + Clone + 'static,
{
    let mut report = Report::new(short_name::<Solved<H, D, X, M>>());
    let mut random = Random::default();
    let positions = [
        ("0", 0.0),
        ("1e-8", 1e-8),
        ("near", 0.3 * REACH),
        ("far", REACH),
    ];
    for (at, reach) in positions {
        let Some(q) = inside(map, t, reach, &mut random) else {
            report.impossible("domain", at, "outside the domain");
            continue;
        };
        let x = map.phi(t, &q);
        let h = map.constraint().h(t, &x);
        let J = derived::tangent(&Equations(map.constraint()), t, &x).B;
        report.defect(
            "h(t, phi) = 0",
            at,
            h.norm(),
            RESIDUAL * J.norm() * (1.0 + x.norm()),
        );
        laws(&mut report, "", map, at, t, &q, &mut random);
        // A chart per coordinate and the tangent space; all coordinates take part.
        let splits = (0..X).map(|k| Some(std::array::from_fn(|j| (k + j) % X)));
        for independent in splits.chain([None]) {
            let mut probe = map.clone();
            let zero = SVector::zeros();
            let possible = probe.switch(t, &q, &zero, independent);
            if !possible.is_some_and(|new| roomy(&probe, t, &new.q)) {
                continue;
            }
            let to = |m: &mut Solved<H, D, X, M>, q: &_, v: &_| m.switch(t, q, v, independent);
            let own = map.independent();
            let back = |m: &mut Solved<H, D, X, M>, q: &_, v: &_| m.switch(t, q, v, own);
            // The change back into a tangent space leads to another one.
            let back: Option<&Change<_, D>> = own.is_some().then_some(&back);
            let name = match independent {
                Some(k) => format!("{at}, to {k:?}"),
                None => format!("{at}, to the tangent space"),
            };
            exchange(&mut report, &name, map, t, &q, &to, back, &mut random);
        }
    }
    report
}

/// A change of the coordinates of a map at (q, q̇).
type Change<'a, M, const D: usize> =
    dyn Fn(&mut M, &SVector<f64, D>, &SVector<f64, D>) -> Option<Reparametrized<D>> + 'a;

/// Checks the laws of a change of coordinates of any map at time `t` and `q`: x, ẋ, ẍ and forces
/// are the same before and after `change`, the map is one afterwards, and `back`, if it is given,
/// leads back.
pub fn rewriting<M, const D: usize, const N: usize>(
    map: &M,
    t: f64,
    q: &SVector<f64, D>,
    change: &Change<'_, M, D>,
    back: Option<&Change<'_, M, D>>,
) -> Report
where
    M: Map<D, N> + Clone + 'static,
{
    let mut report = Report::new(short_name::<M>());
    let mut random = Random::default();
    exchange(&mut report, "q", map, t, q, change, back, &mut random);
    report
}

#[allow(clippy::too_many_arguments, reason = "what is checked, where and how")]
fn exchange<M, const D: usize, const N: usize>(
    report: &mut Report,
    at: &str,
    map: &M,
    t: f64,
    q: &SVector<f64, D>,
    change: &Change<'_, M, D>,
    back: Option<&Change<'_, M, D>>,
    random: &mut Random,
) where
    M: Map<D, N> + Clone + 'static,
{
    let v = random.vector::<D>();
    let mut changed = map.clone();
    let Some(new) = change(&mut changed, q, &v) else {
        return report.impossible("change", at, "no change was made");
    };
    let unit = 1.0 + map.phi(t, q).norm();
    for a in [random.vector::<D>(), random.vector::<D>()] {
        let before = map.kinematics(t, q, &v, &a);
        let after = changed.kinematics(t, &new.q, &new.v, &(new.B * a + new.c));
        let unit = unit + before.x_dot.norm() + before.x_ddot.norm();
        agree(
            report,
            "change: x, x_dot, x_ddot stay",
            at,
            &[
                relative(&after.x, &before.x, unit),
                relative(&after.x_dot, &before.x_dot, unit),
                relative(&after.x_ddot, &before.x_ddot, unit),
            ],
        );
        // Covectors go back with the transpose: B'f = (dq*/dq)' B*'f for every f.
        let defect = relative(&(after.B * new.B), &before.B, before.B.norm());
        agree(report, "change: forces stay", at, &[defect]);
        let Some(back) = back else { continue };
        let mut returned = changed.clone();
        let Some(old) = back(&mut returned, &new.q, &new.v) else {
            return report.impossible("change and back", at, "there is no change back");
        };
        let size = unit + new.B.norm() * old.B.norm();
        agree(
            report,
            "change and back",
            at,
            &[
                relative(&old.q, q, size),
                relative(&old.v, &v, size),
                relative(&(old.B * (new.B * a + new.c) + old.c), &a, size * size),
                relative(&returned.phi(t, &old.q), &map.phi(t, q), unit),
            ],
        );
    }
    laws(report, "changed: ", &changed, at, t, &new.q, random);
    report.defect(
        "change: q is a number",
        at,
        if new.q.iter().all(|q| q.is_finite()) {
            0.0
        } else {
            f64::NAN
        },
        CLOSED_FORM,
    );
}

/// A position at this distance, or at half of it as often as needed to be inside the domain.
fn inside<H, const D: usize, const X: usize, const M: usize>(
    map: &Solved<H, D, X, M>,
    t: f64,
    reach: f64,
    random: &mut Random,
) -> Option<SVector<f64, D>>
where
    H: Implicit<X, M>,
{
    let mut q = SVector::<f64, D>::zeros();
    random.direction(reach, q.as_mut_slice());
    for (j, q) in q.iter_mut().enumerate() {
        *q *= map
            .independent()
            .map_or(1.0, |k| map.constraint().size(k[j]));
    }
    for _ in 0..20 {
        if roomy(map, t, &q) {
            return Some(q);
        }
        q *= 0.5;
    }
    None
}

/// Whether a position is well inside the domain: the steps of the laws stay there too.
fn roomy<H, const D: usize, const X: usize, const M: usize>(
    map: &Solved<H, D, X, M>,
    t: f64,
    q: &SVector<f64, D>,
) -> bool
where
    H: Implicit<X, M>,
{
    let margin = map.margin(t, q);
    let step = |j: usize, sign: f64| {
        let mut q = *q;
        // Steps go in all directions at once, and the motion is bent.
        q[j] += sign * 0.6 * margin.min(0.3) * (D as f64).sqrt();
        map.margin(t, &q) > 0.0
    };
    margin * REGULAR > 1.0 && (0..D).all(|j| step(j, 1.0) && step(j, -1.0))
}
