//! Errors planted in components of a model: `check::model` names the component, the block, and how
//! much of it is missing.

use crate::support::*;
use pullback_conformance::LawRow;

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Planted {
    Nothing,
    /// Ḃ of the joint is half of itself.
    LostFactor,
    /// K_σ of the joint has the other sign.
    SwappedSign,
    /// The frame does not turn with its parent's rotation, but about fixed axes.
    FixedAxes,
    /// C of the body is missing: nothing but gyroscopic terms.
    MissingTangent,
    /// Ω×JΩ is missing in the body's force.
    MissingForce,
    /// A tenth too much kinetic energy.
    WrongEnergy,
}

/// A rigid link with a closed form that overrides the derived one.
#[derive(Clone)]
struct Link(Planted);

const C: [f64; 3] = [0.3, -0.2, 0.5];

impl Map<6, 6> for Link {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 6>) -> SVector<S, 6> {
        let (parent, c) = (Pose::of(q, 0), Vector3::from(C).map(S::constant));
        let d = parent.translated(&c).d - c;
        let mut x = SVector::<S, 6>::new(d.x, d.y, d.z, q[3], q[4], q[5]);
        if self.0 == Planted::FixedAxes {
            x[2] += q[3] * 0.1;
        }
        x
    }

    fn kinematics(
        &self,
        t: f64,
        q: &SVector<f64, 6>,
        v: &SVector<f64, 6>,
        a: &SVector<f64, 6>,
    ) -> Kinematics<6, 6> {
        let mut out = derived::kinematics(self, t, q, v, a);
        if self.0 == Planted::LostFactor {
            out.B_dot *= 0.5;
        }
        out
    }

    fn geometric_stiffness(
        &self,
        t: f64,
        q: &SVector<f64, 6>,
        f: &SVector<f64, 6>,
    ) -> SMatrix<f64, 6, 6> {
        let K = derived::geometric_stiffness(self, t, q, f);
        match self.0 {
            Planted::SwappedSign => -K,
            _ => K,
        }
    }
}

fn body() -> RigidBody {
    let J = Matrix3::from_diagonal(&Vector3::new(0.2, 0.3, 0.45));
    RigidBody::new(2.0, J, Vector3::zeros()).unwrap()
}

/// A rigid body without some of its gyroscopic terms, or with a wrong energy.
struct Top(Planted);

impl Element for Top {
    fn dim(&self) -> usize {
        6
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let mut again = Response {
            r: &mut *out.r,
            K: out.K.as_deref_mut(),
            C: match self.0 {
                Planted::MissingTangent => None,
                _ => out.C.as_deref_mut(),
            },
            M: out.M.as_deref_mut(),
            r_t: None,
        };
        InCharts(&body()).evaluate(at, &mut again)?;
        if self.0 == Planted::MissingForce && !at.v.is_empty() {
            let [psi, rate] = [at.x, at.v].map(|x| Vector3::new(x[3], x[4], x[5]));
            let T = so3::tangent(&psi);
            let Omega = T * rate;
            let lost = T.tr_mul(&Omega.cross(&(body().inertia().J * Omega)));
            for k in 0..3 {
                out.r[3 + k] += lost[k];
            }
        }
        Ok(())
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities::of_energies(self)
    }
}

impl ElementEnergies for Top {
    fn kinetic_energy(&self, at: &Motion<'_>) -> Option<f64> {
        let factor = match self.0 {
            Planted::WrongEnergy => 1.1,
            _ => 1.0,
        };
        Some(factor * InCharts(&body()).abilities().kinetic_energy(at)?)
    }
}

/// A beam with a link at its end that carries a body, and a spinning body beside it.
fn report(planted: Planted, seed: u64) -> Report {
    let mut b = ModelBuilder::new();
    let root = b.node("root", [0.0; 3]).unwrap();
    let tip = b.node("tip", [1.0, 0.2, 0.1]).unwrap();
    lay(&mut b, "arm", [root, tip], 2, 1, coupled());
    b.support(root, &Dof::ALL);
    let end = b.position(tip) + Vector3::from(C);
    let far = b
        .mapped_node("far", end.into(), Link(planted).boxed(), &[tip])
        .unwrap();
    b.element("load", body(), &[far]).unwrap();
    let hub = b.node("hub", [0.0, 0.0, 2.0]).unwrap();
    b.element("top", Top(planted), &[hub]).unwrap();
    checked(b, seed)
}

