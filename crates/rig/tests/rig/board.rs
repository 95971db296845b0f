//! Tests of the compact form of a rig: encoding and decoding, errors with numbers; arbitrary bytes cause neither a
//! panic nor an invalid rig.

use proptest::prelude::*;
use sinew_core::JointKind;
use sinew_rig::board::{BoardRig, BoardRigError};
use sinew_rig::drive::Drive;
use sinew_rig::{Description, toml_file};

type Board = BoardRig<8, 12, 9>;

/// A rig with every kind of drive, limit and address.
const RIG: &str = r#"
name = "everything"
[mount]
position_m = [0, 1, 0]
rotation_xyzw = [0.6, 0, 0, 0.8]
[[body]]
name = "base"
mass_kg = 1
[[body]]
name = "ball"
mass_kg = 0.2
center_of_mass_m = [0, 0.1, 0]
box_m = [0.1, 0.2, 0.1]
[[body]]
name = "wrist"
mass_kg = 0.1
[[body]]
name = "finger"
[[body]]
name = "tip"
[[body]]
name = "jaw"
mass_kg = 0.05
[[body]]
name = "lid"
[[joint]]
name = "shoulder"
type = "spherical"
parent = "base"
child = "ball"
range_deg = [[0, 60]]
[[joint]]
name = "wrist"
type = "universal"
parent = "ball"
child = "wrist"
position_m = [0, 0.2, 0]
axis = [1, 0, 0]
second_axis = [0, 0, 1]
[[joint]]
name = "knuckle"
parent = "wrist"
child = "finger"
axis = [1, 0, 0]
range_deg = [10, 80]
speed_deg_s = 90
[[joint]]
name = "slide"
type = "prismatic"
parent = "finger"
child = "tip"
axis = [0, 1, 0]
range_m = [0, 0.02]
home_m = 0.01
[[joint]]
name = "jaw"
parent = "base"
child = "jaw"
axis = [1, 0, 0]
effort = 0.3
[[joint]]
name = "lid"
parent = "base"
child = "lid"
axis = [1, 0, 0]
[[limit]]
joint = "jaw"
other = "lid"
least_deg = 0
[[drive]]
joints = ["shoulder"]
servos = ["s0", "s1", "s2"]
matrix = { rows = [[1, 0, 0], [0, 0.5, 0.5], [0, 0.5, -0.5]] }
[[drive]]
joints = ["wrist"]
servos = ["s3", "s4"]
matrix = { rows = [[0.5, 0.5], [0.5, -0.5]], offset_deg = [5, 0] }
[[drive]]
joints = ["knuckle", "slide"]
servos = ["s5"]
matrix = { rows = [[1], [0.01]] }
[[drive]]
joints = ["jaw"]
servos = ["s6"]
curve = { points_deg = [[-40, -10], [0, 0], [40, 25]] }
[[drive]]
joints = ["lid"]
servos = ["s7"]
[drive.four_bar]
ground_m = 0.05
crank_m = 0.02
coupler_m = 0.05
rocker_m = 0.03
crank_zero_deg = 90
rocker_zero_deg = 90
[[servo]]
name = "s0"
model = "XL330-M288-T"
id = 1
[[servo]]
name = "s1"
model = "XL330-M288-T"
id = 2
direction = -1
gear = 2
[[servo]]
name = "s2"
model = "STS3215-12V"
bus = "other"
id = 1
[[servo]]
name = "s3"
model = "XM430-W350-T"
id = 4
[[servo]]
name = "s4"
model = "MX-28"
id = 5
offset_deg = 10
[[servo]]
name = "s5"
model = "MX-64"
id = 6
torque_nm = 2
[[servo]]
name = "s6"
model = "MG90S"
bus = "pwm"
channel = 3
on_signal_loss = "home"
[[servo]]
name = "s7"
model = "MG996R"
bus = "pwm"
channel = 4
range_deg = [-30, 30]
acceleration_deg_s2 = 1000
"#;

fn described() -> Description {
    toml_file::read(RIG).unwrap_or_else(|error| panic!("{error}"))
}

fn baked() -> Board {
    let rig = described();
    Board::bake(&rig, &rig.mechanism().unwrap()).unwrap_or_else(|error| panic!("{error}"))
}

fn encoded(rig: &Board) -> Vec<u8> {
    let mut bytes = vec![0; 4096];
    let length = rig.encode(&mut bytes).unwrap();
    bytes.truncate(length);
    bytes
}

