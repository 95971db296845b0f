//! Results of one run, as a whole in a folder.
//!
//! They are written into a folder within it. Only when all are on the disk, those of the run before are removed, and
//! the new ones moved to their places: results of two runs never lie side by side. While they are moved, the file
//! [`UNFINISHED`] is there, and stays if the machine stops just then.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};

use super::same;

/// Locked while a run writes; holds which files are whose.
const LOCK: &str = ".sinew";
/// Where results are until they are whole.
const STAGE: &str = ".sinew-part";
/// There while results are moved to their places.
const UNFINISHED: &str = "UNFINISHED";

/// Results that cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// The system refuses.
    #[error("{}: {source}", path.display())]
    Io {
        /// Folder or file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// Somebody else writes there.
    #[error("{}: another run writes into this folder; give each its own", folder.display())]
    Busy {
        /// The folder.
        folder: PathBuf,
    },
    /// A result would take the place of what was read.
    #[error("{}: is the {what}, and would be lost: give another folder to write", file.display())]
    Input {
        /// The file.
        file: PathBuf,
        /// What the command reads there.
        what: String,
    },
}

/// A folder that results are being written into, locked against other runs. They are there from [`Folder::finish`] on;
/// dropped before, it leaves what was there.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    lock: File,
    kind: String,
    inputs: Vec<(String, PathBuf)>,
}

impl Folder {
    /// Opens a folder for results of a kind: those of other kinds are left alone. `inputs`: what the command reads.
    ///
    /// # Errors
    /// [`FolderError::Io`]; [`FolderError::Busy`] if another run has it.
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
        // Of a run that was stopped.
        remove(fs::remove_dir_all(&stage)).map_err(io_at(&stage))?;
        fs::create_dir(&stage).map_err(io_at(&stage))?;
        Ok(results)
    }

    /// Where the files of this run are to be written.
    pub fn stage(&self) -> PathBuf {
        self.path.join(STAGE)
    }

    /// Puts all files of the stage in their places, and removes those of the same kind that a run before left. Returns
    /// where they are.
    ///
    /// # Errors
    /// [`FolderError::Io`]; [`FolderError::Input`] if one would replace what the command read.
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
        // Whoever comes after a kill knows of old files and of new ones.
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

    /// Kind and name of each file that runs before left.
    fn read_list(&mut self) -> Result<Vec<[String; 2]>, FolderError> {
        let mut bytes = Vec::new();
        self.lock
            .rewind()
            .and_then(|()| self.lock.read_to_end(&mut bytes))
            .map_err(io_at(&self.path))?;
        let text = String::from_utf8_lossy(&bytes);
        let lines = text.lines().filter_map(|line| line.split_once('\t'));
        // A name is one of this folder, whoever wrote the list.
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
        // Nobody can be told here; the next run removes it.
        let _ = fs::remove_dir_all(self.stage());
    }
}

/// The files in a folder, in order. Ours all have names that are text.
fn names(folder: &Path) -> io::Result<Vec<String>> {
    let name = |entry: io::Result<fs::DirEntry>| {
        entry?.file_name().into_string().map_err(|_| io::ErrorKind::InvalidFilename.into())
    };
    let mut names: Vec<String> = fs::read_dir(folder)?.map(name).collect::<io::Result<_>>()?;
    names.sort();
    Ok(names)
}

/// What is not there needs no removing.
fn remove(removed: io::Result<()>) -> io::Result<()> {
    removed
        .or_else(|error| if error.kind() == io::ErrorKind::NotFound { Ok(()) } else { Err(error) })
}

fn io_at(path: &Path) -> impl FnOnce(io::Error) -> FolderError {
    let path = path.to_owned();
    move |source| FolderError::Io { path, source }
}
