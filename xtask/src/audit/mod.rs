//! Looks for what must not be in a board's program: in an image of all that one may call, see
//! `firmware/src/bin/audit`.

mod report;
mod rules;

use std::process::Command;

use anyhow::{Result, bail, ensure};

use crate::elf::{Elf, Lines};
use crate::{arm, step};

/// The image, and the feature of `firmware` that it needs.
const IMAGE: &str = "audit";

/// What a panic calls in the image, and nobody has.
const MISSING: &str = "a_panic_can_be_reached";

/// The parts of the image. Each must be there, or nothing was looked at.
const PARTS: [&str; 15] = [
    "audit::decode::show",
    "audit::decode::coordinates",
    "audit::construct::trees",
    "audit::construct::controllers",
    "audit::construct::projections",
    "audit::construct::observers",
    "audit::targets::trajectories",
    "audit::targets::differences",
    "audit::tick::controller",
    "audit::tick::app",
    "audit::tick::replay",
    "audit::kernels::kinematics",
    "audit::kernels::state_errors",
    "audit::kernels::dynamics",
    "audit::kernels::elementary",
];

/// Links the image, reads it, and fails if anything is in it that must not be.
pub(crate) fn run() -> Result<()> {
    let links = build()?;
    let path = arm::image(IMAGE);
    let elf = Elf::load(&path)?;
    let lines = Lines::of(&path)?;
    let findings = rules::findings(&elf);
    println!("\n{}", report::contents(&elf, &PARTS));
    println!("{}", report::verdict(&elf, &findings));
    let missing: Vec<_> = PARTS.into_iter().filter(|part| elf.named(part).is_none()).collect();
    ensure!(missing.is_empty(), "the image has no {}", missing.join(", "));
    if !findings.is_empty() {
        println!("{}", report::findings(&findings, &elf, &lines, &PARTS));
        bail!("the image holds what it must not");
    }
    ensure!(links, "the image does not link, though no panic is in it");
    println!("The image links without a panic handler, and holds nothing that it must not.");
    Ok(())
}

/// Builds the image; `false` if it does not link for a panic that can be reached. Then it is there all the same, linked
/// with a handler, so that it can be looked at.
fn build() -> Result<bool> {
    eprintln!("\n== link all that boards may call, without a panic handler");
    let mut strict = cargo()?;
    let output = strict.output()?;
    if output.status.success() {
        return Ok(true);
    }
    let problem = String::from_utf8_lossy(&output.stderr);
    ensure!(problem.contains(MISSING), "the image does not compile:\n{problem}");
    eprintln!("== a panic can be reached: link with a handler, to see where");
    let mut explained = cargo()?;
    explained.args(["--", "-C", &format!("link-arg=--defsym={MISSING}=0")]);
    step::run("link with a handler", &mut explained)?;
    Ok(false)
}

fn cargo() -> Result<Command> {
    let mut command = arm::toolchain()?.cargo("rustc");
    command.args(["--package", "sinew-firmware", "--profile", "firmware"]).args([
        "--features",
        IMAGE,
        "--bin",
        IMAGE,
    ]);
    Ok(command)
}
