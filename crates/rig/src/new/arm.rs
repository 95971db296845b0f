//! A desk arm.

use super::turn::Turn;
use crate::description::{Address, Body, Description, Drive, DriveKind, Servo, Supply};

/// Mass of one servo, kg (an XL330 has 18 g).
const SERVO_KG: f64 = 0.018;

/// Mass of the printed walls around a servo, per length, kg/m: 1.2 mm of plastic at 1250 kg/m³ around a section of
/// [`WIDTH_M`] by [`DEPTH_M`].
const WALLS_KG_M: f64 = 0.18;

/// Outer section of a link, m: a servo of 20 mm by 26 mm, the walls and some air.
const WIDTH_M: f64 = 0.026;
const DEPTH_M: f64 = 0.034;

/// The reason why an arm cannot be created.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("an arm has 1 to 40 joints, not {joints}")]
pub struct ArmError {
    /// Requested number of joints.
    pub joints: usize,
}

/// Creates a desk arm of small bus servos on printed links. The first joint turns about the vertical, then two joints
/// bend, one turns, two bend, and so on; each link is shorter than the previous one, down to the length of a servo.
///
/// With up to six joints, its servos can hold any pose continuously. Longer arms are useful only as tails.
///
/// # Errors
/// [`ArmError`] unless there are 1 to 40 joints.
pub fn arm(joints: usize) -> Result<Description, ArmError> {
    if !(1..=40).contains(&joints) {
        return Err(ArmError { joints });
    }
    let base_height_m = 0.04;
    let mut rig = Description {
        name: format!("arm of {joints}"),
        supply: Some(Supply { voltage_v: 5.0, current_a: 10.0 }),
        bodies: vec![Body {
            name: "base".to_owned(),
            mass_kg: 0.3,
            center_of_mass_m: [0.0, base_height_m / 2.0, 0.0],
            box_m: Some([0.1, base_height_m, 0.1]),
            ..Body::default()
        }],
        ..Description::default()
    };
    let mut parent = "base".to_owned();
    let mut height_m = base_height_m;
    for (id, index) in (1_u8..).zip(0..joints) {
        let turns = index % 3 == 0;
        let name = format!("{}{}", if turns { "turn" } else { "bend" }, index + 1);
        let joint = Turn {
            name: &name,
            parent: &parent,
            position_m: [0.0, height_m, 0.0],
            axis: if turns { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] },
            range_deg: if turns { [-150.0, 150.0] } else { [-100.0, 100.0] },
            home_deg: if turns { 0.0 } else { 20.0 },
            speed_deg_s: 180.0,
            acceleration_deg_s2: 1000.0,
        };
        rig.joints.push(joint.joint());
        let length_m = link_length_m(index);
        rig.bodies.push(Body {
            name: name.clone(),
            mass_kg: to_millionths(SERVO_KG + WALLS_KG_M * length_m),
            center_of_mass_m: [0.0, length_m / 2.0, 0.0],
            box_m: Some([WIDTH_M, length_m, DEPTH_M]),
            ..Body::default()
        });
        rig.drives.push(Drive {
            joints: vec![name.clone()],
            servos: vec![name.clone()],
            kind: DriveKind::one_to_one(1),
        });
        rig.servos.push(Servo {
            name: name.clone(),
            model: "XL330-M288-T".to_owned(),
            address: Address::Id(id),
            ..Servo::default()
        });
        height_m = length_m;
        parent = name;
    }
    Ok(rig)
}

/// Length of the first link, mm. With this length, the second joint of an arm with six joints can hold it level
/// continuously, with a margin of 8 % (0.120 of 0.130 N m).
const FIRST_MM: f64 = 59.0;

/// Length of a servo with its horn, mm.
const SERVO_MM: f64 = 30.0;

/// Returns the length of a link in whole millimetres: each is a sixth shorter than the previous one, down to the
/// length of a servo.
fn link_length_m(index: usize) -> f64 {
    let length_mm = (0..index).fold(FIRST_MM, |length: f64, _| length * 5.0 / 6.0);
    length_mm.max(SERVO_MM).round() / 1000.0
}

fn to_millionths(number: f64) -> f64 {
    (number * 1e6).round() / 1e6
}
