//! Benchmarks foreign libraries beside the core: a short program for each (`dev/bench/peers`).

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};

use crate::python::Venv;
use sinew_steps::step;

/// Packages with C++ headers and libraries, in tested versions.
const PACKAGES: [&str; 3] = ["pin==4.1.0", "cmeel-eigen==3.4.1", "mujoco==4.0.0"];
/// Definitions that Pinocchio's build files set for users of its headers.
const DEFINITIONS: [&str; 4] = [
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
];

/// Version of MuJoCo that computed the golden file of actuators. MuJoCo 4.0.0 reads few models differently: `position`
/// in a class drops the first number of an inherited `biasprm`.
const OF_ACTUATORS: [&str; 1] = ["mujoco==3.3.7"];

/// Random models of actuators whose forces are compared with MuJoCo's.
const MODELS: &str = "1000";

/// Compares forces of actuators, builds the programs, and runs the bench.
pub(crate) fn run() -> Result<()> {
    actuators(&Venv::install("actuators", &OF_ACTUATORS, &OF_ACTUATORS.join("\n"), |_| Ok(()))?)?;
    let venv = Venv::install("peers", &PACKAGES, &PACKAGES.join("\n"), |_| Ok(()))?;
    let packages = packages(&venv)?;
    let mut programs = Vec::new();
    for (name, scalar) in [("Pinocchio,_double", "double"), ("Pinocchio,_float", "float")] {
        let headers = packages.join("cmeel.prefix/include");
        let mut options: Vec<OsString> = DEFINITIONS.map(OsString::from).into();
        options.push(format!("-DSCALAR={scalar}").into());
        for folder in [headers.join("eigen3"), headers] {
            options.extend(["-isystem".into(), folder.into_os_string()]);
        }
        programs.push(compiled(&venv, name, "pinocchio.cpp", &options)?);
    }
    let mujoco = packages.join("mujoco");
    let library = library(&mujoco)?;
    let mut path = OsString::from("-Wl,-rpath,");
    path.push(&mujoco);
    let options = ["-isystem".into(), mujoco.join("include").into(), library.into(), path];
    programs.push(compiled(&venv, "MuJoCo,_double", "mujoco.cpp", &options)?);

    let mut bench = step::cargo();
    bench.args(["bench", "--locked", "-p", "sinew-bench", "--bench", "against"]);
    bench.env("SINEW_PEERS", env::join_paths(&programs)?);
    step::run("the core beside others", &mut bench)
}

/// Compares the efforts of imported joints with MuJoCo's forces.
fn actuators(venv: &Venv) -> Result<()> {
    let file = venv.folder.join("actuators.json");
    let mut script = venv.python(&step::root().join("tests/golden/actuators.py"));
    script.arg(MODELS).arg(&file).current_dir(&venv.folder);
    step::run("forces of random actuators, by MuJoCo", &mut script)?;
    let mut test = step::cargo();
    test.args(["test", "--locked", "-p", "sinew-rig", "--features", "std", "--test", "rig"]);
    test.args(["--", "--include-ignored", "efforts_of_many_models"]).env("SINEW_ACTUATORS", &file);
    step::run("efforts of random actuators", &mut test)
}

/// Compiles a program for a generic machine of the target, like our own programs.
fn compiled(venv: &Venv, name: &str, source: &str, options: &[OsString]) -> Result<PathBuf> {
    let program = venv.folder.join(name);
    let source = step::root().join("dev/bench/peers").join(source);
    let mut compiler = step::command("g++");
    compiler.args(["-std=c++17", "-O3", "-DNDEBUG", "-o"]).arg(&program).arg(source).args(options);
    step::run(&format!("compile {name}"), &mut compiler)
        .context("it takes g++, of Debian's package of that name")?;
    Ok(program)
}

/// Returns the folder in which pip has installed the packages.
fn packages(venv: &Venv) -> Result<PathBuf> {
    let lib = venv.folder.join("lib");
    let entry =
        std::fs::read_dir(&lib)?.next().with_context(|| format!("{} is empty", lib.display()))?;
    Ok(entry?.path().join("site-packages"))
}

/// Returns MuJoCo's library, whose name contains its version.
fn library(folder: &Path) -> Result<PathBuf> {
    let entries = std::fs::read_dir(folder)?.filter_map(Result::ok).map(|entry| entry.path());
    let mut found = entries.filter(|path| {
        path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("libmujoco.so"))
    });
    found.next().with_context(|| format!("no libmujoco.so in {}", folder.display()))
}
