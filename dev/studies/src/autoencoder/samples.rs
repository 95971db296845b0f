//! Poses in the form for the network and the losses.

use candle_core::{Device, Result, Tensor};
use glam::DQuat;

use super::data::Poses;
use super::kinematics::{Form, Kinematics};
use super::two_columns;
use crate::recordings::Pose;

/// Poses, one per row.
#[derive(Debug, Clone)]
pub(super) struct Rows {
    /// Input of the network: two columns per joint, minus the mean of all training poses, divided by a common
    /// deviation.
    pub(super) input: Tensor,
    /// Two columns per joint.
    pub(super) columns: Tensor,
    /// Result of forward kinematics.
    pub(super) global: Tensor,
}

impl Rows {
    pub(super) fn len(&self) -> Result<usize> {
        self.input.dim(0)
    }

    /// Returns the rows with these indices.
    pub(super) fn at(&self, indices: &Tensor) -> Result<Self> {
        Ok(Self {
            input: self.input.index_select(indices, 0)?,
            columns: self.columns.index_select(indices, 0)?,
            global: self.global.index_select(indices, 0)?,
        })
    }
}

/// Training and test poses, and the conversion of the network's numbers to columns.
#[derive(Debug, Clone)]
pub(super) struct Samples {
    pub(super) train: Rows,
    pub(super) test: Rows,
    mean: Tensor,
    deviation: f64,
}

impl Samples {
    pub(super) fn new(poses: &Poses) -> Result<Self> {
        let (mean, deviation) = statistics(&poses.train);
        #[expect(clippy::cast_possible_truncation, reason = "rounds to the network's f32")]
        let mean: Vec<f32> = mean.iter().map(|mean| *mean as f32).collect();
        let mean = Tensor::from_vec(
            mean,
            (1, poses.skeleton.joints.len() * two_columns::NUMBERS),
            &Device::Cpu,
        )?;
        let kinematics = Kinematics::new(&poses.skeleton, Form::Fused)?;
        let rows = |poses: &[Pose]| {
            let columns = columns(poses)?;
            let input = columns.broadcast_sub(&mean)?.affine(deviation.recip(), 0.0)?;
            let global = kinematics.global(&columns)?;
            Ok::<_, candle_core::Error>(Rows { input, columns, global })
        };
        Ok(Self { train: rows(&poses.train)?, test: rows(&poses.test)?, mean, deviation })
    }

    /// Converts the output of the network to two columns per joint.
    pub(super) fn columns(&self, output: &Tensor) -> Result<Tensor> {
        output.affine(self.deviation, 0.0)?.broadcast_add(&self.mean)
    }
}

/// Returns the mean of every number, and the root of their mean variance: numbers that hardly change stay small.
fn statistics(poses: &[Pose]) -> (Vec<f64>, f64) {
    let rows = || poses.iter().map(|pose| numbers(pose));
    let count = poses.len() as f64;
    let width = poses.first().map_or(0, |pose| pose.len() * two_columns::NUMBERS);
    let mut mean = vec![0.0; width];
    for row in rows() {
        for (mean, x) in mean.iter_mut().zip(row) {
            *mean += x / count;
        }
    }
    let squares: f64 = rows()
        .map(|row| row.zip(&mean).map(|(x, mean)| (x - mean) * (x - mean)).sum::<f64>())
        .sum();
    let deviation = (squares / (count * width as f64)).sqrt();
    // If all poses are equal, no scale is needed.
    (mean, if deviation > 0.0 { deviation } else { 1.0 })
}

fn numbers(pose: &[DQuat]) -> impl Iterator<Item = f64> {
    pose.iter().flat_map(|rotation| two_columns::from_rotation(*rotation))
}

/// Returns two columns per joint, a row per pose.
fn columns(poses: &[Pose]) -> Result<Tensor> {
    #[expect(clippy::cast_possible_truncation, reason = "rounds to the network's f32")]
    let values: Vec<f32> = poses.iter().flat_map(|pose| numbers(pose)).map(|x| x as f32).collect();
    let width = values.len() / poses.len();
    Tensor::from_vec(values, (poses.len(), width), &Device::Cpu)
}

/// Returns the poses for rows with two columns per joint.
pub(super) fn poses(columns: &Tensor) -> Result<Vec<Pose>> {
    let rotation = |columns: &[f32]| {
        two_columns::to_rotation(std::array::from_fn(|number| f64::from(columns[number])))
    };
    let rows = columns.to_vec2::<f32>()?;
    Ok(rows
        .iter()
        .map(|row| row.chunks_exact(two_columns::NUMBERS).map(rotation).collect())
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_never_change_come_out_as_they_are() {
        let pose = |angle: f64| vec![DQuat::from_rotation_x(angle), DQuat::from_rotation_z(0.3)];
        let (mean, deviation) = statistics(&[pose(-0.5), pose(0.5)]);
        assert!((mean[6] - 0.3_f64.cos()).abs() < 1e-12 && deviation > 0.1);
        assert!((mean[2]).abs() < 1e-12, "the first column is the axis");
        let still = [pose(0.1), pose(0.1)];
        assert!((statistics(&still).1 - 1.0).abs() < f64::EPSILON);
    }

    #[test]
    fn poses_come_back_from_their_columns() {
        let there = vec![vec![DQuat::from_rotation_y(1.0), DQuat::from_rotation_x(-2.0)]];
        let back = poses(&columns(&there).unwrap()).unwrap();
        for (a, b) in there[0].iter().zip(&back[0]) {
            assert!(a.angle_between(*b) < 1e-3, "{a} {b}");
        }
    }
}
