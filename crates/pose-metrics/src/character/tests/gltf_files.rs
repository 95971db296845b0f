use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::*;

/// The bytes of a buffer, and the buffer's views.
#[derive(Default)]
struct Data {
    bytes: Vec<u8>,
    views: Vec<Value>,
}

impl Data {
    fn view<const N: usize>(&mut self, chunks: impl IntoIterator<Item = [u8; N]>) {
        let offset = self.bytes.len();
        self.bytes.extend(chunks.into_iter().flatten());
        let length = self.bytes.len() - offset;
        self.views.push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": length }));
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
    }

    fn floats(&mut self, numbers: &[f32]) {
        self.view(numbers.iter().map(|number| number.to_le_bytes()));
    }
}

/// Returns an arm of two joints under a node in centimetres, with a node between the joints and a square of skin.
/// It is modelled in centimetres, and in metres in the world.
fn arm() -> (Value, Vec<u8>) {
    let mut data = Data::default();
    data.floats(&[0.0, 0.0, 0.0, 100.0, 0.0, 0.0, 100.0, 10.0, 0.0, 0.0, 10.0, 0.0]);
    data.view([[0_u8, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0]]);
    data.view([[255_u8, 0, 0, 0], [255, 0, 0, 0], [255, 0, 0, 0], [51, 204, 0, 0]]);
    data.view([0_u16, 1, 2, 0, 2, 3].map(u16::to_le_bytes));
    let mut inverse = [0.0; 32];
    for diagonal in (0..16).step_by(5) {
        inverse[diagonal] = 1.0;
        inverse[16 + diagonal] = 1.0;
    }
    // The elbow was at x = 60 when the skin was modelled.
    inverse[16 + 12] = -60.0;
    data.floats(&inverse);
    let file = json!({
        "asset": { "version": "2.0" },
        "nodes": [
            { "name": "armature", "scale": [0.01, 0.01, 0.01], "translation": [0.0, 1.0, 0.0], "children": [1] },
            { "name": "shoulder", "children": [2] },
            { "name": "between", "rotation": [0.0, 0.0, 0.707_106_77, 0.707_106_77], "children": [3] },
            { "name": "elbow", "translation": [60.0, 0.0, 0.0], "children": [] },
            { "name": "skin", "mesh": 0, "skin": 0, "translation": [7.0, 7.0, 7.0] },
        ],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2 }, "indices": 3,
        }] }],
        "skins": [{ "joints": [1, 3], "inverseBindMatrices": 4 }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
              "min": [0.0, 0.0, 0.0], "max": [100.0, 10.0, 0.0] },
            { "bufferView": 1, "componentType": 5121, "count": 4, "type": "VEC4" },
            { "bufferView": 2, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC4" },
            { "bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR" },
            { "bufferView": 4, "componentType": 5126, "count": 2, "type": "MAT4" },
        ],
        "bufferViews": data.views,
        "buffers": [{ "byteLength": data.bytes.len() }],
    });
    (file, data.bytes)
}

/// Returns the file as a `.glb`.
fn glb((file, mut bytes): (Value, Vec<u8>)) -> Vec<u8> {
    let mut text = file.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let word = |number: usize| u32::try_from(number).unwrap().to_le_bytes();
    let size = word(12 + 8 + text.len() + 8 + bytes.len());
    let parts: [&[u8]; 9] = [
        b"glTF",
        &word(2),
        &size,
        &word(text.len()),
        b"JSON",
        &text,
        &word(bytes.len()),
        b"BIN\0",
        &bytes,
    ];
    parts.concat()
}

/// Returns the file as a `.gltf` with an embedded buffer.
fn embedded((mut file, bytes): (Value, Vec<u8>)) -> Vec<u8> {
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes));
    file["buffers"][0]["uri"] = uri.into();
    file.to_string().into_bytes()
}

fn parse(bytes: &[u8]) -> Result<Character, Refusal> {
    gltf::parse(bytes, "arm".into(), Path::new(""))
}

/// Parses the arm after a change.
fn changed(change: impl FnOnce(&mut Value)) -> Result<Character, Refusal> {
    let (mut file, bytes) = arm();
    change(&mut file);
    parse(&embedded((file, bytes)))
}

fn close(found: DVec3, expected: [f64; 3]) {
    assert!(found.distance(expected.into()) < 1e-6, "{found} for {expected:?}");
}

