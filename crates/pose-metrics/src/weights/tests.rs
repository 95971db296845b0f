use glam::DVec3;
use proptest::prelude::*;

use super::radii::{self, PER_LENGTH};
use super::*;
use crate::character::{Joint, Mesh};

fn joint(name: &str, parent: Option<usize>, position_m: DVec3) -> Joint {
    Joint { name: name.into(), parent, position_m }
}

/// Returns an arm along x whose last bone has no length. Its joints are listed from the end inwards.
fn arm(mesh: Option<Mesh>) -> Character {
    let joints = vec![
        joint("hand end", Some(1), DVec3::X * 1.5),
        joint("hand", Some(2), DVec3::X * 1.5),
        joint("elbow", Some(3), DVec3::X),
        joint("shoulder", None, DVec3::ZERO),
    ];
    Character::new("arm".into(), joints, mesh).unwrap()
}

/// Returns a tube of 24 sides around the arm: radius 0.1 m around the upper arm, 0.05 m around the rest.
fn sleeve() -> Mesh {
    let mut mesh = Mesh::default();
    let sides = 24_u8;
    for (joint, from_m, to_m, radius_m) in [(3, 0.0, 1.0, 0.1), (2, 1.0, 1.5, 0.05)] {
        for ring in 0..=20 {
            let x = from_m + (to_m - from_m) * f64::from(ring) / 20.0;
            let first = mesh.positions_m.len();
            for side in 0..sides {
                let (sin, cos) =
                    (f64::from(side) * std::f64::consts::TAU / f64::from(sides)).sin_cos();
                mesh.positions_m.push(DVec3::new(x, radius_m * cos, radius_m * sin));
                mesh.skin.push(vec![(joint, 1.0)]);
                let here = first + usize::from(side);
                let next = first + usize::from((side + 1) % sides);
                if ring > 0 {
                    mesh.triangles.push([here, next, here - 24]);
                    mesh.triangles.push([next, here - 24, next - 24]);
                }
            }
        }
    }
    mesh
}

fn close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 1e-6, "{found} for {expected}");
    }
}

#[test]
fn lengths_of_an_arm() {
    let settings = Settings { base: Some(0.25), discount: 0.5, ..Settings::default() };
    let weighing = weigh(&arm(None), Method::Lengths, &settings).unwrap();
    // hand: 0.25 + 0.5 (0 + 0.25); elbow: 0.25 + 0.5 (0.5 + 0.375); shoulder: 0.25 + 0.5 (1 + 0.6875).
    let raw = [0.25, 0.375, 0.6875, 1.09375];
    let sum: f64 = raw.iter().sum();
    close(&weighing.weights, &raw.map(|weight| weight / sum));
}

/// Checks that the estimated radii are those of the sleeve, and that its skin gives the weights of cylinders with
/// these radii.
#[test]
fn radii_are_those_of_the_sleeve() {
    let character = arm(Some(sleeve()));
    let radii_m = Radii::Estimated.of(&character).unwrap();
    assert!((radii_m[2] - 0.1).abs() < 1e-12 && (radii_m[1] - 0.05).abs() < 1e-12, "{radii_m:?}");
    assert_eq!((radii_m[0].to_bits(), radii_m[3].to_bits()), (0, 0), "no bone: {radii_m:?}");
    let base = Some(0.01);
    let settings = Settings { base, ..Settings::default() };
    let cylinders = weigh(&character, Method::Cylinders, &settings).unwrap();
    let mesh = weigh(&character, Method::Mesh, &settings).unwrap();
    for (cylinder, mesh) in cylinders.weights.iter().zip(&mesh.weights) {
        // The tube has 24 flat sides, and a ring for each twentieth of a bone.
        assert!((mesh / cylinder - 1.0).abs() < 0.02, "{mesh} for {cylinder}");
    }
}

#[test]
fn bones_without_skin_are_as_thick_as_they_are_long() {
    let radii_m = Radii::Estimated.of(&arm(None)).unwrap();
    assert_eq!(radii_m, [0.0, 0.5 * PER_LENGTH, PER_LENGTH, 0.0]);
    assert_eq!(Radii::Uniform(0.03).of(&arm(None)).unwrap(), [0.0, 0.03, 0.03, 0.0]);
}

