//! `Geno.bin`, the character of D. Holden's `GenoView` (github.com/orangeduck/GenoView): little-endian arrays
//! after three counts. The format has no magic number; the file is identified by its size.
//!
//! | bytes | content |
//! | --- | --- |
//! | 3 u32 | vertices V, triangles T, bones N |
//! | V 3 f32 | positions, m |
//! | V 2 f32, V 3 f32 | texture coordinates, normals |
//! | V 4 u8, V 4 f32 | indices of bones, and their weights |
//! | T 3 u16 | vertices of the triangles |
//! | N (32 char, i32) | name padded with zeros, parent, -1 for the root |
//! | N 10 f32 | rest pose in the world: translation (m), rotation x y z w, scale |

use glam::DVec3;

use super::error::{FilePosition, Refusal, refuse};
use super::limits::{A_PLACE, JOINT_COUNT_MAX, is_place};
use super::mesh::{Mesh, shares};
use super::model::{Character, Joint};

const HEADER: usize = 3 * 4;
const VERTEX: usize = (3 + 2 + 3) * 4 + 4 + 4 * 4;
const TRIANGLE: usize = 3 * 2;
const NAME: usize = 32;
const BONE: usize = NAME + 4 + 10 * 4;

/// Parses the bytes of a file.
///
/// # Errors
/// [`Refusal`] with the byte, if the sizes are inconsistent or the parts do not make a character.
pub(super) fn parse(bytes: &[u8], name: String) -> Result<Character, Refusal> {
    let mut bytes = Bytes { bytes, at: 0 };
    let [vertices, triangles, bones] = bytes.counts()?;
    let positions_m = bytes.vectors(vertices)?;
    // Texture coordinates and normals do not affect the motion.
    bytes.take(vertices * (2 + 3) * 4);
    let skin = bytes.skin(vertices, bones)?;
    let triangles = bytes.triangles(triangles, vertices)?;
    let joints = bytes.joints(bones)?;
    Character::new(name, joints, Some(Mesh { positions_m, skin, triangles }))
}