#[test]
fn a_skinned_character_stands_in_its_bind_pose() {
    let character = parse(&glb(arm())).unwrap();
    let [shoulder, elbow] = character.joints() else { panic!("{:?}", character.joints()) };
    assert_eq!((shoulder.name.as_str(), shoulder.parent), ("shoulder", None));
    assert_eq!((elbow.name.as_str(), elbow.parent), ("elbow", Some(0)));
    close(shoulder.position_m, [0.0, 1.0, 0.0]);
    // In the scene the elbow is raised; in the bind pose the arm is straight.
    close(elbow.position_m, [0.6, 1.0, 0.0]);
    let mesh = character.mesh().unwrap();
    close(mesh.positions_m[2], [1.0, 1.1, 0.0]);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.skin[1], [(1, 1.0)]);
    assert_eq!(mesh.skin[3], [(0, 51.0 / 255.0), (1, 204.0 / 255.0)]);
}

#[test]
fn buffers_may_be_in_the_file_or_beside_it() {
    let character = parse(&glb(arm())).unwrap();
    assert_eq!(parse(&embedded(arm())).unwrap(), character);
    let folder = tempfile::tempdir().unwrap();
    let (mut file, bytes) = arm();
    file["buffers"][0]["uri"] = "the%20arm.bin".into();
    std::fs::write(folder.path().join("the arm.bin"), bytes).unwrap();
    let path = folder.path().join("arm.gltf");
    std::fs::write(&path, file.to_string()).unwrap();
    let beside = read(&path, &Options::default()).unwrap();
    assert_eq!((beside.joints(), beside.mesh()), (character.joints(), character.mesh()));
    for (uri, told) in [
        ("https://a.b/c.bin", "expected a file in the folder of this one"),
        ("../arm.bin", "expected a file in the folder of this one"),
        ("no.bin", "buffer 0: URI: expected a file that can be read"),
        ("data:,abc", "expected data in base64"),
        ("data:x;base64,?", "expected base64"),
        ("data:x;base64,AAAA", "buffer 0: data: expected"),
    ] {
        file["buffers"][0]["uri"] = uri.into();
        std::fs::write(&path, file.to_string()).unwrap();
        let message = read(&path, &Options::default()).unwrap_err().to_string();
        assert!(message.contains("arm.gltf: ") && message.contains(told), "{message}");
    }
}

