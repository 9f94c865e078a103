//! Modes of straight beams against the exact solutions of Timoshenko's equations.
#![allow(clippy::unwrap_used, non_snake_case)]

use super::assert_near;
use crate::support::beams::straight;
use crate::support::dynamics::observed;
use nalgebra::{Matrix3, Matrix4};
use pullback::elements::beam::Damping;
use pullback::integrators::linearization::{
    Linearized, ModeOptions, Modes, Selection, linearize, modes,
};
use pullback::manifold::system::Point;
use pullback::prelude::*;

/// A beam along x of length 1: stiffness in stretching, shear, torsion and bending, inertia per length.
#[derive(Clone, Copy)]
struct Beam {
    EA: f64,
    GA: f64,
    GJ: f64,
    EI: [f64; 2],
    A_rho: f64,
    I_rho: [f64; 2],
    damping: Damping,
}

const BEAM: Beam = Beam {
    EA: 400.0,
    GA: 150.0,
    GJ: 0.8,
    EI: [1.0, 1.7],
    A_rho: 1.0,
    I_rho: [2.5e-3, 4.25e-3],
    damping: Damping {
        mass: 0.0,
        stiffness: 0.0,
    },
};

impl Beam {
    fn section(&self) -> Section {
        let section = Section::diagonal(self.EA, [self.GA; 2], self.GJ, self.EI).unwrap();
        let [I2, I3] = self.I_rho;
        let inertia = Matrix3::from_diagonal(&[I2 + I3, I2, I3].into());
        let section = section.with_mass(self.A_rho, inertia);
        section.with_damping(self.damping).unwrap()
    }

