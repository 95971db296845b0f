//! Losses of the trainings: means of absolute differences.

use candle_core::{Device, Result, Tensor};
use sinew_mocap::Skeleton;

use super::kinematics::{self, Form, Kinematics};
use super::method::Method;
use super::samples::Rows;
use super::two_columns;

/// A loss of reconstructed columns.
#[derive(Debug, Clone)]
pub(super) struct Loss {
    /// Weights, `[1, numbers]`: each joint's weight at each of its six numbers.
    weights: Tensor,
    global: Option<Global>,
}

/// Part of a loss besides the local rotations.
#[derive(Debug, Clone)]
struct Global {
    kinematics: Kinematics,
    /// Factors on global positions and columns, `[1, numbers]`.
    factors: Tensor,
}

impl Loss {
    /// Returns the loss of a method: `weights` has a weight for each joint, with a mean of 1; an error of 1 m in a
    /// global position costs as much as an error of `position_per_m` in a number of a column.
    pub(super) fn new(
        skeleton: &Skeleton,
        method: Method,
        weights: &[f64],
        position_per_m: f64,
        form: Form,
    ) -> Result<Self> {
        let row = |values: Vec<f64>| {
            #[expect(clippy::cast_possible_truncation, reason = "rounds to the network's f32")]
            let values: Vec<f32> = values.iter().map(|value| *value as f32).collect();
            let count = values.len();
            Tensor::from_vec(values, (1, count), &Device::Cpu)
        };
        let of_joint = |weight: &f64| [*weight; two_columns::NUMBERS];
        let global = (method == Method::ForwardKinematics).then(|| {
            // Means over three numbers for positions and six for rotations, from a mean over nine.
            let (position, column) = (3.0 * position_per_m, 1.5);
            let [p, c] = [position, column];
            let of_joint: [f64; kinematics::NUMBERS] = [p, p, p, c, c, c, c, c, c];
            Ok::<_, candle_core::Error>(Global {
                kinematics: Kinematics::new(skeleton, form)?,
                factors: row(of_joint.repeat(skeleton.joints.len()))?,
            })
        });
        Ok(Self {
            weights: row(weights.iter().flat_map(of_joint).collect())?,
            global: global.transpose()?,
        })
    }

    /// Returns the mean over a batch.
    pub(super) fn mean(&self, columns: &Tensor, target: &Rows) -> Result<Tensor> {
        let local = (columns - &target.columns)?.abs()?.broadcast_mul(&self.weights)?.mean_all()?;
        let Some(Global { kinematics, factors }) = &self.global else { return Ok(local) };
        let global = (kinematics.global(columns)? - &target.global)?.abs()?;
        local + global.broadcast_mul(factors)?.mean_all()?
    }
}
