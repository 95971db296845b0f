//! Reads a motion and prints its skeleton: `cargo run -p sinew-mocap --example joints -- walk.bvh`.

use std::error::Error;
use std::path::PathBuf;

use sinew_mocap::format;

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args_os().nth(1).ok_or("expected a file: BVH, AMC or humanoid3d text")?;
    let recording = format::read(&PathBuf::from(file))?;
    let rate = recording.frame_time_s.map_or("no rate".into(), |s| format!("{:.2} Hz", s.recip()));
    println!("{}: {} frames, {rate}", recording.name, recording.frames.len());
    for joint in &recording.skeleton.joints {
        let parent = joint.parent.map_or("-", |parent| &recording.skeleton.joints[parent].name);
        println!("{:24} on {parent:24} at {:.3}", joint.name, joint.offset_m);
    }
    Ok(())
}
