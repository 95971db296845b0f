//! Reads Acclaim motions: an AMC file, and the ASF file of its skeleton.
//!
//! A bone of the ASF begins where its parent ends; its direction and length are given in the rest pose, in world
//! axes. Its `axis` gives the orientation of its rotation axes: `C`, the rotations by three angles about the fixed
//! axes, in the order of the letters (the first letter is applied first). The AMC gives the bone's angles in the
//! order of its `dof`: `M`, with the first angle applied first too. The bone's rotation relative to its parent,
//! both in the world's axes in the rest pose, is `C M C^-1`. The joint that moves a bone has the bone's name and is
//! at its beginning.
//!
//! The AMC numbers its frames. A skipped number is a missing frame, and a bone that a frame does not contain is a
//! missing sample. Both are gaps.
//!
//! Lengths divided by the ASF's `length` unit are in inches, according to M. Schafer's definition of the format
//! ("2.54 - data in cm, local units in inches") and to CMU's data with its 0.45. The format has no frame rate;
//! `:SAMPLES-PER-SECOND`, which some writers add, is used.

mod amc;
mod asf;
mod channel;
mod error;
mod lines;

use std::path::{Path, PathBuf};

pub use error::{Error, Problem};

use super::recording::{self, Recording};
use crate::encoding;

const METRES_PER_INCH: f64 = 0.0254;
/// The `length` of CMU's files: 0.45 in the file is one inch.
const CMU_LENGTH: f64 = 0.45;

/// Reads the motion in the AMC file at `path`, with the ASF file that [`find_asf`] finds. The clip's name is the
/// stem of the AMC file.
///
/// # Errors
/// [`Error::NoSkeleton`] if no ASF file is found; [`Error::Io`] or [`Error::Syntax`], with the position, if either
/// file cannot be read.
pub fn read(path: &Path) -> Result<Recording, Error> {
    let bytes = |path: &Path| {
        crate::read::bytes(path).map_err(|source| Error::Io { file: path.to_path_buf(), source })
    };
    // The requested file is read first: if it does not exist, the error must not be about its skeleton.
    let amc = bytes(path)?;
    let asf_path = find_asf(path)?;
    parse((&bytes(&asf_path)?, &asf_path), (&amc, path))
}

/// Reads the texts of an ASF and an AMC file. The paths are used in errors, and the AMC's stem is the name of the
/// clip.
///
/// # Errors
/// [`Error::Syntax`], for the same reasons as in [`read`].
pub fn parse(asf: (&[u8], &Path), amc: (&[u8], &Path)) -> Result<Recording, Error> {
    let in_file = |path: &Path| {
        let file = path.to_path_buf();
        move |(at, problem)| Error::Syntax { file, at, problem }
    };
    let skeleton = asf::parse(&encoding::lossy(asf.0)).map_err(in_file(asf.1))?;
    let samples = recording::sample_count_max(asf.0.len() + amc.0.len());
    let motion = amc::parse(&encoding::lossy(amc.0), &skeleton, samples);
    let motion = motion.map_err(in_file(amc.1))?;
    // Other writers do not agree on `length`: it may mean metres, inches, or nothing.
    let is_cmu = (skeleton.length_unit - CMU_LENGTH).abs() < 1e-9;
    Ok(Recording {
        name: recording::stem(amc.1),
        skeleton: skeleton.skeleton(),
        frames: motion.frames,
        frame_time_s: motion.frame_time_s,
        metres_per_unit: is_cmu.then_some(METRES_PER_INCH / skeleton.length_unit),
        notes: Vec::new(),
    })
}

/// Finds the ASF file of the AMC file at `amc`, in the same folder: the file with the same stem; or CMU's
/// `SUBJECT.asf` for `SUBJECT_TRIAL.amc`; or the only ASF file there.
///
/// # Errors
/// [`Error::NoSkeleton`] with the possible names; [`Error::Io`] if the folder cannot be listed.
pub fn find_asf(amc: &Path) -> Result<PathBuf, Error> {
    let folder = amc.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    let listed = || -> std::io::Result<Vec<PathBuf>> {
        std::fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path())).collect()
    };
    let mut files = listed().map_err(|source| Error::Io { file: folder.to_path_buf(), source })?;
    files.retain(|file| file.extension().is_some_and(|found| found.eq_ignore_ascii_case("asf")));
    files.sort();
    let stem = recording::stem(amc);
    let subject = stem.split_once('_').map(|(subject, _)| subject.to_owned());
    let named = [Some(stem), subject].into_iter().flatten().collect::<Vec<_>>();
    for name in &named {
        if let Some(file) = files.iter().find(|file| recording::stem(file) == *name) {
            return Ok(file.clone());
        }
    }
    match &files[..] {
        [file] => Ok(file.clone()),
        _ => Err(Error::NoSkeleton {
            file: amc.to_path_buf(),
            expected: named.into_iter().map(|name| format!("`{name}.asf`")).collect(),
            found: files.len(),
        }),
    }
}

#[cfg(test)]
mod tests;