/// The file's bytes, whose number was checked, and the read position.
struct Bytes<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    /// Reads the numbers of vertices, triangles and bones. Checks that they match the file's size.
    fn counts(&mut self) -> Result<[usize; 3], Refusal> {
        let found = self.bytes.len();
        if found < HEADER {
            let expected = "12 bytes of counts of vertices, triangles and bones";
            return Err(refuse("a Geno.bin", expected, format!("{found} bytes")));
        }
        let stored: [u64; 3] =
            core::array::from_fn(|_| u64::from(u32::from_le_bytes(self.array())));
        let [vertices, triangles, bones] = stored;
        let sizes = [(vertices, VERTEX), (triangles, TRIANGLE), (bones, BONE)];
        // Three products of 32 and 7 bits: no overflow is possible.
        let size =
            sizes.iter().fold(HEADER as u64, |sum, (count, size)| sum + count * *size as u64);
        if size != found as u64 {
            let expected = format!(
                "{size} bytes for {vertices} vertices, {triangles} triangles and {bones} bones as the first 12 say"
            );
            return Err(refuse("a Geno.bin", expected, format!("{found}")));
        }
        if bones > JOINT_COUNT_MAX as u64 {
            let expected = format!("at most {JOINT_COUNT_MAX} bones");
            return Err(refuse("a Geno.bin", expected, bones).at(FilePosition::Byte(8)));
        }
        Ok(stored.map(|count| usize::try_from(count).expect("no more than the file has bytes")))
    }

    fn take(&mut self, count: usize) -> &'a [u8] {
        let taken = &self.bytes[self.at..self.at + count];
        self.at += count;
        taken
    }

    fn array<const N: usize>(&mut self) -> [u8; N] {
        self.take(N).try_into().expect("as many as were taken")
    }

    fn number(&mut self) -> f64 {
        f64::from(f32::from_le_bytes(self.array()))
    }

    fn vector(&mut self, item: impl FnOnce() -> String) -> Result<DVec3, Refusal> {
        let place = FilePosition::Byte(self.at);
        let vector = DVec3::from_array(core::array::from_fn(|_| self.number()));
        if is_place(vector) {
            return Ok(vector);
        }
        Err(refuse(item(), A_PLACE, vector).at(place))
    }

    fn vectors(&mut self, count: usize) -> Result<Vec<DVec3>, Refusal> {
        (0..count).map(|vertex| self.vector(|| format!("vertex {vertex}"))).collect()
    }

    fn skin(&mut self, vertices: usize, bones: usize) -> Result<Vec<Vec<(usize, f64)>>, Refusal> {
        let indices_at = self.at;
        let indices = self.take(vertices * 4).chunks_exact(4);
        let skin = indices.enumerate().map(|(vertex, indices)| {
            let place = FilePosition::Byte(self.at);
            let weights: [f64; 4] = core::array::from_fn(|_| self.number());
            let pairs = indices.iter().map(|bone| usize::from(*bone)).zip(weights);
            let in_vertex = |r: Refusal| r.of(format!("vertex {vertex}")).at(place);
            let (shares, is_one) = shares(pairs).map_err(in_vertex)?;
            if !is_one {
                // The only program that writes this format divides by the sum.
                return Err(in_vertex(refuse("weights", "a sum of 1", "another")));
            }
            if let Some((bone, _)) = shares.iter().find(|(bone, _)| *bone >= bones) {
                let place = FilePosition::Byte(indices_at + 4 * vertex);
                let refusal =
                    refuse(format!("vertex {vertex}"), format!("bones below {bones}"), bone);
                return Err(refusal.at(place));
            }
            Ok(shares)
        });
        skin.collect()
    }

    fn triangles(&mut self, count: usize, vertices: usize) -> Result<Vec<[usize; 3]>, Refusal> {
        let triangle = |triangle| {
            let place = FilePosition::Byte(self.at);
            let corners: [usize; 3] =
                core::array::from_fn(|_| usize::from(u16::from_le_bytes(self.array())));
            match corners.iter().find(|corner| **corner >= vertices) {
                None => Ok(corners),
                Some(corner) => {
                    let expected = format!("vertices below {vertices}");
                    Err(refuse(format!("triangle {triangle}"), expected, corner).at(place))
                }
            }
        };
        (0..count).map(triangle).collect()
    }

    fn joints(&mut self, bones: usize) -> Result<Vec<Joint>, Refusal> {
        let named: Vec<(String, Option<usize>)> =
            (0..bones).map(|bone| self.bone(bone, bones)).collect::<Result<_, _>>()?;
        let joint = |(bone, (name, parent))| {
            let position_m = self.vector(|| format!("bone {bone} `{name}`"))?;
            let place = FilePosition::Byte(self.at);
            let rest: [f64; 7] = core::array::from_fn(|_| self.number());
            // Rotation and scale are not used, but a value that is not finite indicates damage.
            if rest.iter().all(|number| number.is_finite()) {
                return Ok(Joint { name, parent, position_m });
            }
            let item = format!("bone {bone} `{name}`");
            Err(refuse(item, "a finite rotation and scale", format!("{rest:?}")).at(place))
        };
        named.into_iter().enumerate().map(joint).collect()
    }

    fn bone(&mut self, bone: usize, bones: usize) -> Result<(String, Option<usize>), Refusal> {
        let place = FilePosition::Byte(self.at);
        let name = self.take(NAME);
        let end = name.iter().position(|byte| *byte == 0).unwrap_or(NAME);
        let name = core::str::from_utf8(&name[..end]).unwrap_or_default();
        if name.is_empty() || name.chars().any(char::is_control) {
            let found = "other bytes";
            return Err(refuse(format!("bone {bone}"), "a name in UTF-8", found).at(place));
        }
        let place = FilePosition::Byte(self.at);
        let parent = i32::from_le_bytes(self.array());
        if parent == -1 {
            return Ok((name.to_owned(), None));
        }
        let index = usize::try_from(parent).ok().filter(|index| *index < bones);
        let expected = || format!("a parent from -1 to {}", bones - 1);
        index
            .map(|index| (name.to_owned(), Some(index)))
            .ok_or_else(|| refuse(format!("bone {bone} `{name}`"), expected(), parent).at(place))
    }
}
