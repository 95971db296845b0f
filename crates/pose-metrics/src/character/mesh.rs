//! The skin of a character, and the weights of its vertices.

use glam::DVec3;

use super::error::{Refusal, refuse};
use super::limits::{A_PLACE, is_place};

/// A skinned triangle mesh in the rest pose.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Position of every vertex in the world, in metres.
    pub positions_m: Vec<DVec3>,
    /// Joints with which each vertex moves: their indices and weights. Weights are above 0 and sum to 1.
    pub skin: Vec<Vec<(usize, f64)>>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[usize; 3]>,
}

impl Mesh {
    pub(super) fn check(&self, joints: usize) -> Result<(), Refusal> {
        let Self { positions_m, skin, triangles } = self;
        if skin.len() != positions_m.len() {
            return Err(refuse(
                "the mesh",
                format!("skin of {} vertices", positions_m.len()),
                skin.len(),
            ));
        }
        for (vertex, (position_m, shares)) in positions_m.iter().zip(skin).enumerate() {
            let item = || format!("vertex {vertex}");
            if !is_place(*position_m) {
                return Err(refuse(item(), A_PLACE, position_m));
            }
            if let Some((joint, _)) = shares.iter().find(|(joint, _)| *joint >= joints) {
                return Err(refuse(item(), format!("joints below {joints}"), joint));
            }
            let sum: f64 = shares.iter().map(|(_, share)| share).sum();
            if !((sum - 1.0).abs() < 1e-6 && shares.iter().all(|(_, share)| *share > 0.0)) {
                return Err(refuse(item(), "shares above 0 that sum to 1", sum));
            }
        }
        for (index, triangle) in triangles.iter().enumerate() {
            if let Some(vertex) = triangle.iter().find(|vertex| **vertex >= positions_m.len()) {
                let expected = format!("vertices below {}", positions_m.len());
                return Err(refuse(format!("triangle {index}"), expected, vertex));
            }
        }
        Ok(())
    }
}

/// Tolerated deviation of the sum of stored weights from 1: eight weights of eight bits, each rounded.
const SHARE_ROUNDING: f64 = 0.02;

/// Maximum weight. Larger weights indicate damage: programs that do not normalize write at most a few times 1.
const SHARE_MAX: f64 = 1e3;

/// Returns the weights above 0 of a vertex, normalized to a sum of exactly 1, and whether the stored sum was 1 up
/// to rounding.
pub(super) fn shares(
    stored: impl IntoIterator<Item = (usize, f64)>,
) -> Result<(Vec<(usize, f64)>, bool), Refusal> {
    let mut shares: Vec<(usize, f64)> = Vec::new();
    for (joint, share) in stored {
        if !(0.0..=SHARE_MAX).contains(&share) {
            return Err(refuse("weight", "a number from 0 to 1000", share));
        }
        if share > 0.0 {
            shares.push((joint, share));
        }
    }
    let sum = shares.iter().fold(0.0, |sum, (_, share)| sum + share);
    if sum <= 0.0 {
        return Err(refuse("weights", "a sum of 1", sum));
    }
    let is_one = (sum - 1.0).abs() <= SHARE_ROUNDING;
    Ok((shares.into_iter().map(|(joint, share)| (joint, share / sum)).collect(), is_one))
}
