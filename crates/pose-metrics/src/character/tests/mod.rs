mod gltf_files;
mod shape_keys;
mod urdf_files;

use std::path::PathBuf;

use glam::DVec3;
use proptest::prelude::*;
use sinew_figure::measured::UnitOverrides;

use super::mesh::shares;
use super::*;

fn joint(name: &str, parent: Option<usize>, position_m: [f64; 3]) -> Joint {
    Joint { name: name.into(), parent, position_m: position_m.into() }
}

/// Returns the message with which a character of these joints is refused.
fn refusal(joints: Vec<Joint>, mesh: Option<Mesh>) -> String {
    Character::new("x".into(), joints, mesh).unwrap_err().to_string()
}

#[test]
fn only_trees_are_characters() {
    let hips = || joint("hips", None, [0.0; 3]);
    assert!(refusal(vec![], None).contains("expected 1 to 1024 joints, found 0"));
    assert_eq!(
        refusal(vec![hips(), joint("hips", Some(0), [0.0; 3])], None),
        "joint 1 `hips`: expected a name of its own, found that of joint 0"
    );
    assert_eq!(
        refusal(vec![hips(), joint("head", None, [0.0; 3])], None),
        "the character: expected one joint without a parent, found `hips` and `head`"
    );
    assert_eq!(
        refusal(vec![hips(), joint("head", Some(2), [0.0; 3])], None),
        "joint 1 `head`: expected a parent below 2, found 2"
    );
    let round = vec![hips(), joint("a", Some(2), [0.0; 3]), joint("b", Some(1), [0.0; 3])];
    assert_eq!(
        refusal(round, None),
        "joint 1 `a`: expected ancestors that end at a root, found a loop of parents"
    );
    assert!(refusal(vec![joint("a", Some(0), [0.0; 3])], None).contains("a loop of parents"));
    for bad in [f64::NAN, f64::INFINITY, 1e6] {
        let message = refusal(vec![joint("a", None, [0.0, bad, 0.0])], None);
        assert!(message.contains("joint 0 `a`: expected finite coordinates"), "{message}");
    }
}

/// Checks that a parent may have a larger index than its children.
#[test]
fn joints_may_come_in_any_order() {
    let joints = vec![joint("hand", Some(1), [0.0, 3.0, 4.0]), joint("arm", None, [0.0; 3])];
    let character = Character::new("x".into(), joints, None).unwrap();
    assert!((character.bone_length_m(0) - 5.0).abs() < 1e-15);
    assert!(character.bone_length_m(1).abs() < 1e-15);
    assert_eq!(character.find("arm"), Some(1));
}

#[test]
fn a_mesh_must_hang_together() {
    let mesh = || Mesh {
        positions_m: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        skin: vec![vec![(0, 1.0)]; 3],
        triangles: vec![[0, 1, 2]],
    };
    let with = |change: fn(&mut Mesh)| {
        let mut mesh = mesh();
        change(&mut mesh);
        refusal(vec![joint("a", None, [0.0; 3])], Some(mesh))
    };
    assert!(with(|m| m.skin.truncate(2)).contains("expected skin of 3 vertices, found 2"));
    assert!(with(|m| m.triangles[0][1] = 3).contains("triangle 0: expected vertices below 3"));
    assert!(with(|m| m.skin[1][0].0 = 1).contains("vertex 1: expected joints below 1, found 1"));
    assert!(with(|m| m.skin[1][0].1 = 0.9).contains("vertex 1: expected shares above 0 that sum"));
    assert!(with(|m| m.skin[2][0].1 = f64::NAN).contains("vertex 2: expected shares"));
    assert!(with(|m| m.positions_m[2].z = f64::NAN).contains("vertex 2: expected finite"));
}

#[test]
fn shares_are_made_to_sum_to_one() {
    let eight_bits = [(3, 127.0 / 255.0), (4, 127.0 / 255.0), (0, 0.0)];
    assert_eq!(shares(eight_bits).unwrap(), (vec![(3, 0.5), (4, 0.5)], true));
    assert_eq!(shares([(0, 0.5), (1, 1.5)]).unwrap(), (vec![(0, 0.25), (1, 0.75)], false));
    assert!(shares([(0, 0.0)]).unwrap_err().to_string().contains("expected a sum of 1, found 0"));
    for bad in [-0.1, f64::NAN, f64::INFINITY] {
        shares([(0, bad), (1, 1.0)]).unwrap_err();
    }
}

