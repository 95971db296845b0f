//! Checks the commands in the documentation with the programs themselves.

use std::process::{Command, Output};

use anyhow::Result;

use super::cargo::Workspace;
use super::fault::Fault;
use super::page::Page;
use crate::task::Task;
use crate::{nextest, studies};

/// Our programs, by the package or manifest in the cargo command.
const PROGRAMS: [(&str, &str); 2] =
    [("sinew-sim", "sinew"), ("dev/studies/Cargo.toml", "sinew-studies")];

pub(super) fn check(pages: &[Page]) -> Result<Vec<Fault>> {
    let workspace = Workspace::read()?;
    let mut faults = Vec::new();
    for page in pages {
        for (line, command) in &page.commands {
            let wrong = calls(command).iter().find_map(|call| fault(call, &workspace));
            faults.extend(wrong.map(|what| Fault {
                path: page.path.clone(),
                line: *line,
                what: format!("`{}`: {what}", command.trim()),
            }));
        }
    }
    Ok(faults)
}

/// A call of a program, with its arguments.
#[derive(Debug, PartialEq)]
enum Call {
    /// A call of one of our programs.
    Program(&'static str, Vec<String>),
    Xtask(Vec<String>),
    /// A call of cargo, with its options.
    Cargo(Vec<String>),
    /// A line with an unclosed quote.
    NoCommand,
}

/// Returns the calls in a shell line, of the programs that can be checked.
fn calls(line: &str) -> Vec<Call> {
    let Some(words) = shlex::split(line) else { return vec![Call::NoCommand] };
    words
        .split(|word| ["|", "&&", "&", ";", "do", "done"].contains(&word.as_str()))
        .flat_map(|words| {
            // Removes a redirection to a file.
            let words = words.split(|word| word == ">").next().unwrap_or_default();
            let is_variable = |word: &&String| word.contains('=') && !word.starts_with('-');
            call(&words[words.iter().take_while(is_variable).count()..])
        })
        .collect()
}

fn call(words: &[String]) -> Vec<Call> {
    let of_package = |package: &str| PROGRAMS.iter().find(|(name, _)| *name == package);
    let (program, rest) = match words.split_first() {
        Some((program, rest)) => (program.as_str(), rest),
        None => return Vec::new(),
    };
    if let Some((_, program)) = PROGRAMS.iter().find(|(_, name)| *name == program) {
        return vec![Call::Program(program, rest.to_vec())];
    }
    let ("cargo", Some((command, rest))) = (program, rest.split_first()) else { return Vec::new() };
    if command == "xtask" {
        return vec![Call::Xtask(rest.to_vec())];
    }
    let dashes = rest.iter().position(|word| word == "--").unwrap_or(rest.len());
    let (options, arguments) = (&rest[..dashes], rest.get(dashes + 1..).unwrap_or_default());
    let mut calls = vec![Call::Cargo(options.to_vec())];
    if command == "run" && !options.iter().any(|option| option == "--example" || option == "--bin")
    {
        let is_choice = |option: &&String| ["-p", "--manifest-path"].contains(&option.as_str());
        let package = options.iter().skip_while(|option| !is_choice(option)).nth(1);
        let program = of_package(package.map_or("sinew-sim", String::as_str));
        calls.extend(program.map(|(_, name)| Call::Program(name, arguments.to_vec())));
    }
    calls
}

fn fault(call: &Call, workspace: &Workspace) -> Option<String> {
    match call {
        Call::NoCommand => Some("its quotes do not end".into()),
        Call::Cargo(options) => workspace.fault(options),
        Call::Xtask(words) => {
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            Task::parse(&words).is_none().then(|| "xtask has no such command".into())
        }
        Call::Program(name, arguments) => match parsed(name, arguments) {
            Ok(Some(output)) if !output.status.success() => {
                let text = String::from_utf8_lossy(&output.stderr);
                Some(text.lines().next().unwrap_or("refused").to_owned())
            }
            Ok(_) => None,
            Err(error) => Some(format!("{name}: {error}")),
        },
    }
}

/// Lets one of our programs parse its arguments; `None` if it is the studies' program, and is not built.
fn parsed(name: &str, arguments: &[String]) -> Result<Option<Output>> {
    let program = match name {
        "sinew-studies" => studies::program(),
        name => nextest::program(name)?,
    };
    if name == "sinew-studies" && !program.exists() {
        return Ok(None);
    }
    Ok(Some(Command::new(program).args(arguments).arg("--parse-only").output()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn our_programs_are_found_in_what_a_shell_reads() {
        let program = |name, arguments: &str| Call::Program(name, words(arguments));
        assert_eq!(
            calls("sinew clip find a/ --like b # what it does"),
            [program("sinew", "clip find a/ --like b")]
        );
        assert_eq!(
            calls(
                "SINEW_DATA=path cargo run --release --manifest-path dev/studies/Cargo.toml -- mds --quick"
            ),
            [
                Call::Cargo(words("--release --manifest-path dev/studies/Cargo.toml")),
                program("sinew-studies", "mds --quick")
            ]
        );
        assert_eq!(
            calls("cargo run --release"),
            [Call::Cargo(words("--release")), program("sinew", "")]
        );
        assert_eq!(
            calls("cargo run -p sinew-core --example six_joints"),
            [Call::Cargo(words("-p sinew-core --example six_joints"))]
        );
        assert_eq!(
            calls("cargo xtask budget --accept && git diff"),
            [Call::Xtask(words("budget --accept"))]
        );
        assert_eq!(calls("for clip in *.bvh; do"), []);
        assert_eq!(calls("sinew 'find"), [Call::NoCommand]);
    }
}
