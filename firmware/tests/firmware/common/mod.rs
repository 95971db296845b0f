//! Random rigs with every kind of drive, for the tests.

use std::fmt::Write;

use proptest::prelude::*;
use sinew_firmware::drives::{Condition, Encoder};
use sinew_rig::board::BoardRig;
use sinew_rig::toml_file;
use sinew_servo_bus::{Effort, Feedback};

/// A rig type with room for the largest random rig.
pub(crate) type Rig = BoardRig<16, 24, 24>;

/// Kind of a drive, which connects servos to joints.
#[derive(Debug, Clone)]
pub(crate) enum Kind {
    Single { gear: f32, direction: i8 },
    Mirrored,
    Mimic { ratio: f32 },
    Differential,
    Slide { m_rad: f32 },
    Curve { falls: bool },
    FourBar,
    Ball { rows: [[f32; 3]; 3] },
}

pub(crate) fn kinds() -> impl Strategy<Value = Vec<Kind>> {
    let small = -0.3_f32..0.3;
    let kind = prop_oneof![
        (0.5_f32..3.0, prop::sample::select(vec![-1_i8, 1]))
            .prop_map(|(gear, direction)| Kind::Single { gear, direction }),
        Just(Kind::Mirrored),
        prop_oneof![-2.0_f32..-0.1, 0.1_f32..2.0].prop_map(|ratio| Kind::Mimic { ratio }),
        Just(Kind::Differential),
        (0.005_f32..0.05).prop_map(|m_rad| Kind::Slide { m_rad }),
        any::<bool>().prop_map(|falls| Kind::Curve { falls }),
        Just(Kind::FourBar),
        prop::array::uniform9(small).prop_map(|[a, b, c, d, e, f, g, h, i]| Kind::Ball {
            rows: [[1.0 + a, b, c], [d, 1.0 + e, f], [g, h, 1.0 + i]]
        }),
    ];
    prop::collection::vec(kind, 1..5)
}

/// Returns a rig with these drives, side by side on one base. All servos are XL330.
pub(crate) fn rig(kinds: &[Kind]) -> Rig {
    let mut text = "name = \"random\"\n[[body]]\nname = \"base\"\nmass_kg = 1\n".to_owned();
    let (mut joints, mut servos) = (0, 0);
    for kind in kinds {
        let (types, count) = match kind {
            Kind::Single { .. } | Kind::Curve { .. } | Kind::FourBar => (vec!["revolute"], 1),
            Kind::Slide { .. } => (vec!["prismatic"], 1),
            Kind::Mirrored => (vec!["revolute"], 2),
            Kind::Mimic { .. } => (vec!["revolute"; 2], 1),
            Kind::Differential => (vec!["revolute"; 2], 2),
            Kind::Ball { .. } => (vec!["spherical"], 3),
        };
        let (first_joint, first_servo) = (joints, servos);
        for kind in &types {
            let axis = if *kind == "spherical" { "" } else { "axis = [1, 0, 0]\n" };
            let (name, body) = (format!("j{joints}"), format!("b{joints}"));
            write!(
                text,
                "[[body]]\nname = \"{body}\"\nmass_kg = 0.1\n[[joint]]\nname = \"{name}\"\ntype = \"{kind}\"\n\
                 parent = \"base\"\nchild = \"{body}\"\n{axis}"
            )
            .unwrap();
            joints += 1;
        }
        for _ in 0..count {
            writeln!(
                text,
                "[[servo]]\nname = \"s{servos}\"\nmodel = \"XL330-M288-T\"\nid = {servos}"
            )
            .unwrap();
            match kind {
                Kind::Single { gear, direction } => {
                    writeln!(text, "gear = {gear}\ndirection = {direction}\noffset_deg = 5")
                        .unwrap();
                }
                Kind::FourBar => writeln!(text, "range_deg = [-30, 30]").unwrap(),
                _ => {}
            }
            servos += 1;
        }
        let names = |of: &str, from: usize, to: usize| {
            (from..to).map(|index| format!("\"{of}{index}\"")).collect::<Vec<_>>().join(", ")
        };
        let how = match kind {
            Kind::Single { .. } => "matrix = { rows = [[1]] }".to_owned(),
            Kind::Mirrored => "matrix = { rows = [[0.5, -0.5]] }".to_owned(),
            Kind::Mimic { ratio } => format!("matrix = {{ rows = [[1], [{ratio}]] }}"),
            Kind::Differential => "matrix = { rows = [[0.5, 0.5], [0.5, -0.5]] }".to_owned(),
            Kind::Slide { m_rad } => format!("matrix = {{ rows = [[{m_rad}]] }}"),
            Kind::Curve { falls } => {
                let sign = if *falls { -1 } else { 1 };
                format!(
                    "curve = {{ points_deg = [[-60, {}], [0, 0], [60, {}]] }}",
                    -20 * sign,
                    35 * sign
                )
            }
            Kind::FourBar => {
                "[drive.four_bar]\nground_m = 0.05\ncrank_m = 0.02\ncoupler_m = 0.05\n\
                 rocker_m = 0.03\ncrank_zero_deg = 90\nrocker_zero_deg = 90"
                    .to_owned()
            }
            Kind::Ball { rows } => format!("matrix = {{ rows = {rows:?} }}"),
        };
        writeln!(
            text,
            "[[drive]]\njoints = [{}]\nservos = [{}]\n{how}",
            names("j", first_joint, joints),
            names("s", first_servo, servos)
        )
        .unwrap();
    }
    let described = toml_file::read(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    Rig::bake(&described, &described.mechanism().unwrap())
        .unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Returns the condition of a cool servo that was read at a position of its own shaft.
pub(crate) fn read(own_rad: f32, velocity_rad_s: f32, current_a: f32) -> Condition {
    let feedback = Feedback {
        position_rad: own_rad + Encoder::default().zero_rad,
        velocity_rad_s,
        effort: Effort::Current(current_a),
        age_ticks: 0,
    };
    Condition { feedback: Some(feedback), temperature_c: Some(30.0), ..Condition::default() }
}