fn given(text: &str) -> Result<Vec<f64>, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("radii.csv");
    std::fs::write(&file, text).unwrap();
    let radii_m = radii::read(&file).and_then(|given| Radii::Given(given).of(&arm(None)));
    radii_m.map_err(|error| error.to_string().replace(&file.display().to_string(), "FILE"))
}

#[test]
fn radii_are_read_by_joint() {
    let radii_m = given("radius_m,joint,more\n0.04,hand,x\n,shoulder,\n0.06,elbow,y\n").unwrap();
    assert_eq!(radii_m, [0.0, 0.04, 0.06, 0.0]);
    let character = arm(None);
    let estimated = Radii::Estimated.of(&character).unwrap();
    assert_eq!(given(&table::csv(&character, Some(&estimated), &[])).unwrap(), estimated);
}

#[test]
fn radii_that_do_not_fit_are_refused() {
    let message = |text: &str| given(text).unwrap_err();
    assert_eq!(
        message("joint,radius_m\nhand,0.04\nelbow,-1\n"),
        "FILE:3: joint `elbow`: expected metres from 0 to 100000, found -1.0"
    );
    assert_eq!(
        message("joint,radius_m\nhand,1e30\n"),
        "FILE:2: joint `hand`: expected metres from 0 to 100000, found 1e30"
    );
    assert_eq!(
        message("joint,radius_m\nhand,0.04\nhand,0.05\n"),
        "FILE:3: joint `hand`: expected each joint once, found it in line 2 too"
    );
    assert_eq!(
        message("joint,radius_m\nhand,0.04\nknee,0.05\n"),
        "FILE:3: joint `knee`: expected a joint of arm, found none of this name"
    );
    assert_eq!(
        message("joint,radius_m\nhand end,0.04\n"),
        "FILE: expected a radius of every bone that has a length, found none of joint `hand` and 1 others"
    );
    assert_eq!(
        message("joint,radius\nhand,0.04\n"),
        "FILE:1: expected the columns joint and radius_m, found joint, radius"
    );
    let no_number = message("joint,radius_m\nhand,thick\n");
    assert!(no_number.contains("line: 2"), "{no_number}");
    assert!(message("joint,radius_m\nhand,NaN\n").contains("found NaN"));
}

#[test]
fn what_cannot_be_weighed_is_refused() {
    let message =
        |method, settings: &Settings| weigh(&arm(None), method, settings).unwrap_err().to_string();
    let default = Settings::default;
    assert_eq!(
        message(Method::Mesh, &default()),
        "method mesh: expected a character with a skinned mesh, found a skeleton only"
    );
    for base in [-0.1, f64::NAN, f64::INFINITY, 1e60, 3e38] {
        let message = message(Method::Lengths, &Settings { base: Some(base), ..default() });
        assert_eq!(message, format!("base: expected a number from 0 to 1e15, found {base:?}"));
    }
    let message_of = |discount| message(Method::Lengths, &Settings { discount, ..default() });
    assert_eq!(message_of(1.1), "discount: expected a number from 0 to 1, found 1.1");
    for radius_m in [-0.1, f64::NAN, 1e30] {
        let radii = Radii::Uniform(radius_m);
        let message = message(Method::Cylinders, &Settings { radii, ..default() });
        let expected = format!("radii: expected metres from 0 to 100000, found {radius_m:?}");
        assert_eq!(message, expected);
    }
    let many = (0..300).map(|i: usize| joint(&i.to_string(), i.checked_sub(1), DVec3::ZERO));
    let many = Character::new("many".into(), many.collect(), None).unwrap();
    assert_eq!(
        weigh(&many, Method::Lengths, &default()).unwrap_err().to_string(),
        "expected at most 256 joints, found 300"
    );
}

