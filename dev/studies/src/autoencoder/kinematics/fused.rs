//! Forward kinematics as one operation, with a gradient that is derived by hand: one sweep outwards, one sweep
//! inwards.

use candle_core::{CpuStorage, CustomOp1, Error, Layout, Result, Shape, Tensor};
use glam::{Mat3, Vec3};
use sinew_mocap::Skeleton;

use super::layout::{NUMBERS, SQUARE_MIN};
use crate::autoencoder::two_columns;

/// Skeleton for the sweeps: each joint's parent and its offset in metres.
#[derive(Debug, Clone)]
pub(in super::super) struct Fused {
    joints: Vec<(Option<usize>, Vec3)>,
}

/// A rotation that is made of two columns, with the data for its gradient.
struct Orthonormal {
    rotation: Mat3,
    /// Lengths of the first column, and of the second without its part along the first.
    lengths: [f32; 2],
    /// The second column of the input, and its part along the first.
    second: Vec3,
    along: f32,
}

impl Orthonormal {
    fn new(columns: &[f32]) -> Self {
        let (a, second) = (Vec3::from_slice(columns), Vec3::from_slice(&columns[3..]));
        let length = |v: Vec3| libm::sqrtf(v.length_squared() + SQUARE_MIN);
        let x = a / length(a);
        let along = x.dot(second);
        let across = second - x * along;
        let y = across / length(across);
        let lengths = [length(a), length(across)];
        Self { rotation: Mat3::from_cols(x, y, x.cross(y)), lengths, second, along }
    }

    /// Converts the gradient with respect to the matrix to that with respect to the columns.
    fn gradient(&self, by: &Mat3) -> [Vec3; 2] {
        let Mat3 { x_axis: x, y_axis: y, .. } = self.rotation;
        let mut by_x = by.x_axis + y.cross(by.z_axis);
        let by_y = by.y_axis + by.z_axis.cross(x);
        let by_across = (by_y - y * y.dot(by_y)) / self.lengths[1];
        by_x -= by_across * self.along + self.second * x.dot(by_across);
        [(by_x - x * x.dot(by_x)) / self.lengths[0], by_across - x * x.dot(by_across)]
    }
}

impl Fused {
    pub(super) fn new(skeleton: &Skeleton) -> Self {
        let joints = skeleton.joints.iter();
        Self { joints: joints.map(|joint| (joint.parent, joint.offset_m.as_vec3())).collect() }
    }

    /// Computes local and global rotations and global positions of one pose.
    fn outwards(&self, columns: &[f32], world: &mut Vec<(Orthonormal, Mat3, Vec3)>) {
        world.clear();
        for ((parent, offset_m), columns) in
            self.joints.iter().zip(columns.chunks_exact(two_columns::NUMBERS))
        {
            let local = Orthonormal::new(columns);
            let (turn, position_m) = match parent {
                None => (local.rotation, Vec3::ZERO),
                Some(parent) => {
                    let (_, turn, origin_m) = &world[*parent];
                    (*turn * local.rotation, *origin_m + *turn * *offset_m)
                }
            };
            world.push((local, turn, position_m));
        }
    }

    /// Computes the gradient with respect to the columns of one pose, from that with respect to its positions and
    /// global rotations.
    fn inwards(
        &self,
        world: &[(Orthonormal, Mat3, Vec3)],
        by_global: &[f32],
        by_columns: &mut [f32],
        by_world: &mut Vec<(Mat3, Vec3)>,
    ) {
        by_world.clear();
        by_world.extend(by_global.chunks_exact(NUMBERS).map(|by| {
            let [position, x, y] = [0, 3, 6].map(|at| Vec3::from_slice(&by[at..]));
            (Mat3::from_cols(x, y, Vec3::ZERO), position)
        }));
        for (joint, (parent, offset_m)) in self.joints.iter().enumerate().rev() {
            let (local, ..) = &world[joint];
            let (by_turn, by_position) = by_world[joint];
            let by_local = match parent {
                None => by_turn,
                Some(parent) => {
                    let (by_parent, by_origin) = &mut by_world[*parent];
                    *by_origin += by_position;
                    let outer = Mat3::from_cols(
                        by_position * offset_m.x,
                        by_position * offset_m.y,
                        by_position * offset_m.z,
                    );
                    *by_parent += by_turn * local.rotation.transpose() + outer;
                    world[*parent].1.transpose() * by_turn
                }
            };
            let by = &mut by_columns[two_columns::NUMBERS * joint..][..two_columns::NUMBERS];
            let [by_first, by_second] = local.gradient(&by_local);
            by[..3].copy_from_slice(&by_first.to_array());
            by[3..].copy_from_slice(&by_second.to_array());
        }
    }

    /// Returns the count of input numbers of a pose.
    fn inputs(&self) -> usize {
        two_columns::NUMBERS * self.joints.len()
    }
}

impl CustomOp1 for Fused {
    fn name(&self) -> &'static str {
        "forward-kinematics"
    }

    fn cpu_fwd(&self, storage: &CpuStorage, layout: &Layout) -> Result<(CpuStorage, Shape)> {
        let (from, to) = layout
            .contiguous_offsets()
            .ok_or(Error::RequiresContiguous { op: "forward-kinematics" })?;
        let columns = &storage.as_slice::<f32>()?[from..to];
        let mut world = Vec::new();
        let mut global = Vec::with_capacity(columns.len() / two_columns::NUMBERS * NUMBERS);
        for pose in columns.chunks_exact(self.inputs()) {
            self.outwards(pose, &mut world);
            for (_, turn, position_m) in &world {
                for v in [*position_m, turn.x_axis, turn.y_axis] {
                    global.extend(v.to_array());
                }
            }
        }
        let shape = Shape::from((columns.len() / self.inputs(), NUMBERS * self.joints.len()));
        Ok((CpuStorage::F32(global), shape))
    }

    fn bwd(&self, columns: &Tensor, _: &Tensor, by_global: &Tensor) -> Result<Option<Tensor>> {
        let values = columns.flatten_all()?.to_vec1::<f32>()?;
        let by_global = by_global.flatten_all()?.to_vec1::<f32>()?;
        let mut by_columns = vec![0.0; values.len()];
        let (mut world, mut by_world) = (Vec::new(), Vec::new());
        let poses = values.chunks_exact(self.inputs());
        let by_poses = by_global.chunks_exact(NUMBERS * self.joints.len());
        let by_columns_of = by_columns.chunks_exact_mut(self.inputs());
        for ((pose, by_global), by_columns) in poses.zip(by_poses).zip(by_columns_of) {
            self.outwards(pose, &mut world);
            self.inwards(&world, by_global, by_columns, &mut by_world);
        }
        Ok(Some(Tensor::from_vec(by_columns, columns.shape(), columns.device())?))
    }
}
