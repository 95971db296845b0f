//! The straight line between two poses, with rounding.

use super::case::{Case, kind};
use crate::golden;
use crate::rounding::{Number, Rotation, State, Vector};
use sinew_core::JointKind;

/// A line: its points from the first pose to the last.
pub(super) struct Line {
    /// Coordinates of both ends, by joint.
    ends: [Vec<Vector>; 2],
    coordinates: Vec<Vec<Vector>>,
    /// States of the joints in the world, by point.
    pub(super) places: Vec<Vec<State>>,
}

/// Returns the core's coordinates of rotation vectors, which are converted by way of poses.
pub(super) fn coordinates(vectors: &[golden::Vector]) -> Vec<Vector> {
    vectors.iter().map(|vector| Rotation::exp(Vector::given(vector.0)).log()).collect()
}

/// Returns the states of the joints in the world.
pub(super) fn placed(case: &Case, coordinates: &[Vector]) -> Vec<State> {
    places(case, coordinates, Rotation::exp, Rotation::unit)
}

fn places(
    case: &Case,
    coordinates: &[Vector],
    turn: impl Fn(Vector) -> Rotation,
    finish: impl Fn(Rotation) -> Rotation,
) -> Vec<State> {
    let mut places: Vec<State> = Vec::with_capacity(coordinates.len());
    for (joint, vector) in coordinates.iter().enumerate() {
        let place = match case.parent(joint) {
            Some(parent) if kind(joint) != JointKind::Fixed => {
                let parent = places[parent];
                let offset = Vector::given(case.offset[joint].0);
                State {
                    rotation: finish(parent.rotation.after(turn(*vector))),
                    position: parent.position + parent.rotation.turn(offset),
                    ..parent
                }
            }
            _ => State::world(),
        };
        places.push(place);
    }
    places
}

impl Line {
    pub(super) fn new(case: &Case) -> Self {
        Self::with(case, Rotation::exp, Rotation::unit)
    }

    /// Computes the line with the operations of the core's code for four points at a time.
    pub(super) fn by_fours(case: &Case) -> Self {
        Self::with(case, exp_by_powers, |rotation| rotation)
    }

    fn with(
        case: &Case,
        turn: impl Fn(Vector) -> Rotation,
        finish: impl Fn(Rotation) -> Rotation,
    ) -> Self {
        let ends = [coordinates(&case.theta0), coordinates(&case.theta1)];
        let steps = Number::known(f64::from(case.N));
        let at = |k| {
            let t = Number::known(f64::from(k)) / steps;
            ends[0].iter().zip(&ends[1]).map(|(a, b)| *a + (*b - *a) * t).collect()
        };
        let coordinates: Vec<Vec<Vector>> = (0..=case.N).map(at).collect();
        let places =
            coordinates.iter().map(|vectors| places(case, vectors, &turn, &finish)).collect();
        Self { ends, coordinates, places }
    }

    pub(super) fn angle_distance(&self) -> Number {
        let [a, b] = &self.ends;
        root_of_squares(a.iter().zip(b).map(|(a, b)| *b - *a))
    }

    pub(super) fn rotation_distance(&self) -> Number {
        let [a, b] = &self.ends;
        let turn =
            |(a, b): (&Vector, &Vector)| Rotation::exp(*a).inverse().after(Rotation::exp(*b)).log();
        root_of_squares(a.iter().zip(b).map(turn))
    }

    /// Returns the distance between two points.
    pub(super) fn distance(&self, a: usize, b: usize) -> Number {
        let ways = self.places[a].iter().zip(&self.places[b]);
        root_of_squares(ways.map(|(a, b)| a.position - b.position))
    }

    fn steps(&self) -> impl Iterator<Item = Number> {
        (1..self.places.len()).map(|k| self.distance(k - 1, k))
    }

    pub(super) fn length(&self) -> Number {
        self.steps().fold(Number::ZERO, |sum, step| sum + step)
    }

    pub(super) fn energy(&self) -> Number {
        self.steps().fold(Number::ZERO, |sum, step| sum + step * step)
    }

    /// Returns the gradient of the energy at a point: with respect to joint rotations in body axes, and with respect to
    /// rotation vectors.
    pub(super) fn gradient(&self, case: &Case, point: usize) -> [Vec<Vector>; 2] {
        let [before, at, after] = [point - 1, point, point + 1].map(|k| &self.places[k]);
        let count = at.len();
        let mut forces: Vec<Vector> = (0..count)
            .map(|joint| {
                let [before, at, after] = [before, at, after].map(|places| places[joint].position);
                ((at - before) - (after - at)).doubled(2.0)
            })
            .collect();
        let mut moments = vec![Vector::ZERO; count];
        let mut of_motions = vec![Vector::ZERO; count];
        let mut of_vectors = vec![Vector::ZERO; count];
        for joint in (0..count).rev() {
            if let Some(parent) = case.parent(joint) {
                let arm = at[joint].position - at[parent].position;
                forces[parent] = forces[parent] + forces[joint];
                moments[parent] = moments[parent] + (moments[joint] + arm.cross(forces[joint]));
            }
            if kind(joint) != JointKind::Fixed {
                of_motions[joint] = at[joint].rotation.inverse().turn(moments[joint]);
                of_vectors[joint] = in_vectors(self.coordinates[point][joint], of_motions[joint]);
            }
        }
        [of_motions, of_vectors]
    }
}

fn root_of_squares(vectors: impl Iterator<Item = Vector>) -> Number {
    vectors.fold(Number::ZERO, |sum, vector| sum + vector.dot(vector)).sqrt()
}

/// Multiplies a vector by the transpose of the exponential map's right Jacobian.
fn in_vectors(at: Vector, of_motion: Vector) -> Vector {
    let angle = at.length();
    let (sine, cosine) = (angle.function(f64::sin), angle.function(f64::cos));
    let squared = angle * angle;
    let (of_cross, of_square) = if squared.exact() < 0.06 {
        // A series is used, since the differences below have no significant digits left.
        (
            squared.function(|s| 0.5 - s * (1.0 / 24.0 - s / 720.0)),
            squared.function(|s| 1.0 / 6.0 - s * (1.0 / 120.0 - s / 5040.0)),
        )
    } else {
        ((Number::known(1.0) - cosine) / squared, (angle - sine) / (squared * angle))
    };
    let across = at.cross(of_motion);
    of_motion + across * of_cross + at.cross(across) * of_square
}

/// Computes the exponential map by powers of the angle up to π, without a branch or a root.
fn exp_by_powers(vector: Vector) -> Rotation {
    let half = vector.doubled(0.5);
    let squared = half.dot(half);
    // The series is 1 - x² / (n (n + 1)) (1 - x² / ((n + 2) (n + 3)) ...), summed as powers.
    let series = |first: f64| {
        let mut coefficients = vec![1.0];
        for k in 0..9 {
            let n = first + 2.0 * f64::from(k);
            coefficients.push(-coefficients[coefficients.len() - 1] / (n * (n + 1.0)));
        }
        coefficients
            .into_iter()
            .rev()
            .fold(Number::ZERO, |sum, next| Number::known(next) + squared * sum)
    };
    Rotation::of(half * series(2.0), series(1.0))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn the_series_is_the_exponential_map() {
        let vector = Vector::given(DVec3::new(1.0, -2.0, 1.5));
        let (a, b) = (exp_by_powers(vector).exact(), Rotation::exp(vector).exact());
        assert!((a - b).length() < 1e-9, "{a} {b}");
    }
}