/// Components that fail, each once.
fn broken(report: &Report) -> Vec<&str> {
    let mut all: Vec<&str> = failures(report).into_iter().map(|[of, _]| of).collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn failure<'a>(report: &'a Report, component: &str, law: &str) -> &'a LawRow {
    let found = report
        .rows()
        .iter()
        .find(|r| r.component == component && r.law == law);
    let row = found.unwrap_or_else(|| panic!("no {law} of {component}\n{report}"));
    assert!(!row.passed, "{report}");
    assert!(!row.blocks.is_empty(), "{report}");
    row
}

const LINK: &str = "joint far (link)";
const TOP: &str = "element top (top)";
const SEEDS: std::ops::Range<u64> = 0..4;

#[test]
fn without_errors_all_is_well() {
    for seed in SEEDS {
        report(Planted::Nothing, seed).assert();
    }
}

#[test]
fn a_lost_factor_in_the_rate_of_the_operator() {
    for seed in SEEDS {
        let report = report(Planted::LostFactor, seed);
        assert_eq!(broken(&report), [LINK, "model"], "{report}");
        let row = failure(&report, LINK, "B_dot, B_ddot along the motion");
        let block = &row.blocks[0];
        assert_eq!(block.matrix, "B_dot");
        assert_eq!(block.rows, "displacement of node far");
        assert_eq!(block.columns, "rotation of node tip");
        assert!((block.factor - 0.5).abs() < 1e-6, "{block}");
        assert!((block.defect / block.right - 0.5).abs() < 1e-6, "{block}");
        // 2 Bᵀ M Ḃ of what is attached to the tip.
        let row = failure(&report, "model", "C = -dr/dv");
        assert!(row.blocks[0].columns.ends_with("node tip"), "{report}");
        assert!(row.blocks[0].rows.ends_with("node tip"), "{report}");
    }
}

#[test]
fn a_swapped_sign_in_the_geometric_stiffness() {
    for seed in SEEDS {
        let report = report(Planted::SwappedSign, seed);
        assert_eq!(broken(&report), [LINK, "model"], "{report}");
        let row = failure(&report, LINK, "K_sigma = d(B'f)/dq");
        let block = &row.blocks[0];
        assert_eq!(block.matrix, "K_sigma");
        assert_eq!([&block.rows, &block.columns], ["rotation of node tip"; 2]);
        assert!((block.factor + 1.0).abs() < 1e-6, "{block}");
        assert!((block.defect / block.right - 2.0).abs() < 1e-6, "{block}");
        let block = &failure(&report, "model", "K = -dr/dx").blocks[0];
        assert_eq!([&block.rows, &block.columns], ["rotation of node tip"; 2]);
    }
}

#[test]
fn a_missing_gyroscopic_tangent() {
    for seed in SEEDS {
        let report = report(Planted::MissingTangent, seed);
        assert_eq!(broken(&report), [TOP, "model"], "{report}");
        for component in broken(&report) {
            let block = &failure(&report, component, "C = -dr/dv").blocks[0];
            assert_eq!(block.matrix, "C");
            assert_eq!([&block.rows, &block.columns], ["rotation of node hub"; 2]);
            // All of it: the body has nothing else that depends on velocities.
            assert!(block.factor.abs() < 1e-9, "{block}");
            assert!((block.defect / block.right - 1.0).abs() < 1e-9, "{block}");
        }
    }
}

/// Ω×JΩ does no work and turns with the body: neither power nor objectivity miss it.
#[test]
fn a_missing_gyroscopic_force() {
    for seed in SEEDS {
        let report = report(Planted::MissingForce, seed);
        assert_eq!(broken(&report), [TOP, "model"], "{report}");
        let row = failure(&report, TOP, "inertia = d/dt dT/dv - dT/dx");
        assert_eq!(row.blocks.len(), 1, "{report}");
        assert_eq!(row.blocks[0].rows, "rotation of node hub");
    }
}

#[test]
fn a_kinetic_energy_that_is_not_that_of_the_mass_matrix() {
    for seed in SEEDS {
        let report = report(Planted::WrongEnergy, seed);
        let failed = [TOP, "T = v.Mv/2"];
        assert!(failures(&report).contains(&failed), "{report}");
    }
}

#[test]
fn a_frame_that_does_not_turn_with_its_master() {
    for seed in SEEDS {
        let report = report(Planted::FixedAxes, seed);
        // A position that depends on a component of Ψ depends on its chart too.
        let expected = [
            [LINK, "frames move rigidly with their parents"],
            ["model", "change of charts: forces stay"],
            ["model", "change of charts: motion stays"],
            ["model", "change of charts: energies and powers stay"],
        ];
        assert_eq!(failures(&report), expected, "{report}");
    }
}
