//! The results at the end of a run: figures and `result.json`.

use super::Recorder;
use crate::output::directory::{Directory, OutputError, drawing};
use crate::output::panels::panels;
use crate::output::plot::{self, Shapes};
use crate::output::results::{Ending, NAME, Results};
use crate::solve::Counts;
use crate::warnings::unbalanced;

impl Recorder<'_> {
    pub(super) fn write_results(&mut self, ending: &Ending) -> Result<(), OutputError> {
        let mut warnings = self.warnings(ending);
        warnings.extend(unbalanced(&self.statistics.counts).map(str::to_owned));
        self.statistics.seconds = self.seconds();
        self.statistics.largest_rotation = self.record.largest_rotation;
        let files = self.directory.files().to_vec();
        let results = Results {
            program: concat!("pullback ", env!("CARGO_PKG_VERSION")),
            model: self.setting.source,
            title: self.setting.file.title.as_deref(),
            complete: *ending == Ending::Complete,
            ending,
            settings: self.setting.file,
            statistics: self.statistics,
            notes: self.setting.notes,
            warnings: &warnings,
            last: self.last.as_ref(),
            files: &files,
        };
        self.directory.write_json(NAME, &results)
    }

    /// Title of a figure, which says whether the run is incomplete, and for shapes whether displacements are scaled.
    fn figure_title(&self, ending: &Ending, shape: bool) -> Option<String> {
        let mut words: Vec<String> = self.setting.file.title.iter().cloned().collect();
        let scale = self.setting.output.deformation_scale;
        if shape && scale != 1.0 {
            words.push(format!("displacements × {scale}"));
        }
        if *ending != Ending::Complete {
            words.push("incomplete".to_owned());
        }
        (!words.is_empty()).then(|| words.join(", "))
    }

    /// Writes all results at the end of a run; `result.json` comes last.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn finish(mut self, ending: &Ending, counts: Counts) -> Result<Directory, OutputError> {
        self.statistics.counts = counts;
        self.write_pending()?;
        self.write_history()?;
        if self.setting.output.figures && !self.rows.is_empty() {
            let title = self.figure_title(ending, false);
            let shape_title = self.figure_title(ending, true);
            self.record.shapes.extend(self.record.latest.take());
            let shape =
                plot::deformed(shape_title.as_deref(), &self.reference, &self.record.shapes);
            let shape = shape.map_err(drawing("deformed.svg"))?;
            self.directory.write("deformed.svg", &shape)?;
            let shapes = self.record.shapes.iter().map(|(_, shapes)| shapes);
            let extents = shapes.chain([&self.reference]).map(Shapes::extent);
            let length = extents.fold(0.0, f64::max);
            let panels = panels(self.setting.plan, &self.probes, &self.rows, length);
            let history = plot::panels(title.as_deref(), &panels);
            let history = history.map_err(drawing("history.svg"))?;
            self.directory.write("history.svg", &history)?;
        }
        self.write_results(ending)?;
        Ok(self.directory)
    }
}
