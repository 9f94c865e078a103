//! Records converged steps and writes what they give.

use super::directory::{Directory, OutputError};
use super::history::{Row, csv};
use super::plot::{self, Curve, Panel, Shapes};
use super::results::{Ending, FinalState, NAME, NodeResult, ReactionResult, Results, Statistics};
use super::vtu::{Frame, collection, grid};
use crate::input::{Geometry, ModelFile, Output, Plan};
use crate::probe::{Answers, Probe};
use pullback_elements::model::Model;
use pullback_integrators::statics::Step;
use pullback_manifold::system::{Evaluation, Point, System};
use std::time::{Duration, Instant};

/// Time between two checkpoints of history and results.
const CHECKPOINT: Duration = Duration::from_secs(5);

/// Shapes kept for the figure of the deformed structure.
const SHAPES: usize = 64;

/// What does not change while an analysis runs.
pub struct Setting<'a> {
    /// The model file's path, as it is shown.
    pub source: &'a str,
    /// The file with defaults.
    pub file: &'a ModelFile,
    /// What is computed.
    pub plan: &'a Plan,
    /// Where the lines are.
    pub geometry: &'a Geometry,
    /// What is written.
    pub output: Output,
}

/// Collects steps and writes files.
pub struct Recorder<'a> {
    setting: Setting<'a>,
    directory: Directory,
    probes: Vec<Probe>,
    rows: Vec<Row>,
    frames: Vec<Frame>,
    reference: Shapes,
    /// Shapes on the way, thinned out as they grow many.
    shapes: Vec<(f64, Shapes)>,
    /// The shape of the last row, where it is not among them.
    latest: Option<(f64, Shapes)>,
    /// Every how many rows a shape is kept.
    stride: usize,
    last: Option<FinalState>,
    /// The grid of the last row, where it has not been written.
    pending: Option<(Frame, String)>,
    statistics: Statistics,
    started: Instant,
    checkpoint: Instant,
}

