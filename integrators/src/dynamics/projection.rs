//! Projection of steps onto the energy and momenta of the motion.
//!
//! With the symmetries ξ of the system, their fields X = q̇(ξ) and the mass matrix M, the smallest change
//! of velocities in the kinetic energy that restores momenta X·p and energy is
//!
//! ```text
//! q̇ ↦ Σ jₖ eₖ + s w,    w = q̇ − Σ (eₖ·M q̇) eₖ,    eₖ the fields made orthonormal in M
//! ```
//!
//! with the target momenta jₖ, which include the impulses of constant forces: they fix the rigid
//! part of the motion, and s the energy of the rest (Hairer, Lubich & Wanner, *Geometric Numerical
//! Integration*, IV.4). A rigid or nearly rigid body has no rest: its energy at given momenta
//! depends on its orientation. So the projection may also rotate the whole by η about its centre of
//! mass, which changes that energy by J([η, Ω]) = η·(Ω × J), and weighs both by their lengths |s −
//! 1|²|w|² + |η|²/h² in M.
//!
//! A projection onto a set that contains the exact solution does not increase the error; one onto a
//! target that is itself in error does. So the energy is projected into the tolerance of the work
//! of the step ([`Invariants::unsure`]), to a single value only if nothing but steady loads does
//! work, and not at all while a motion is prescribed: T is then not quadratic in the velocities,
//! and has a least value at p = 0 that no velocities can reach.

use super::invariants::{Invariants, Momentum};
use super::{DynamicsError, Progress, State, Stepper};
use crate::abilities::{energetics, energies};
use crate::vectors::{add, dot};
use nalgebra::Vector3;
use pullback_manifold::system::{Energies, Evaluation, RigidRates, Symmetry, System, Weights};

/// Largest number of passes.
const PASSES: usize = 5;
/// Tolerance of energy over the sum of the magnitudes of its parts, and of momenta over their sizes.
const ROUNDING: f64 = 1e-14;
/// Remaining part of the length of a field that depends on others.
const DEPENDENT: f64 = 1e-7;
/// Largest rotation in a step, as a part of the motion of the step.
const TURN: f64 = 0.1;

/// Relative change of the energy by a rotation that counts as none.
const NO_TURN: f64 = 1e-10;
/// Kinetic energy of prescribed motions, relative to the parts of the whole, that counts as none.
const AT_REST: f64 = 1e-12;

/// A symmetry in the orthonormal basis.
struct Direction {
    xi: RigidRates,
    e: Vec<f64>,
    Me: Vec<f64>,
    /// The target momentum, and the present one.
    j: f64,
    c: f64,
}

/// The projection of a scheme, with its buffers.
pub(super) struct InvariantProjection {
    scheme: &'static str,
    p: Vec<f64>,
    w: Vec<f64>,
    field: Vec<f64>,
    basis: Vec<Direction>,
    kept: Vec<Symmetry>,
    /// Number of directions in use.
    rank: usize,
}

impl InvariantProjection {
    pub(super) fn new(n: usize, scheme: &'static str) -> Self {
        let zeros = || vec![0.0; n];
        let direction = || Direction {
            xi: [0.0; 6],
            e: zeros(),
            Me: zeros(),
            j: 0.0,
            c: 0.0,
        };
        Self {
            scheme,
            p: zeros(),
            w: zeros(),
            field: zeros(),
            basis: (0..6).map(|_| direction()).collect(),
            kept: Vec::with_capacity(6),
            rank: 0,
        }
    }

    /// Invariants of the present state, until the end of a span of times.
    pub(super) fn set_target(
        &mut self,
        system: &mut dyn System,
        stepper: &mut Stepper,
        progress: &mut Progress,
        until: f64,
    ) -> Result<Invariants, DynamicsError> {
        let state = &progress.state;
        let now = self.energies(system, state)?;
        let symmetries = energetics(system).symmetries([state.t, until], &state.q, &state.v);
        // What is found before the first step is not counted, as the largest frequency is not.
        progress.summary.evaluations += usize::from(progress.summary.steps > 0);
        self.momentum(system, stepper, state, &now)?;
        let mut invariants = Invariants::of(&now);
        for symmetry in symmetries {
            energetics(system).rigid_rates(&state.q, &symmetry.motion, &mut self.field);
            let value = dot(&self.field, &self.p);
            invariants.momenta.push(Momentum { symmetry, value });
        }
        Ok(invariants)
    }

    /// Energies of a state.
    pub(super) fn energies(
        &self,
        system: &mut dyn System,
        state: &State,
    ) -> Result<Energies, DynamicsError> {
        let known = energies(system, state.point()).map_err(DynamicsError::at(state.t))?;
        known.ok_or(DynamicsError::NoEnergy {
            scheme: self.scheme,
        })
    }

