//! The results at the end of a run: figures and `result.json`.

use super::Recorder;
use crate::input::FigureFormat;
use crate::output::directory::{Directory, OutputError, drawing, encoding};
use crate::output::panels::panels;
use crate::output::plot::{self, Shapes};
use crate::output::results::{Ending, NAME, PROGRAM, Results};
use crate::solve::Counts;
use serde::ser::Error;

impl Recorder<'_> {
    /// Writes `result.json`; returns its warnings.
    pub(super) fn write_results(&mut self, ending: &Ending) -> Result<Vec<String>, OutputError> {
        let warnings = self.recording.warnings(ending);
        self.statistics.counts = self.recording.counts;
        self.statistics.seconds = self.seconds();
        self.statistics.largest_rotation = self.recording.seen.largest_rotation;
        let files = self.directory.files().to_vec();
        // TOML has no null: keys that are absent stay absent.
        let settings = toml::Table::try_from(self.setting.file).map_err(Error::custom);
        let results = Results {
            program: PROGRAM,
            model: self.setting.source,
            title: self.setting.file.title.as_deref(),
            complete: *ending == Ending::Complete,
            ending,
            settings: settings.map_err(encoding(NAME))?,
            statistics: self.statistics,
            notes: self.setting.notes,
            warnings: &warnings,
            last: self.last.as_ref(),
            files: &files,
        };
        self.directory.write_json(NAME, &results)?;
        Ok(warnings)
    }

    /// Title of a figure, which says whether the run is incomplete, and for shapes whether displacements are scaled.
    fn figure_title(&self, ending: &Ending, shape: bool) -> Option<String> {
        let mut words: Vec<String> = self.setting.file.title.iter().cloned().collect();
        let scale = self.setting.file.output.deformation_scale;
        if shape && scale != 1.0 {
            words.push(format!("displacements × {scale}"));
        }
        if *ending != Ending::Complete {
            words.push("incomplete".to_owned());
        }
        (!words.is_empty()).then(|| words.join(", "))
    }

    fn write_figures(&mut self, ending: &Ending) -> Result<(), OutputError> {
        self.record.shapes.extend(self.record.latest.take());
        let title = self.figure_title(ending, true);
        let units = &self.setting.file.units;
        let (reference, shapes) = (&self.reference, &self.record.shapes);
        let shape = plot::deformed(title.as_deref(), units, reference, shapes, None);
        let shape = shape.map_err(drawing("deformed.svg"))?;
        self.write_figure("deformed", &shape)?;
        let (reference, shapes) = (&self.reference, &self.record.shapes);
        if self.setting.file.output.figures.include(FigureFormat::Html) {
            let parameter = self.setting.plan.parameter();
            let page = plot::viewer(title.as_deref(), units, parameter, reference, shapes);
            self.directory.write("deformed.html", &page)?;
        }
        let shapes = self.record.shapes.iter().map(|(_, shapes)| shapes);
        let extents = shapes.chain([&self.reference]).map(Shapes::extent);
        let length = extents.fold(0.0, f64::max);
        let title = self.figure_title(ending, false);
        let panels = panels(
            self.setting.plan,
            units,
            &self.recording.probes,
            &self.recording.rows,
            length,
        );
        let history = plot::panels(title.as_deref(), &panels).map_err(drawing("history.svg"))?;
        self.write_figure("history", &history)
    }

    /// Writes a figure in the formats of the model file.
    pub(super) fn write_figure(&mut self, name: &str, svg: &str) -> Result<(), OutputError> {
        let figures = &self.setting.file.output.figures;
        if figures.include(FigureFormat::Svg) {
            self.directory.write(&format!("{name}.svg"), svg)?;
        }
        if figures.include(FigureFormat::Png) {
            let name = format!("{name}.png");
            let png = plot::png(svg).map_err(drawing(&name))?;
            self.directory.write(&name, &png)?;
        }
        if figures.include(FigureFormat::Pdf) {
            let name = format!("{name}.pdf");
            let pdf = plot::pdf(svg).map_err(drawing(&name))?;
            self.directory.write(&name, &pdf)?;
        }
        Ok(())
    }

    /// Writes all results at the end of a run, `result.json` last; returns their directory and the warnings.
    pub fn finish(
        mut self,
        ending: &Ending,
        counts: Counts,
    ) -> Result<(Directory, Vec<String>), OutputError> {
        self.recording.counts = counts;
        self.write_pending()?;
        self.write_history()?;
        if !self.setting.file.output.figures.is_none() && !self.recording.rows.is_empty() {
            self.write_figures(ending)?;
        }
        let warnings = self.write_results(ending)?;
        Ok((self.directory, warnings))
    }
}
