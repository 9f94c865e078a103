//! The modes or critical loads at the end of a run: tables, figures, and ParaView files of their vibration.

use super::Recorder;
use crate::input::Geometry;
use crate::modes::{CriticalLoads, Eigenvalues, ModelModes};
use crate::output::directory::{OutputError, drawing};
use crate::output::plot::{self, Shapes};
use crate::output::vtu::{VtuFrame, collection, grid};
use crate::probe::Answers;
use nalgebra::Vector3;
use num_complex::Complex64;
use pullback_elements::model::Context;
use pullback_integrators::significant;
use pullback_manifold::system::{Point, Quantity, System};
use serde_json::json;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Columns of `modes.csv`.
const COLUMNS: &str = "mode,frequency,damping_ratio,re,im,residual,\
                       participation_x,participation_y,participation_z,\
                       effective_mass_x,effective_mass_y,effective_mass_z\n";
/// Modes that are drawn.
const DRAWN: usize = 24;
/// ParaView files of a period.
const PHASES: usize = 12;
/// Largest displacement of a mode as drawn, relative to the extent of the model.
const AMPLITUDE: f64 = 0.1;
/// Largest angle of a mode as drawn, in radians.
const LARGEST_ANGLE: f64 = 0.5;

impl Recorder<'_> {
    /// Writes modes or critical loads at a state; the model is left in another configuration.
    pub fn write_eigenvalues(
        &mut self,
        context: &mut Context,
        at: Point<'_>,
        found: &Eigenvalues,
    ) -> Result<(), OutputError> {
        let warnings = &mut self.recording.seen.warnings;
        warnings.extend_from_slice(found.warnings());
        match found {
            Eigenvalues::Modes(modes) => self.write_modes(context, at, modes),
            Eigenvalues::Campbell(found) => {
                self.write_campbell(found)?;
                let at = Point { q: &found.q, ..at };
                self.write_modes(context, at, &found.last)
            }
            Eigenvalues::Critical(loads) => self.write_critical_loads(context, at, loads),
        }
    }

    fn write_critical_loads(
        &mut self,
        context: &mut Context,
        at: Point<'_>,
        loads: &CriticalLoads,
    ) -> Result<(), OutputError> {
        let mut csv = "mode,load,error\n".to_owned();
        for (k, mode) in loads.modes.iter().enumerate() {
            csv += &format!("{},{:?},{:?}\n", k + 1, mode.load, mode.error);
        }
        self.directory.write("buckling.csv", &csv)?;
        let entries = loads.modes.iter().map(|mode| {
            json!({
                "load": mode.load,
                "error": mode.error,
                "shape": mode.shape,
                "nodes": node_offsets(context, at, &mode.shape),
            })
        });
        let all = json!({
            "coordinates": loads.names,
            "modes": entries.collect::<Vec<_>>(),
        });
        self.directory.write_json("buckling.json", &all)?;
        for (k, mode) in loads.modes.iter().enumerate().take(DRAWN) {
            let title = format!("buckling at load parameter {}", significant(mode.load));
            let shape: Vec<Complex64> = mode.shape.iter().map(|x| Complex64::from(*x)).collect();
            self.draw(context, at, (k + 1, &title), &shape)?;
        }
        Ok(())
    }

    /// Writes the modes about a state.
    fn write_modes(
        &mut self,
        context: &mut Context,
        at: Point<'_>,
        modes: &ModelModes,
    ) -> Result<(), OutputError> {
        let mut csv = COLUMNS.to_owned();
        for (k, mode) in modes.modes.iter().enumerate() {
            let m = &mode.mode;
            csv += &format!("{},{:?},{:?}", k + 1, m.frequency(), m.damping_ratio());
            let numbers = [m.eigenvalue.re, m.eigenvalue.im, m.residual];
            let shares = mode.participation.map(|gamma| gamma.re);
            for x in numbers
                .into_iter()
                .chain(shares)
                .chain(mode.effective_mass())
            {
                csv += &format!(",{x:?}");
            }
            csv.push('\n');
        }
        self.directory.write("modes.csv", &csv)?;
        let entries = modes.modes.iter().map(|m| {
            let shape = parts(&m.mode.shape);
            json!({
                "nodes": node_offsets(context, at, &shape[0]),
                "frequency": m.mode.frequency(),
                "damping_ratio": m.mode.damping_ratio(),
                "eigenvalue": [m.mode.eigenvalue.re, m.mode.eigenvalue.im],
                "residual": m.mode.residual,
                "participation": m.participation.map(|x| [x.re, x.im]),
                "effective_mass": m.effective_mass(),
                "shape": shape,
            })
        });
        let all = json!({
            "counted": modes.counted,
            "coordinates": modes.names,
            "modes": entries.collect::<Vec<_>>(),
        });
        self.directory.write_json("modes.json", &all)?;
        for (k, mode) in modes.modes.iter().enumerate().take(DRAWN) {
            let title = format!(
                "mode {}, frequency {}, damping ratio {}",
                k + 1,
                significant(mode.mode.frequency()),
                significant(mode.mode.damping_ratio())
            );
            self.draw(context, at, (k + 1, &title), &mode.mode.shape)?;
        }
        Ok(())
    }

    /// A figure of a shape, and a period of its vibration; nothing where it leaves the domain of a joint.
    fn draw(
        &mut self,
        context: &mut Context,
        at: Point<'_>,
        (number, title): (usize, &str),
        shape: &[Complex64],
    ) -> Result<(), OutputError> {
        let geometry = self.setting.geometry;
        let Some(scale) = drawn_scale(context, geometry, at, shape) else {
            return Ok(());
        };
        let (output, units) = (&self.setting.file.output, &self.setting.file.units);
        let factor = |phase: f64| Complex64::from_polar(scale, phase);
        let Some(displaced) = displace(context, at, shape, factor(0.0)) else {
            return Ok(());
        };
        let shapes = [(0.0, Shapes::of(displaced, geometry, 1.0))];
        let mut frames = Vec::new();
        if output.paraview_every != Some(0) {
            for k in 0..PHASES {
                let phase = TAU * k as f64 / PHASES as f64;
                let Some(context) = displace(context, at, shape, factor(phase)) else {
                    return Ok(());
                };
                let file = format!("mode_{number:02}_{k:02}.vtu");
                let text = grid(context, geometry, &Answers::of(context, at.t), None);
                self.directory.write(&file, &text)?;
                frames.push(VtuFrame {
                    t: k as f64 / PHASES as f64,
                    file,
                });
            }
            self.directory
                .write(&format!("mode_{number:02}.pvd"), &collection(&frames))?;
        }
        if !output.figures.is_none() && displace(context, at, shape, Complex64::ZERO).is_some() {
            let state = Shapes::of(context, geometry, 1.0);
            let name = format!("mode_{number:02}");
            let figure =
                plot::deformed(Some(title), units, &state, &shapes, Some(["state", "mode"]));
            self.write_figure(&name, &figure.map_err(drawing(&name))?)?;
        }
        Ok(())
    }
}