    /// Restores the invariants of the state at the end of a step of size h; returns its energies.
    pub(super) fn restore(
        &mut self,
        system: &mut dyn System,
        stepper: &mut Stepper,
        progress: &mut Progress,
        h: f64,
    ) -> Result<Energies, DynamicsError> {
        let (state, summary) = (&mut progress.state, &mut progress.summary);
        if let Some(invariants) = &mut progress.invariants {
            let momenta = &mut invariants.momenta;
            self.kept.clear();
            self.kept.extend(momenta.iter().map(|m| m.symmetry));
            energetics(system).keep_symmetries(state.point(), &mut self.kept);
            momenta.retain(|m| self.kept.contains(&m.symmetry));
        }
        let mut now = self.energies(system, state)?;
        let Some(invariants) = &mut progress.invariants else {
            return Ok(now);
        };
        invariants.add_step(&now, h);
        let (mut stale, mut bounded, mut driven) = (true, false, false);
        for _ in 0..PASSES {
            let gross = now.kinetic + now.stored.abs() + now.potential.abs();
            let closed = invariants.energy_gap(now.total()).abs() <= ROUNDING * gross;
            if !stale && (driven || closed) {
                break;
            }
            summary.evaluations += 1;
            driven = self.momentum(system, stepper, state, &now)?;
            let missing = self.split(system, state, invariants, &stepper.S);
            if missing <= ROUNDING && (driven || closed) {
                break;
            }
            let rigid: f64 = self
                .directions()
                .map(|d| 0.5 * (d.j * d.j - d.c * d.c))
                .sum();
            let needed = invariants.energy_gap(now.total() + rigid);
            let fixed = bounded || driven || needed == 0.0;
            let needed = (!fixed).then_some(needed);
            let [moved, limited] = self.correct(system, state, needed, h);
            (stale, bounded) = (moved, bounded || limited);
            now = self.energies(system, state)?;
            if bounded && !stale {
                break;
            }
        }
        if driven {
            (invariants.energy, invariants.unsure) = (now.total(), 0.0);
        }
        invariants.set_power(&now);
        Ok(now)
    }

    /// Restores the momenta, and the energy that is needed, if any; whether coordinates change, and
    /// whether only a part of the energy can be added.
    fn correct(
        &mut self,
        system: &mut dyn System,
        state: &mut State,
        needed: Option<f64>,
        h: f64,
    ) -> [bool; 2] {
        let mut gammas = [0.0; 6];
        let rest = dot(&self.p, &self.w) - self.rigid_in_rest();
        self.turns(system, &state.q, &mut gammas);
        let shares = needed.map(|needed| self.shares(needed, rest, &gammas, h));
        let ([s, eta], limited) = shares.unwrap_or(([1.0, 0.0], false));
        add(&mut state.v, s - 1.0, &self.w);
        for (d, gamma) in self.basis[..self.rank].iter().zip(gammas) {
            add(&mut state.v, d.j - d.c, &d.e);
            add(&mut state.q, eta * gamma, &d.e);
        }
        if eta != 0.0 {
            // Charts that are recentred at the end of a step are recentred again.
            state.change_charts(system);
        }
        [eta != 0.0, limited]
    }

    /// The factor s of the rest and that of the rotations γ that add the needed energy; whether they
    /// add only a part of it.
    fn shares(&self, needed: f64, rest: f64, gammas: &[f64; 6], h: f64) -> ([f64; 2], bool) {
        // The rest gains the energy p·w dλ by dλ, the rotation h² Σ γ² dλ.
        let (rest, size) = (rest.max(0.0), gammas.iter().map(|g| g * g).sum::<f64>());
        let slope = rest + h * h * size;
        if slope == 0.0 {
            return ([1.0, 0.0], true);
        }
        let wanted = 1.0 + 2.0 * needed / slope;
        // Near rest the velocities cannot supply this energy; the next steps will.
        let square = wanted.max(0.0);
        // Energy that the rest does not supply, without rounding errors.
        let left = match square == wanted {
            true => needed * h * h * size / slope,
            false => needed - 0.5 * (square - 1.0) * rest,
        };
        let speed: f64 = self.directions().map(|d| d.j * d.j).sum::<f64>();
        let [eta, most] = match size > 0.0 {
            true => [left / size, TURN * h * (speed / size).sqrt()],
            false => [0.0; 2],
        };
        let limited = eta.abs() > most || (size == 0.0 && square != wanted);
        ([square.sqrt(), eta.max(-most).min(most)], limited)
    }

    fn directions(&self) -> impl Iterator<Item = &Direction> {
        self.basis[..self.rank].iter()
    }

    /// The part of p·w from rigid motions: rounding errors, unless a motion is prescribed.
    fn rigid_in_rest(&self) -> f64 {
        self.directions().map(|d| d.c * dot(&d.Me, &self.w)).sum()
    }

