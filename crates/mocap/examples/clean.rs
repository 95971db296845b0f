//! Fills gaps, low-passes at 6 Hz, resamples to 100 Hz and writes a BVH file in centimetres:
//! `cargo run -p sinew-mocap --example clean -- take.amc clean.bvh`.

use std::error::Error;
use std::path::Path;

use sinew_mocap::{bvh, filter::LowPass, flips, format, gaps, resample::resample};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(from), Some(to)) = (arguments.next(), arguments.next()) else {
        return Err("expected a motion and the BVH file to write".into());
    };
    // Default unit: centimetres; default rate: 120 Hz.
    let recording = format::read(Path::new(&from))?.in_metres(0.01);
    let frame_time_s = recording.frame_time_s.unwrap_or(1.0 / 120.0);

    let (mut clip, filled) = gaps::fill(recording, frame_time_s, 0.5)?;
    if !filled.gaps.is_empty() {
        println!("{filled}");
    }
    let flips = flips::find(&clip, &vec![true; clip.skeleton.joints.len()]);
    if !flips.0.is_empty() {
        println!("{flips}");
    }
    if let Some(low_pass) = LowPass::new(clip.rate_hz(), 6.0) {
        low_pass.apply_to_clip(&mut clip)?;
    }
    bvh::write(Path::new(&to), &resample(&clip, 100.0), 0.01)?;
    Ok(())
}
