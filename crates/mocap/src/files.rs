//! Finds the clips in a list of files and folders.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::{Path, PathBuf};

use crate::{format, recording};

/// The reason why paths do not name clips.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A folder cannot be listed.
    #[error("{}: cannot be listed: {source}", folder.display())]
    Folder {
        /// Path of the folder.
        folder: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A folder contains no clip.
    #[error(
        "{}: expected {} files in the folder, found none (its subfolders are not searched)",
        folder.display(), format::NAMES
    )]
    NoClips {
        /// Path of the folder.
        folder: PathBuf,
    },
    /// A file is named twice.
    #[error("{}: is given twice, also as {}", file.display(), first.display())]
    GivenTwice {
        /// Path of the file.
        file: PathBuf,
        /// Earlier path of the same file.
        first: PathBuf,
    },
}

/// A file with a clip, and the name of the clip.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClipFile {
    /// Path of the file.
    pub path: PathBuf,
    /// Stem of the file, preceded by the folders that distinguish it from other files of that stem.
    pub name: String,
    /// Whether the file was found in a named folder, instead of being named itself.
    pub from_folder: bool,
}

/// The clips that a list of paths names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExpandedPaths {
    /// Files with clips.
    pub clips: Vec<ClipFile>,
    /// Other files in the folders, one line for each with the reason why it is not a clip.
    pub left_out: Vec<String>,
}

impl ExpandedPaths {
    /// Separates results from errors. `made` contains a result for each clip, in their order. Returns the results,
    /// and a line for each file that is left out: files that are not clips, and files of folders whose result is an
    /// error.
    ///
    /// # Errors
    /// The first error of a file that was named itself, or of any file if `is_strict`; if there are no results, the
    /// first error of all.
    pub fn take<T, E: Display>(
        &self,
        made: impl IntoIterator<Item = Result<T, E>>,
        is_strict: bool,
    ) -> Result<(Vec<T>, Vec<String>), E> {
        let (mut taken, mut left_out, mut first) = (Vec::new(), self.left_out.clone(), None);
        for (file, made) in self.clips.iter().zip(made) {
            match made {
                Ok(made) => taken.push(made),
                Err(error) if file.from_folder && !is_strict => {
                    // With its causes, if the error prints them separately.
                    let why = format!("{error:#}");
                    let path = file.path.display().to_string();
                    let is_named = why.contains(&path);
                    left_out.push(if is_named { why } else { format!("{path}: {why}") });
                    first = first.or(Some(error));
                }
                Err(error) => return Err(error),
            }
        }
        first.filter(|_| taken.is_empty()).map_or(Ok((taken, left_out)), Err)
    }
}

impl ClipFile {
    /// Refers to the clip in `path`; its name is the stem of the file.
    pub fn new(path: &Path) -> Self {
        Self { path: path.to_path_buf(), name: recording::stem(path), from_folder: false }
    }
}

/// Returns the clips that `paths` name, see [`expand_all`].
///
/// # Errors
/// Those of [`expand_all`].
pub fn expand(paths: &[PathBuf]) -> Result<Vec<ClipFile>, Error> {
    expand_all(paths).map(|expanded| expanded.clips)
}

/// Returns the clips that `paths` name, in the order of `paths`; those of a folder are in the order of their names. A
/// file is used as given. A folder stands for its files whose name or, for texts, content is that of a motion;
/// subfolders are not searched.
///
/// # Errors
/// [`Error::Folder`] and [`Error::NoClips`]; [`Error::GivenTwice`] for a file that two paths name.
pub fn expand_all(paths: &[PathBuf]) -> Result<ExpandedPaths, Error> {
    let (mut files, mut left_out) = (Vec::new(), Vec::new());
    let mut from_folder = Vec::new();
    for path in paths {
        if path.is_dir() {
            let (clips, others) = in_folder(path)?;
            files.extend(clips);
            left_out.extend(others);
        } else {
            files.push(path.clone());
        }
        from_folder.resize(files.len(), path.is_dir());
    }
    let mut seen = BTreeMap::new();
    for file in &files {
        // A missing file is reported later, by its reader.
        let place = file.canonicalize().unwrap_or_else(|_| file.clone());
        if let Some(first) = seen.insert(place, file) {
            return Err(Error::GivenTwice { file: file.clone(), first: first.clone() });
        }
    }
    let names = names(&files);
    let clip = |((path, name), from_folder)| ClipFile { path, name, from_folder };
    let clips = files.into_iter().zip(names).zip(from_folder).map(clip).collect();
    Ok(ExpandedPaths { clips, left_out })
}

type InFolder = (Vec<PathBuf>, Vec<String>);

fn in_folder(folder: &Path) -> Result<InFolder, Error> {
    let listed = || -> std::io::Result<Vec<PathBuf>> {
        std::fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path())).collect()
    };
    let mut files =
        listed().map_err(|source| Error::Folder { folder: folder.to_path_buf(), source })?;
    files.sort();
    let (clips, others): (Vec<_>, Vec<_>) =
        files.into_iter().partition(|file| format::is_motion(file));
    if clips.is_empty() {
        return Err(Error::NoClips { folder: folder.to_path_buf() });
    }
    let told = |file: PathBuf| format!("{}: {}", file.display(), why_not(&file));
    Ok((clips, others.into_iter().map(told).collect()))
}

