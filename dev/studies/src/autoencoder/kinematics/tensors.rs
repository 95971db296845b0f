//! Forward kinematics in tensor operations, differentiated by the framework.

use candle_core::{D, Device, Result, Tensor};
use sinew_mocap::Skeleton;

use super::layout::SQUARE_MIN;

/// Joints whose global poses are computed at once: none is a descendant of another.
#[derive(Debug, Clone)]
struct Group {
    /// Indices of the joints.
    joints: Tensor,
    /// Place of all their parents: a group, and indices in it. `None` for the root.
    parents: Option<(usize, Tensor)>,
    /// Offsets, `[joints, 3, 1]`, in metres.
    offset_m: Tensor,
}

/// Forward kinematics, group by group.
#[derive(Debug, Clone)]
pub(in super::super) struct Tensors {
    groups: Vec<Group>,
    /// For each joint, its place in the concatenated groups.
    places: Tensor,
}

impl Tensors {
    /// Creates the operations. The groups must contain every joint once, and all parents of a group must be in one
    /// earlier group.
    pub(super) fn new(skeleton: &Skeleton, groups: &[Vec<usize>]) -> Result<Self> {
        let order: Vec<usize> = groups.iter().flatten().copied().collect();
        let places = (0..order.len()).map(|joint| place(&order, joint));
        let places = indices(places)?;
        let made = groups.iter().map(|joints| {
            let parent = |joint: usize| skeleton.joints[joint].parent;
            let holding = parent(joints[0]).map(|first| {
                groups.iter().position(|group| group.contains(&first)).expect("a group holds it")
            });
            let parents = holding
                .map(|group| {
                    let parents = joints.iter().filter_map(|joint| parent(*joint));
                    let places = parents.map(|parent| place(&groups[group], parent));
                    Ok::<_, candle_core::Error>((group, indices(places)?))
                })
                .transpose()?;
            let offsets = joints
                .iter()
                .flat_map(|joint| skeleton.joints[*joint].offset_m.as_vec3().to_array());
            Ok(Group {
                joints: indices(joints.iter().copied())?,
                parents,
                offset_m: Tensor::from_iter(offsets, &Device::Cpu)?.reshape((
                    joints.len(),
                    3,
                    1,
                ))?,
            })
        });
        Ok(Self { groups: made.collect::<Result<_>>()?, places })
    }

    pub(super) fn global(&self, columns: &Tensor) -> Result<Tensor> {
        let poses = columns.dim(0)?;
        let local = rotations(&columns.reshape((poses, (), 2, 3))?)?;
        let mut world: Vec<(Tensor, Tensor)> = Vec::with_capacity(self.groups.len());
        for group in &self.groups {
            let local = local.index_select(&group.joints, 1)?;
            world.push(match &group.parents {
                None => (local.narrow(D::Minus1, 0, 1)?.zeros_like()?, local),
                Some((holding, parents)) => {
                    let (origin_m, turn) = &world[*holding];
                    let turn = turn.index_select(parents, 1)?;
                    let offset_m = group.offset_m.broadcast_left(poses)?.contiguous()?;
                    let position_m =
                        (origin_m.index_select(parents, 1)? + turn.matmul(&offset_m)?)?;
                    (position_m, turn.matmul(&local)?)
                }
            });
        }
        // A position becomes one more column: all nine numbers of a joint are transposed at once.
        let joined: Vec<Tensor> = world
            .iter()
            .map(|(position_m, turn)| {
                Tensor::cat(&[position_m, &turn.narrow(D::Minus1, 0, 2)?], D::Minus1)
            })
            .collect::<Result<_>>()?;
        let all = Tensor::cat(&joined, 1)?.index_select(&self.places, 1)?;
        all.transpose(D::Minus1, D::Minus2)?.contiguous()?.reshape((poses, ()))
    }
}

/// Returns rotation matrices of columns `[poses, joints, 2, 3]`, by Gram-Schmidt.
fn rotations(columns: &Tensor) -> Result<Tensor> {
    let unit = |v: &Tensor| {
        let length = (v.sqr()?.sum_keepdim(D::Minus1)? + f64::from(SQUARE_MIN))?.sqrt()?;
        v.broadcast_div(&length)
    };
    let x = unit(&columns.narrow(2, 0, 1)?.squeeze(2)?)?;
    let b = columns.narrow(2, 1, 1)?.squeeze(2)?;
    let along = (&x * &b)?.sum_keepdim(D::Minus1)?;
    let y = unit(&(&b - x.broadcast_mul(&along)?)?)?;
    // The cross product: components rotated by one and by two places.
    let turned = |v: &Tensor, by: usize| {
        let (tail, head) = (v.narrow(D::Minus1, by, 3 - by)?, v.narrow(D::Minus1, 0, by)?);
        Tensor::cat(&[tail, head], D::Minus1)
    };
    let z = ((turned(&x, 1)? * turned(&y, 2)?)? - (turned(&x, 2)? * turned(&y, 1)?)?)?;
    Tensor::stack(&[x, y, z], D::Minus1)
}

fn place(joints: &[usize], joint: usize) -> usize {
    joints.iter().position(|other| *other == joint).expect("every joint is in a group")
}

fn indices(values: impl Iterator<Item = usize>) -> Result<Tensor> {
    let values: Vec<u32> = values.map(|v| u32::try_from(v).expect("few joints")).collect();
    let count = values.len();
    Tensor::from_vec(values, count, &Device::Cpu)
}
