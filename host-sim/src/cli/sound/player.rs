//! A program that plays the sound of a show while the show runs.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::str::FromStr;

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
        let file = path.display().to_string();
        let words = self.0.iter().map(|word| word.replace("{}", &file));
        Ok(Player {
            words: words.collect(),
            offset_s: place_s,
            last_s: None,
            child: None,
            is_over: false,
        })
    }
}

/// A program that plays a sound while the show runs. A loop starts it again in each round.
#[derive(Debug)]
pub(in crate::cli) struct Player {
    words: Vec<String>,
    /// Place in the sound when the show starts, s; negative if the sound begins later.
    offset_s: f64,
    /// The show's newest place, s; `None` before the show starts.
    last_s: Option<f64>,
    child: Option<Child>,
    /// Whether the sound has ended for good, or could not begin.
    is_over: bool,
}

impl Player {
    /// Receives the show's place in each tick, or with each message, s; `None` while the show's clock does not run.
    /// Starts the program when the sound's time has come, and ends it when the clock stops.
    pub(in crate::cli) fn note(&mut self, place_s: Option<f64>) {
        let Some(place_s) = place_s else {
            if self.last_s.is_some() {
                self.end();
                self.is_over = true;
            }
            return;
        };
        if self.last_s.replace(place_s).is_some_and(|last_s| place_s < last_s) {
            // The next round of a loop.
            self.end();
        }
        if self.child.is_some() || self.is_over || place_s + self.offset_s < 0.0 {
            return;
        }
        match self.start(place_s) {
            Ok(child) => self.child = Some(child),
            Err(error) => {
                self.is_over = true;
                note(format_args!("warning: {error:#}: the show goes on without its sound"));
            }
        }
    }

    /// Starts the program at a place of the show. Prints by how much the sound is late if the command has no `{s}`.
    fn start(&self, place_s: f64) -> anyhow::Result<Child> {
        let at_s = (place_s + self.offset_s).max(0.0);
        if self.words.iter().any(|word| word.contains("{s}")) {
            note(format_args!("the sound starts at {at_s:.3} s, where the show is"));
        } else {
            note(format_args!("the sound starts {:.0} ms behind the show", 1e3 * at_s));
        }
        let words: Vec<String> =
            self.words.iter().map(|word| word.replace("{s}", &format!("{at_s:.3}"))).collect();
        let (program, arguments) = words.split_first().context("--sound-with: no command")?;
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
        let error = of("aplay {}", 500_000).unwrap_err().to_string();
        assert!(error.contains("begins at 0.50 s of its sound"), "{error}");
        assert_eq!(of("p -ss {s} {}", 500_000).unwrap().words, ["p", "-ss", "{s}", "a b.wav"]);
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
        played.note(None);
        assert!(played.child.is_none());
        played.note(Some(0.02));
        let first = played.child.as_ref().unwrap().id();
        played.note(Some(0.5));
        assert_eq!(played.child.as_ref().unwrap().id(), first);
        // The next round of a loop has a new program.
        played.note(Some(0.01));
        assert_ne!(played.child.as_ref().unwrap().id(), first);
        played.note(None);
        assert!(played.child.is_none() && played.is_over);
        played.note(Some(0.02));
        assert!(played.child.is_none());
    }

    /// A sound that begins after the show waits for its time.
    #[cfg(unix)]
    #[test]
    fn a_late_sound_waits() {
        let command = PlayerCommand::from_str("sleep 60{}").unwrap();
        let mut late = command.player(Path::new(""), &sound(-500_000)).unwrap();
        late.note(Some(0.49));
        assert!(late.child.is_none());
        late.note(Some(0.5));
        assert!(late.child.is_some());
    }
}
