//! The package for Python: builds the wheel, and tests it in a fresh environment of each installed Python.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, bail, ensure};
use sinew_steps::step;

use crate::python::Venv;
use crate::{deny, lints, nextest};

/// The package's folder, a separate workspace.
pub(crate) const FOLDER: &str = "crates/python";
/// Name and version of the program that builds wheels.
const MATURIN: &str = "maturin==1.16.0";
/// Versions of Python on which the wheel must run. The newest installed version also checks types and the notebook.
const VERSIONS: [&str; 4] = ["3.10", "3.11", "3.12", "3.13"];
/// Packages that every environment needs.
const TESTED_WITH: [&str; 2] = ["numpy", "pytest==9.2.0"];
/// Additional packages for the newest version: for types, for the notebook, and another library for dynamics.
const MORE: [&str; 6] =
    ["mypy==2.4.1", "pin==4.1.0", "matplotlib", "nbclient", "ipykernel", "pandas"];
/// Other libraries for dynamics, and headers for the loop in C++.
const BESIDE: [&str; 5] =
    ["numpy", "pin==4.1.0", "cmeel-eigen==3.4.1", "mujoco==4.0.0", "dynibo==0.5.2"];
/// The package of `LeRobot`, which brings torch (4 GB), and the packages of its test.
const LEROBOT: [&str; 2] = ["lerobot[dataset]==0.6.1", TESTED_WITH[1]];
/// Versions of Python for which this `LeRobot` exists.
const OF_LEROBOT: [&str; 2] = ["3.12", "3.13"];
/// Maximum size of the wheel, bytes.
const WHEEL_MAX: u64 = 8_000_000;

/// Builds the wheel, and tests it with all installed versions of Python.
pub(crate) fn run() -> Result<()> {
    let found = interpreters();
    let wheel = build()?;
    let absent: Vec<&str> = VERSIONS
        .into_iter()
        .filter(|version| !found.iter().any(|(found, _)| found == version))
        .collect();
    let Some(last) = found.len().checked_sub(1) else {
        bail!("no Python of {} is installed: the wheel is not tested", VERSIONS.join(", "));
    };
    for (index, (version, python)) in found.iter().enumerate() {
        test(version, python, &wheel, index == last)?;
    }
    if !absent.is_empty() {
        eprintln!("\n== not tested, because they are not installed: Python {}", absent.join(", "));
    }
    let Some((_, python)) = found.iter().find(|(version, _)| OF_LEROBOT.contains(version)) else {
        eprintln!("\n== LeRobot: left out, it needs Python {}", OF_LEROBOT.join(" or "));
        return Ok(());
    };
    with_lerobot(python, &wheel)
}

/// Tests the classes for `LeRobot` with its real package, in an environment that is kept because of its size.
fn with_lerobot(python: &Path, wheel: &Path) -> Result<()> {
    let venv = Venv::install_with(python, "lerobot", &LEROBOT, &LEROBOT.join("\n"), |_| Ok(()))?;
    let wheel = wheel.display().to_string();
    venv.pip(&["install", "--force-reinstall", "--no-deps", &wheel])?;
    let mut test = Command::new(venv.folder.join("bin/python"));
    test.current_dir(step::root().join(FOLDER));
    test.args(["-m", "pytest", "--quiet", "tests/test_lerobot.py"]);
    // Without a network and without the user's folder of `LeRobot`.
    test.env("HF_HUB_OFFLINE", "1").env("HF_HOME", venv.folder.join("home"));
    step::run("ten episodes by LeRobot", &mut test)
}

/// Measures inverse dynamics beside other libraries.
pub(crate) fn bench() -> Result<()> {
    let wheel = build()?.display().to_string();
    let venv = Venv::install("wheel-bench", &BESIDE, &BESIDE.join("\n"), |_| Ok(()))?;
    venv.pip(&["install", "--force-reinstall", "--no-deps", &wheel])?;
    let script = step::root().join(FOLDER).join("bench/dynamics.py");
    step::run("inverse dynamics beside others", &mut venv.python(&script))
}

/// Checks the format of the package's Rust code, which `cargo fmt --all` does not reach.
pub(crate) fn format() -> Result<()> {
    let manifest = format!("{FOLDER}/Cargo.toml");
    let mut fmt = step::cargo();
    fmt.args(["fmt", "--check", "--manifest-path", &manifest]);
    step::run("format of the package for Python", &mut fmt)
}

