//! An exact solution instead of a reference: a function of time, or a file.

use super::CompareError;
use super::reference::{Reference, exactly_conserved};
use super::sample::{ErrorQuantity, QUANTITIES, Sample, Values, sizes};
use nalgebra::{Matrix3, Vector3};
use pullback_manifold::so3;
use std::fmt;
use std::path::Path;
use std::sync::Arc;

/// Round-off of a quantity over its largest size.
const ROUND_OFF: f64 = 1e-14;

/// A known trajectory of the frame nodes.
///
/// The function takes a sample with all frame nodes in the order of their definition, filled with NaN, and
/// writes the known values; errors are measured of these alone.
#[derive(Clone)]
pub struct Exact {
    name: String,
    at: Arc<Trajectory>,
}

type Trajectory = dyn Fn(&mut Sample) + Send + Sync;

impl fmt::Debug for Exact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Exact({})", self.name)
    }
}

impl Exact {
    /// A trajectory from a function that fills a sample at its time.
    pub fn new(name: impl Into<String>, at: impl Fn(&mut Sample) + Send + Sync + 'static) -> Self {
        Self {
            name: name.into(),
            at: Arc::new(at),
        }
    }

    /// Writes the known values at the time of a sample into it.
    pub fn fill(&self, sample: &mut Sample) {
        (self.at)(sample);
    }

    /// The trajectory as a reference at the times of a comparison.
    pub(super) fn reference(&self, times: &[f64], nodes: usize) -> Reference {
        let samples = times.iter().map(|&t| {
            let mut sample = Sample::unknown(t, nodes);
            self.fill(&mut sample);
            sample
        });
        let samples: Vec<Sample> = samples.collect();
        let size = sizes(&samples);
        let error = Values(size.0.map(|size| ROUND_OFF * size));
        Reference {
            scheme: self.name.clone(),
            steps: [0.0; 3],
            order: Values([f64::NAN; QUANTITIES]),
            extrapolated: Values([false; QUANTITIES]),
            error,
            conserved: exactly_conserved(&samples),
            evaluations: 0,
            chart_changes: 0,
            samples,
        }
    }
}

/// The value in a column of a file of exact values.
#[derive(Clone, Copy, PartialEq)]
enum Column {
    Time,
    Energy,
    /// Node, quantity (in the order of [`ErrorQuantity::ALL`]), component.
    Node(usize, usize, usize),
}

/// Reads exact values from a CSV file: a column `t`, optionally `energy`, and columns
/// `NODE.position.x`, `NODE.rotation.y` (rotation vector from the reference orientation), `NODE.velocity.z`,
/// `NODE.angular_velocity.x`, `NODE.acceleration.x`, `NODE.angular_acceleration.x`, the three components of each. Rows are
/// required at the times of the comparison; others are ignored.
///
/// # Errors
/// [`CompareError::Exact`] with the position in the file.
pub fn read(path: &Path, nodes: &[String], times: &[f64]) -> Result<Exact, CompareError> {
    let text = std::fs::read_to_string(path).map_err(|error| error.to_string());
    let samples = text.and_then(|text| samples(&text, nodes, times));
    let samples = samples.map_err(|problem| CompareError::Exact {
        path: path.to_owned(),
        problem,
    })?;
    let name = format!("exact, {}", path.display());
    Ok(Exact::new(name, move |out| {
        let known = samples.iter().find(|known| known.t == out.t);
        known.into_iter().for_each(|known| *out = known.clone());
    }))
}

