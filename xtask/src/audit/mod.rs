//! Looks for what must not be in a board's program: in an image of all that one may call, see
//! `firmware/src/bin/audit`.

mod coverage;
mod report;
mod rules;

use std::process::Command;

use anyhow::{Result, bail, ensure};

use crate::elf::{Elf, Lines};
use crate::{arm, step};

use rules::{Finding, Rule};

/// The image, and the feature of `firmware` that it needs.
const IMAGE: &str = "audit";

/// What a panic calls in the image, and nobody has.
const MISSING: &str = "a_panic_can_be_reached";

/// The parts of the image. Each must be there, or nothing was looked at.
const PARTS: [&str; 18] = [
    "audit::decode::show",
    "audit::decode::coordinates",
    "audit::construct::trees",
    "audit::construct::controllers",
    "audit::construct::projections",
    "audit::construct::observers",
    "audit::construct::importance",
    "audit::targets::trajectories",
    "audit::targets::differences",
    "audit::tick::controller",
    "audit::tick::controller_of_little_room",
    "audit::tick::app",
    "audit::tick::replay",
    "audit::tick::parity",
    "audit::kernels::kinematics",
    "audit::kernels::state_errors",
    "audit::kernels::dynamics",
    "audit::kernels::elementary",
];

/// What must be found in the image with faults, and in which function.
const FAULTS: [(Rule, &str); 6] = [
    (Rule::Panic, "audit::faults::index"),
    (Rule::DoublePrecision, "audit::faults::double"),
    (Rule::FusedMultiplyAdd, "audit::faults::fused"),
    (Rule::Formatting, "audit::faults::text"),
    (Rule::Recursion, "audit::faults::factorial"),
    (Rule::IndirectCall, "audit::faults::pointer"),
];

/// Links the image, reads it, and fails if anything is in it that must not be.
pub(crate) fn run() -> Result<()> {
    let links = build(IMAGE)?;
    let path = arm::image(IMAGE);
    let elf = Elf::load(&path)?;
    let findings = rules::findings(&elf);
    println!("\n{}", report::contents(&elf, &PARTS));
    println!("{}", report::verdict(&elf, &findings));
    let missing: Vec<_> = PARTS.into_iter().filter(|part| elf.named(part).is_none()).collect();
    ensure!(missing.is_empty(), "the image has no {}", missing.join(", "));
    let lines = Lines::of(&path)?;
    if !findings.is_empty() {
        println!("{}", report::findings(&findings, &elf, &lines, &PARTS));
        bail!("the image holds what it must not");
    }
    ensure!(links, "the image does not link without a panic handler, though no panic is in it");
    let left_out = coverage::left_out(&elf, &lines)?;
    ensure!(
        left_out.is_empty(),
        "public functions are not in the image; call them in firmware/src/bin/audit:\n  {}",
        left_out.join("\n  ")
    );
    println!(
        "The image links without a panic handler, has every public function, and holds nothing that it must not."
    );
    Ok(())
}

/// Links the image with faults, and fails if one of them is not found.
pub(crate) fn self_test() -> Result<()> {
    ensure!(!build("audit_faults")?, "the image links without a panic handler, with a panic in it");
    let path = arm::image(IMAGE);
    let elf = Elf::load(&path)?;
    let mut findings = rules::findings(&elf);
    let name_of = |finding: &Finding| elf.functions()[finding.function].name.as_str();
    findings.retain(|finding| FAULTS.contains(&(finding.rule, name_of(finding))));
    println!("\n{}", report::findings(&findings, &elf, &Lines::of(&path)?, &PARTS));
    for fault in FAULTS {
        let found = findings.iter().any(|finding| (finding.rule, name_of(finding)) == fault);
        ensure!(found, "the audit does not find the {} of {}", fault.0.name(), fault.1);
    }
    println!(
        "The image with faults does not link without a panic handler, and each of the faults is found."
    );
    Ok(())
}

/// Lints the image, faults included.
pub(crate) fn lint() -> Result<()> {
    let toolchain = arm::toolchain()?;
    if toolchain == arm::Toolchain::Debian {
        return Ok(());
    }
    step::run(
        "clippy of the audit's image",
        toolchain
            .cargo("clippy")
            .args(["--package", "sinew-firmware", "--profile", "firmware"])
            .args(["--features", "audit_faults", "--bin", IMAGE, "--", "--deny", "warnings"]),
    )
}

/// Builds the image with a feature; `false` if it does not link for a panic that can be reached. Then it is there all
/// the same, linked with a handler, so that it can be looked at.
fn build(feature: &str) -> Result<bool> {
    eprintln!("\n== link all that boards may call, without a panic handler");
    let output = cargo(feature)?.output()?;
    if output.status.success() {
        return Ok(true);
    }
    let problem = String::from_utf8_lossy(&output.stderr);
    ensure!(problem.contains(MISSING), "the image does not build:\n{problem}");
    step::run(
        "a panic can be reached: link with a handler, to see where",
        cargo(feature)?.args(["--", "-C", &format!("link-arg=--defsym={MISSING}=0")]),
    )?;
    Ok(false)
}

fn cargo(feature: &str) -> Result<Command> {
    let mut command = arm::toolchain()?.cargo("rustc");
    command.args(["--package", "sinew-firmware", "--profile", "firmware"]).args([
        "--features",
        feature,
        "--bin",
        IMAGE,
    ]);
    Ok(command)
}
