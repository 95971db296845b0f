//! Sounds of shows: `bake` describes them; `console` and `play` find their files.

mod player;

use std::fmt::Write as _;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail, ensure};
use sha2::{Digest as _, Sha256};
use sinew_life::sound::duration_s;
use sinew_show::sound::Sound;

pub(super) use player::{Player, PlayerCommand};

/// Largest file of a sound, bytes. For comparison: an hour of stereo at 44.1 kHz has 635 MB.
const BYTES_MAX: u64 = 1 << 30;

/// A sound's file and its bytes.
#[derive(Debug)]
pub(super) struct FoundSound {
    pub(super) path: PathBuf,
    pub(super) bytes: Vec<u8>,
}

/// Describes the sound in a WAV file. `offset_s`: time of the sound at the start of the show, s.
pub(super) fn describe(path: &Path, offset_s: f64) -> anyhow::Result<Sound> {
    let of_file = || path.display().to_string();
    let bytes = read(path)?;
    let duration_s = duration_s(Cursor::new(&bytes)).with_context(of_file)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    ensure!(
        offset_s < duration_s,
        "{}: the sound lasts {duration_s:.2} s, and is over before the show begins, at {offset_s:.2} s of the sound",
        of_file()
    );
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below hours")]
    Ok(Sound {
        name,
        sha256: Sha256::digest(&bytes).into(),
        file_len: bytes.len() as u64,
        duration_us: (duration_s * 1e6).round() as u64,
        offset_us: (offset_s * 1e6).round() as i64,
    })
}

/// Finds the file of a show's sound in the folder of the show, or in the working directory. Fails if the file has
/// changed since `bake`.
pub(super) fn find(show: &Path, sound: &Sound) -> anyhow::Result<FoundSound> {
    // Only the file name counts: a show from elsewhere must not open files of other folders.
    let name = Path::new(&sound.name).file_name().context("the show's sound has no name")?;
    let beside = show.parent().unwrap_or(Path::new("")).join(name);
    let places = [beside, PathBuf::from(name)];
    let Some(path) = places.iter().find(|path| path.is_file()) else {
        bail!(
            "the show's sound {} is not there: expected it beside {}",
            sound.name,
            show.display()
        );
    };
    let bytes = read(path)?;
    let hash: [u8; 32] = Sha256::digest(&bytes).into();
    ensure!(
        hash == sound.sha256,
        "{}: it is not the sound with which {} was baked: bake again with `--sound`",
        path.display(),
        show.display()
    );
    Ok(FoundSound { path: path.clone(), bytes })
}

fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    let of_file = || path.display().to_string();
    let length = path.metadata().with_context(of_file)?.len();
    ensure!(length <= BYTES_MAX, "{}: expected a sound of at most 1 GB", of_file());
    std::fs::read(path).with_context(of_file)
}

/// Returns a hash as hexadecimal text.
pub(super) fn hex(sha256: &[u8; 32]) -> String {
    let mut text = String::with_capacity(64);
    for byte in sha256 {
        write!(text, "{byte:02x}").expect("a string takes everything");
    }
    text
}