impl<'a> Recorder<'a> {
    /// Opens the directory and marks it as the place of a run that has not ended.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn new(
        setting: Setting<'a>,
        directory: Directory,
        probes: Vec<Probe>,
        model: &Model,
    ) -> Result<Self, OutputError> {
        let elements = setting
            .geometry
            .lines
            .iter()
            .map(|l| l.elements.len())
            .sum();
        let statistics = Statistics {
            nodes: model.frames().count(),
            elements,
            unknowns: model.pattern().dim(),
            symmetric: model.is_symmetric(),
            ..Statistics::default()
        };
        let now = Instant::now();
        let mut recorder = Self {
            reference: Shapes::of(model, setting.geometry, true),
            setting,
            directory,
            probes,
            rows: Vec::new(),
            frames: Vec::new(),
            shapes: Vec::new(),
            latest: None,
            stride: 1,
            last: None,
            pending: None,
            statistics,
            started: now,
            checkpoint: now,
        };
        recorder.write_results(&Ending::Running)?;
        Ok(recorder)
    }

    /// Records the reference configuration where it is in equilibrium at the first load.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn start(&mut self, model: &mut Model) -> Result<(), OutputError> {
        let n = model.pattern().dim();
        let (q, t) = (vec![0.0; n], self.setting.plan.start());
        let mut r = vec![0.0; n];
        let at = Point {
            t,
            q: &q,
            v: &[],
            a: &[],
        };
        let evaluated = model.evaluate(at, Evaluation::residual(&mut r));
        if evaluated.is_err() || r.iter().any(|r| *r != 0.0) {
            return Ok(());
        }
        let row = Row {
            t,
            ..Row::default()
        };
        self.add(model, row)
    }

    /// Records a converged step, with the model in its configuration.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn record(&mut self, model: &Model, step: &Step<'_>) -> Result<(), OutputError> {
        let event = match (self.setting.plan, step.event) {
            (Plan::Path(_, names), Some(k)) => names.get(k).cloned(),
            _ => None,
        };
        let end = step.residuals.last();
        let before = step.residuals.len().checked_sub(2);
        let correction = before.map_or(0.0, |k| {
            let i = &step.residuals[k];
            i.correction * i.damping
        });
        let [force, moment, _] = end.map_or([0.0; 3], |i| i.residual);
        let row = Row {
            step: step.number,
            t: step.t,
            step_size: step.step_size,
            iterations: step.iterations,
            residual: [force, moment],
            ratio: end.map_or(0.0, |i| i.ratio),
            correction,
            // A located event repeats the changes of the step it lies in.
            chart_changes: if event.is_some() {
                0
            } else {
                step.chart_changes
            },
            event,
            ..Row::default()
        };
        self.add(model, row)?;
        if self.checkpoint.elapsed() > CHECKPOINT {
            self.write_history()?;
            self.write_results(&Ending::Running)?;
            self.checkpoint = Instant::now();
        }
        Ok(())
    }

    fn add(&mut self, model: &Model, mut row: Row) -> Result<(), OutputError> {
        let answers = Answers::of(model, row.t);
        row.largest_rotation = model.largest_rotation();
        row.strain_energy = answers.strain_energy();
        for probe in &mut self.probes {
            probe.record(model, &answers, &mut row.probes);
        }
        if row.event.is_none() && row.step > 0 {
            self.statistics.steps += 1;
            self.statistics.iterations += row.iterations;
            self.statistics.chart_changes += row.chart_changes;
        }
        self.last = Some(final_state(model, &answers, row.t));
        let number = self.rows.len();
        let shape = (row.t, Shapes::of(model, self.setting.geometry, false));
        if number.is_multiple_of(self.stride) {
            self.latest = None;
            self.keep(shape);
        } else {
            self.latest = Some(shape);
        }
        let every = self.setting.output.paraview_every;
        if every > 0 {
            let frame = Frame {
                t: row.t,
                file: format!("step_{number:04}.vtu"),
            };
            let text = grid(model, self.setting.geometry, &answers);
            self.pending = Some((frame, text));
            if number.is_multiple_of(every) {
                self.write_pending()?;
            }
        }
        self.rows.push(row);
        Ok(())
    }

    /// Keeps a shape; when there are too many, every second one goes. The limit is even, so the
    /// last one stays.
    fn keep(&mut self, shape: (f64, Shapes)) {
        self.shapes.push(shape);
        if self.shapes.len() > SHAPES {
            let all = std::mem::take(&mut self.shapes);
            self.shapes = all.into_iter().step_by(2).collect();
            self.stride *= 2;
        }
    }

    fn write_pending(&mut self) -> Result<(), OutputError> {
        if let Some((frame, text)) = self.pending.take() {
            self.directory.write(&frame.file, &text)?;
            self.frames.push(frame);
            self.directory
                .write("steps.pvd", &collection(&self.frames))?;
        }
        Ok(())
    }

    fn columns(&self) -> Vec<String> {
        self.probes.iter().flat_map(Probe::columns).collect()
    }

    fn write_history(&mut self) -> Result<(), OutputError> {
        let text = csv(&self.columns(), &self.rows);
        self.directory.write("history.csv", &text)
    }

    fn write_results(&mut self, ending: &Ending) -> Result<(), OutputError> {
        self.statistics.seconds = self.started.elapsed().as_secs_f64();
        let results = Results {
            program: concat!("pullback ", env!("CARGO_PKG_VERSION")),
            model: self.setting.source,
            title: self.setting.file.title.as_deref(),
            complete: *ending == Ending::Complete,
            ending,
            settings: self.setting.file,
            statistics: self.statistics,
            last: self.last.as_ref(),
            files: self.directory.files(),
        };
        let text = serde_json::to_string_pretty(&results).map_err(|source| {
            let name = NAME.to_owned();
            OutputError::Encode { name, source }
        })?;
        self.directory.write(NAME, &(text + "\n"))
    }

    /// Rows so far.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Writes everything that a run ends with; `result.json` comes last.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn finish(
        mut self,
        ending: &Ending,
        summary: Option<&pullback_integrators::statics::Summary>,
    ) -> Result<Directory, OutputError> {
        if let Some(s) = summary {
            self.statistics.rejected = Some(s.rejected);
            self.statistics.factorisations = Some(s.factorisations);
            self.statistics.evaluations = Some(s.evaluations);
        }
        self.write_pending()?;
        self.write_history()?;
        if self.setting.output.figures && !self.rows.is_empty() {
            let title = self.setting.file.title.as_deref();
            let draw = |name: &str, drawn: Result<String, plot::PlotError>| {
                drawn.map_err(|source| OutputError::Draw {
                    name: name.to_owned(),
                    source,
                })
            };
            self.shapes.extend(self.latest.take());
            let shape = plot::deformed(title, &self.reference, &self.shapes);
            let shape = draw("deformed.svg", shape)?;
            self.directory.write("deformed.svg", &shape)?;
            let history = draw("history.svg", plot::panels(title, &self.panels()))?;
            self.directory.write("history.svg", &history)?;
        }
        self.write_results(ending)?;
        Ok(self.directory)
    }

    /// One panel per quantity, in the order of the probes; the strain energy where there are none.
    fn panels(&self) -> Vec<Panel> {
        // A path turns back in the load: its custom is to have the load upright.
        let upright = matches!(self.setting.plan, Plan::Path(..));
        let mut panels: Vec<(crate::input::Quantity, Vec<Curve>)> = Vec::new();
        let mut column = 0;
        for probe in &self.probes {
            for label in probe.columns() {
                let points = self.rows.iter().map(|row| {
                    let value = row.probes[column];
                    if upright {
                        (value, row.t)
                    } else {
                        (row.t, value)
                    }
                });
                let curve = Curve::new(label, points.collect());
                let quantity = probe.quantity();
                match panels.iter_mut().find(|(q, _)| *q == quantity) {
                    Some((_, curves)) => curves.push(curve),
                    None => panels.push((quantity, vec![curve])),
                }
                column += 1;
            }
        }
        if panels.is_empty() {
            let points = self.rows.iter().map(|row| {
                if upright {
                    (row.strain_energy, row.t)
                } else {
                    (row.t, row.strain_energy)
                }
            });
            let curve = Curve::new("strain energy", points.collect());
            panels.push((crate::input::Quantity::strain_energy, vec![curve]));
        }
        panels
            .into_iter()
            .map(|(quantity, curves)| {
                let (load, value) = ("load parameter t".to_owned(), quantity.axis().to_owned());
                let (x, y) = if upright {
                    (value, load)
                } else {
                    (load, value)
                };
                Panel { x, y, curves }
            })
            .collect()
    }
}

fn final_state(model: &Model, answers: &Answers, t: f64) -> FinalState {
    let nodes = model.frames().map(|(id, name)| {
        let state = model.node_state(id);
        let result = NodeResult {
            displacement: state.d.into(),
            rotation: state.psi.into(),
            place: state.place.into(),
        };
        (name.to_owned(), result)
    });
    let reactions = answers.reactions().iter().map(|r| {
        let result = ReactionResult {
            force: r.force.into(),
            moment: r.moment.into(),
        };
        (r.node.clone(), result)
    });
    FinalState {
        t,
        nodes: nodes.collect(),
        reactions: reactions.collect(),
        strain_energy: answers.strain_energy(),
        load_potential: model.load_potential(t),
    }
}