/// Tests a square of two triangles, and a vertex that belongs to no triangle.
#[test]
fn a_vertex_stands_for_the_surface_around_it() {
    let mesh = Mesh {
        positions_m: [
            DVec3::ZERO,
            2.0 * DVec3::X,
            DVec3::new(2.0, 2.0, 0.0),
            2.0 * DVec3::Y,
            DVec3::Z,
        ]
        .into(),
        skin: vec![vec![(0, 1.0)]; 5],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let close = |areas: &[f64], expected: [f64; 5]| {
        areas.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12)
    };
    let third = 2.0 / 3.0;
    let surface = mesh.vertex_areas_m2(VertexArea::Surface);
    assert!(close(&surface, [2.0 * third, third, 2.0 * third, third, 0.0]), "{surface:?}");
    let article = mesh.vertex_areas_m2(VertexArea::Article);
    assert!(close(&article, [2.0, 2.0, 2.0, 2.0, 0.0]), "{article:?}");
}

/// Returns a Geno.bin of two bones, three vertices and a triangle.
fn geno_bin() -> Vec<u8> {
    let mut bytes: Vec<u8> = [3_u32, 1, 2].iter().flat_map(|n| n.to_le_bytes()).collect();
    let floats = |bytes: &mut Vec<u8>, numbers: &[f32]| {
        bytes.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
    };
    floats(&mut bytes, &[0.0, 1.0, 0.0, 0.5, 1.0, 0.0, 0.0, 1.5, 0.0]);
    floats(&mut bytes, &[0.0; 3 * 5]);
    bytes.extend([0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    floats(&mut bytes, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.25, 0.75, 0.0, 0.0]);
    bytes.extend([0_u16, 1, 2].iter().flat_map(|n| n.to_le_bytes()));
    for (name, parent) in [("Hips", -1_i32), ("Spine", 0)] {
        let mut padded = [0; 32];
        padded[..name.len()].copy_from_slice(name.as_bytes());
        bytes.extend(padded);
        bytes.extend(parent.to_le_bytes());
    }
    for y in [1.0, 1.25] {
        floats(&mut bytes, &[0.0, y, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
    }
    bytes
}

fn geno(bytes: &[u8]) -> Result<Character, Refusal> {
    geno::parse(bytes, "geno".into())
}

#[test]
fn a_geno_bin_is_read() {
    let character = geno(&geno_bin()).unwrap();
    assert_eq!(
        character.joints(),
        [joint("Hips", None, [0.0, 1.0, 0.0]), joint("Spine", Some(0), [0.0, 1.25, 0.0])]
    );
    let mesh = character.mesh().unwrap();
    assert_eq!(mesh.positions_m[2], DVec3::new(0.0, 1.5, 0.0));
    assert_eq!(mesh.skin, [vec![(0, 1.0)], vec![(1, 1.0)], vec![(0, 0.25), (1, 0.75)]]);
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
}

#[test]
fn a_damaged_geno_bin_is_refused_with_its_place() {
    let message = |at: usize, new: &[u8]| {
        let mut bytes = geno_bin();
        bytes[at..at + new.len()].copy_from_slice(new);
        geno(&bytes).unwrap_err().to_string()
    };
    let bones = 12 + 3 * 52 + 6;
    assert_eq!(
        message(0, &[4]),
        "a Geno.bin: expected 378 bytes for 4 vertices, 1 triangles and 2 bones as the first 12 say, found 326"
    );
    let nan = f32::NAN.to_le_bytes();
    assert!(
        message(24, &nan).starts_with("byte 24: vertex 1: expected finite"),
        "{}",
        message(24, &nan)
    );
    assert!(message(112, &[9]).starts_with("byte 112: vertex 1: expected bones below 2, found 9"));
    assert!(
        message(120, &0.5_f32.to_le_bytes())
            .starts_with("byte 120: vertex 0: weights: expected a sum of 1, found another")
    );
    assert!(
        message(168, &[3]).starts_with("byte 168: triangle 0: expected vertices below 3, found 3")
    );
    assert!(message(bones, &[0]).starts_with("byte 174: bone 0: expected a name in UTF-8"));
    assert!(
        message(bones + 68, &[7])
            .contains("bone 1 `Spine`: expected a parent from -1 to 1, found 7")
    );
    assert!(message(bones + 68, &[1]).contains("joint 1 `Spine`: expected ancestors"));
    assert!(message(bones + 72, &nan).contains("bone 0 `Hips`: expected finite coordinates"));
    assert!(message(bones + 84, &nan).contains("expected a finite rotation and scale"));
    assert!(geno(&[]).unwrap_err().to_string().contains("found 0 bytes"));
}

/// Generates changes of a file: kind, place, and byte.
fn damage() -> impl Strategy<Value = Vec<(u8, prop::sample::Index, u8)>> {
    prop::collection::vec((0..4_u8, any::<prop::sample::Index>(), any::<u8>()), 1..5)
}

/// Overwrites, inserts and removes bytes, and truncates the file.
fn damaged(mut bytes: Vec<u8>, damage: Vec<(u8, prop::sample::Index, u8)>) -> Vec<u8> {
    for (kind, at, byte) in damage {
        if bytes.is_empty() {
            break;
        }
        let at = at.index(bytes.len());
        match kind {
            0 => bytes[at] = byte,
            1 => bytes.insert(at, byte),
            2 => drop(bytes.drain(at..(at + usize::from(byte)).min(bytes.len()))),
            _ => bytes.truncate(at),
        }
    }
    bytes
}

/// Checks that a character that was read is valid, with the constructor.
fn check(read: Result<Character, Refusal>) {
    if let Ok(Character { name, joints, mesh, notes: _ }) = read {
        Character::new(name, joints, mesh).unwrap();
    }
}

proptest! {
    #[test]
    fn no_damage_makes_the_reader_of_geno_panic(damage in damage()) {
        check(geno(&damaged(geno_bin(), damage)));
    }

    #[test]
    fn no_bytes_make_the_reader_of_geno_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        check(geno(&bytes));
    }

    /// Checks that a truncated file is not recognized, since the file is identified by its size alone.
    #[test]
    fn a_cut_geno_bin_is_refused(at in 0..326_usize) {
        prop_assert!(geno(&geno_bin()[..at]).is_err());
    }
}

const BVH: &str = "HIERARCHY ROOT a\n{ OFFSET 0 100 0 CHANNELS 3 Zrotation Xrotation Yrotation End Site { OFFSET 0 -10 0 } JOINT b\n\
    { OFFSET 0 0 20 CHANNELS 3 Zrotation Xrotation Yrotation End Site { OFFSET 0 5 0 } End Site { OFFSET 0 0 0 }\n\
    End Site { OFFSET 1 0 0 } } }\nMOTION Frames: 2 Frame Time: 0.01\n0 0 0 0 0 0\n90 0 0 0 0 0\n";

fn units(metres_per_unit: f64) -> UnitOverrides {
    UnitOverrides { metres_per_unit: Some(metres_per_unit), up: None }
}

fn bvh(options: &Options) -> Result<Character, Error> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("two.bvh");
    std::fs::write(&file, BVH).unwrap();
    read(&file, options)
}

#[test]
fn a_skeleton_has_joints_at_the_ends_of_its_bones() {
    let options = Options { units: units(0.01), frame: None };
    let character = bvh(&options).unwrap();
    assert_eq!(character.name(), "two");
    assert_eq!(
        character.joints(),
        [
            joint("a", None, [0.0, 1.0, 0.0]),
            joint("aEnd", Some(0), [0.0, 0.9, 0.0]),
            joint("b", Some(0), [0.0, 1.0, 0.2]),
            joint("bEnd", Some(2), [0.0, 1.05, 0.2]),
            joint("bEnd2", Some(2), [0.01, 1.0, 0.2]),
        ]
    );
    // Frame 1 turns the root by 90 degrees about z: y becomes -x.
    let turned = bvh(&Options { frame: Some(1), ..options }).unwrap();
    let end = turned.joints()[3].position_m;
    assert!(end.distance(DVec3::new(-0.05, 1.0, 0.2)) < 1e-12, "{end}");
}

#[test]
fn a_skeleton_without_unit_or_frame_is_refused() {
    let message = |options: &Options| bvh(options).unwrap_err().to_string();
    let unit = message(&Options::default());
    assert!(
        unit.contains("no arms and legs show the body's height; give it with --metres-per-unit"),
        "{unit}"
    );
    let frame = message(&Options { units: units(0.01), frame: Some(2) });
    assert!(frame.contains("two.bvh: --frame: expected a frame below 2, found 2"), "{frame}");
}

fn data() -> PathBuf {
    std::env::var_os("SINEW_DATA").expect("SINEW_DATA names the folder of the data").into()
}

/// Checks that mesh and motion are of one character: equal joints, bones of equal length, and frame 0 in the pose
/// of the mesh.
#[test]
#[ignore = "needs SINEW_DATA"]
fn geno_is_the_same_in_both_of_its_files() {
    let options = Options { frame: Some(0), ..Options::default() };
    let geno = read(&data().join("geno/Geno.bin"), &Options::default()).unwrap();
    let bind = read(&data().join("geno/Geno_bind.bvh"), &options).unwrap();
    assert_eq!((geno.joints().len(), bind.joints().len()), (75, 75));
    for (mesh, motion) in geno.joints().iter().zip(bind.joints()) {
        assert_eq!((&mesh.name, mesh.parent), (&motion.name, motion.parent));
        let off_m = mesh.position_m.distance(motion.position_m);
        assert!(off_m < 1e-4, "{}: {off_m}", mesh.name);
    }
    let mesh = geno.mesh().unwrap();
    assert_eq!((mesh.positions_m.len(), mesh.triangles.len()), (10329, 18660));
    let surface_m2: f64 = mesh.triangle_areas_m2().iter().sum();
    let of_vertices_m2: f64 = mesh.vertex_areas_m2(VertexArea::Surface).iter().sum();
    assert!((surface_m2 - 1.697).abs() < 1e-3 && (surface_m2 - of_vertices_m2).abs() < 1e-9);
}