/// The samples of a file at the times of a comparison.
fn samples(text: &str, nodes: &[String], times: &[f64]) -> Result<Vec<Sample>, String> {
    let mut lines = text.lines().zip(1..);
    let (head, _) = lines.next().ok_or("it is empty")?;
    let columns = columns(head, nodes)?;
    let Some(of_time) = columns.iter().position(|c| *c == Column::Time) else {
        return Err("it has no column `t`".to_owned());
    };
    if columns.len() == 1 {
        return Err("nothing is known in it but times".to_owned());
    }
    let rows = lines.filter(|(line, _)| !line.trim().is_empty());
    let rows = rows.map(|(line, number)| row(line, number, columns.len()));
    let rows = rows.collect::<Result<Vec<_>, _>>()?;
    let near = 1e-9 * times.last().copied().unwrap_or(1.0);
    let mut samples = Vec::with_capacity(times.len());
    for (k, &t) in times.iter().enumerate() {
        let mut at = rows.iter().filter(|row| (row[of_time] - t).abs() <= near);
        let Some(row) = at.next() else {
            let (n, to) = (times.len() - 1, times.last().copied().unwrap_or(0.0));
            return Err(format!(
                "there is no row for t = {t}; the comparison looks at the times k * {to}/{n}, k = 0 to \
                 {n} (this is k = {k})"
            ));
        };
        if at.any(|other| other[..] != row[..] && other[of_time] == row[of_time]) {
            return Err(format!("rows for t = {t} contradict each other"));
        }
        samples.push(sample(t, row, &columns, nodes.len()));
    }
    Ok(samples)
}

fn columns(head: &str, nodes: &[String]) -> Result<Vec<Column>, String> {
    // Skips a byte order mark.
    let head = head.trim_start_matches('\u{feff}');
    let names: Vec<&str> = head.split(',').map(str::trim).collect();
    let mut known = names.iter().enumerate();
    if let Some((_, name)) = known.find(|(k, name)| names[..*k].contains(name)) {
        return Err(format!("column `{name}` is there twice"));
    }
    names.iter().map(|name| column(name, nodes)).collect()
}

/// The numbers of a row.
fn row(line: &str, number: usize, columns: usize) -> Result<Vec<f64>, String> {
    let cells = line.split(',').map(|cell| {
        let x = cell.trim().parse().ok().filter(|x: &f64| x.is_finite());
        x.ok_or_else(|| format!("line {number}: `{}` is not a number", cell.trim()))
    });
    let cells = cells.collect::<Result<Vec<_>, _>>()?;
    match cells.len() {
        found if found == columns => Ok(cells),
        found => Err(format!("line {number}: {found} cells, not {columns}")),
    }
}

fn column(name: &str, nodes: &[String]) -> Result<Column, String> {
    match name {
        "t" => return Ok(Column::Time),
        "energy" => return Ok(Column::Energy),
        _ => {}
    }
    let quantities = ErrorQuantity::ALL[..6].iter().map(|of| of.key());
    let quantities: Vec<String> = quantities.collect();
    let mut parts = name.rsplitn(3, '.');
    let (component, field, node) = (parts.next(), parts.next(), parts.next());
    let component = component.and_then(|c| ["x", "y", "z"].iter().position(|k| *k == c));
    let field = field.and_then(|f| quantities.iter().position(|k| k == f));
    let (Some(component), Some(field), Some(node)) = (component, field, node) else {
        return Err(format!(
            "column `{name}` is not one of t, energy, NODE.{}.x (or y, z)",
            quantities.join(".x, NODE.")
        ));
    };
    match nodes.iter().position(|known| known == node) {
        Some(node) => Ok(Column::Node(node, field, component)),
        None => Err(format!(
            "column `{name}`: the model has no node `{node}`, but {}",
            nodes.join(", ")
        )),
    }
}

fn sample(t: f64, row: &[f64], columns: &[Column], nodes: usize) -> Sample {
    let mut out = Sample::unknown(t, nodes);
    let mut turns = vec![Vector3::repeat(f64::NAN); nodes];
    for (value, column) in row.iter().zip(columns) {
        match *column {
            Column::Time => {}
            Column::Energy => {
                out.energy = *value;
                out.gross_energy = value.abs();
            }
            Column::Node(node, field, k) => {
                let (n, turn) = (&mut out.nodes[node], &mut turns[node]);
                let fields = [
                    &mut n.position,
                    turn,
                    &mut n.velocity,
                    &mut n.omega,
                    &mut n.acceleration,
                    &mut n.omega_dot,
                ];
                fields[field][k] = *value;
            }
        }
    }
    for (node, turn) in out.nodes.iter_mut().zip(turns) {
        node.R = match turn.iter().all(|x| x.is_finite()) {
            true => so3::rotation(&turn),
            false => Matrix3::repeat(f64::NAN),
        };
    }
    out
}
