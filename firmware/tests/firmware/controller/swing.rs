//! A small show for the desk arm.

use sinew_show::write::{Motion, Settings, write};
use sinew_show::{Joint, Rate};

use super::test_rig::{Kind, figure};

/// Returns a show in which all joints swing around a pose away from home, and end there.
pub(crate) fn swing(kind: Kind, seconds: u32, is_loop: bool, rig: u32) -> Vec<u8> {
    let figure = figure(kind);
    let samples = seconds * 100;
    let mut q = Vec::new();
    for sample in 0..=samples {
        let t = f64::from(sample) / f64::from(samples);
        // Value and slope are zero at both ends.
        let swing = (std::f64::consts::TAU * t).sin() * (std::f64::consts::PI * t).sin().powi(2);
        for (joint, home) in figure.home.iter().enumerate() {
            let way = if joint % 2 == 0 { 0.6 } else { -0.6 };
            q.push(home + way + 0.4 * swing);
        }
    }
    let joints: Vec<Joint> =
        figure.board.tree().bodies().iter().map(|body| body.joint.into()).collect();
    let motion = Motion {
        joints: &joints,
        q: &q,
        rate: Rate { samples: 100, seconds: 1 },
        is_loop,
        rig,
        cues: &[],
        time_code: None,
        course: &[],
    };
    write(&motion, &Settings::default()).unwrap().bytes
}
