//! Acclaim's motions: an AMC file, and the ASF file of its skeleton.
//!
//! A bone of the ASF begins where its parent ends and has a direction and a length in the rest pose, in
//! world axes. Its `axis` gives the axes about which it turns: `C`, the rotations by the three angles
//! about the fixed axes in the order of the letters (the first letter first). The AMC gives each
//! bone's angles in the order of its `dof`, `M`, likewise the first one first. The bone's rotation
//! relative to its parent, both with the world's axes in the rest pose, is `C M C^-1`. The joint that
//! moves a bone has the bone's name and sits at its beginning.
//!
//! The AMC numbers its frames: a number that is left out is a missing frame, and a bone that a frame
//! leaves out is a missing sample. Both are gaps.
//!
//! Lengths are inches after division by the ASF's `length` unit: so M. Schafer's definition of the
//! format ("2.54 - data in cm, local units in inches"), and CMU's data with its 0.45. The format has no
//! frame rate of its own; `:SAMPLES-PER-SECOND`, which some writers give, is used.

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
/// The `length` of CMU's files: a unit of theirs is an inch, and 0.45 of it a number in the file.
const CMU_LENGTH: f64 = 0.45;

/// Reads the motion in the AMC file at `path` and the ASF file that [`find_asf`] finds for it; the clip
/// is named after the AMC's stem.
///
/// # Errors
/// [`Error::NoSkeleton`] if no ASF file is found; [`Error::Io`] or [`Error::Syntax`], with the place, if
/// one of the two cannot be read.
pub fn read(path: &Path) -> Result<Recording, Error> {
    let bytes = |path: &Path| {
        crate::read::bytes(path).map_err(|source| Error::Io { file: path.to_path_buf(), source })
    };
    // First the file that was asked for: if it is not there, its skeleton is not what is missing.
    let amc = bytes(path)?;
    let asf_path = find_asf(path)?;
    parse((&bytes(&asf_path)?, &asf_path), (&amc, path))
}

/// Reads the texts of an ASF and an AMC file; the paths name them in errors, and the AMC's stem names
/// the clip.
///
/// # Errors
/// [`Error::Syntax`], as [`read`].
pub fn parse(asf: (&[u8], &Path), amc: (&[u8], &Path)) -> Result<Recording, Error> {
    let in_file = |path: &Path| {
        let file = path.to_path_buf();
        move |(at, problem)| Error::Syntax { file, at, problem }
    };
    let skeleton = asf::parse(&encoding::lossy(asf.0)).map_err(in_file(asf.1))?;
    let samples = recording::sample_count_max(asf.0.len() + amc.0.len());
    let motion = amc::parse(&encoding::lossy(amc.0), &skeleton, samples);
    let motion = motion.map_err(in_file(amc.1))?;
    // What others mean by `length` is not agreed on: metres, inches, or nothing.
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

/// The ASF file of the motion in the AMC file at `amc`, in the same folder: the one of the same stem; or
/// CMU's `SUBJECT.asf` for `SUBJECT_TRIAL.amc`; or the only one there.
///
/// # Errors
/// [`Error::NoSkeleton`] with the names that would do; [`Error::Io`] if the folder cannot be listed.
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
