//! Links the images for the board that QEMU emulates. The show of one image and the rigs of others are made here.

#[path = "build/performer.rs"]
mod performer;

use std::path::Path;
use std::{env, fs};

use sinew_rig::{board::BoardRig, new};
use sinew_show::write::{Motion, Settings, write};
use sinew_show::{Joint, Rate};

/// The largest number of servos of an arm, and the number of its bodies.
const MOST: usize = 40;
const BODIES: usize = MOST + 1;

fn main() {
    sinew_image::link(sinew_image::EMULATED, &[]);

    let show = performer::with_motion(|motion| write(motion, &Settings::default()));
    let folder = env::var_os("OUT_DIR").expect("cargo names a folder");
    let bytes = show.expect("the motion can be written").bytes;
    fs::write(Path::new(&folder).join("performer.show"), bytes).expect("the show can be stored");
    for servos in [6, 18, 20, MOST] {
        let (rig, show) = arm(servos);
        for (bytes, kind) in [(rig, "rig"), (show, "show")] {
            let path = Path::new(&folder).join(format!("arm_{servos}.{kind}"));
            fs::write(path, bytes).expect("it can be stored");
        }
    }
    println!("cargo:rerun-if-changed=build");
}

/// Returns an arm of `sinew rig new --arm` in the compact form of a board, and a show for it. In 4 s each joint
/// swings by less than the limit of the following-error detector, so that servos that do not move cause no fault.
fn arm(servos: usize) -> (Vec<u8>, Vec<u8>) {
    let mut rig = new::arm(servos).expect("an arm may have so many joints");
    // The servos can hold six bodies at home, and the load grows with the square of the number of bodies. The
    // bodies are therefore made lighter; otherwise the arm could not be armed.
    let lighter = (6.0 / servos as f64).powi(2);
    rig.bodies.iter_mut().for_each(|body| body.mass_kg *= lighter);
    let mechanism = rig.mechanism().expect("a new arm is sound");
    let board = BoardRig::<BODIES, MOST, MOST>::bake(&rig, &mechanism);
    let board = board.expect("a board takes it");
    let mut bytes = vec![0; 1 << 16];
    let len = board.encode(&mut bytes).expect("there is room");
    bytes.truncate(len);
    let crc = u32::from_le_bytes(*bytes.last_chunk().expect("it ends with its CRC"));

    let joints: Vec<Joint> = board.tree().bodies().iter().map(|body| body.joint.into()).collect();
    let rate = Rate { samples: 100, seconds: 1 };
    let home = mechanism.home();
    let q: Vec<f64> = (0..=4 * rate.samples)
        .flat_map(|sample| {
            let time_s = f64::from(sample) / f64::from(rate.samples);
            let swing = move |joint: usize| 0.05 * libm::sin(3.0 * time_s + joint as f64);
            home.iter().enumerate().map(move |(joint, home)| home + swing(joint))
        })
        .collect();
    let motion = Motion {
        joints: &joints,
        q: &q,
        rate,
        is_loop: false,
        rig: crc,
        cues: &[],
        time_code: None,
        course: &[],
    };
    (bytes, write(&motion, &Settings::default()).expect("the motion can be written").bytes)
}
