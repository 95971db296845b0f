//! Old names of commands and options, and their new names.

use clap::Command;

/// Old top-level commands, each with the command that replaces it.
const COMMANDS: &[(&str, &str)] = &[
    ("blend", "sinew clip blend"),
    ("doctor", "sinew board doctor"),
    ("export", "sinew clip export"),
    ("faults", "sinew board faults"),
    ("figure", "sinew evaluate figure"),
    ("find", "sinew clip find"),
    ("flash", "sinew board flash"),
    ("inspect", "sinew clip inspect"),
    ("latency", "sinew evaluate latency"),
    ("map", "sinew clip map"),
    ("monitor", "sinew board monitor"),
    ("robustness", "sinew evaluate robustness"),
    ("servos", "sinew servo simulate"),
    ("settings", "sinew board settings"),
    ("study", "cargo run --release --manifest-path dev/studies/Cargo.toml --"),
    ("sweep", "sinew evaluate sweep"),
    ("upload", "sinew board upload"),
    ("verify", "sinew evaluate verify"),
    ("weights", "sinew clip weights"),
];

/// Commands, an old option of these commands, and the option or developer's command that replaces it.
const OPTIONS: &[(&[&str], &str, &str)] = &[
    (&["bake", "clip blend", "evaluate", "evaluate sweep", "report"], "--out", "--output"),
    (&["clip find"], "--out", "--picture"),
    (&["bake"], "--error", "--tolerance-deg"),
    (&["bake"], "--blend", "--loop-blend-s"),
    (&["bake"], "--page", "--html"),
    (&["bake", "clip export", "evaluate", "play", "record"], "--cutoff", "--cutoff-hz"),
    (&["board simulate", "board upload rig", "board doctor", "play"], "--rate", "--rate-hz"),
    (&["clip export", "clip find", "record", "rig check", "rig view"], "--rate", "--rate-hz"),
    (&["evaluate", "evaluate robustness", "evaluate sweep"], "--rate", "--rate-hz"),
    (&["evaluate latency"], "--rates", "--rates-hz"),
    (&["evaluate", "evaluate latency"], "--frames", "--frame-rate-hz"),
    (&["evaluate robustness", "evaluate sweep"], "--frames", "--frame-rate-hz"),
    (&["evaluate", "evaluate latency"], "--shares", "--speed-shares"),
    (&["evaluate robustness", "evaluate sweep"], "--shares", "--speed-shares"),
    (&["evaluate robustness"], "--front", "--projection-weights"),
    (&["evaluate robustness"], "--seeds", "--rigs"),
    (&["clip find"], "--apart", "--apart-s"),
    (&["clip blend"], "--seconds", "--blend-s"),
    (&["clip blend"], "--leave", "--alone-s"),
    (&["rig check", "rig view"], "--latency", "--latency-ticks"),
    (&["play", "record"], "--board", "--target PORT"),
    (&["play"], "--emulate", "--target nucleo"),
    (&["play"], "--qemu", "cargo xtask node"),
    (&["record"], "--simulate", "--target sim"),
    (&["board simulate", "record"], "--hand", "--guide"),
    (&["record"], "--let-go", "--release-test-s"),
    (&["record"], "--masses", "--mass-scale"),
    (&["record"], "--friction", "--friction-scale"),
    (&["servo"], "--bus", "--port"),
    (&["servo"], "--wait", "--timeout-ms"),
    (&["servo scan"], "--up-to", "--max-id"),
    (&["servo watch"], "--count", "--samples"),
    (&["servo watch"], "--every", "--interval-ms"),
    (&["servo apply"], "--release", "--torque-off"),
    (&["servo calibrate"], "--margin", "--margin-deg"),
    (&["board doctor", "board faults", "board flash", "board monitor"], "--board", "--port"),
    (&["board settings", "board upload rig", "board upload show"], "--board", "--port"),
    (&["board monitor"], "--every", "--interval-ms (in ms, not in s)"),
    (&["board monitor"], "--lines", "--samples"),
    (&["board upload rig", "board upload show"], "--by", "--approved-by"),
];

