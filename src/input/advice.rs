//! Suggestions for refused model files.

use super::error::InputProblem;
use super::names::closest;
use pullback_elements::beam::SectionError;

fn names(known: &[String]) -> String {
    const SHOWN: usize = 24;
    let mut shown: Vec<String> = known.iter().take(SHOWN).map(|k| format!("`{k}`")).collect();
    if known.len() > SHOWN {
        shown.push(format!("... ({} in all)", known.len()));
    }
    shown.join(", ")
}

/// Words of other programs, and the keys that mean the same here.
const SYNONYMS: &[(&str, &str)] = &[
    ("linear", "proportional"),
    ("frequency", "omega"),
    ("stiffness", "k"),
    ("k", "stiffness"),
    ("dt", "step"),
    ("gravity", "loads"),
    ("limit-point", "turning_point"),
    ("harmonic", "sine"),
    ("step", "pulse"),
    ("hinge", "revolute"),
    ("pinned", "position"),
    ("clamped", "all"),
    ("reaction", "reaction_force"),
    ("bending_moment", "M"),
    ("joint_angle", "joint_coordinate"),
    ("angle", "joint_coordinate"),
];

/// Keys of earlier versions and the present ones.
pub(super) const RENAMED: &[(&str, &str)] = &[
    ("master", "parent"),
    ("driven", "prescribed"),
    ("motor", "actuator"),
    ("place", "position"),
    ("centre", "center"),
    ("hat", "triangle"),
    ("run-up", "spin_up"),
    ("way", "displacement"),
    ("way 1", "displacement 1"),
    ("way 2", "displacement 2"),
    ("arc-length", "arc_length"),
    ("turning-point", "turning_point"),
    ("constant-velocity", "constant_velocity"),
    ("on-curve", "on_curve"),
    ("on-surface", "on_surface"),
];

/// Parts of parser messages and their explanations.
const EXPLANATIONS: &[(&str, &str)] = &[
    (
        "an array of length 3",
        "three numbers in brackets are expected, such as [X, Y, Z] of a position or [Fx, Fy, Fz] of a \
         force; decimals stand after a point",
    ),
    (
        "an array of length 2",
        "two numbers in brackets are expected, such as GA = [GA2, GA3] of a section or [t, value] of \
         a table",
    ),
    (
        "an array of length 6",
        "six numbers in brackets are expected: along and about the three axes, and six rows of them \
         in the matrix of a section",
    ),
    (
        "a whole number",
        "a whole number stands without quotes and point, such as 8",
    ),
    (
        "expected f64",
        "a number stands without quotes, its decimals after a point",
    ),
    (
        "exactly one key",
        "one at a time: one of static, arc_length, dynamic, modes, buckling and campbell for an analysis, one \
         function for a time",
    ),
];

/// Explanation of a parser message.
fn explanation(message: &str) -> Option<String> {
    let found = EXPLANATIONS.iter().find(|(part, _)| message.contains(part));
    found.map(|(_, explanation)| (*explanation).to_owned())
}

fn suggestion(found: &str, known: &[String]) -> String {
    let last = found.rsplit('.').next().unwrap_or(found);
    if let Some((word, now)) = RENAMED.iter().find(|(word, _)| *word == last) {
        return format!("`{word}` is now `{now}`");
    }
    if let Some(key) = found.strip_suffix("_deg")
        && known.iter().any(|known| known == key)
    {
        return format!("give `{key}`, in radians");
    }
    let known_as = SYNONYMS
        .iter()
        .find(|(word, ours)| *word == found && known.iter().any(|known| known == ours));
    let known_as = known_as.map(|(_, ours)| (*ours).to_owned());
    let near = known_as.or_else(|| closest(found, known.iter().map(String::as_str)));
    match near {
        _ if known.is_empty() => "none is defined".to_owned(),
        Some(near) => format!("did you mean `{near}`? There are: {}", names(known)),
        None => format!("there are: {}", names(known)),
    }
}

impl InputProblem {
    /// The suggestion for a refusal.
    pub fn advice(&self) -> Option<String> {
        match self {
            Self::UnknownKey { found, known }
            | Self::JointKey {
                key: found, known, ..
            }
            | Self::UnknownName {
                name: found, known, ..
            } => Some(suggestion(found, known)),
            Self::Parameter { found, known, .. } if !known.is_empty() => {
                Some(suggestion(found, known))
            }
            Self::Range { expected, .. } | Self::ProbeComponent { expected, .. } => {
                Some(format!("expected {expected}"))
            }
            Self::Toml(message) => explanation(message),
            Self::Components { expected, .. } => {
                explanation(&format!("an array of length {expected}"))
            }
            _ => self.advice_on_parts().map(str::to_owned),
        }
    }