/// Real and imaginary parts of a shape.
pub(super) fn parts(shape: &[Complex64]) -> [Vec<f64>; 2] {
    let part = |pick: fn(&Complex64) -> f64| shape.iter().map(pick).collect();
    [part(|x| x.re), part(|x| x.im)]
}

/// Displacement and rotation of each frame by a shape, in linear approximation; nothing where they are undefined.
fn node_offsets(
    context: &mut Context,
    at: Point<'_>,
    shape: &[f64],
) -> Option<BTreeMap<String, [[f64; 3]; 2]>> {
    let zero = vec![0.0; shape.len()];
    // The velocities with q̇ = φ less those of prescribed motion.
    let mut rates = |v: &[f64]| {
        let point = Point { v, a: &zero, ..at };
        context.configure(point).ok()?;
        let frames = context.frames();
        let rates = frames.map(|(id, name)| {
            let state = context.node_state(id);
            (name.to_owned(), [state.velocity, state.omega])
        });
        Some(rates.collect::<BTreeMap<_, _>>())
    };
    let (moved, mut still) = (rates(shape)?, rates(&zero)?);
    let offset = |(name, [d, theta]): (String, [Vector3<f64>; 2])| {
        let [d_0, theta_0] = still.remove(&name)?;
        Some((name, [(d - d_0).into(), (theta - theta_0).into()]))
    };
    moved.into_iter().map(offset).collect()
}

/// The factor of a shape with which its displacements are a tenth of the model, and its angles moderate.
fn drawn_scale(
    context: &mut Context,
    geometry: &Geometry,
    at: Point<'_>,
    shape: &[Complex64],
) -> Option<f64> {
    let largest = |pick: &dyn Fn(usize) -> bool| {
        let chosen = shape.iter().enumerate().filter(|(i, _)| pick(*i));
        chosen.map(|(_, x)| x.norm()).fold(0.0, f64::max)
    };
    let angle = largest(&|i| context.pattern().coordinates()[i].quantity == Quantity::Angle);
    let small = 1e-6 / largest(&|_| true);
    let state = Shapes::of(
        displace(context, at, shape, Complex64::ZERO)?,
        geometry,
        1.0,
    );
    let moved = [Complex64::from(small), Complex64::new(0.0, small)].map(|factor| {
        let context = displace(context, at, shape, factor)?;
        Some(Shapes::of(context, geometry, 1.0).distance(&state) / small)
    });
    let rate = moved.into_iter().flatten().fold(0.0, f64::max);
    let scale = (AMPLITUDE * state.extent() / rate).min(LARGEST_ANGLE / angle);
    Some(scale).filter(|scale| scale.is_finite() && *scale > 0.0)
}

/// The model displaced from its state by the real part of a shape times a factor.
fn displace<'a>(
    context: &'a mut Context,
    at: Point<'_>,
    shape: &[Complex64],
    factor: Complex64,
) -> Option<&'a Context> {
    let moved = |(q, x): (&f64, &Complex64)| q + (x * factor).re;
    let q: Vec<f64> = at.q.iter().zip(shape).map(moved).collect();
    context.configure(Point::statics(at.t, &q)).ok()?;
    Some(context)
}
