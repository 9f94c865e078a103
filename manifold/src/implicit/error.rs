//! Errors of implicit constraints, with the names of equations and coordinates.

/// Why a constraint cannot be solved at its starting point.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
#[non_exhaustive]
pub enum ImplicitError {
    /// The equations or their derivatives are not finite there.
    #[error("{equation} or its derivative is not finite at the given point")]
    NotFinite { equation: String },
    /// Newton's method found no configuration near the guess.
    #[error(
        "no configuration near the given one satisfies the equations: {equation} is {residual:.3e} \
         after {} iterations; start closer, or the parts do not fit together",
        super::start::ITERATIONS
    )]
    NotAssembled { equation: String, residual: f64 },
    /// Newton's method found no configuration, and some parameters are prescribed.
    #[error(
        "no configuration near the given one satisfies the equations with {prescribed} as prescribed: \
         {equation} is {residual:.3e}; prescribe no more than is free, from where the parts are drawn"
    )]
    Overprescribed {
        prescribed: String,
        equation: String,
        residual: f64,
    },
    /// An equation depends on others and contradicts them.
    #[error("{equation} contradicts {others}, on which it depends: it is {residual:.3e}, not zero")]
    Inconsistent {
        equation: String,
        others: String,
        /// Its residual where the others vanish.
        residual: f64,
    },
    /// An equation is violated, and no coordinate changes it.
    #[error(
        "{equation} is {residual:.3e} and does not change with any coordinate at the point that was \
         given or reached: start from elsewhere, unless the parts do not fit together"
    )]
    Flat { equation: String, residual: f64 },
    /// No coordinate changes an equation at the solution, but some do beside it.
    #[error(
        "{equation} does not change with any coordinate where it is zero, though it does beside: it \
         touches zero there, as a square does; write it so that it goes through zero, or start from \
         another configuration"
    )]
    Touching { equation: String },
    /// There are more independent equations than the number of coordinates q allows.
    #[error(
        "the equations have rank {rank} and leave {} of {coordinates} coordinates free, not \
         {expected}: {equation} does not follow from the others; if it should, lengths do not fit",
        .coordinates - .rank
    )]
    TooManyEquations {
        /// The equation that is closest to dependent.
        equation: String,
        rank: usize,
        /// Coordinates x.
        coordinates: usize,
        expected: usize,
    },
    /// A singular configuration, or more redundant equations than expected.
    #[error(
        "the configuration is singular: there {equations}, so that {} left \
         free and not {expected}; undetermined are {coordinates}. Start from another \
         configuration, or remove equations that say the same",
        counted(*.left)
    )]
    Singular {
        equations: String,
        /// Names of the coordinates that the others do not determine.
        coordinates: String,
        left: usize,
        expected: usize,
    },
}

/// Error of the evaluation of a solved constraint at some q.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(super) enum EvaluationError {
    /// Newton's method does not contract: q is too far from the last converged state.
    #[error(
        "its equations find no solution near the last one; {equation} is {residual:.3e}: take smaller \
         steps"
    )]
    TooFar { equation: String, residual: f64 },
    /// The dependent coordinates are no longer determined.
    #[error(
        "its equations become singular (condition {condition:.1e}): {equations}; undetermined are \
         {coordinates}"
    )]
    Singular {
        condition: f64,
        equations: String,
        coordinates: String,
    },
    /// There is a singular configuration between here and the last converged state.
    #[error(
        "its equations, or its coordinates with them, become singular before it gets there: take smaller \
         steps"
    )]
    Crossed,
    /// A prescribed motion demands what the equations do not allow.
    #[error("{prescribed} cannot get there: it is prescribed beyond what the linkage reaches")]
    OutOfReach { prescribed: String },
    /// Prescribed motions contradict each other.
    #[error(
        "the prescribed motions of {prescribed} contradict each other: {equation} is {residual:.3e}; as the \
         parts are linked fewer of them are free: prescribe no more than is free"
    )]
    Overprescribed {
        prescribed: String,
        equation: String,
        residual: f64,
    },
    /// An equation that was redundant no longer follows from the others.
    #[error(
        "{equation} was redundant and no longer follows from the others: it is {residual:.3e}; the \
         parts, or their prescribed motions, do not fit together exactly enough: give positions \
         and axes with all their digits, and prescribe no more than is free"
    )]
    Inconsistent { equation: String, residual: f64 },
}

fn counted(coordinates: usize) -> String {
    match coordinates {
        1 => "1 coordinate is".to_owned(),
        n => format!("{n} coordinates are"),
    }
}
