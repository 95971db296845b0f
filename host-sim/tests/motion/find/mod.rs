//! `sinew clip find` and `sinew clip blend` as commands: their output, pictures, files and exit codes.

mod any_skeleton;
mod blend;
mod search;

use std::fs;
use std::path::Path;

use serde_json::Value;
use sinew_figure::builtin;
use sinew_mocap::{bvh, gaps};

use crate::common::{sinew_in, text};

/// Writes the first built-in clips as BVH files into the folder `clips`, and returns their names.
fn clips(folder: &Path, count: usize) -> Vec<String> {
    fs::create_dir_all(folder.join("clips")).expect("a folder to write to");
    builtin::clips()
        .into_iter()
        .take(count)
        .map(|clip| {
            let frame_time_s = clip.frame_time_s.expect("a rate");
            let (clip, _) = gaps::fill(clip, frame_time_s, 0.5).expect("short gaps");
            let file = folder.join("clips").join(format!("{}.bvh", clip.name));
            bvh::write(&file, &clip, 1.0).expect("a clip that can be written");
            clip.name
        })
        .collect()
}

fn json(folder: &Path, arguments: &[&str]) -> (Value, String) {
    let output = sinew_in(folder, &[arguments, &["--format", "json"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    (serde_json::from_slice(&output.stdout).expect("JSON"), text(&output.stderr))
}
