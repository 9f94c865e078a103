//! Modes of straight beams against the exact solutions of Timoshenko's equations.

use super::assert_near;
use crate::support::beams::straight;
use nalgebra::{Matrix3, Matrix4};
use pullback::elements::beam::Damping;
use pullback::integrators::linearization::{
    Linearized, ModeOptions, Modes, Selection, linearize, modes,
};
use pullback::manifold::system::Point;
use pullback::prelude::*;

/// A beam along x of length 1 and Aρ = 1: bending stiffness, inertia per length and damping by mass and stiffness.
#[derive(Clone, Copy)]
struct Beam {
    EI: [f64; 2],
    I_rho: [f64; 2],
    damping: [f64; 2],
}

const BEAM: Beam = Beam {
    EI: [1.0, 1.7],
    I_rho: [2.5e-3, 4.25e-3],
    damping: [0.0; 2],
};
const EA: f64 = 400.0;
const GA: f64 = 150.0;
const GJ: f64 = 0.8;

impl Beam {
    fn section(&self) -> Section {
        let section = Section::diagonal(EA, [GA; 2], GJ, self.EI).unwrap();
        let [I2, I3] = self.I_rho;
        let section = section
            .with_mass(1.0, Matrix3::from_diagonal(&[I2 + I3, I2, I3].into()))
            .unwrap();
        let [mass, stiffness] = self.damping;
        section.with_damping(Damping { mass, stiffness }).unwrap()
    }

    /// Elements of order three, clamped at the first node or free.
    fn context(&self, elements: usize, clamped: bool) -> Context {
        let mut b = ModelBuilder::new();
        let ends = [("A", 0.0), ("B", 1.0)].map(|(name, x)| b.node(name, [x, 0.0, 0.0]).unwrap());
        let line = BeamLine {
            order: 3,
            ..BeamLine::new(elements, self.section())
        };
        let axis = straight(&b, ends);
        b.line("beam", &axis, ends, &line).unwrap();
        if clamped {
            b.support(ends[0], &Dof::ALL);
        }
        Context::new(b.build().unwrap())
    }

    /// Determinant of the free end of a clamped beam that vibrates with ω in bending about axis `k`, by the
    /// exponential of w' = Q/GA + φ, φ' = M/EI, Q' = −Aρ ω² w, M' = −Q − Iρ ω² φ.
    fn clamped_free(&self, k: usize, omega: f64) -> f64 {
        let square = omega * omega;
        let mut A = Matrix4::zeros();
        (A[(0, 1)], A[(0, 2)], A[(1, 3)]) = (1.0, 1.0 / GA, 1.0 / self.EI[k]);
        A[(2, 0)] = -square;
        (A[(3, 1)], A[(3, 2)]) = (-self.I_rho[k] * square, -1.0);
        let end = A.exp().fixed_view::<2, 2>(2, 2).into_owned();
        end.determinant()
    }

    /// The lowest frequencies of the clamped beam, sorted.
    fn frequencies(&self, count: usize) -> Vec<f64> {
        let mut all = Vec::new();
        for k in 0..2 {
            let f = |omega| self.clamped_free(k, omega);
            let grid = (0..4000).map(|i| [0.05 * f64::from(i), 0.05 * f64::from(i + 1)]);
            let signs = grid.filter(|&[a, b]| f(a) * f(b) < 0.0);
            all.extend(signs.map(|[a, b]| bisect(&f, a, b)));
        }
        let I_polar = self.I_rho[0] + self.I_rho[1];
        for n in 0..count {
            let kappa = (n as f64 + 0.5) * std::f64::consts::PI;
            all.push(kappa * EA.sqrt());
            all.push(kappa * (GJ / I_polar).sqrt());
        }
        all.sort_by(f64::total_cmp);
        all.truncate(count);
        all
    }
}

fn bisect(f: &dyn Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    for _ in 0..80 {
        let m = 0.5 * (a + b);
        if f(a) * f(m) <= 0.0 { b = m } else { a = m }
    }
    0.5 * (a + b)
}

fn linear(context: &mut Context) -> Linearized {
    let q = vec![0.0; context.initial().len()];
    linearize(context, Point::statics(0.0, &q)).unwrap()
}

fn omegas(found: &Modes) -> Vec<f64> {
    found.modes.iter().map(|m| m.omega()).collect()
}

#[test]
fn modes_of_a_cantilever() {
    let exact = BEAM.frequencies(10);
    let errors = [8, 16].map(|elements| {
        let lin = linear(&mut BEAM.context(elements, true));
        let found = modes(&lin, &ModeOptions::lowest(10)).unwrap();
        assert_eq!(found.counted, Some(10));
        for mode in &found.modes {
            assert!(mode.residual < 1e-12, "{}", mode.residual);
        }
        let pairs = found.modes.iter().zip(&exact);
        let errors = pairs.map(|(mode, exact)| (mode.omega() / exact - 1.0).abs());
        errors.collect::<Vec<f64>>()
    });
    // Frequencies converge with twice the order of the elements.
    for k in [3, 6, 8] {
        let order = (errors[0][k] / errors[1][k]).log2();
        assert!((order - 6.0).abs() < 0.2, "mode {}: order {order}", k + 1);
    }
    assert!(errors[1].iter().all(|e| *e < 1e-6), "{errors:?}");
}