/// Checks that every accepted setting gives weights.
#[test]
fn the_largest_settings_are_weighed() {
    let mut mesh = sleeve();
    for position_m in &mut mesh.positions_m {
        *position_m *= 6e4;
    }
    let radii = Radii::Uniform(crate::character::COORDINATE_MAX_M);
    let settings = Settings { base: Some(BASE_MAX), radii, ..Settings::default() };
    let joints = |joint: usize| Joint {
        name: joint.to_string(),
        parent: joint.checked_sub(1),
        position_m: DVec3::ONE * if joint.is_multiple_of(2) { 1e5 } else { -1e5 },
    };
    let largest = (0..JOINT_COUNT_MAX).map(joints).collect();
    let largest = Character::new("largest".into(), largest, Some(mesh)).unwrap();
    for method in Method::ALL {
        let weights = weigh(&largest, method, &settings).unwrap().weights;
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-5, "{method}");
    }
}

/// Checks that a mesh without triangles, or only with triangles of zero area, is refused: every joint would keep
/// its base.
#[test]
fn a_mesh_without_surface_is_refused() {
    let message =
        |mesh| weigh(&arm(Some(mesh)), Method::Mesh, &Settings::default()).unwrap_err().to_string();
    assert_eq!(
        message(Mesh { triangles: vec![], ..sleeve() }),
        "method mesh: expected a mesh with a surface, found 0 triangles without area"
    );
    let mut flat = sleeve();
    flat.positions_m.fill(DVec3::Y);
    let count = flat.triangles.len();
    assert_eq!(
        message(flat),
        format!(
            "method mesh: expected a mesh with a surface, found {count} triangles without area"
        )
    );
}

#[test]
fn tables_have_a_row_for_each_joint() {
    let character = arm(Some(sleeve()));
    let settings = Settings::default();
    let radii_m = settings.radii.of(&character).unwrap();
    let weighings: Vec<Weighing> =
        Method::ALL.map(|method| weigh(&character, method, &settings).unwrap()).into();
    let text = table::text(&character, Some(&radii_m), &weighings);
    let row = text.lines().find(|line| line.starts_with(" elbow ")).expect("indented by its depth");
    assert!(
        row.split_whitespace().eq([
            "elbow",
            "100.00",
            "10.00",
            "0.27106285",
            "0.07477359",
            "0.07458025"
        ]),
        "{row}"
    );
    assert_eq!(text.lines().count(), 10, "{text}");
    let json: serde_json::Value =
        serde_json::from_str(&table::json(&character, &weighings)).unwrap();
    for weighing in &weighings {
        let list = json["methods"][weighing.method.name()].as_array().unwrap();
        assert_eq!(list.len(), 4);
        assert_eq!(list[1]["joint"], "hand");
        assert_eq!(list[1]["weight"].as_f64().unwrap().to_bits(), weighing.weights[1].to_bits());
    }
    let csv = table::csv(&character, Some(&radii_m), &weighings);
    assert!(
        csv.starts_with("joint,parent,length_m,radius_m,lengths,cylinders,mesh\nhand end,hand,0,")
    );
}

proptest! {
    /// Checks that the position and rotation of a character do not change its joints' weights; its size changes
    /// them only relative to the base.
    #[test]
    fn weights_do_not_depend_on_place_and_turn(
        x in -50.0..50.0, angle in -3.0..3.0, size in 0.5..2.0,
    ) {
        let character = arm(Some(sleeve()));
        let turn = glam::DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), angle);
        let moved = |position_m: DVec3| turn * position_m * size + DVec3::new(x, 1.0, -x);
        let mut joints = character.joints().to_vec();
        for joint in &mut joints {
            joint.position_m = moved(joint.position_m);
        }
        let mut mesh = character.mesh().unwrap().clone();
        for position_m in &mut mesh.positions_m {
            *position_m = moved(*position_m);
        }
        let other = Character::new("other".into(), joints, Some(mesh)).unwrap();
        for (method, scale) in [(Method::Lengths, size), (Method::Cylinders, size * size * size), (Method::Mesh, size * size * size)] {
            let with = |character, base| {
                weigh(character, method, &Settings { base: Some(base), ..Settings::default() }).unwrap().weights
            };
            for (a, b) in with(&character, 0.01).iter().zip(with(&other, 0.01 * scale)) {
                prop_assert!((a / b - 1.0).abs() < 1e-5, "{method}: {a} {b}");
            }
        }
    }
}
