//! A smooth curve through given points.

use crate::joint::Curve;
use nalgebra::Vector3;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::system::Quantity;

/// Error of a spline.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "each message says what its variant is")]
#[non_exhaustive]
pub enum SplineError {
    #[error("its curve needs {needs} points at least, got {got}")]
    Few { needs: usize, got: usize },
    #[error(
        "point {number} of its curve must be finite and apart from the one before; a closed curve goes on from its last \
         point to the first, which is not repeated"
    )]
    Point {
        /// Number of the point, from 1; of a closed curve one more for the last piece, back to the first.
        number: usize,
    },
    #[error("its points are too unevenly spaced for a smooth curve")]
    Uneven,
    #[error(
        "it must start between 0 and {length}, the length of its curve along the points, got {start}"
    )]
    Start { start: f64, length: f64 },
}

/// The cubic spline through points, over the sum of the chords between them: twice continuously
/// differentiable, without curvature at the ends of an open curve (de Boor 2001, chapter IV).
///
/// The parameter is zero at the start. A closed curve continues from its last point to the first, any
/// number of times.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    /// Parameters of the points.
    knots: Vec<f64>,
    /// Coefficients of 1, u, u², u³ of each piece, u = s − knot.
    pieces: Vec<[Vector3<f64>; 4]>,
    closed: bool,
    /// Number of turns and piece, if the curve is frozen to one.
    kept: Option<(f64, usize)>,
}

impl Spline {
    /// The curve through `points`, relative to the parent's node, with its start at this length of chords.
    ///
    /// # Errors
    /// [`SplineError`].
    pub fn through(points: &[[f64; 3]], closed: bool, start: f64) -> Result<Self, SplineError> {
        let (got, needs) = (points.len(), if closed { 3 } else { 2 });
        if got < needs {
            return Err(SplineError::Few { needs, got });
        }
        let mut points: Vec<_> = points.iter().map(|p| Vector3::from(*p)).collect();
        points.extend(closed.then_some(points[0]));
        let mut knots = vec![-start];
        for (k, pair) in points.windows(2).enumerate() {
            let chord = (pair[1] - pair[0]).norm();
            let finite = pair[0].iter().all(|x| x.is_finite()) && chord.is_finite();
            // A chord may be lost beside the length so far.
            let next = knots[k] + chord;
            if !(finite && next > knots[k]) {
                return Err(SplineError::Point { number: k + 2 });
            }
            knots.push(next);
        }
        let length = knots[knots.len() - 1] - knots[0];
        if !(0.0..=length).contains(&start) {
            return Err(SplineError::Start { start, length });
        }
        let bends = bends(&points, &knots, closed).ok_or(SplineError::Uneven)?;
        let piece = |k: usize| {
            let h = knots[k + 1] - knots[k];
            let [from, to] = [bends[k], bends[k + 1]];
            let slope = (points[k + 1] - points[k]) / h - (2.0 * from + to) * (h / 6.0);
            [points[k], slope, 0.5 * from, (to - from) / (6.0 * h)]
        };
        let pieces = (0..knots.len() - 1).map(piece).collect();
        Ok(Self {
            knots,
            pieces,
            closed,
            kept: None,
        })
    }

    /// First and last parameter.
    fn ends(&self) -> [f64; 2] {
        [self.knots[0], self.knots[self.pieces.len()]]
    }

    /// Number of turns of a closed curve at a parameter, and the piece.
    fn piece(&self, s: f64) -> (f64, usize) {
        let [first, last] = self.ends();
        let turns = match self.closed {
            true => ((s - first) / (last - first)).floor(),
            false => 0.0,
        };
        let s = s - turns * (last - first);
        let after = self.knots.partition_point(|knot| *knot <= s);
        (turns, after.clamp(1, self.pieces.len()) - 1)
    }
}

/// Second derivatives at the knots: the first derivatives are continuous. `None` where numbers
/// under- or overflow.
///
/// Those inside follow from those at the ends by a diagonally dominant tridiagonal system. They are zero at
/// the ends of an open curve; at those of a closed one they are equal, and the slope is continuous.
fn bends(points: &[Vector3<f64>], knots: &[f64], closed: bool) -> Option<Vec<Vector3<f64>>> {
    let n = points.len() - 1;
    let h = |k: usize| knots[k + 1] - knots[k];
    let slope = |k: usize| (points[k + 1] - points[k]) / h(k);
    // Second derivatives for zeros at the ends, and those for ones at the ends alone.
    let (mut bends, mut more) = (vec![Vector3::zeros(); n + 1], vec![0.0; n + 1]);
    (more[0], more[n]) = (1.0, 1.0);
    let mut upper = vec![0.0; n];
    for k in 1..n {
        let (before, after) = (h(k - 1) / 6.0, h(k) / 6.0);
        let pivot = 2.0 * (before + after) - before * upper[k - 1];
        upper[k] = after / pivot;
        bends[k] = (slope(k) - slope(k - 1) - before * bends[k - 1]) / pivot;
        more[k] = -before * more[k - 1] / pivot;
    }
    for k in (1..n).rev() {
        bends[k] = bends[k] - upper[k] * bends[k + 1];
        more[k] -= upper[k] * more[k + 1];
    }
    if closed {
        let (before, after) = (h(n - 1) / 6.0, h(0) / 6.0);
        let jump = slope(0) - slope(n - 1) - before * bends[n - 1] - after * bends[1];
        let end = jump / (2.0 * (before + after) + before * more[n - 1] + after * more[1]);
        for (bend, more) in bends.iter_mut().zip(more) {
            *bend += end * more;
        }
    }
    let finite = bends.iter().flatten().all(|b| b.is_finite());
    finite.then_some(bends)
}

impl Curve for Spline {
    fn at<S: Scalar>(&self, s: S) -> Vector3<S> {
        let (turns, k) = self.kept.unwrap_or_else(|| self.piece(s.re()));
        let [first, last] = self.ends();
        let u = s - turns * (last - first) - self.knots[k];
        let [a, b, c, d] = &self.pieces[k];
        Vector3::from_fn(|i, _| ((u * d[i] + c[i]) * u + b[i]) * u + a[i])
    }

    fn quantity(&self) -> Quantity {
        Quantity::Length
    }

    fn freeze_piece(&mut self, at: Option<f64>) {
        self.kept = at.map(|s| self.piece(s));
    }

    fn margin(&self, s: f64) -> f64 {
        let [first, last] = self.ends();
        match self.closed {
            true => f64::INFINITY,
            // Its ends belong to it.
            false => (s - first).min(last - s) + 1e-9 * (last - first),
        }
    }
}
