//! Modes and critical loads of a model.

use crate::linear::{check_mobility, equations, warning_of_motion};
use crate::terminal::plural;
use nalgebra::Vector3;
use num_complex::Complex64;
use pullback_elements::model::Context;
use pullback_elements::time::Input;
use pullback_integrators::linearization::{
    BucklingError, BucklingMode, CampbellDiagram, CampbellError, CampbellOptions,
    LinearizationError, Linearized, Mode, ModeOptions, ModesError, Selection, buckling_while,
    campbell, modes_while,
};
use pullback_integrators::significant;
use pullback_manifold::system::{Point, System, SystemError};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// The modes of a model about a state.
#[derive(Clone, Debug)]
pub struct ModelModes {
    /// By growing |λ|.
    pub modes: Vec<ModelMode>,
    /// Names of the coordinates of their shapes.
    pub names: Vec<String>,
    /// Number of eigenvalues in the region searched, by Sylvester's law of inertia; `None` with damping.
    pub counted: Option<usize>,
    /// What a user should know of the search.
    pub warnings: Vec<String>,
}

/// A mode, and its share in the motion of the whole model.
#[derive(Clone, Debug)]
pub struct ModelMode {
    /// The mode.
    pub mode: Mode,
    /// Linear momentum of the model that moves with velocities φ, global components: the participation factors
    /// of translations of the ground.
    pub participation: [Complex64; 3],
}

impl ModelMode {
    /// Effective masses |Γ|² of the mode for translations along the axes.
    pub fn effective_mass(&self) -> [f64; 3] {
        self.participation.map(|gamma| gamma.norm_sqr())
    }
}