/// Compiles and lints the package's Rust without linking it. No build of the product compiles it.
pub(crate) fn check() -> Result<()> {
    let manifest = format!("{FOLDER}/Cargo.toml");
    let mut check = step::cargo();
    check.args(["check", "--locked", "--manifest-path", &manifest]);
    check.env("CARGO_TARGET_DIR", step::root().join("target/python-check"));
    step::run("check of the package for Python", lints::while_compiling(&mut check))
}

/// Builds the wheel and lints its code. Returns its path.
fn build() -> Result<PathBuf> {
    deny::check(Some(&format!("{FOLDER}/Cargo.toml")))?;
    let venv = Venv::install("maturin", &[MATURIN], MATURIN, |_| Ok(()))?;
    let folder = step::root().join("target/wheel");
    let _ = fs::remove_dir_all(&folder);
    let mut maturin = Command::new(venv.folder.join("bin/maturin"));
    maturin.current_dir(step::root().join(FOLDER));
    maturin.args(["build", "--release", "--locked", "--out"]).arg(&folder);
    maturin.env("CARGO_TARGET_DIR", step::root().join("target/python"));
    step::run("build and lint the wheel", lints::while_compiling(&mut maturin))?;
    let mut entries = fs::read_dir(&folder)?.filter_map(|entry| Some(entry.ok()?.path()));
    let wheel = entries.next().with_context(|| format!("no wheel in {}", folder.display()))?;
    let size = fs::metadata(&wheel)?.len();
    eprintln!("   {}: {:.2} MB", wheel.display(), size as f64 / 1e6);
    ensure!(size <= WHEEL_MAX, "the wheel has {size} bytes; expected at most {WHEEL_MAX}");
    Ok(wheel)
}

/// Tests the wheel in a fresh environment of an interpreter. `is_last`: whether this is the newest version.
fn test(version: &str, python: &Path, wheel: &Path, is_last: bool) -> Result<()> {
    let venv = Venv { folder: step::root().join("target").join(format!("wheel-{version}")) };
    let _ = fs::remove_dir_all(&venv.folder);
    let mut make = Command::new(python);
    step::run(&format!("Python {version}"), make.args(["-m", "venv"]).arg(&venv.folder))?;
    let more: &[&str] = if is_last { &MORE } else { &[] };
    let wheel = wheel.display().to_string();
    venv.pip(&[&["install", &wheel][..], &TESTED_WITH, more].concat())?;
    let package = step::root().join(FOLDER);
    let run = |title: &str, arguments: &[&str]| {
        let mut command = Command::new(venv.folder.join("bin/python"));
        command.current_dir(&package).arg("-m").args(arguments);
        // If `sinew` is built, the tests compare the package with it.
        if let Some(program) = nextest::program("sinew").ok().filter(|program| program.exists()) {
            command.env("SINEW_PROGRAM", program);
        }
        step::run(&format!("{title}, Python {version}"), &mut command)
    };
    run("tests of the wheel", &["pytest", "--quiet"])?;
    if is_last {
        run("types", &["mypy", "--strict", "python/sinew_motion", "examples"])?;
    }
    Ok(())
}

/// Returns the installed interpreters with their versions, from the path or from pyenv.
fn interpreters() -> Vec<(&'static str, PathBuf)> {
    let works = |python: &Path| {
        step::output(Command::new(python).args(["-c", "import ensurepip, venv"])).is_some()
    };
    let find = |version: &'static str| {
        let on_path = PathBuf::from(format!("python{version}"));
        let all = std::iter::once(on_path).chain(of_pyenv(version));
        all.into_iter().find(|python| works(python)).map(|python| (version, python))
    };
    VERSIONS.into_iter().filter_map(find).collect()
}

/// Returns all interpreters of a version that pyenv has installed.
fn of_pyenv(version: &str) -> Vec<PathBuf> {
    let own = std::env::var_os("PYENV_ROOT").map(PathBuf::from);
    let root = own.or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".pyenv")));
    let entries = root.and_then(|root| fs::read_dir(root.join("versions")).ok());
    let names = entries.into_iter().flatten().flatten().map(|entry| entry.path());
    let is_it = |path: &PathBuf| {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        name.is_some_and(|name| name.starts_with(&format!("{version}.")))
    };
    names.filter(is_it).map(|path| path.join("bin/python")).collect()
}
