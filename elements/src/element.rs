//! The element interface: one evaluation of the residual and the requested tangents.

mod abilities;

pub use abilities::{Abilities, Combined, CrossSections, ElementEnergies, SectionState};

use pullback_manifold::domain::DomainError;
use pullback_manifold::system::Weights;

/// Time, coordinates, velocities and accelerations of an element, node by node. A frame node has
/// six coordinates (d, Ψ): displacement from its reference position and rotation vector from its
/// reference orientation, both in global components.
///
/// An element that [reads poses](Properties::reads_poses) has the displacement and the modified Rodrigues
/// parameters (d, σ) instead, the velocity and the angular velocity (ẋ, ω), and (ẍ, ω̇). Its residual is a
/// force and a moment, and its tangents are derivatives along (δx, δθ), (δx, δθ)˙ and (δx, δθ)¨: see
/// [`ToPose`](pullback_manifold::map::ToPose).
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    /// Time, or load parameter in statics.
    pub t: f64,
    /// Values that a program sets ([`Input`](crate::time::Input)), for functions of time.
    pub inputs: &'a [f64],
    /// Coordinates.
    pub x: &'a [f64],
    /// Velocities; empty in statics.
    pub v: &'a [f64],
    /// Accelerations; empty in statics.
    pub a: &'a [f64],
    /// Coordinates at the previous iterate, if any and if no node is mapped. K may then use stresses extrapolated linearly from
    /// there instead of those at `x`: the residual is the same, and K differs by terms of second order in
    /// the step, so Newton's method stays quadratic. The tangent is free of the large spurious stresses of
    /// a big step in a slender element (Magisano, Leonetti & Garcea 2017, Comput. Methods Appl. Mech. Eng.
    /// 313).
    pub previous: Option<&'a [f64]>,
}

/// Output of an evaluation. Everything is zero on entry and the element **adds** to it.
///
/// Matrices are n×n, column by column, n = [`Element::dim`].
pub struct Response<'a> {
    /// Residual covector r = f_ext − f_int − f_acc.
    pub r: &'a mut [f64],
    /// K = −∂r/∂x, if requested.
    pub K: Option<&'a mut [f64]>,
    /// C = −∂r/∂ẋ, if requested.
    pub C: Option<&'a mut [f64]>,
    /// M = −∂r/∂ẍ, if requested.
    pub M: Option<&'a mut [f64]>,
    /// Partial derivative ∂r/∂t at a fixed motion, if requested.
    pub r_t: Option<&'a mut [f64]>,
}

/// Limit of the relative rotation of nodes, in messages.
pub(crate) const ONE_TURN: &str = "the range of relative rotation of its nodes, less than one turn: \
                                  take more elements, or a revolute joint for what turns freely";

/// Matrices of tangents, each with the weights of K, C and M in it.
pub type CombinedTangents<'a> = [Option<(Weights, &'a mut [f64])>; 3];

impl Response<'_> {
    /// The residual and the requested parts K, C and M of the tangent.
    pub(crate) fn parts(&mut self) -> (&mut [f64], CombinedTangents<'_>) {
        let K = self.K.as_deref_mut().map(|K| (Weights::STATIC, K));
        let C = self.C.as_deref_mut().map(|C| (Weights::DAMPING, C));
        let M = self.M.as_deref_mut().map(|M| (Weights::MASS, M));
        (&mut *self.r, [K, C, M])
    }
}

/// Properties of an element that hold at all motions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Properties {
    /// It is an applied load, which sets the scale of convergence tests. All its power counts as supplied, also what
    /// it dissipates; it has no mass.
    pub load: bool,
    /// The residual depends on time alone, so that all tangents are zero; it has no moments at
    /// frames, whose covectors depend on the rotation.
    pub dead: bool,
    /// It is a load with a time-independent potential, its energy. Its work is then known exactly,
    /// not only to the order of a scheme.
    pub time_independent: bool,
    /// K is symmetric at rest, at every point of the domain.
    pub symmetric: bool,
    /// Its forces rotate with a rigid motion of all its nodes, as internal ones do: false for elements
    /// that are tied to space, and for most loads.
    pub objective: bool,
    /// It depends on rotations of its nodes: false for an element that uses positions only, whose nodes
    /// may rotate relative to each other without limit.
    pub sees_rotations: bool,
    /// It reads the poses of its nodes, all of them frames, and gives forces and moments:
    /// [`Motion`].
    pub reads_poses: bool,
}

impl Properties {
    /// A conservative element between its nodes: a beam, a spring, a body.
    pub const INTERNAL: Self = Self {
        load: false,
        dead: false,
        time_independent: false,
        symmetric: true,
        objective: true,
        sees_rotations: true,
        reads_poses: false,
    };

    /// A load with a symmetric tangent.
    pub const LOAD: Self = Self {
        load: true,
        objective: false,
        ..Self::INTERNAL
    };

    /// Properties of the sum of two elements on the same nodes.
    #[must_use]
    pub fn sum(self, other: Self) -> Self {
        Self {
            load: self.load && other.load,
            dead: self.dead && other.dead,
            time_independent: self.time_independent && other.time_independent,
            symmetric: self.symmetric && other.symmetric,
            objective: self.objective && other.objective,
            sees_rotations: self.sees_rotations || other.sees_rotations,
            reads_poses: self.reads_poses && other.reads_poses,
        }
    }
}

/// An element or a load: a contribution to the residual by nodes.
///
/// Beams, bodies, springs and loads implement it. The coordinates may belong to free nodes or come
/// from any constraint map.
pub trait Element: Send + Sync {
    /// Number of coordinates: the sum of its nodes' dimensions.
    fn dim(&self) -> usize;

    /// Adds the residual, and the requested tangents, at the given motion.
    ///
    /// # Errors
    /// [`DomainError`] if the motion is outside the element's domain.
    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError>;

    /// Its properties at all motions; [`Properties::INTERNAL`] by default.
    fn properties(&self) -> Properties {
        Properties::INTERNAL
    }

    /// Its optional abilities; none by default.
    fn abilities(&self) -> Abilities<'_> {
        Abilities::default()
    }

    /// Times at which its functions of time have a kink; none by default.
    fn kinks(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Name of its type, for reports.
    fn kind(&self) -> &'static str {
        std::any::type_name::<Self>()
    }
}

impl<E: Element + 'static> From<E> for Box<dyn Element> {
    fn from(element: E) -> Self {
        Box::new(element)
    }
}
