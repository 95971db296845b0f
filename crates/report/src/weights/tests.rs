use glam::DVec3;
use sinew_pose_metrics::character::{Joint, Mesh};
use sinew_pose_metrics::weights::{Method, Settings, weigh};

use super::*;
use crate::file::alone;
use crate::png;

fn arm() -> Character {
    let joint = |name: &str, parent, x| Joint {
        name: name.into(),
        parent,
        position_m: DVec3::new(x, 1.0, 0.0),
    };
    let joints = vec![joint("shoulder & co", None, 0.0), joint("elbow", Some(0), 0.3)];
    let mesh = Mesh {
        positions_m: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        skin: vec![vec![(1, 1.0)]; 3],
        triangles: vec![[0, 1, 2], [0, 2, 1]],
    };
    Character::new("arm".into(), joints, Some(mesh)).unwrap()
}

#[test]
fn every_joint_has_discs_bars_and_a_name() {
    let arm = arm();
    let weighings = Method::ALL.map(|method| weigh(&arm, method, &Settings::default()).unwrap());
    let svg = alone(&picture(&arm, &weighings).0);
    assert_eq!(svg.matches("<circle").count(), 6);
    assert_eq!(svg.matches("class=\"weight\"").count(), 6);
    assert!(svg.contains(">shoulder &amp; co</text>") && svg.contains(">elbow</text>"));
    assert!(!svg.contains("var(") && !svg.contains("NaN") && !svg.contains("inf"));
    // One of the two triangles faces the viewer.
    let skin = svg.split_once("class=\"skin\" d=\"").unwrap().1.split_once('"').unwrap().0;
    assert_eq!(skin.matches('Z').count(), 1, "{skin}");
    assert!(png::png(&svg).starts_with(b"\x89PNG"));
}

/// A single joint has no size.
#[test]
fn a_point_can_be_drawn() {
    let joints = vec![Joint { name: "a".into(), parent: None, position_m: DVec3::ZERO }];
    let point = Character::new("point".into(), joints, None).unwrap();
    let weighing = weigh(&point, Method::Lengths, &Settings::default()).unwrap();
    let svg = alone(&picture(&point, &[weighing]).0);
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
}

#[test]
fn other_files_are_refused() {
    let error = write(Path::new("weights.jpg"), &arm(), &[]).unwrap_err();
    assert_eq!(error.to_string(), "expected a picture named *.svg or *.png");
}