#[test]
fn without_bind_matrices_joints_stand_as_the_scene_has_them() {
    let remove = |file: &mut Value| {
        file["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    };
    let character = changed(remove).unwrap();
    // Raised by the node between the joints.
    close(character.joints()[1].position_m, [0.0, 1.6, 0.0]);
    // Vertex 1 is in the elbow's frame: 100 along its x axis, which points up.
    close(character.mesh().unwrap().positions_m[1], [0.0, 2.6, 0.0]);
}

#[test]
fn joints_in_two_halves_get_the_node_above_as_their_root() {
    let character = changed(|file| {
        file["nodes"][1]["children"] = json!([]);
        file["nodes"][0]["children"] = json!([1, 2]);
    })
    .unwrap();
    let parents: Vec<_> = character.joints().iter().map(|j| (j.name.as_str(), j.parent)).collect();
    assert_eq!(parents, [("shoulder", Some(2)), ("elbow", Some(2)), ("armature", None)]);
    let message = changed(|file| {
        file["nodes"][1].as_object_mut().unwrap().remove("children");
    });
    let message = message.unwrap_err().to_string();
    assert!(message.contains("the joints: expected one root, or a node above all"), "{message}");
}

#[test]
fn a_mesh_on_a_joint_moves_with_it() {
    let character = changed(|file| {
        file["nodes"][3]["children"] = json!([5]);
        let watch = json!({ "name": "watch", "mesh": 0, "translation": [0.0, 0.0, 5.0] });
        file["nodes"].as_array_mut().unwrap().push(watch);
        // A mesh that is not attached to a joint is scenery.
        file["nodes"].as_array_mut().unwrap().push(json!({ "name": "floor", "mesh": 0 }));
    })
    .unwrap();
    let mesh = character.mesh().unwrap();
    assert_eq!((mesh.positions_m.len(), mesh.triangles.len()), (8, 4));
    assert_eq!((&mesh.skin[4], mesh.triangles[3]), (&vec![(1, 1.0)], [4, 6, 7]));
    close(mesh.positions_m[4], [0.6, 1.0, 0.05]);
}

/// Lines, and an incomplete triangle, on nodes that do not belong to the character.
#[test]
fn scenery_may_be_anything() {
    let character = changed(|file| {
        let mut mesh = file["meshes"][0].clone();
        mesh["primitives"][0]["mode"] = 1.into();
        file["meshes"].as_array_mut().unwrap().push(mesh.clone());
        mesh["primitives"][0] = json!({ "attributes": { "POSITION": 0 } });
        file["meshes"].as_array_mut().unwrap().push(mesh);
        for mesh in [1, 2] {
            let node = json!({ "name": "floor", "mesh": mesh, "scale": [0.0, 0.0, 0.0] });
            file["nodes"].as_array_mut().unwrap().push(node);
        }
    });
    assert_eq!(character, parse(&glb(arm())));
}

#[test]
fn rotations_are_unit_quaternions() {
    let rotated = |rotation: [f32; 4]| changed(|f| f["nodes"][2]["rotation"] = json!(rotation));
    let character = rotated([0.0, 0.0, 0.706_8, 0.706_8]).unwrap();
    assert_eq!(character, parse(&glb(arm())).unwrap());
    for (rotation, found) in [
        ([0.0, 0.0, 2.0, 0.0], "[0.0, 0.0, 2.0, 0.0] of length 2"),
        ([0.0; 4], "[0.0, 0.0, 0.0, 0.0] of length 0"),
        ([0.0, 0.0, 0.0, 0.75], "[0.0, 0.0, 0.0, 0.75] of length 0.75"),
    ] {
        let expected =
            format!("node 2 `between`: rotation: expected a quaternion of length 1, found {found}");
        assert_eq!(rotated(rotation).unwrap_err().to_string(), expected);
    }
    // Rounding changes only the length, which is normalized.
    let unbound = |rotation: [f32; 4]| {
        changed(|file| {
            file["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
            file["nodes"][2]["rotation"] = json!(rotation);
        })
    };
    close(unbound([0.0, 0.0, 0.706_8, 0.706_8]).unwrap().joints()[1].position_m, [0.0, 1.6, 0.0]);
}

#[test]
fn nodes_that_are_used_have_an_inverse() {
    let message = |change: fn(&mut Value)| changed(change).unwrap_err().to_string();
    assert_eq!(
        message(|f| f["nodes"][0]["scale"] = json!([0.01, 0.0, 0.01])),
        "skin 0: node 0 `armature`: scale: expected three numbers other than 0, found [0.01, 0.0, 0.01]"
    );
    let singular = message(|f| {
        // The third column is the sum of the first two.
        f["nodes"][1]["matrix"] =
            json!([1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    });
    assert!(
        singular.starts_with(
            "skin 0: node 1 `shoulder`: matrix: expected one that has an inverse, found [[1.0,"
        ),
        "{singular}"
    );
    // Small axes are accepted, since they are far from linearly dependent.
    changed(|f| f["nodes"][0]["scale"] = json!([1e-9, 0.01, -0.01])).unwrap();
}

#[test]
fn strips_and_fans_are_triangles() {
    let mode = |mode: u32| {
        let character = changed(|file| file["meshes"][0]["primitives"][0]["mode"] = mode.into());
        character.map(|character| character.mesh().unwrap().triangles.clone())
    };
    assert_eq!(mode(5).unwrap(), [[0, 1, 2], [2, 1, 0], [2, 0, 2], [2, 0, 3]]);
    assert_eq!(mode(6).unwrap(), [[0, 1, 2], [0, 2, 0], [0, 0, 2], [0, 2, 3]]);
    assert!(
        mode(1).unwrap_err().to_string().contains("node 4: primitive 0: mode: expected triangles")
    );
    let plain = changed(|file| {
        file["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("indices");
    });
    assert!(plain.unwrap_err().to_string().contains("expected three indices of each, found 4"));
}

#[test]
fn damage_is_named() {
    let message = |change: fn(&mut Value)| changed(change).unwrap_err().to_string();
    for (told, message) in [
        ("expected glTF 2.0", message(|f| f["skins"][0]["joints"][1] = 9.into())),
        (
            "an attribute of a mesh: expected an accessor below 5, found 9",
            message(|f| f["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 9.into()),
        ),
        (
            "expected a node with a mesh and a skin, found none",
            message(|f| _ = f["nodes"].as_array_mut().unwrap().pop()),
        ),
        (
            "skin 0: accessor 0: expected Mat4",
            message(|f| f["skins"][0]["inverseBindMatrices"] = 0.into()),
        ),
        (
            "expected 2 inverse bind matrices, found 1",
            message(|f| f["accessors"][4]["count"] = 1.into()),
        ),
        (
            "accessor 4: expected 3 elements within buffer 0",
            message(|f| f["accessors"][4]["count"] = 3.into()),
        ),
        (
            "node 2: expected one parent, found 0 and 1",
            message(|f| f["nodes"][0]["children"] = json!([1, 2])),
        ),
        (
            "expected ancestors that end at a root",
            message(|f| {
                f["nodes"][0]["children"] = json!([]);
                f["nodes"][3]["children"] = json!([1]);
            }),
        ),
        (
            "JOINTS_0 and WEIGHTS_0: expected 4 as of POSITION, found 3 and 4",
            message(|f| f["accessors"][1]["count"] = 3.into()),
        ),
        (
            "expected both JOINTS_0 and WEIGHTS_0",
            message(|f| {
                f["meshes"][0]["primitives"][0]["attributes"]
                    .as_object_mut()
                    .unwrap()
                    .remove("WEIGHTS_0");
            }),
        ),
        (
            "vertex 0: weights: expected a sum of 1, found 0",
            message(|f| f["accessors"][2]["bufferView"] = 1.into()),
        ),
        (
            "expected glTF 2.0",
            message(|f| {
                f["accessors"][2].as_object_mut().unwrap().remove("bufferView");
            }),
        ),
    ] {
        assert!(message.contains(told), "{message}");
    }
    let mut bytes = glb(arm());
    bytes[8] = 3;
    let header = parse(&bytes).unwrap_err().to_string();
    assert!(header.starts_with("byte 8: the header: expected the file's size"), "{header}");
}

#[test]
fn weights_that_do_not_sum_to_one_are_divided_by_their_sum_and_told() {
    let (file, mut bytes) = arm();
    let at = bytes.windows(4).position(|weights| weights == [51, 204, 0, 0]).unwrap();
    bytes[at] = 204;
    let character = parse(&embedded((file, bytes))).unwrap();
    let told = "the weights of 1 vertices do not sum to 1 and were divided by their sum";
    assert!(character.notes().iter().any(|note| note == told), "{:?}", character.notes());
    assert_eq!(character.mesh().unwrap().skin[3], [(0, 0.5), (1, 0.5)]);
}

#[test]
fn what_is_only_stored_otherwise_is_read_and_what_is_packed_named() {
    let requires = |name: &str| changed(|f| f["extensionsRequired"] = json!([name]));
    for name in ["KHR_mesh_quantization", "KHR_materials_unlit", "VRMC_vrm", "KHR_texture_basisu"] {
        assert_eq!(requires(name), parse(&embedded(arm())), "{name}");
    }
    let packed = requires("EXT_meshopt_compression").unwrap_err().to_string();
    assert!(packed.contains("`gltfpack -noq -kn -i IN.glb -o OUT.glb` unpacks them"), "{packed}");
    assert!(packed.ends_with("found `EXT_meshopt_compression`"), "{packed}");
    assert!(requires("EXT_unheard_of").is_err());
    // Corners as integers of 16 bits; when normalized, 32767 represents 1.
    for (normalized, factor) in [(false, 1.0), (true, 1.0 / 32767.0)] {
        let (mut file, mut bytes) = arm();
        let at = bytes.len();
        for number in [0_i16, 0, 0, 0, 100, 0, 0, 0, 100, 10, 0, 0, 0, 10, -5, 0] {
            bytes.extend(number.to_le_bytes());
        }
        let views = file["bufferViews"].as_array_mut().unwrap();
        let place = views.len();
        views.push(json!({ "buffer": 0, "byteOffset": at, "byteLength": 32, "byteStride": 8 }));
        file["accessors"][0] = json!({
            "bufferView": place, "componentType": 5122, "normalized": normalized, "count": 4, "type": "VEC3",
            "min": [0, 0, -5], "max": [100, 10, 0],
        });
        file["buffers"][0]["byteLength"] = bytes.len().into();
        let character = parse(&embedded((file, bytes))).unwrap();
        let corners = &character.mesh().unwrap().positions_m;
        close(corners[1], [factor, 1.0, 0.0]);
        close(corners[3], [0.0, 1.0 + 0.1 * factor, -0.05 * factor]);
    }
}

/// Returns numbers that are valid in JSON but not in glTF.
fn odd_number() -> impl Strategy<Value = Value> {
    prop_oneof![
        (-3_i64..12).prop_map(Value::from),
        any::<u64>().prop_map(Value::from),
        any::<f64>().prop_map(Value::from),
        Just(Value::Null),
        Just(json!([])),
    ]
}

/// Replaces the numbers of a document at these places.
fn with_odd_numbers(value: &mut Value, next: &mut usize, odd: &[(usize, Value)]) {
    match value {
        Value::Number(_) => {
            if let Some((_, odd)) = odd.iter().find(|(place, _)| place == next) {
                *value = odd.clone();
            }
            *next += 1;
        }
        Value::Array(values) => values.iter_mut().for_each(|v| with_odd_numbers(v, next, odd)),
        Value::Object(values) => values.values_mut().for_each(|v| with_odd_numbers(v, next, odd)),
        _ => {}
    }
}

proptest! {
    #[test]
    fn no_damage_makes_the_reader_of_gltf_panic(damage in damage()) {
        check(parse(&damaged(glb(arm()), damage.clone())));
        check(parse(&damaged(embedded(arm()), damage)));
    }

    #[test]
    fn no_odd_numbers_make_it_panic(odd in prop::collection::vec((0..80_usize, odd_number()), 1..4)) {
        let (mut file, bytes) = arm();
        with_odd_numbers(&mut file, &mut 0, &odd);
        check(parse(&glb((file, bytes))));
    }
}
