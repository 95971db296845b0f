//! Output files of commands. This module protects input files from being overwritten.
//!
//! Options that name an output file have the type [`OutputPath`]; options that name a folder or a link have the type
//! [`OutputPlace`]. Before a command runs, each output is compared with all other files on the command line, by the
//! file itself, not by its name. Each output file is also opened for writing, so that no result is computed, and no rig
//! is led by hand, for a file that cannot be written.

use std::ffi::{OsStr, OsString};
use std::ops::Deref;
use std::path::{Path, PathBuf};

use clap::builder::Arg;
use clap::{ArgMatches, Command};
use sinew_host_util::output;

/// A file that a command writes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct OutputPath(PathBuf);

/// A folder into which a command writes, or a link that it creates.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct OutputPlace(PathBuf);

macro_rules! path {
    ($name:ident) => {
        impl From<OsString> for $name {
            fn from(path: OsString) -> Self {
                Self(path.into())
            }
        }

        impl Deref for $name {
            type Target = Path;

            fn deref(&self) -> &Path {
                &self.0
            }
        }

        impl AsRef<Path> for $name {
            fn as_ref(&self) -> &Path {
                &self.0
            }
        }
    };
}

path!(OutputPath);
path!(OutputPlace);

/// Refuses a command that would overwrite its input, write two outputs into one file, or write a file that cannot be
/// written.
pub(super) fn check(command: &Command, matches: &ArgMatches) -> anyhow::Result<()> {
    let (mut written, mut read): (Vec<PathBuf>, Vec<(String, PathBuf)>) = (Vec::new(), Vec::new());
    let mut files = Vec::new();
    let (mut command, mut matches) = (command, matches);
    loop {
        for arg in command.get_arguments().filter(|arg| arg.get_action().takes_values()) {
            let values = matches.try_get_raw(arg.get_id().as_str()).ok().flatten();
            for value in values.into_iter().flatten() {
                if is_output(arg) {
                    written.push(value.into());
                    if is_of::<OutputPath>(arg) {
                        files.push(PathBuf::from(value));
                    }
                } else {
                    read.extend(parts(value).map(|part| (name(arg), part)));
                }
            }
        }
        let Some((name, below)) = matches.subcommand() else { break };
        let Some(of_name) = command.find_subcommand(name) else { break };
        (command, matches) = (of_name, below);
    }
    let written: Vec<&Path> = written.iter().map(PathBuf::as_path).collect();
    let read: Vec<(&str, Option<&Path>)> =
        read.iter().map(|(what, path)| (what.as_str(), Some(path.as_path()))).collect();
    output::distinct(&written, &read)?;
    files.iter().try_for_each(|file| output::try_to_write(file))
}

fn is_output(arg: &Arg) -> bool {
    is_of::<OutputPath>(arg) || is_of::<OutputPlace>(arg)
}

fn is_of<T: 'static>(arg: &Arg) -> bool {
    arg.get_value_parser().type_id() == std::any::TypeId::of::<T>()
}

/// Returns an option's name for a message.
fn name(arg: &Arg) -> String {
    let id = arg.get_id().as_str();
    // An option with an id of one letter is named by its value.
    let names = arg.get_value_names().and_then(|names| names.first()).filter(|_| id.len() == 1);
    names.map_or_else(|| id.replace('_', " "), ToString::to_string)
}

/// Returns the files that a value may name: the value itself, and its parts before and after `@` (`walk.bvh@1.2s`), `=`
/// or a comma.
fn parts(value: &OsStr) -> impl Iterator<Item = PathBuf> {
    let text = value.to_str().unwrap_or_default();
    let cut: Vec<PathBuf> = text.split([',', '@', '=']).map(PathBuf::from).collect();
    std::iter::once(PathBuf::from(value)).chain(cut).filter(|part| !part.as_os_str().is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Collects all arguments of a command and of its sub-commands, with the commands' names.
    fn arguments(command: &Command, path: &str, found: &mut Vec<(String, String, bool)>) {
        for arg in command.get_arguments().filter(|arg| arg.get_action().takes_values()) {
            let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
            found.push((format!("{path} {}", arg.get_id()), help, is_output(arg)));
        }
        for below in command.get_subcommands() {
            arguments(below, &format!("{path} {}", below.get_name()), found);
        }
    }

    #[test]
    fn each_option_that_names_a_file_to_write_is_known_as_one() {
        let mut command = super::super::command_line();
        command.build();
        let mut found = Vec::new();
        arguments(&command, "sinew", &mut found);
        let names = ["output", "record", "html", "picture", "pty"];
        let words = ["to write", "Write", "write into", "draw into", "draw the"];
        let (mut known, mut missed) = (0, Vec::new());
        for (name, help, is_output) in &found {
            known += usize::from(*is_output);
            let id = name.rsplit(' ').next().unwrap_or_default();
            let says_so = words.iter().any(|word| help.contains(word)) && help.contains("file");
            if (names.contains(&id) || says_so) && !is_output {
                missed.push(format!("{name}: {help}"));
            }
        }
        assert!(known >= 15, "{known}");
        assert!(missed.is_empty(), "{missed:#?}");
    }
}
