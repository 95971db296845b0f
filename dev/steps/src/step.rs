//! Running other programs, and saying so.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

/// The workspace's folder.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .canonicalize()
        .expect("this crate is in the workspace")
}

/// Cargo of the toolchain that runs this, in the workspace's folder.
pub fn cargo() -> Command {
    command(&std::env::var("CARGO").unwrap_or_else(|_| "cargo".into()))
}

/// A program, run in the workspace's folder.
pub fn command(program: &str) -> Command {
    let mut command = Command::new(program);
    command.current_dir(root());
    command
}

/// A program that lets all others go first, where the system has a way to say so.
pub fn patient(program: &str) -> Command {
    if cfg!(not(unix)) {
        return command(program);
    }
    let mut command = command("nice");
    command.args(["-n", "19", program]);
    command
}

/// Steps that have ended in this program, with the time that each took.
static DONE: Mutex<Vec<(String, Duration)>> = Mutex::new(Vec::new());

/// Adds a step to the table of [`table`].
pub fn record(title: &str, taken: Duration) {
    DONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push((title.to_owned(), taken));
}

/// Returns a table of the steps that have ended, in seconds, and their sum.
pub fn table() -> String {
    let done = DONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let sum = ("sum".to_owned(), done.iter().map(|(_, taken)| *taken).sum());
    let row =
        |(title, taken): &(String, Duration)| format!("{:>8.1}  {title}\n", taken.as_secs_f64());
    done.iter().chain([&sum]).map(row).collect()
}

/// Runs a step that is no other program.
///
/// # Errors
/// As `action` has them.
pub fn of<T>(title: &str, action: impl FnOnce() -> Result<T>) -> Result<T> {
    eprintln!("\n== {title}");
    let start = Instant::now();
    let result = action();
    record(title, start.elapsed());
    result
}

/// Runs a step to its end, its output as it comes.
///
/// # Errors
/// If the program does not start, or fails.
pub fn run(title: &str, command: &mut Command) -> Result<()> {
    eprintln!("\n== {title}");
    let start = Instant::now();
    let status = command.status().with_context(|| format!("cannot start {}", line(command)))?;
    record(title, start.elapsed());
    if !status.success() {
        bail!("{title}: {status}\n  {}", line(command));
    }
    eprintln!("== {title}: done in {:.0} s", start.elapsed().as_secs_f64());
    Ok(())
}

/// A step beside others, for what these leave idle: an image is linked by one core.
pub struct Beside {
    title: &'static str,
    command: String,
    child: Child,
    log: PathBuf,
}

impl Beside {
    /// Begins a step. `log`: a file for its output.
    ///
    /// # Errors
    /// If the program does not start, or the file cannot be written.
    pub fn begin(title: &'static str, command: &mut Command, log: PathBuf) -> Result<Self> {
        let output = File::create(&log).with_context(|| log.display().to_string())?;
        command.stdin(Stdio::null()).stdout(output.try_clone()?).stderr(output);
        let child = command.spawn().with_context(|| format!("cannot start {}", line(command)))?;
        let command = line(command);
        eprintln!("\n== {title}: beside the next steps, its output in {}", log.display());
        Ok(Self { title, command, child, log })
    }

    /// Waits for its end.
    ///
    /// # Errors
    /// If the program failed.
    pub fn end(mut self) -> Result<()> {
        let Self { title, command, child, log } = &mut self;
        eprintln!("\n== {title}: what is left of it");
        let start = Instant::now();
        let status = child.wait()?;
        eprint!("{}", String::from_utf8_lossy(&fs::read(log)?));
        record(&format!("{title}: what is left of it"), start.elapsed());
        if !status.success() {
            bail!("{title}: {status}\n  {command}");
        }
        eprintln!("== {title}: done in {:.0} s more", start.elapsed().as_secs_f64());
        Ok(())
    }
}

impl Drop for Beside {
    /// A run that failed begins no further part of it.
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What a program prints, if it can be run and succeeds.
pub fn output(command: &mut Command) -> Option<String> {
    let output = command.stdin(Stdio::null()).stderr(Stdio::null()).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// The command as one would type it.
fn line(command: &Command) -> String {
    let variables = command.get_envs().filter_map(|(name, value)| {
        Some(format!("{}={}", name.to_string_lossy(), value?.to_string_lossy()))
    });
    let words = std::iter::once(command.get_program())
        .chain(command.get_args())
        .map(|word| word.to_string_lossy().into_owned());
    variables.chain(words).collect::<Vec<_>>().join(" ")
}
