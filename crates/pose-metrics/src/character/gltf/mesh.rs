//! Reads the vertices and triangles of a node's mesh.

use ::gltf::accessor::{DataType, Dimensions};
use ::gltf::mesh::{Mode, Primitive};
use ::gltf::{Node, Semantic};
use glam::{DMat4, DVec3};

use super::accessor::Elements;
use super::buffers::Buffers;
use super::nodes::Nodes;
use super::skeleton::{Binding, Skeleton};
use crate::character::error::{Refusal, refuse};
use crate::character::mesh::{Mesh, shares};

type Shares = Vec<(usize, f64)>;

/// Appends the mesh of a node; nothing if the node does not belong to the character. Returns the number of
/// vertices whose weights do not sum to 1.
pub(super) fn add(
    mesh: &mut Mesh,
    node: &Node<'_>,
    skeleton: &Skeleton,
    nodes: &Nodes,
    buffers: &Buffers,
) -> Result<usize, Refusal> {
    let Some(owner) = Owner::of(node, skeleton, nodes)? else { return Ok(0) };
    let mut unlike_one = 0;
    for primitive in node.mesh().iter().flat_map(::gltf::Mesh::primitives) {
        let in_primitive =
            |refusal: Refusal| refusal.of(format!("primitive {}", primitive.index()));
        let local_m = positions_m(&primitive, buffers).map_err(in_primitive)?;
        let first = mesh.positions_m.len();
        let triangles = triangles(&primitive, local_m.len(), buffers).map_err(in_primitive)?;
        match owner {
            Owner::Skin(binding) => {
                let (skin, unlike) =
                    skin(&primitive, local_m.len(), binding, buffers).map_err(in_primitive)?;
                unlike_one += unlike;
                let bound = local_m.iter().zip(&skin).map(|(p, shares)| match binding.world {
                    Some(world) => world.transform_point3(*p),
                    None => shares
                        .iter()
                        .map(|(joint, share)| *share * skeleton.world[*joint].transform_point3(*p))
                        .sum(),
                });
                mesh.positions_m.extend(bound);
                mesh.skin.extend(skin);
            }
            Owner::Joint { joint, world } => {
                mesh.positions_m.extend(local_m.iter().map(|p| world.transform_point3(*p)));
                mesh.skin.extend(local_m.iter().map(|_| vec![(joint, 1.0)]));
            }
        }
        mesh.triangles.extend(triangles.into_iter().map(|corners| corners.map(|c| first + c)));
    }
    Ok(unlike_one)
}

/// The skin or the joint with which a mesh moves.
enum Owner<'a> {
    Skin(&'a Binding),
    /// The joint to which the mesh is attached, and the transform from the mesh to the world.
    Joint {
        joint: usize,
        world: DMat4,
    },
}

impl<'a> Owner<'a> {
    /// Returns the owner of a node's mesh; `None` for scenery, which belongs to no skin or joint. Scenery is not
    /// checked further, since it may contain lines or anything else.
    fn of(node: &Node<'_>, skeleton: &'a Skeleton, nodes: &Nodes) -> Result<Option<Self>, Refusal> {
        let binding = node.skin().and_then(|skin| skeleton.skins[skin.index()].as_ref());
        if let Some(binding) = binding {
            return Ok(Some(Self::Skin(binding)));
        }
        let carrier = skeleton.joint(node.index()).or(skeleton.joint_above(node.index(), nodes));
        let Some(joint) = carrier else { return Ok(None) };
        let from_joint =
            nodes.world(skeleton.nodes[joint])?.inverse() * nodes.world(node.index())?;
        Ok(Some(Self::Joint { joint, world: skeleton.world[joint] * from_joint }))
    }
}

fn positions_m(primitive: &Primitive<'_>, buffers: &Buffers) -> Result<Vec<DVec3>, Refusal> {
    let accessor = primitive.get(&Semantic::Positions);
    let accessor = accessor.ok_or_else(|| refuse("attributes", "POSITION", "none"))?;
    // Integers by KHR_mesh_quantization. The transforms of joints and nodes scale them.
    let any = [DataType::F32, DataType::I8, DataType::U8, DataType::I16, DataType::U16];
    let elements = Elements::new(&accessor, buffers, Dimensions::Vec3, &any)?;
    let one = if accessor.normalized() { elements.one() } else { 1.0 };
    let position_m = |vertex| {
        // The minimum of a signed type is slightly below -1.
        let mut numbers = elements
            .numbers(vertex)
            .map(|number| if one > 1.0 { (number / one).max(-1.0) } else { number });
        DVec3::from_array(core::array::from_fn(|_| numbers.next().unwrap_or(f64::NAN)))
    };
    Ok((0..elements.count()).map(position_m).collect())
}