/// Writes the CRC-32 (ISO-HDLC) of the content into the last four bytes. It is computed bit by bit, independently
/// of the product's table.
fn sign(bytes: &mut [u8]) {
    let Some((content, stored)) = bytes.split_last_chunk_mut::<4>() else { return };
    let crc = content.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg())
        })
    });
    *stored = (!crc).to_le_bytes();
}

#[test]
fn a_rig_is_the_same_after_encoding_and_decoding() {
    let rig = baked();
    let bytes = encoded(&rig);
    let again = Board::decode(&bytes).unwrap();
    assert_eq!(again, rig);
    // Boards of other capacities decode the same rig.
    let larger = BoardRig::<32, 40, 20>::decode(&bytes).unwrap();
    assert_eq!(larger.tree().bodies(), rig.tree().bodies());
    assert_eq!((larger.drives(), larger.servos()), (rig.drives(), rig.servos()));
}

#[test]
fn a_baked_rig_is_the_described_one() {
    let rig = baked();
    // Sizes of the table in the documentation.
    let drives = [9 * 4 + 3 * 4 + 12, 4 * 4 + 2 * 4 + 8, 2 * 4 + 2 * 4 + 6, 2 + 24 + 4, 34 + 4];
    let expected = 16 + 7 * 100 + 9 * 24 + 20 + (5 * 6 + drives.iter().sum::<usize>()) + 8 * 56 + 4;
    assert_eq!(encoded(&rig).len(), expected);
    assert_eq!(rig.tree().bodies()[1].joint, JointKind::Spherical);
    // The mount is stored in the placement of body 0; gravity points along -y of the world.
    let placement = rig.tree().bodies()[0].placement;
    assert!(
        (placement.rotation.x - 0.6).abs() < 1e-6 && (placement.translation_m.y - 1.0).abs() < 1e-6
    );
    let [ball, .., jaw, lid] = rig.dofs() else { panic!("{:?}", rig.dofs()) };
    assert!(ball.range[0] >= 0.0 && (ball.range[1] - 60_f32.to_radians()).abs() < 1e-6);
    assert!((jaw.effort - 0.3).abs() < 1e-7 && lid.effort > jaw.effort, "{jaw:?} {lid:?}");
    let knuckle = rig.dofs()[5];
    assert!((knuckle.home - 10_f32.to_radians()).abs() < 1e-6, "{knuckle:?}");
    assert!((knuckle.speed - 90_f32.to_radians()).abs() < 1e-5, "{knuckle:?}");
    assert!((rig.dofs()[6].home - 0.01).abs() < 1e-8);
    assert_eq!((rig.limits()[0].dof, rig.limits()[0].other), (7, 8));
    assert_eq!(rig.drives()[2].dofs, [5, 6]);
    assert!(matches!(&rig.drives()[0].drive, Drive::Matrix(matrix) if matrix.is_ball()));
    assert_eq!(
        rig.servos().iter().map(|servo| servo.bus).collect::<Vec<_>>(),
        [0, 0, 1, 0, 0, 0, 2, 2]
    );
    assert!((rig.servos()[1].servo.settings().gear + 2.0).abs() < 1e-6);
}

#[test]
fn what_a_board_does_not_hold_is_refused_by_number() {
    let rig = described();
    let mechanism = rig.mechanism().unwrap();
    let bytes = encoded(&baked());
    macro_rules! refused {
        ($bodies:literal, $dofs:literal, $servos:literal) => {{
            type Small = BoardRig<$bodies, $dofs, $servos>;
            let baking = Small::bake(&rig, &mechanism).unwrap_err().to_string();
            assert_eq!(Small::decode(&bytes).unwrap_err().to_string(), baking);
            baking
        }};
    }
    assert_eq!(refused!(6, 12, 9), "the rig has 7 bodies, the board holds 6");
    assert_eq!(refused!(7, 8, 9), "the rig has 9 degrees of freedom, the board holds 8");
    assert_eq!(refused!(7, 9, 7), "the rig has 8 servos, the board holds 7");
    assert!(BoardRig::<7, 9, 8>::decode(&bytes).is_ok());
    let short = baked().encode(&mut vec![0; bytes.len() - 1]).unwrap_err();
    assert_eq!(short, BoardRigError::Length { expected: bytes.len(), found: bytes.len() - 1 });
}

