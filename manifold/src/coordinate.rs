//! What is known of a coordinate of a system.

/// Physical quantity of a coordinate. Its conjugate residual is a force, a moment or neither; norms
/// and convergence tests treat them separately.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// A length; the residual is a force.
    Length,
    /// An angle or rotation vector component; the residual is a moment.
    Angle,
    /// Anything else.
    Other,
}

impl Quantity {
    /// All quantities, in the order of their indices.
    pub const ALL: [Self; 3] = [Self::Length, Self::Angle, Self::Other];

    /// Index in [`Quantity::ALL`].
    pub fn index(self) -> usize {
        self as usize
    }

    /// Typical size of its coordinates in a system of this length.
    pub fn size(self, length: f64) -> f64 {
        match self {
            Self::Length => length,
            Self::Angle | Self::Other => 1.0,
        }
    }

    /// Name of the conjugate residual.
    pub fn conjugate(self) -> &'static str {
        match self {
            Self::Length => "force",
            Self::Angle => "moment",
            Self::Other => "residual",
        }
    }
}

/// A coordinate of a system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoordinateInfo {
    /// Physical quantity.
    pub quantity: Quantity,
    /// Typical size, in its unit: a length of the model, one radian, one.
    pub size: f64,
    /// Size of the numbers that the coordinate is added to, such as a position in space; it
    /// determines the rounding errors. Its typical size if `None`.
    pub magnitude: Option<f64>,
    /// Whether it is a Lagrange multiplier: an unknown without mass whose residual row is an equation
    /// of the coordinates. Its velocity and acceleration have no meaning, and its momentum is the rate
    /// ḣ of the equation. Its typical size follows from the values of a matrix.
    pub is_multiplier: bool,
}

impl Default for CoordinateInfo {
    fn default() -> Self {
        Self {
            quantity: Quantity::Other,
            size: 1.0,
            magnitude: None,
            is_multiplier: false,
        }
    }
}