    /// Elements of order three, clamped at the first node or free.
    fn context(&self, elements: usize, order: usize, clamped: bool) -> Context {
        let mut b = ModelBuilder::new();
        let ends = [("A", 0.0), ("B", 1.0)].map(|(name, x)| b.node(name, [x, 0.0, 0.0]).unwrap());
        let line = BeamLine {
            elements,
            order,
            section: self.section(),
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
        (A[(0, 1)], A[(0, 2)], A[(1, 3)]) = (1.0, 1.0 / self.GA, 1.0 / self.EI[k]);
        A[(2, 0)] = -self.A_rho * square;
        (A[(3, 1)], A[(3, 2)]) = (-self.I_rho[k] * square, -1.0);
        let end = A.exp().fixed_view::<2, 2>(2, 2).into_owned();
        end.determinant()
    }

    /// The lowest frequencies of the clamped beam, sorted.
    fn frequencies(&self, count: usize) -> Vec<f64> {
        let mut all = Vec::new();
        for k in 0..2 {
            let f = |omega| self.clamped_free(k, omega);
            let grid = (0..4000).map(|i| 0.05 * f64::from(i));
            for a in grid {
                let b = a + 0.05;
                if f(a) * f(b) < 0.0 {
                    all.push(bisect(&f, a, b));
                }
            }
        }
        let I_polar = self.I_rho[0] + self.I_rho[1];
        for n in 0..count {
            let kappa = (n as f64 + 0.5) * std::f64::consts::PI;
            all.push(kappa * (self.EA / self.A_rho).sqrt());
            all.push(kappa * (self.GJ / I_polar).sqrt());
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
        let lin = linear(&mut BEAM.context(elements, 3, true));
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
        damping: Damping { mass, stiffness },
        ..BEAM
    };
    let lin = linear(&mut damped.context(16, 3, true));
    let found = modes(&lin, &ModeOptions::lowest(6)).unwrap();
    for (mode, omega) in found.modes.iter().zip(BEAM.frequencies(6)) {
        assert_near(mode.omega(), omega, 1e-6);
        let ratio = 0.5 * (mass / omega + stiffness * omega);
        assert_near(mode.damping_ratio(), ratio, 1e-6);
    }
}

#[test]
fn modes_of_a_free_beam() {
    for elements in [2, 16, 64] {
        let lin = linear(&mut BEAM.context(elements, 3, false));
        let found = modes(&lin, &ModeOptions::lowest(8)).unwrap();
        let omegas = omegas(&found);
        assert_eq!(found.counted, Some(8));
        let rigid = omegas[..6].iter().all(|omega| *omega <= 1e-7 * omegas[6]);
        assert!(rigid && omegas[6] > 20.0, "{omegas:?}");
        assert!(found.factorisations <= 20, "{}", found.factorisations);
    }
}

#[test]
fn all_modes_in_a_range() {
    let exact: Vec<f64> = BEAM.frequencies(40);
    let lin = linear(&mut BEAM.context(32, 3, true));
    for range in [[20.0, 60.0], [0.0, 5.0], [100.0, 200.0]] {
        let inside = |x: &&f64| (range[0]..range[1]).contains(*x);
        let inside: Vec<&f64> = exact.iter().filter(inside).collect();
        let options = ModeOptions {
            selection: Selection::Range(range),
            undamped: false,
        };
        let found = modes(&lin, &options).unwrap();
        assert_eq!(found.counted, Some(inside.len()));
        assert_eq!(found.modes.len(), inside.len());
        for (mode, exact) in found.modes.iter().zip(inside) {
            assert_near(mode.omega(), *exact, 1e-5);
        }
    }
    let options = ModeOptions {
        selection: Selection::Nearest {
            count: 4,
            omega: 50.0,
        },
        undamped: false,
    };
    let nearest = omegas(&modes(&lin, &options).unwrap());
    assert_eq!(nearest.len(), 4);
    assert_near(nearest[0], exact[5], 1e-5);
}

#[test]
fn double_frequencies_are_found_twice() {
    let round = Beam {
        EI: [1.0; 2],
        I_rho: [2.5e-3; 2],
        ..BEAM
    };
    for elements in [4, 64] {
        let lin = linear(&mut round.context(elements, 3, true));
        let found = modes(&lin, &ModeOptions::lowest(5)).unwrap();
        assert!(found.counted >= Some(5));
        let omegas = omegas(&found);
        for k in [0, 2] {
            assert_near(omegas[k + 1], omegas[k], 1e-9);
        }
        assert!(omegas[2] > 4.0 * omegas[0]);
    }
}

/// A small vibration in the shape of a mode has its frequency.
#[test]
fn a_small_motion_has_the_frequency_of_its_mode() {
    let mut context = BEAM.context(8, 3, true);
    let lin = linear(&mut context);
    let mode = &modes(&lin, &ModeOptions::lowest(1)).unwrap().modes[0];
    let shape: Vec<f64> = mode.shape.iter().map(|x| x.re).collect();
    let largest = shape.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let q: Vec<f64> = shape.iter().map(|x| 1e-6 * x / largest).collect();
    let period = std::f64::consts::TAU / mode.omega();
    let watched = q.iter().position(|x| x.abs() > 5e-7).unwrap();
    let options = DynamicOptions::new(10.0 * period, period / 400.0);
    let mut before = [0.0, q[watched]];
    let mut zeros = Vec::new();
    let rest = vec![0.0; q.len()];
    observed(&mut context, [&q, &rest], &options, &mut |_, step| {
        let state = &step.progress.state;
        let now = [state.t, state.q[watched]];
        if before[1] * now[1] < 0.0 {
            zeros.push(before[0] - before[1] * (now[0] - before[0]) / (now[1] - before[1]));
        }
        before = now;
    });
    let n = zeros.len() - 1;
    assert_near(2.0 * (zeros[n] - zeros[0]) / n as f64, period, 1e-4);
}

#[test]
fn a_state_out_of_balance_is_refused() {
    let mut context = BEAM.context(4, 1, true);
    let mut q = vec![0.0; context.initial().len()];
    q[1] = 0.1;
    // Without loads and reactions nothing measures the residual; the clamp is a reaction.
    let error = linearize(&mut context, Point::statics(0.0, &q)).unwrap_err();
    assert!(error.to_string().contains("not in balance"), "{error}");
}