#[test]
fn damaged_bytes_are_refused_wherever_they_are() {
    let bytes = encoded(&baked());
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x10;
        assert!(Board::decode(&damaged).is_err(), "byte {at}");
        assert!(Board::decode(&bytes[..at]).is_err(), "cut at {at}");
    }
    let mut longer = bytes.clone();
    longer.extend([0; 4]);
    sign(&mut longer);
    assert!(matches!(Board::decode(&longer), Err(BoardRigError::Length { .. })));
    let mut version = bytes;
    version[4] = 2;
    assert_eq!(Board::decode(&version), Err(BoardRigError::Version { found: 2 }));
    version[0] = b'X';
    assert_eq!(Board::decode(&version), Err(BoardRigError::Magic { found: *b"XNWR" }));
}

/// Asserts properties that every decoded rig must have, whatever its bytes were.
fn check_invariants(rig: &Board) {
    let finite = |numbers: &[f32]| numbers.iter().all(|number| number.is_finite());
    assert_eq!(rig.tree().dof_count(), rig.dofs().len());
    for dof in rig.dofs() {
        assert!(dof.range[0] <= dof.range[1] && dof.home.is_finite());
        assert!(dof.speed >= 0.0 && dof.acceleration >= 0.0 && dof.effort >= 0.0);
    }
    for limit in rig.limits() {
        assert!(rig.dofs().get(usize::from(limit.dof)).is_some() && limit.dof != limit.other);
        assert!(
            rig.dofs().get(usize::from(limit.other)).is_some() && limit.range[0] <= limit.range[1]
        );
    }
    let mut taken = Vec::new();
    for of in rig.drives() {
        assert_eq!((of.drive.dofs(), of.drive.servos()), (of.dofs.len(), of.servos.len()));
        assert!(of.dofs.iter().all(|dof| usize::from(*dof) < rig.dofs().len()));
        for servo in &of.servos {
            assert!(usize::from(*servo) < rig.servos().len() && !taken.contains(servo));
            taken.push(*servo);
        }
        let home: Vec<f32> = of.dofs.iter().map(|dof| rig.dofs()[usize::from(*dof)].home).collect();
        // The drive refuses a home beyond 1e6; accepted homes give finite numbers.
        if let Ok(pose) = of.drive.at_joints(&home) {
            let ones = vec![1.0; of.servos.len()];
            assert!(finite(pose.servos()) && finite(&pose.joint_velocities(&ones).unwrap()));
            assert!(finite(&pose.joint_efforts(&ones).unwrap()));
        }
    }
    for servo in rig.servos() {
        assert!(servo.servo.own_position(0.1).is_ok() && finite(&servo.servo.shaft_range()));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn random_bytes_are_no_rig(mut bytes in prop::collection::vec(any::<u8>(), 0..400), signed: bool) {
        if signed && bytes.len() > 16 {
            bytes[..6].copy_from_slice(b"SNWR\x01\x00");
            // Counts that are mostly within the capacities.
            for at in (6..16).step_by(2) {
                (bytes[at], bytes[at + 1]) = (bytes[at] % 10, 0);
            }
            sign(&mut bytes);
        }
        if let Ok(rig) = Board::decode(&bytes) {
            check_invariants(&rig);
        }
    }

    #[test]
    fn a_signed_rig_of_changed_bytes_is_refused_or_whole(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        special in prop::option::of((any::<prop::sample::Index>(), prop::sample::select(vec![
            f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -1.0, f32::MAX, f32::MIN_POSITIVE,
        ]))),
    ) {
        let mut bytes = encoded(&baked());
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Some((at, number)) = special {
            let at = 2 * at.index(bytes.len() / 2 - 2);
            bytes[at..at + 4].copy_from_slice(&number.to_le_bytes());
        }
        sign(&mut bytes);
        if let Ok(rig) = Board::decode(&bytes) {
            check_invariants(&rig);
            let again = Board::decode(&encoded(&rig)).unwrap();
            // Decoding normalizes rotations and axes, which may change their last bits; everything else is equal.
            prop_assert_eq!(again.tree().len(), rig.tree().len());
            prop_assert_eq!((again.dofs(), again.limits()), (rig.dofs(), rig.limits()));
            prop_assert_eq!((again.drives(), again.servos()), (rig.drives(), rig.servos()));
        }
    }
}
