//! Writes the show that QEMU's `mps2-an386` performs, with its rig. Prints the hashes of the torques that this
//! machine computes for it, in the format of the image.
//!
//! Usage: `figure_show RIG SHOW`, with the files to write.

use std::error::Error;
use std::fs;

use sinew_test_support::figure::figure_show;

/// Duration of the show, s.
const SECONDS: f64 = 21.0;

fn main() -> Result<(), Box<dyn Error>> {
    let files: Vec<_> = std::env::args_os().skip(1).collect();
    let [rig_file, show_file] = &files[..] else {
        return Err("expected two files to write: RIG SHOW".into());
    };
    let figure = figure_show(SECONDS);
    fs::write(rig_file, &figure.rig)?;
    fs::write(show_file, &figure.show)?;
    figure.torque_hashes()?.iter().for_each(|line| println!("{line}"));
    Ok(())
}