/// Returns the new names for old names in refused arguments; `None` if there are no old names.
pub(super) fn answer(arguments: &[String], command: &Command) -> Option<String> {
    let (path, renamed) = path(arguments, command);
    let mut lines: Vec<String> = renamed.into_iter().collect();
    let options = arguments.iter().take_while(|argument| *argument != "--");
    for argument in options.filter(|argument| argument.starts_with("--")) {
        let name = argument.split('=').next().unwrap_or_default();
        let is_below = |of: &&str| path == **of || path.starts_with(&format!("{of} "));
        let found = OPTIONS.iter().find_map(|(commands, old, new)| {
            commands.iter().find(|of| *old == name && is_below(of)).map(|of| (of, new))
        });
        if let Some((of, new)) = found {
            lines.push(format!("`{name}` of `sinew {of}` is `{new}` now"));
        }
    }
    (!lines.is_empty()).then(|| lines.join("; "))
}

/// Returns the command that the arguments name, its words joined by spaces, and a message if its name is old.
fn path(arguments: &[String], command: &Command) -> (String, Option<String>) {
    let mut words: Vec<&str> = Vec::new();
    let mut given = arguments.iter().map(String::as_str).filter(|word| !word.starts_with('-'));
    let mut renamed = None;
    let first = given.clone().next();
    if let Some((old, new)) = COMMANDS.iter().find(|(old, _)| first == Some(*old)) {
        renamed = Some(format!("`sinew {old}` is `{new}` now"));
        words.extend(new.split(' ').skip(1));
        given.next();
    }
    let mut command = words.iter().try_fold(command, |command, word| command.find_subcommand(word));
    for word in given {
        if let Some(below) = command.and_then(|command| command.find_subcommand(word)) {
            words.push(word);
            command = Some(below);
        }
    }
    // Arguments without a command belong to the evaluation.
    (if words.is_empty() { "evaluate".to_owned() } else { words.join(" ") }, renamed)
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory as _, Parser as _};

    use super::*;
    use crate::cli::Cli;

    /// The top-level commands before they were grouped.
    const BEFORE: [&str; 27] = [
        "evaluate",
        "verify",
        "inspect",
        "map",
        "bake",
        "play",
        "record",
        "report",
        "export",
        "figure",
        "sweep",
        "robustness",
        "latency",
        "weights",
        "study",
        "find",
        "blend",
        "rig",
        "servo",
        "board",
        "monitor",
        "faults",
        "settings",
        "upload",
        "flash",
        "doctor",
        "servos",
    ];

    fn told(line: &str) -> String {
        let arguments: Vec<String> = line.split(' ').map(str::to_owned).collect();
        Cli::try_parse_from(["sinew"].into_iter().chain(line.split(' '))).expect_err(line);
        answer(&arguments, &Cli::command()).expect(line)
    }

    fn find(path: &str) -> Command {
        let mut command = Cli::command();
        command.build();
        let found =
            path.split(' ').try_fold(&command, |command, word| command.find_subcommand(word));
        found.expect(path).clone()
    }

    #[test]
    fn every_command_of_before_is_there_or_answers() {
        let today = Cli::command();
        for old in BEFORE {
            if today.find_subcommand(old).is_some() {
                assert!(COMMANDS.iter().all(|(name, _)| *name != old), "{old}");
                continue;
            }
            let (_, new) = COMMANDS.iter().find(|(name, _)| *name == old).expect(old);
            assert_eq!(told(old), format!("`sinew {old}` is `{new}` now"));
            if let Some(path) = new.strip_prefix("sinew ") {
                find(path);
            }
        }
    }

    #[test]
    fn every_option_of_before_answers_with_one_of_today() {
        for (commands, old, new) in OPTIONS {
            let new = new.split(' ').next().expect("a word");
            for path in *commands {
                let command = find(path);
                let has = |name: &str| {
                    command
                        .get_arguments()
                        .any(|option| option.get_long() == name.strip_prefix("--"))
                };
                assert!(has(new) || new == "cargo", "{path}: {new}");
                assert!(!has(old), "{path}: {old}");
                assert!(told(&format!("{path} {old}")).contains(new), "{path} {old}");
            }
        }
    }

    #[test]
    fn all_old_names_of_a_line_are_told() {
        assert_eq!(
            told("monitor --every=2 --lines 3 --board x"),
            "`sinew monitor` is `sinew board monitor` now; \
             `--every` of `sinew board monitor` is `--interval-ms (in ms, not in s)` now; \
             `--lines` of `sinew board monitor` is `--samples` now; \
             `--board` of `sinew board monitor` is `--port` now"
        );
        assert_eq!(told("--out a"), "`--out` of `sinew evaluate` is `--output` now");
        assert_eq!(told("servo --bus x scan"), "`--bus` of `sinew servo` is `--port` now");
        assert_eq!(answer(&["--oot".to_owned()], &Cli::command()), None);
    }
}
