//! The emulated NUCLEO-F446RE: `sinew-emulator IMAGE [FLASH]`.
//!
//! It runs an unmodified image on rigless's models, and communicates with a host in lines of text over standard input
//! and output: see `README.md` in this folder. Times are ns since power-on, bytes are hexadecimal digits.
//!
//! # Files
//! - `board`, `flash`: the differences of the F446RE to rigless's F427; its flash.
//! - `wire`: the far end of a serial line.
//! - `protocol`, `driver`: the lines of text; lockstep with the host.

mod board;
mod driver;
mod flash;
mod protocol;
mod wire;

use std::io::{self, BufReader, BufWriter};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use rigless::emulator::{Start, run};
use rigless::image::Image;
use rigless::session::Session;
use rigless::time::VirtualNanos;

use board::Nucleo;
use driver::Lockstep;

fn main() -> ExitCode {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let (image, flash) = match arguments.as_slice() {
        [image] => (image, None),
        [image, flash] => (image, Some(flash.as_path())),
        _ => {
            eprintln!("Usage: sinew-emulator IMAGE [FLASH]");
            return ExitCode::from(2);
        }
    };
    match emulate(image, flash) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("error: {}: {why}", image.display());
            ExitCode::FAILURE
        }
    }
}

/// Runs an image. `kept` is a file with the content of flash from before the last power loss.
fn emulate(image: &Path, kept: Option<&Path>) -> Result<(), Box<dyn std::error::Error>> {
    let image = Image::read(image, None)?;
    let mut flash = match kept {
        Some(path) => std::fs::read(path)?,
        None => vec![0xFF; flash::LEN],
    };
    flash.resize(flash::LEN, 0xFF);
    for (address, bytes) in image.segments() {
        let place = address.checked_sub(flash::BASE).and_then(|from| usize::try_from(from).ok());
        let of_flash = place.and_then(|from| flash.get_mut(from..from + bytes.len()));
        of_flash.ok_or("it has a part that is not in the F446's flash")?.copy_from_slice(bytes);
    }
    let mut session = Session::new(Box::new(Nucleo::new()?), 0, VirtualNanos(0))?;
    session.board_mut().is_array_in_place = true;
    let driver = Lockstep::new(BufReader::new(io::stdin()), BufWriter::new(io::stdout()), flash);
    run(session, &Start::new(&[image]), driver)?;
    Ok(())
}
