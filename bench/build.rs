//! The images are for the board that QEMU has. One of them plays a show, one has a rig: both are made here.

#[path = "build/performer.rs"]
mod performer;

use std::path::Path;
use std::{env, fs};

use sinew_rig::{board::BoardRig, new};
use sinew_show::write::{Settings, write};

/// Servos of the rig, and as many joints.
const SERVOS: usize = 18;

fn main() {
    sinew_image::link(sinew_image::EMULATED, &[]);

    let show = performer::with_motion(|motion| write(motion, &Settings::default()));
    let folder = env::var_os("OUT_DIR").expect("cargo names a folder");
    let bytes = show.expect("the motion can be written").bytes;
    fs::write(Path::new(&folder).join("performer.show"), bytes).expect("the show can be stored");
    fs::write(Path::new(&folder).join("arm_18.rig"), arm()).expect("the rig can be stored");
    println!("cargo:rerun-if-changed=build");
}

/// An arm as `sinew rig new --arm 18` makes it, as a board has it.
fn arm() -> Vec<u8> {
    let rig = new::arm(SERVOS).expect("an arm may have so many joints");
    let mechanism = rig.mechanism().expect("a new arm is sound");
    let board = BoardRig::<{ SERVOS + 1 }, SERVOS, SERVOS>::bake(&rig, &mechanism);
    let mut bytes = vec![0; 1 << 16];
    let len = board.expect("a board takes it").encode(&mut bytes).expect("there is room");
    bytes.truncate(len);
    bytes
}
