//! Writes the show that QEMU's `mps2-an386` performs, with its rig, and prints the hashes of the torques that this
//! machine computes for it, as the image prints its own.
//!
//! `figure_show RIG SHOW`: the files to write.

use std::error::Error;
use std::fs;

use sinew_bit_parity::replay::{METHODS, hash, ticks, tree};
use sinew_figure::BODY_COUNT;
use sinew_show::Show;
use sinew_tests::figure::{COORDINATES, DOFS, FigureShow, figure_show};

/// How long the show is, s.
const SECONDS: f64 = 21.0;

fn main() -> Result<(), Box<dyn Error>> {
    let files: Vec<_> = std::env::args_os().skip(1).collect();
    let [rig_file, show_file] = &files[..] else {
        return Err("expected two files to write: RIG SHOW".into());
    };
    let FigureShow { rig, show } = figure_show(SECONDS);
    fs::write(rig_file, &rig)?;
    fs::write(show_file, &show)?;
    let (tree, show) = (tree::<BODY_COUNT, DOFS>(&rig)?, Show::open(&show)?);
    show.check_rig(rig.last_chunk().copied().map_or(0, u32::from_le_bytes))?;
    let ticks = ticks(&show);
    for method in METHODS {
        let hash = hash::<BODY_COUNT, COORDINATES>(&tree, show, method, ticks)?;
        println!("method={method} ticks={ticks} hash={hash:016x}");
    }
    Ok(())
}