/// Returns the weights of every vertex by the character's joints, and the number of vertices whose weights do not
/// sum to 1.
fn skin(
    primitive: &Primitive<'_>,
    vertices: usize,
    binding: &Binding,
    buffers: &Buffers,
) -> Result<(Vec<Shares>, usize), Refusal> {
    let mut sets = Vec::new();
    for set in 0.. {
        let joints = primitive.get(&Semantic::Joints(set));
        let weights = primitive.get(&Semantic::Weights(set));
        let (joints, weights) = match (joints, weights) {
            (Some(joints), Some(weights)) => (joints, weights),
            (None, None) if set > 0 => break,
            _ => {
                let expected = format!("both JOINTS_{set} and WEIGHTS_{set}");
                return Err(refuse("attributes", expected, "not both"));
            }
        };
        let whole = [DataType::U8, DataType::U16];
        let any = [DataType::F32, DataType::U8, DataType::U16];
        let joints = Elements::new(&joints, buffers, Dimensions::Vec4, &whole)?;
        let weights = Elements::new(&weights, buffers, Dimensions::Vec4, &any)?;
        if joints.count() != vertices || weights.count() != vertices {
            let found = format!("{} and {}", joints.count(), weights.count());
            let item = format!("JOINTS_{set} and WEIGHTS_{set}");
            return Err(refuse(item, format!("{vertices} as of POSITION"), found));
        }
        sets.push((joints, weights));
    }
    let mut unlike_one = 0;
    let mut of_vertex = |vertex: usize| {
        let stored = sets.iter().flat_map(|(joints, weights)| {
            let one = weights.one();
            joints.indices(vertex).zip(weights.numbers(vertex).map(move |weight| weight / one))
        });
        let in_vertex = |refusal: Refusal| refusal.of(format!("vertex {vertex}"));
        let (entries, is_one) = shares(stored).map_err(in_vertex)?;
        unlike_one += usize::from(!is_one);
        let joint = |(entry, share): (usize, f64)| {
            let joint = binding.joints.get(entry).copied();
            let expected = || format!("an index below {}", binding.joints.len());
            joint
                .map(|joint| (joint, share))
                .ok_or_else(|| in_vertex(refuse("joint", expected(), entry)))
        };
        entries.into_iter().map(joint).collect()
    };
    let skin = (0..vertices).map(&mut of_vertex).collect::<Result<_, Refusal>>()?;
    Ok((skin, unlike_one))
}

fn triangles(
    primitive: &Primitive<'_>,
    vertices: usize,
    buffers: &Buffers,
) -> Result<Vec<[usize; 3]>, Refusal> {
    let indices: Vec<usize> = match primitive.indices() {
        None => (0..vertices).collect(),
        Some(accessor) => {
            let whole = [DataType::U8, DataType::U16, DataType::U32];
            let elements = Elements::new(&accessor, buffers, Dimensions::Scalar, &whole)?;
            (0..elements.count()).flat_map(|element| elements.indices(element)).collect()
        }
    };
    if let Some(index) = indices.iter().find(|index| **index >= vertices) {
        return Err(refuse("indices", format!("vertices below {vertices}"), index));
    }
    match primitive.mode() {
        Mode::Triangles if indices.len().is_multiple_of(3) => Ok(indices
            .chunks_exact(3)
            .map(|corners| [corners[0], corners[1], corners[2]])
            .collect()),
        Mode::Triangles => Err(refuse("triangles", "three indices of each", indices.len())),
        // Every other triangle of a strip has the opposite orientation.
        Mode::TriangleStrip => Ok(indices
            .windows(3)
            .enumerate()
            .map(|(place, corners)| match place % 2 {
                0 => [corners[0], corners[1], corners[2]],
                _ => [corners[1], corners[0], corners[2]],
            })
            .collect()),
        Mode::TriangleFan => Ok(indices
            .get(1..)
            .unwrap_or_default()
            .windows(2)
            .map(|corners| [indices[0], corners[0], corners[1]])
            .collect()),
        other => Err(refuse("mode", "triangles, or strips or fans of them", format!("{other:?}"))),
    }
}