    /// The suggestion for a part of the model or a load.
    fn advice_on_parts(&self) -> Option<&'static str> {
        Some(match self {
            Self::Section {
                source: SectionError::NotPositive { quantity, .. },
                ..
            } if quantity.contains("stiffness ") || quantity.contains("modulus") => {
                "give a number above zero; what is to be nearly rigid gets a large one"
            }
            Self::Section {
                source: SectionError::NotPositiveDefinite { .. },
                ..
            } => {
                "every strain must cost energy: give positive numbers on the diagonal, and couplings \
                 C(i,j) with C(i,j)² < C(i,i) C(j,j)"
            }
            Self::Section {
                source: SectionError::NotSymmetric { .. },
                ..
            } => "make the two entries equal",
            Self::LoadTarget { load: "force", .. } => {
                "on a line use force_per_length = [fx, fy, fz]; a force needs a node"
            }
            Self::Path { .. } => {
                "keys, numbers of entries from 0 and names, with points between them, such as loads.0.force.2"
            }
            Self::Empty => "describe at least [nodes] and [[lines]], [[bodies]] or [[springs]]",
            Self::Number { .. } => "numbers must be finite and below 1e100; choose other units",
            Self::Missing { what: "nodes" } => "add [nodes] with positions such as A = [0, 0, 0]",
            Self::Missing { .. } => "add at least one of [[lines]], [[bodies]], [[springs]]",
            Self::Duplicate { .. } => "give each its own name",
            Self::Name { what: "title", .. } => {
                "a title is one line of text: leave line breaks and other control characters out"
            }
            Self::Name { .. } => {
                "names must not be empty and must not contain `/`, `:`, quotes, commas or line \
                 breaks; `line/1` is the first inner node of a line, `line:1` its first element"
            }
            Self::SectionKind { .. } => {
                "give exactly one of stiffness, matrix, rectangle, circle, tube"
            }
            Self::NoMaterial { .. } => "add material = { E = ..., nu = ..., rho = ... }",
            Self::ZeroLength { .. } => "move one of the nodes",
            Self::UselessSupport { .. } => "add fix = \"all\" or prescribed = { rz = ... }",
            Self::PrescribedTwice { .. } => "remove it from one of the supports",
            Self::PrescribedEvent { .. } => "choose a free coordinate, or stop at a load",
            Self::FarEvent { .. } => "choose a displacement, or a load",
            Self::LoadKind { .. } => {
                "give exactly one of force, moment (on a node), force_per_length (on a line), \
                 gravity (on all lines, or one)"
            }
            Self::NoMass { .. } => "add mass = { A_rho = ... } or a material with rho",
            Self::SpringKind { .. } => {
                "give stiffness, damping (and rest_length), or bushing = { stiffness = [...] }"
            }
            Self::Cycle { .. } => "let at least one of them start at a node of [nodes]",
            _ => return self.advice_on_motion(),
        })
    }

    /// The suggestion for a probe, a loop or an initial condition.
    fn advice_on_motion(&self) -> Option<&'static str> {
        Some(match self {
            Self::NoReaction { .. } => {
                "probe a node that has a support, or the `joint_force` of a joint"
            }
            Self::ClosureKey { .. } => "add it, or remove this key",
            Self::NoJoint { .. } => "probe the node that bears the joint's name",
            Self::DynamicProbe { .. } => {
                "add [analysis.dynamic] or [analysis.modes], or remove the probe"
            }
            Self::InitialNode { .. } => "name the node",
            Self::InitialNothing => "add displacement, rotation, velocity or angular_velocity",
            Self::InitialHeld { .. } => {
                "remove it, free the node or its joint, or give a joint before it a `rate` or `value`"
            }
            Self::InitialAttached { .. } => {
                "give it to the joint's parent, or give the joint a `value` or `rate`; a ball joint takes rotations"
            }
            Self::Geared { .. } => "give it to the joint at the other end of the gear",
            Self::Column { .. } => "give the probe another name",
            Self::Jump => "use a ramp, triangle, table, sine or spin_up",
            Self::LoopRates { .. } => {
                "give as many rates as the loops leave free, the others follow"
            }
            Self::LoopLocked { .. } => {
                "remove it; if it should move, release something along the loop, or see whether axes \
                 and positions are given with all their digits"
            }
            Self::LoopMotion { .. } => {
                "give a joint there a `rate`, or the velocities to other nodes or lines"
            }
            Self::DrawnApart { .. } => {
                "draw both where they start, or give the nodes of the line [[initial]] entries with \
                 displacement and rotation"
            }
            Self::Equilibrium { .. } => {
                "let it begin nearer to an equilibrium, by the `value` of joints or the displacement and rotation of \
                 nodes in [[initial]], or remove this key: dampers let a motion come to rest"
            }
            Self::InitialStatics => {
                "add [analysis.dynamic] (for modes [analysis.modes.after.dynamic]), or remove [[initial]], and `value` and `rate` of joints"
            }
            _ => return None,
        })
    }
}
