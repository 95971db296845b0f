//! Writes all results of one run to a folder, completely or not at all.
//!
//! Results are first written to a subfolder. After all of them are on the disk, the results of the previous run are
//! removed, and the new results are moved to their places. Results of two runs are thus never mixed. During the move,
//! the file [`UNFINISHED`] exists; it remains if the machine stops at that time.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};

use super::same;

/// File that is locked while a run writes. It contains the kind and name of each result.
const LOCK: &str = ".sinew";
/// Subfolder for results until all of them are complete.
const STAGE: &str = ".sinew-part";
/// File that exists while results are moved to their places.
const UNFINISHED: &str = "UNFINISHED";

/// An error while results are written to a folder.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// An error of the operating system.
    #[error("{}: {source}", path.display())]
    Io {
        /// Folder or file with the error.
        path: PathBuf,
        /// Cause of the error.
        source: io::Error,
    },
    /// Another run writes to the folder.
    #[error("{}: another run writes into this folder; give each its own", folder.display())]
    Busy {
        /// Folder that is in use.
        folder: PathBuf,
    },
    /// A result would overwrite a file that the command has read.
    #[error("{}: is the {what}, and would be lost: give another folder to write", file.display())]
    Input {
        /// File that would be overwritten.
        file: PathBuf,
        /// Description of the input.
        what: String,
    },
}

/// A folder for results, locked against other runs. [`Folder::finish`] puts the results in their places. If the folder
/// is dropped unfinished, the old results remain.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    lock: File,
    kind: String,
    inputs: Vec<(String, PathBuf)>,
}

impl Folder {
    /// Opens a folder for results of a kind; results of other kinds are not changed. `inputs` are the files that the
    /// command reads, with descriptions.
    ///
    /// # Errors
    /// [`FolderError::Io`]; [`FolderError::Busy`] if another run uses the folder.
    pub fn open(
        folder: &Path,
        kind: &str,
        inputs: &[(&str, Option<&Path>)],
    ) -> Result<Self, FolderError> {
        fs::create_dir_all(folder).map_err(io_at(folder))?;
        let path = folder.join(LOCK);
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false);
        let lock = options.open(&path).map_err(io_at(&path))?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(FolderError::Busy { folder: folder.to_owned() });
            }
            Err(TryLockError::Error(source)) => return Err(io_at(&path)(source)),
        }
        let inputs = inputs
            .iter()
            .filter_map(|(what, path)| Some(((*what).to_owned(), (*path)?.to_owned())));
        let results =
            Self { path: folder.to_owned(), lock, kind: kind.to_owned(), inputs: inputs.collect() };
        let stage = results.stage();
        // The subfolder may remain from a run that was stopped.
        remove(fs::remove_dir_all(&stage)).map_err(io_at(&stage))?;
        fs::create_dir(&stage).map_err(io_at(&stage))?;
        Ok(results)
    }

    /// Returns the folder in which this run must write its files.
    pub fn stage(&self) -> PathBuf {
        self.path.join(STAGE)
    }

    /// Moves all files of the stage to their places, and removes the results of the same kind from the previous run.
    /// Returns the paths of the files.
    ///
    /// # Errors
    /// [`FolderError::Io`]; [`FolderError::Input`] if a result would replace an input of the command.
    pub fn finish(mut self) -> Result<Vec<PathBuf>, FolderError> {
        let stage = self.stage();
        let new = names(&stage).map_err(io_at(&stage))?;
        let (before, mut of_others): (Vec<_>, Vec<_>) =
            self.read_list()?.into_iter().partition(|[kind, _]| *kind == self.kind);
        let gone: BTreeSet<&String> = before.iter().map(|[_, name]| name).chain(&new).collect();
        for name in &gone {
            let file = self.path.join(name);
            if let Some((what, _)) = self.inputs.iter().find(|(_, input)| same(input, &file)) {
                return Err(FolderError::Input { file, what: what.clone() });
            }
        }
        for name in &new {
            let file = stage.join(name);
            File::open(&file).and_then(|file| file.sync_all()).map_err(io_at(&file))?;
        }
        let mark = self.path.join(UNFINISHED);
        let text = "Results were being moved here when the program was stopped: run it again.\n";
        fs::write(&mark, text).map_err(io_at(&mark))?;
        // If the program is killed now, the next run knows both the old files and the new ones.
        let listed = gone.iter().map(|name| [self.kind.clone(), (*name).clone()]);
        let listed: Vec<_> = listed.chain(of_others.iter().cloned()).collect();
        self.write_list(&listed)?;
        for name in gone {
            let file = self.path.join(name);
            remove(fs::remove_file(&file)).map_err(io_at(&file))?;
        }
        let mut files = Vec::new();
        for name in &new {
            let file = self.path.join(name);
            fs::rename(stage.join(name), &file).map_err(io_at(&file))?;
            files.push(file);
        }
        of_others.retain(|[_, name]| !new.contains(name));
        of_others.extend(new.into_iter().map(|name| [self.kind.clone(), name]));
        self.write_list(&of_others)?;
        fs::remove_file(&mark).map_err(io_at(&mark))?;
        Ok(files)
    }

    /// Returns kind and name of each file from earlier runs.
    fn read_list(&mut self) -> Result<Vec<[String; 2]>, FolderError> {
        let mut bytes = Vec::new();
        self.lock
            .rewind()
            .and_then(|()| self.lock.read_to_end(&mut bytes))
            .map_err(io_at(&self.path))?;
        let text = String::from_utf8_lossy(&bytes);
        let lines = text.lines().filter_map(|line| line.split_once('\t'));
        // Only names within this folder are accepted, because anybody may have edited the list.
        let own = lines.filter(|(_, name)| Path::new(name).file_name() == Some(name.as_ref()));
        Ok(own.map(|(kind, name)| [kind.to_owned(), name.to_owned()]).collect())
    }

    fn write_list(&mut self, list: &[[String; 2]]) -> Result<(), FolderError> {
        let text: Vec<u8> =
            list.iter().flat_map(|file| (file.join("\t") + "\n").into_bytes()).collect();
        let write = |lock: &mut File| {
            lock.set_len(0)?;
            lock.rewind()?;
            lock.write_all(&text)?;
            lock.sync_all()
        };
        write(&mut self.lock).map_err(io_at(&self.path))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // A drop cannot report an error; the next run removes the subfolder.
        let _ = fs::remove_dir_all(self.stage());
    }
}

/// Returns the names of the files in a folder, sorted. All names that this program writes are valid text.
fn names(folder: &Path) -> io::Result<Vec<String>> {
    let name = |entry: io::Result<fs::DirEntry>| {
        entry?.file_name().into_string().map_err(|_| io::ErrorKind::InvalidFilename.into())
    };
    let mut names: Vec<String> = fs::read_dir(folder)?.map(name).collect::<io::Result<_>>()?;
    names.sort();
    Ok(names)
}

/// Returns the result of a removal; a file that did not exist is not an error.
fn remove(removed: io::Result<()>) -> io::Result<()> {
    removed
        .or_else(|error| if error.kind() == io::ErrorKind::NotFound { Ok(()) } else { Err(error) })
}

fn io_at(path: &Path) -> impl FnOnce(io::Error) -> FolderError {
    let path = path.to_owned();
    move |source| FolderError::Io { path, source }
}
