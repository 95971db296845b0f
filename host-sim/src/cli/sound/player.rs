//! A program that plays the sound of a show while the show runs.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::str::FromStr;
use std::time::{Duration, Instant};

use anyhow::{Context as _, ensure};
use sinew_host_util::command::note;
use sinew_show::sound::Sound;

/// Command line of a player, as words. `{}` stands for the file, `{s}` for the time in the sound, s.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::cli) struct PlayerCommand(Vec<String>);

impl FromStr for PlayerCommand {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
        if words.len() < 2 || !words.iter().any(|word| word.contains("{}")) {
            return Err("expected a command with `{}` for the file, such as `aplay {}`".to_owned());
        }
        Ok(Self(words))
    }
}

impl PlayerCommand {
    /// Creates a player for a sound.
    pub(in crate::cli) fn player(&self, path: &Path, sound: &Sound) -> anyhow::Result<Player> {
        let place_s = sound.offset_us as f64 * 1e-6;
        let takes_place = self.0.iter().any(|word| word.contains("{s}"));
        ensure!(
            place_s < 0.05 || takes_place,
            "--sound-with: the show begins at {place_s:.2} s of its sound: expected `{{s}}` in the command, such as \
             `ffplay -nodisp -autoexit -ss {{s}} {{}}`"
        );
        let (file, place) = (path.display().to_string(), format!("{:.3}", place_s.max(0.0)));
        let words = self.0.iter().map(|word| word.replace("{s}", &place).replace("{}", &file));
        let wait = Duration::from_secs_f64((-place_s).max(0.0));
        Ok(Player { words: words.collect(), wait, begun: None, child: None, is_over: false })
    }
}

/// A program that plays a sound; it runs at most once.
#[derive(Debug)]
pub(in crate::cli) struct Player {
    words: Vec<String>,
    /// Time from the start of the show to the start of the sound; zero if the sound begins first.
    wait: Duration,
    begun: Option<Instant>,
    child: Option<Child>,
    /// Whether the sound has ended, or could not begin.
    is_over: bool,
}

impl Player {
    /// Receives in each tick, or with each message, whether the show's clock runs (`runs`). Starts the program when the
    /// clock starts, and ends it when the clock stops.
    pub(in crate::cli) fn note(&mut self, runs: bool) {
        if !runs {
            if self.begun.is_some() {
                self.end();
            }
            return;
        }
        let begun = *self.begun.get_or_insert_with(Instant::now);
        if self.child.is_some() || self.is_over || begun.elapsed() < self.wait {
            return;
        }
        match self.start() {
            Ok(child) => self.child = Some(child),
            Err(error) => {
                self.is_over = true;
                note(format_args!("warning: {error:#}: the show goes on without its sound"));
            }
        }
    }

    fn start(&self) -> anyhow::Result<Child> {
        let (program, arguments) = self.words.split_first().context("--sound-with: no command")?;
        let child = Command::new(program)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        child.with_context(|| format!("--sound-with: {program}"))
    }

    /// Ends the program, if it runs.
    fn end(&mut self) {
        self.is_over = true;
        if let Some(mut child) = self.child.take() {
            // If the program has ended by itself, `kill` fails.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        self.end();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sound(offset_us: i64) -> Sound {
        let name = "talk.wav".to_owned();
        Sound { name, sha256: [0; 32], file_len: 44, duration_us: 1_000_000, offset_us }
    }

    #[test]
    fn a_command_has_a_place_for_the_file() {
        for wrong in ["", "aplay", "{}", "aplay talk.wav"] {
            PlayerCommand::from_str(wrong).unwrap_err();
        }
        let path = Path::new("a b.wav");
        let of = |text: &str, offset_us| {
            PlayerCommand::from_str(text).unwrap().player(path, &sound(offset_us))
        };
        assert_eq!(of("aplay -q {}", 0).unwrap().words, ["aplay", "-q", "a b.wav"]);
        let late = of("aplay {}", -500_000).unwrap();
        assert_eq!(late.wait, Duration::from_millis(500));
        let error = of("aplay {}", 500_000).unwrap_err().to_string();
        assert!(error.contains("begins at 0.50 s of its sound"), "{error}");
        assert_eq!(of("p -ss {s} {}", 500_000).unwrap().words[2], "0.500");
    }

    /// The program runs while the show's clock runs.
    #[cfg(unix)]
    #[test]
    fn the_player_ends_with_the_show() {
        let player = || {
            let command = PlayerCommand::from_str("sleep {s}{}").unwrap();
            command.player(Path::new(""), &sound(60_000_000)).unwrap()
        };
        let mut played = player();
        played.note(false);
        assert!(played.child.is_none());
        played.note(true);
        assert!(played.child.is_some());
        played.note(true);
        played.note(false);
        assert!(played.child.is_none() && played.is_over);
        played.note(true);
        assert!(played.child.is_none());
    }
}