/// Returns why a file in a folder is not a clip.
fn why_not(file: &Path) -> &'static str {
    if file.is_dir() {
        "a folder in the folder is not searched"
    } else if file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("asf")) {
        "a skeleton, which is read together with its motions"
    } else {
        "neither its name nor its content is that of a motion"
    }
}

/// Returns a unique name for each file.
fn names(files: &[PathBuf]) -> Vec<String> {
    let mut names: Vec<String> = files.iter().map(|file| recording::stem(file)).collect();
    // This depth exceeds that of any path: at it, only extensions differ.
    let depth_max = files.iter().map(|file| file.components().count()).max().unwrap_or(0) + 1;
    for depth in 1..=depth_max {
        let mut count = BTreeMap::new();
        for name in &names {
            *count.entry(name.clone()).or_insert(0) += 1;
        }
        for (name, file) in names.iter_mut().zip(files) {
            if count[name] > 1 {
                *name = if depth < depth_max {
                    with_folders(file, depth)
                } else {
                    with_extension(file)
                };
            }
        }
    }
    names
}

/// Returns the stem after the last `depth` folders.
fn with_folders(file: &Path, depth: usize) -> String {
    let file = std::path::absolute(file).unwrap_or_else(|_| file.to_path_buf());
    let mut parts = vec![recording::stem(&file)];
    let folders = file.ancestors().skip(1).map_while(Path::file_name);
    parts.extend(folders.take(depth).map(|name| name.to_string_lossy().into_owned()));
    parts.reverse();
    parts.join("/")
}

fn with_extension(file: &Path) -> String {
    file.display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expands_folders_in_order_and_refuses_empty_ones() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let empty = expand(&[folder.path().to_path_buf()]).unwrap_err().to_string();
        assert!(
            empty.ends_with(
                ": expected *.bvh, *.amc or humanoid3d_*.txt files in the folder, found none (its \
                 subfolders are not searched)"
            ),
            "{empty}"
        );
        std::fs::create_dir(at("more")).unwrap();
        for name in [
            "b.bvh",
            "a.BVH",
            "c.txt",
            "t.amc",
            "t.asf",
            "humanoid3d_kick.txt",
            "LICENSE.txt",
            "more/d.bvh",
        ] {
            std::fs::write(at(name), "").unwrap();
        }
        std::fs::write(at("walk.txt"), "{\"Frames\": []}").unwrap();
        std::fs::write(at("settings.txt"), "{\"frames\": 3}").unwrap();
        let paths = [at("c.txt"), folder.path().to_path_buf()];
        let ExpandedPaths { clips: files, left_out } = expand_all(&paths).unwrap();
        let paths: Vec<_> = files.iter().map(|file| file.path.clone()).collect();
        let expected = ["c.txt", "a.BVH", "b.bvh", "humanoid3d_kick.txt", "t.amc", "walk.txt"];
        assert_eq!(paths, expected.map(at));
        let out = ["LICENSE.txt", "c.txt", "more", "settings.txt", "t.asf"].map(at);
        assert_eq!(left_out.len(), out.len());
        for (told, file) in left_out.iter().zip(out) {
            assert!(told.starts_with(&format!("{}: ", file.display())), "{told}");
        }
        assert_eq!(files.iter().filter(|file| file.from_folder).count(), 5);
    }

    #[test]
    fn what_cannot_be_used_is_left_out_of_folders_alone() {
        let expanded = |from_folder: [bool; 2]| ExpandedPaths {
            clips: from_folder
                .into_iter()
                .zip(["a.bvh", "b.bvh"])
                .map(|(from_folder, name)| ClipFile {
                    from_folder,
                    ..ClipFile::new(Path::new(name))
                })
                .collect(),
            left_out: vec!["c.md: no clip".to_owned()],
        };
        let taken = expanded([true, true]).take([Ok(1), Err("a.bvh is cut")], false);
        let told = ["c.md: no clip", "b.bvh: a.bvh is cut"].map(str::to_owned).to_vec();
        assert_eq!(taken, Ok((vec![1], told)));
        let taken = expanded([false, true]).take([Ok(1), Err("b.bvh: is cut")], false);
        assert_eq!(taken.unwrap().1[1], "b.bvh: is cut");
        for (from_folder, is_strict, made, error) in [
            ([true, true], true, [Ok(1), Err("b")], "b"),
            ([true, false], false, [Err("a"), Err("b")], "b"),
            ([true, true], false, [Err("a"), Err("b")], "a"),
        ] {
            assert_eq!(expanded(from_folder).take(made, is_strict), Err(error));
        }
    }

    #[test]
    fn tells_clips_of_one_stem_apart() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["a", "b", "b/a"] {
            std::fs::create_dir(at(name)).unwrap();
        }
        let files = ["a/x.bvh", "b/x.bvh", "b/y.bvh", "b/a/x.bvh", "b/y.amc"];
        for name in files {
            std::fs::write(at(name), "").unwrap();
        }
        let names: Vec<String> =
            expand(&files.map(at)).unwrap().into_iter().map(|file| file.name).collect();
        let base = folder.path().file_name().unwrap().to_str().unwrap();
        assert_eq!(names[0], format!("{base}/a/x"));
        assert_eq!(names[1], "b/x");
        assert_eq!(names[3], "b/a/x");
        assert!(names[2].ends_with("b/y.bvh") && names[4].ends_with("b/y.amc"), "{names:?}");
        let error = expand(&[at("a"), at("b/../a/x.bvh")]).unwrap_err().to_string();
        assert!(error.contains("b/../a/x.bvh: is given twice, also as "), "{error}");
    }
}