#[test]
fn damping_of_modes_is_rayleighs() {
    let (mass, stiffness) = (0.4, 2e-3);
    let damped = Beam {
        damping: [mass, stiffness],
        ..BEAM
    };
    let lin = linear(&mut damped.context(16, true));
    let found = modes(&lin, &ModeOptions::lowest(6)).unwrap();
    for (mode, omega) in found.modes.iter().zip(BEAM.frequencies(6)) {
        assert_near(mode.omega(), omega, 1e-6);
        let ratio = 0.5 * (mass / omega + stiffness * omega);
        assert_near(mode.damping_ratio(), ratio, 1e-6);
    }
}

/// Small stiff structures have frequencies of many digits.
#[test]
fn modes_do_not_depend_on_the_unit_of_time() {
    let mut lin = linear(&mut BEAM.context(6, true));
    lin.K.iter_mut().for_each(|k| *k *= 1e24);
    let found = modes(&lin, &ModeOptions::lowest(4)).unwrap();
    assert_eq!(found.counted, Some(4));
    for (omega, exact) in omegas(&found).iter().zip(BEAM.frequencies(4)) {
        assert_near(*omega, 1e12 * exact, 1e-5);
    }
}

#[test]
fn modes_of_a_free_beam() {
    for elements in [2, 16, 64] {
        let lin = linear(&mut BEAM.context(elements, false));
        let found = modes(&lin, &ModeOptions::lowest(8)).unwrap();
        let omegas = omegas(&found);
        assert_eq!(found.counted, Some(8));
        let rigid = omegas[..6].iter().all(|omega| *omega <= 1e-7 * omegas[6]);
        assert!(rigid && omegas[6] > 20.0, "{omegas:?}");
        assert!(found.factorisations <= 20, "{}", found.factorisations);
    }
}

#[test]
fn the_mode_nearest_to_a_frequency_comes_first() {
    let lin = linear(&mut BEAM.context(32, true));
    let (count, omega) = (4, 50.0);
    let options = ModeOptions {
        selection: Selection::Nearest { count, omega },
        undamped: false,
    };
    let nearest = omegas(&modes(&lin, &options).unwrap());
    assert_eq!(nearest.len(), 4);
    assert_near(nearest[0], BEAM.frequencies(6)[5], 1e-5);
}

#[test]
fn a_state_out_of_balance_is_refused() {
    let mut context = BEAM.context(4, true);
    let mut q = vec![0.0; context.initial().len()];
    q[1] = 0.1;
    // Without loads and reactions nothing measures the residual; the clamp is a reaction.
    let error = linearize(&mut context, Point::statics(0.0, &q)).unwrap_err();
    assert!(error.to_string().contains("not in balance"), "{error}");
}

/// Round beams, whose bending modes are all double, with damping by stiffness β: λ² + β ω² λ + ω² = 0 for each mode without,
/// which are counted.
#[test]
fn damping_loses_no_copies_of_a_mode_and_none_at_rest() {
    let round = |stiffness: f64| Beam {
        EI: [1.0; 2],
        I_rho: [2.5e-3; 2],
        damping: [0.0, stiffness],
    };
    for (clamped, elements) in [(true, 14), (false, 7)] {
        let undamped = linear(&mut round(0.0).context(elements, clamped));
        for beta in [1e-4, 3e-4] {
            let lin = linear(&mut round(beta).context(elements, clamped));
            let selections = [8, 10, 13].map(|count| Selection::Nearest { count, omega: 0.0 });
            let ranges = [
                Selection::Range([0.0, 250.0]),
                Selection::Range([10.0, 300.0]),
            ];
            for selection in selections.into_iter().chain(ranges) {
                let [exact, found] = [(&undamped, true), (&lin, false)].map(|(lin, undamped)| {
                    let options = ModeOptions {
                        selection,
                        undamped,
                    };
                    omegas(&modes(lin, &options).unwrap())
                });
                assert_eq!(found.len(), exact.len(), "{beta} {elements} {selection:?}");
                for (found, exact) in found.iter().zip(&exact) {
                    let off = (found - exact).abs();
                    assert!(
                        off <= 1e-6 * exact,
                        "{beta} {elements} {selection:?}: {found} {exact}"
                    );
                }
            }
        }
    }
}

/// The same where higher modes are overdamped, and λ is real: two for each, which occur twice in bending.
#[test]
fn overdamped_modes_occur_as_often_as_others() {
    let beta = 0.02;
    let round = |stiffness: f64| Beam {
        EI: [1.0; 2],
        I_rho: [2.5e-3; 2],
        damping: [0.0, stiffness],
    };
    let all = ModeOptions {
        selection: Selection::Nearest {
            count: 54,
            omega: 0.0,
        },
        undamped: true,
    };
    let undamped = modes(&linear(&mut round(0.0).context(3, true)), &all).unwrap();
    let mut exact: Vec<f64> = Vec::new();
    for omega in omegas(&undamped) {
        let half = 0.5 * beta * omega * omega;
        let root = (half * half - omega * omega).max(0.0).sqrt();
        match root > 0.0 {
            true => exact.extend([omega * omega / (half + root), half + root]),
            false => exact.push(omega),
        }
    }
    let lin = linear(&mut round(beta).context(3, true));
    let selection = Selection::Range([0.0, 300.0]);
    let found = omegas(
        &modes(
            &lin,
            &ModeOptions {
                selection,
                undamped: false,
            },
        )
        .unwrap(),
    );
    exact.retain(|omega| *omega <= 300.0);
    exact.sort_by(f64::total_cmp);
    assert_eq!(found.len(), exact.len(), "{found:?} {exact:?}");
    for (found, exact) in found.iter().zip(&exact) {
        assert_near(*found, *exact, 1e-6);
    }
}