    /// Writes the mass matrix to `stepper.S` and the generalised momentum. Whether a motion is prescribed: the kinetic energy T = ½ q̇·M q̇ + b·q̇ + c, with p = M q̇ + b, then has a constant c.
    fn momentum(
        &mut self,
        system: &mut dyn System,
        Stepper { r, S, .. }: &mut Stepper,
        state: &State,
        now: &Energies,
    ) -> Result<bool, DynamicsError> {
        let at = state.point();
        let out = Evaluation::with_tangent(r, Weights::MASS, S);
        system
            .evaluate(at, out)
            .map_err(DynamicsError::at(state.t))?;
        let known = energetics(system).momentum(at, &mut self.p);
        product(system, S, &state.v, &mut self.field);
        if !known.map_err(DynamicsError::at(state.t))? {
            self.p.copy_from_slice(&self.field);
            return Ok(false);
        }
        for (i, p) in self.p.iter_mut().enumerate() {
            if system.pattern().coordinates()[i].is_multiplier {
                *p = 0.0;
            }
        }
        let parts = self.p.iter().zip(&state.v).map(|(p, v)| (p * v).abs());
        let size = now.kinetic + parts.sum::<f64>();
        let c = now.kinetic - dot(&self.p, &state.v) + 0.5 * dot(&self.field, &state.v);
        Ok(c.abs() > AT_REST * size)
    }

    /// The orthonormal basis of the symmetries, and the rest w of the velocities; returns the error
    /// of the momenta relative to the sizes of their parts.
    fn split(
        &mut self,
        system: &mut dyn System,
        state: &State,
        invariants: &Invariants,
        M: &[f64],
    ) -> f64 {
        self.rank = 0;
        self.w.copy_from_slice(&state.v);
        let mut missing = 0.0_f64;
        for Momentum { symmetry, value } in &invariants.momenta {
            let motion = &symmetry.motion;
            let (done, rest) = self.basis.split_at_mut(self.rank);
            let Some(d) = rest.first_mut() else { break };
            energetics(system).rigid_rates(&state.q, motion, &mut d.e);
            (d.xi, d.j) = (*motion, *value);
            let parts: f64 = d.e.iter().zip(&self.p).map(|(e, p)| (e * p).abs()).sum();
            let off = (d.j - dot(&d.e, &self.p)).abs();
            if parts > 0.0 {
                missing = missing.max(off / parts.max(d.j.abs()));
            }
            product(system, M, &d.e, &mut d.Me);
            let length = dot(&d.e, &d.Me).max(0.0).sqrt();
            // Twice, against rounding errors.
            for _ in 0..2 {
                for known in done.iter() {
                    let along = dot(&d.Me, &known.e);
                    add(&mut d.e, -along, &known.e);
                    add(&mut d.xi, -along, &known.xi);
                    d.j -= along * known.j;
                }
                product(system, M, &d.e, &mut d.Me);
            }
            let left = dot(&d.e, &d.Me).max(0.0).sqrt();
            if left <= DEPENDENT * length {
                continue;
            }
            for x in d.e.iter_mut().chain(&mut d.Me).chain(&mut d.xi) {
                *x /= left;
            }
            d.j /= left;
            d.c = dot(&d.e, &self.p);
            let along = dot(&d.Me, &state.v);
            add(&mut self.w, -along, &d.e);
            self.rank += 1;
        }
        missing
    }

    /// Derivatives of the energy by rotations along the symmetries: J([ξ, Ω]), J the target
    /// momenta. As [ξ, Ω] is a symmetry as well, it is a sum of the basis.
    fn turns(&mut self, system: &mut dyn System, q: &[f64], gammas: &mut [f64; 6]) {
        let mut Omega = [0.0; 6];
        let mut momentum = 0.0;
        for d in &self.basis[..self.rank] {
            add(&mut Omega, d.j, &d.xi);
            momentum += d.j * d.j;
        }
        for (gamma, d) in gammas.iter_mut().zip(&self.basis[..self.rank]) {
            if d.xi[3..].iter().all(|x| *x == 0.0) {
                continue;
            }
            energetics(system).rigid_rates(q, &bracket(&d.xi, &Omega), &mut self.field);
            let (mut sum, mut length) = (0.0, 0.0);
            for along in &self.basis[..self.rank] {
                let part = dot(&self.field, &along.Me);
                sum += part * along.j;
                length += part * part;
            }
            // A rotation by rounding errors would have an arbitrary axis.
            let most: f64 = length * momentum;
            *gamma = if sum.abs() > NO_TURN * most.sqrt() {
                sum
            } else {
                0.0
            };
        }
    }
}

/// y = A x, for a matrix with these values.
fn product(system: &dyn System, A: &[f64], x: &[f64], y: &mut [f64]) {
    y.fill(0.0);
    system.pattern().multiply_add(1.0, A, x, y);
}

/// The Lie bracket [η, ξ]: the rate at which ξ changes along η.
fn bracket(eta: &RigidRates, xi: &RigidRates) -> RigidRates {
    let parts = |x: &RigidRates| [0, 3].map(|i| Vector3::new(x[i], x[i + 1], x[i + 2]));
    let ([v, omega], [v_xi, omega_xi]) = (parts(eta), parts(xi));
    let linear = omega.cross(&v_xi) - omega_xi.cross(&v);
    let angular = omega.cross(&omega_xi);
    std::array::from_fn(|i| if i < 3 { linear[i] } else { angular[i - 3] })
}
