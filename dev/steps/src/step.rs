//! Runs other programs as steps, and prints their titles and times.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

/// Returns the workspace's folder.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .canonicalize()
        .expect("this crate is in the workspace")
}

/// Returns a command of the cargo that runs this program, in the workspace's folder.
pub fn cargo() -> Command {
    command(&std::env::var("CARGO").unwrap_or_else(|_| "cargo".into()))
}

/// Returns a command of a program, in the workspace's folder.
pub fn command(program: &str) -> Command {
    let mut command = Command::new(program);
    command.current_dir(root());
    command
}

/// Returns a command of a program with the lowest priority, where the system supports it.
pub fn patient(program: &str) -> Command {
    if cfg!(not(unix)) {
        return command(program);
    }
    let mut command = command("nice");
    command.args(["-n", "19", program]);
    command
}

/// Finished steps of this program, with their durations.
static DONE: Mutex<Vec<(String, Duration)>> = Mutex::new(Vec::new());

/// Adds a step to the result of [`table`].
pub fn record(title: &str, taken: Duration) {
    DONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push((title.to_owned(), taken));
}

/// Returns a table of the finished steps, in seconds, and their sum.
pub fn table() -> String {
    let done = DONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let sum = ("sum".to_owned(), done.iter().map(|(_, taken)| *taken).sum());
    let row =
        |(title, taken): &(String, Duration)| format!("{:>8.1}  {title}\n", taken.as_secs_f64());
    done.iter().chain([&sum]).map(row).collect()
}

/// Runs a step that is not another program.
///
/// # Errors
/// The errors of `action`.
pub fn of<T>(title: &str, action: impl FnOnce() -> Result<T>) -> Result<T> {
    eprintln!("\n== {title}");
    let start = Instant::now();
    let result = action();
    record(title, start.elapsed());
    result
}

/// Runs a program as a step, with its output shown as it is written.
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

/// A step that runs in parallel with others, on a core that they leave idle: an image is linked on one core.
pub struct Beside {
    title: &'static str,
    command: String,
    child: Child,
    log: PathBuf,
}

impl Beside {
    /// Starts a step. `log` is a file for the step's output.
    ///
    /// # Errors
    /// If the program does not start, or the file cannot be written.
    pub fn begin(title: &'static str, command: &mut Command, log: PathBuf) -> Result<Self> {
        let output = File::create(&log).with_context(|| log.display().to_string())?;
        command.stdin(Stdio::null()).stdout(output.try_clone()?).stderr(output);
        let child = command.spawn().with_context(|| format!("cannot start {}", line(command)))?;
        let command = line(command);
        eprintln!("\n== {title}: runs beside the next steps; output: {}", log.display());
        Ok(Self { title, command, child, log })
    }

    /// Waits for the end of the step.
    ///
    /// # Errors
    /// If the program failed.
    pub fn end(mut self) -> Result<()> {
        let Self { title, command, child, log } = &mut self;
        eprintln!("\n== {title}: waiting for its end");
        let start = Instant::now();
        let status = child.wait()?;
        eprint!("{}", String::from_utf8_lossy(&fs::read(log)?));
        record(&format!("{title}: waiting for its end"), start.elapsed());
        if !status.success() {
            bail!("{title}: {status}\n  {command}");
        }
        eprintln!("== {title}: done in {:.0} s more", start.elapsed().as_secs_f64());
        Ok(())
    }
}

impl Drop for Beside {
    /// After a failure, the step is ended, too.
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Returns the output of a program, if it can be run and succeeds.
pub fn output(command: &mut Command) -> Option<String> {
    let output = command.stdin(Stdio::null()).stderr(Stdio::null()).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Formats a command as a user would type it.
fn line(command: &Command) -> String {
    let variables = command.get_envs().filter_map(|(name, value)| {
        Some(format!("{}={}", name.to_string_lossy(), value?.to_string_lossy()))
    });
    let words = std::iter::once(command.get_program())
        .chain(command.get_args())
        .map(|word| word.to_string_lossy().into_owned());
    variables.chain(words).collect::<Vec<_>>().join(" ")
}