/// Why there are no modes.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelModesError {
    /// The state cannot be linearised.
    #[error(transparent)]
    Linearization(#[from] LinearizationError),
    /// The search failed.
    #[error("modes: {0}")]
    Modes(#[from] ModesError),
    /// No critical loads.
    #[error("buckling: {0}")]
    Buckling(#[from] BucklingError),
    /// No Campbell diagram.
    #[error("Campbell diagram: {0}")]
    Campbell(#[from] CampbellError),
    /// Everything is prescribed.
    #[error("nothing in the model is free to move: it has neither modes nor equations of motion")]
    Immobile,
    /// A range without modes.
    #[error("no mode has a natural frequency |λ|/2π between {} and {}", significant(.0[0]), significant(.0[1]))]
    None([f64; 2]),
}

impl ModelModesError {
    /// Whether the observer has ended the search.
    pub fn is_interruption(&self) -> bool {
        let interrupted = ModesError::Interrupted;
        match self {
            Self::Modes(error) => *error == interrupted,
            Self::Campbell(CampbellError::Modes { source, .. })
            | Self::Buckling(BucklingError::Search(source)) => *source == interrupted,
            _ => false,
        }
    }
}

impl From<SystemError> for ModelModesError {
    fn from(error: SystemError) -> Self {
        LinearizationError::from(error).into()
    }
}

/// Residual of a mode above which a warning is given.
const INACCURATE: f64 = 1e-6;

/// The modes of a model about a state, with an observer that may end the search.
///
/// # Errors
/// [`ModelModesError`].
pub fn find(
    context: &mut Context,
    at: Point<'_>,
    options: &ModeOptions,
    observer: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<ModelModes, ModelModesError> {
    let lin = equations(context, at)?;
    find_in(context, at, lin, options, observer)
}

/// The modes of a model by its linear equations about a state.
fn find_in(
    context: &mut Context,
    at: Point<'_>,
    lin: Linearized,
    options: &ModeOptions,
    observer: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<ModelModes, ModelModesError> {
    let found = modes_while(&lin, options, observer)?;
    let mut warnings = Vec::new();
    match options.selection {
        Selection::Range(range) if found.modes.is_empty() => {
            return Err(ModelModesError::None(range.map(|omega| omega / TAU)));
        }
        Selection::Nearest { count, .. } if found.modes.len() < count => {
            let modes = plural(found.modes.len(), "mode");
            warnings.push(match found.complete && !found.modes.is_empty() {
                true => format!("the model has {modes}, fewer than count = {count}"),
                false => format!(
                    "{modes} of count = {count} found: others have no mass, or frequencies so far above the lowest that they are \
                     lost in rounding errors; ask for those with `near` or `range`"
                ),
            });
        }
        _ => {}
    }
    if let Some((k, mode)) = (1..)
        .zip(&found.modes)
        .find(|(_, m)| m.residual > INACCURATE)
    {
        warnings.push(format!(
            "mode {k} satisfies its equations only to {:.1e}: it and others like it are lost in rounding errors; ask for fewer modes, \
             or for those around another frequency",
            mode.residual
        ));
    }
    let still = |mode: &Mode| mode.eigenvalue == Complex64::ZERO;
    if !found.modes.is_empty() && found.modes.iter().all(still) {
        warnings.push(
            "all frequencies are zero: nothing in the model is elastic, or loads balance what is"
                .to_owned(),
        );
    }
    warnings.extend(warning_of_motion(context, at)?);
    let participations = participations(context, at, &found.modes)?;
    let modes = found.modes.into_iter().zip(participations);
    let modes = modes.map(|(mode, participation)| ModelMode {
        mode,
        participation,
    });
    Ok(ModelModes {
        modes: modes.collect(),
        names: lin.names,
        counted: found.counted,
        warnings,
    })
}

/// Linear momentum that the velocities of each mode add to that of the state.
fn participations(
    context: &mut Context,
    at: Point<'_>,
    modes: &[Mode],
) -> Result<Vec<[Complex64; 3]>, SystemError> {
    let zeros = vec![0.0; at.q.len()];
    let still = if at.is_static() { &zeros[..] } else { at.v };
    let mut momentum = |v: &[f64]| -> Result<Vector3<f64>, SystemError> {
        let at = Point { v, a: &zeros, ..at };
        Ok(context.energies_and_momentum(at)?.momentum.linear)
    };
    let before = momentum(still)?;
    let mut added = |shape: &[Complex64], part: fn(&Complex64) -> f64| {
        if shape.iter().all(|x| part(x) == 0.0) {
            return Ok(Vector3::zeros());
        }
        let v = still.iter().zip(shape).map(|(v, x)| v + part(x));
        Ok::<_, SystemError>(momentum(&v.collect::<Vec<_>>())? - before)
    };
    let participations = modes.iter().map(|mode| {
        let (re, im) = (added(&mode.shape, |x| x.re)?, added(&mode.shape, |x| x.im)?);
        Ok([0, 1, 2].map(|k| Complex64::new(re[k], im[k])))
    });
    participations.collect()
}

/// Critical loads of a model, nearest to that of an equilibrium.
#[derive(Clone, Debug)]
pub struct CriticalLoads {
    /// The loads with their shapes, by growing distance.
    pub modes: Vec<BucklingMode>,
    /// What a user should know of the search.
    pub warnings: Vec<String>,
    /// Names of the coordinates of their shapes.
    pub names: Vec<String>,
}

/// Modes of a model over the speed of a steady rotation.
#[derive(Clone, Debug)]
pub struct ModelCampbell {
    /// The diagram.
    pub diagram: CampbellDiagram,
    /// The modes at the last speed.
    pub last: ModelModes,
    /// The coordinates there.
    pub q: Vec<f64>,
}

/// Modes over the speed, from coordinates `q` at rest, which end as those at the last one: in coordinates that rotate, and where
/// their equations are periodic, in multi-blade coordinates.
///
/// # Errors
/// [`ModelModesError`].
pub(crate) fn steady_rotation(
    context: &mut Context,
    q: &mut Vec<f64>,
    speed: Input,
    options: &CampbellOptions,
    observer: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<CampbellDiagram, ModelModesError> {
    let (start, mut options) = (q.clone(), options.clone());
    let mut diagram = campbell(context, speed, q, &options, &mut |_| observer());
    if !matches!(diagram, Err(CampbellError::Periodic { .. })) {
        return Ok(diagram?);
    }
    for rotor in context.cyclic_symmetries(speed, &start)? {
        q.clone_from(&start);
        options.rotor = Some(rotor);
        diagram = campbell(context, speed, q, &options, &mut |_| observer());
        if !matches!(diagram, Err(CampbellError::Periodic { .. })) {
            break;
        }
    }
    Ok(diagram?)
}

/// The Campbell diagram of a model from its coordinates at rest.
///
/// # Errors
/// [`ModelModesError`].
pub fn campbell_diagram(
    context: &mut Context,
    mut q: Vec<f64>,
    speed: Input,
    options: &CampbellOptions,
    observer: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<ModelCampbell, ModelModesError> {
    check_mobility(context)?;
    let mut diagram = steady_rotation(context, &mut q, speed, options, observer)?;
    let zeros = vec![0.0; q.len()];
    let at = Point {
        t: options.t,
        q: &q,
        v: &zeros,
        a: &zeros,
    };
    let lowest = ModeOptions::lowest(options.count);
    let lin = match diagram.last.take() {
        Some(lin) => lin,
        None => equations(context, at)?,
    };
    let mut last = find_in(context, at, lin, &lowest, &mut |_| observer())?;
    last.warnings.extend(growing(&diagram));
    Ok(ModelCampbell { diagram, last, q })
}

/// Damping ratio, with a negative sign, above which a mode grows and not by rounding errors.
const GROWS: f64 = 1e-6;

/// Warnings about modes that grow, line by line.
fn growing(diagram: &CampbellDiagram) -> impl Iterator<Item = String> + '_ {
    (1..).zip(&diagram.lines).filter_map(|(k, line)| {
        let grows = |m: &Mode| m.damping_ratio() < -GROWS;
        let modes = line.iter().map(|mode| mode.as_ref().is_some_and(grows));
        let all: Vec<(f64, bool)> = diagram.speeds.iter().copied().zip(modes).collect();
        let runs = all.chunk_by(|a, b| a.1 == b.1).filter(|run| run[0].1);
        let between = runs.map(|run| {
            let [first, last] = [run[0].0, run[run.len() - 1].0].map(significant);
            format!("between {first} and {last}")
        });
        let between = between.collect::<Vec<_>>().join(", and ");
        (!between.is_empty()).then(|| {
            format!("the mode of line {k} grows at speeds {between}: the rotor is unstable there")
        })
    })
}

/// What is found at the end of the steps of an analysis.
#[derive(Clone, Debug)]
pub enum Eigenvalues {
    /// Modes of vibration.
    Modes(ModelModes),
    /// Critical loads.
    Critical(CriticalLoads),
    /// Modes over a speed.
    Campbell(Box<ModelCampbell>),
}

impl Eigenvalues {
    /// What a user should know of them.
    pub fn warnings(&self) -> &[String] {
        match self {
            Self::Modes(found) => &found.warnings,
            Self::Critical(found) => &found.warnings,
            Self::Campbell(found) => &found.last.warnings,
        }
    }
}

/// Error of a critical load above which a warning is given.
const POOR: f64 = 0.1;

/// The critical loads extrapolated from an equilibrium, with an observer that may end the search.
///
/// # Errors
/// [`BucklingError`].
pub fn critical_loads(
    context: &mut Context,
    at: Point<'_>,
    count: usize,
    observer: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<CriticalLoads, BucklingError> {
    let modes = buckling_while(context, at, count, observer)?;
    let mut warnings = Vec::new();
    if modes.len() < count {
        let found = plural(modes.len(), "critical load");
        warnings.push(format!("the model has {found}, fewer than count = {count}"));
    }
    if let Some((k, mode)) = (1..).zip(&modes).find(|(_, mode)| mode.error > POOR) {
        warnings.push(format!(
            "critical load {k}, {}, is a poor estimate: the stiffness or the loads there differ by {:.0} % from those extrapolated, as \
             members bend or turn before they buckle, or loads do not grow in proportion. Find the point itself, with `record = [\"bifurcation\", \
             \"turning_point\"]` in `[analysis.arc_length]`, or extrapolate from a state nearer to it",
            significant(mode.load),
            100.0 * mode.error
        ));
    }
    Ok(CriticalLoads {
        modes,
        warnings,
        names: (0..context.pattern().dim())
            .map(|i| context.name(i))
            .collect(),
    })
}
