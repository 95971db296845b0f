//! Layers: joints that a motion leaves out follow another motion.

use sinew_retarget::feasibility::{Curve, Instant, Performance as _, RigMotion};
use sinew_rig::Mechanism;
use thiserror::Error;

/// Largest distance between the ends of a motion that may begin again, rad or m.
const CLOSED: f64 = 1e-3;

/// The reason why a motion cannot be a layer.
#[derive(Debug, Error)]
pub enum LayerError {
    /// The layer ends too early, and does not end where it began.
    #[error(
        "it lasts {layer_s:.2} s of {motion_s:.2} s, and does not end where it begins: expected a longer motion, or a \
         loop, such as that of `sinew clip idle`"
    )]
    Short {
        /// Duration of the layer, s.
        layer_s: f64,
        /// Duration of the motion, s.
        motion_s: f64,
    },
    /// The layer is not a motion of this rig.
    #[error("it has {found} coordinates, and the rig has {expected}")]
    Rig {
        /// Coordinates of the layer.
        found: usize,
        /// Coordinates of the rig.
        expected: usize,
    },
    /// The layer is invalid.
    #[error(transparent)]
    Motion(#[from] sinew_retarget::feasibility::MotionError),
}

/// Fills all coordinates except the `given` ones with those of a layer, from its beginning. A layer that ends where it
/// began is repeated.
///
/// # Errors
/// [`LayerError`] if the layer is too short, or of another rig.
pub fn fill(
    mechanism: &Mechanism,
    motion: &mut RigMotion,
    given: &[usize],
    layer: &RigMotion,
) -> Result<(), LayerError> {
    let expected = mechanism.home().len();
    let ends = [layer.rows.first(), layer.rows.last()];
    let [Some(first), Some(last)] = ends else {
        return Err(LayerError::Rig { found: 0, expected });
    };
    if first.len() != expected {
        return Err(LayerError::Rig { found: first.len(), expected });
    }
    let (layer_s, motion_s) = (layer.duration_s(), motion.duration_s());
    let is_closed = first.iter().zip(last).all(|(a, b)| (a - b).abs() < CLOSED);
    if layer_s < motion_s && !is_closed {
        return Err(LayerError::Short { layer_s, motion_s });
    }
    let curve = Curve::new(mechanism, layer)?;
    let mut instant = Instant::default();
    for (row, q) in motion.rows.iter_mut().enumerate() {
        curve.at((row as f64 * motion.dt_s) % layer_s, &mut instant);
        for (place, value) in instant.q.iter().enumerate() {
            if !given.contains(&place) {
                q[place] = *value;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(rows: &[[f64; 3]]) -> RigMotion {
        RigMotion { dt_s: 0.1, rows: rows.iter().map(|row| row.to_vec()).collect() }
    }

    #[test]
    fn joints_without_a_column_follow_the_layer() {
        let mechanism = sinew_rig::new::arm(3).unwrap().mechanism().unwrap();
        let mut talk = motion(&[[0.5, 0.0, 0.0]; 9]);
        let mut still = motion(&[[0.0, 0.2, -0.1]; 3]);
        fill(&mechanism, &mut talk, &[0], &still).unwrap();
        for row in &talk.rows {
            assert!((row[0] - 0.5).abs() < 1e-9 && (row[1] - 0.2).abs() < 1e-9, "{row:?}");
        }
        still.rows[2][1] = 0.4;
        let refused = fill(&mechanism, &mut talk, &[0], &still).unwrap_err().to_string();
        assert!(refused.contains("lasts 0.20 s of 0.80 s"), "{refused}");
        let other = RigMotion { dt_s: 0.1, rows: vec![vec![0.0; 2]; 9] };
        let refused = fill(&mechanism, &mut talk, &[0], &other).unwrap_err().to_string();
        assert!(refused.contains("2 coordinates, and the rig has 3"), "{refused}");
    }
}
