//! Virtual environments of Python, for foreign programs.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result};

use sinew_steps::step;

use crate::setup;

/// A virtual environment under `target`.
pub(crate) struct Venv {
    pub(crate) folder: PathBuf,
}

impl Venv {
    /// Creates an environment with packages that pip installs together, or reuses it if `list` is unchanged. `more`
    /// installs packages in separate folders.
    pub(crate) fn install(
        name: &str,
        packages: &[&str],
        list: &str,
        more: impl FnOnce(&Self) -> Result<()>,
    ) -> Result<Self> {
        Self::install_with(Path::new("python3"), name, packages, list, more)
    }

    /// Creates an environment of an interpreter, like [`Self::install`].
    pub(crate) fn install_with(
        python: &Path,
        name: &str,
        packages: &[&str],
        list: &str,
        more: impl FnOnce(&Self) -> Result<()>,
    ) -> Result<Self> {
        let venv = Self { folder: step::root().join("target").join(name) };
        let installed = venv.folder.join("installed");
        if std::fs::read_to_string(&installed).is_ok_and(|found| found == list) {
            return Ok(venv);
        }
        setup::python()?;
        let _ = std::fs::remove_dir_all(&venv.folder);
        let title = format!("Python for {name}");
        step::run(&title, Command::new(python).args(["-m", "venv"]).arg(&venv.folder))?;
        venv.pip(&[&["install"][..], packages].concat())?;
        more(&venv)?;
        std::fs::write(installed, list)?;
        Ok(venv)
    }

    pub(crate) fn pip(&self, arguments: &[&str]) -> Result<()> {
        let mut pip = Command::new(self.folder.join("bin/pip"));
        pip.args(["--disable-pip-version-check", "--quiet"]).args(arguments);
        step::run("pip", &mut pip).context(
            "the packages come from PyPI (https://pypi.org), which cannot be reached or does not have them: \
             nothing has been tried",
        )
    }

    /// Returns the environment's Python with a script.
    pub(crate) fn python(&self, script: &Path) -> Command {
        let mut python = Command::new(self.folder.join("bin/python"));
        python.arg(script);
        python
    }
}
