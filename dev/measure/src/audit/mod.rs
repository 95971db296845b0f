//! Searches for forbidden content in an image of everything that a board's program may call, see `audit/`.

mod coverage;
mod report;
mod rules;

use anyhow::{Result, bail, ensure};

use crate::elf::{Elf, Lines};
use sinew_steps::image::Image;
use sinew_steps::step;

use rules::{Finding, Rule};

/// Image of everything that a board may call.
const IMAGE: Image = Image::AUDIT;

/// Image that contains only faults, each of which must be found.
const FAULTY: Image = Image { name: "faults", ..IMAGE };

/// The missing function that a panic calls in the image.
const MISSING: &str = "a_panic_can_be_reached";

/// The parts of the image. Each must be in the image; otherwise the search would be incomplete.
const PARTS: [&str; 49] = [
    "audit::image::decode::coordinates",
    "audit::image::construct::trees",
    "audit::image::construct::controllers",
    "audit::image::construct::projections",
    "audit::image::construct::observers",
    "audit::image::construct::importance",
    "audit::image::coordinates::bodies",
    "audit::image::coordinates::dynamics",
    "audit::image::coordinates::controller",
    "audit::image::targets::trajectories",
    "audit::image::targets::differences",
    "audit::image::tick::controller",
    "audit::image::tick::controller_of_little_room",
    "audit::image::tick::tracker",
    "audit::image::tick::replay",
    "audit::image::tick::parity",
    "audit::image::kernels::kinematics",
    "audit::image::kernels::state_errors",
    "audit::image::kernels::dynamics",
    "audit::image::kernels::elementary",
    "audit::image::show::decoder",
    "audit::image::show::frames",
    "audit::image::show::blend",
    "audit::image::bus::dynamixel_bus",
    "audit::image::bus::dynamixel_packets",
    "audit::image::bus::dynamixel_groups",
    "audit::image::bus::dynamixel_device",
    "audit::image::bus::feetech_bus",
    "audit::image::bus::feetech_packets",
    "audit::image::bus::feetech_device",
    "audit::image::bus::pca9685",
    "audit::image::bus::readings",
    "audit::image::drives::rig",
    "audit::image::drives::classes",
    "audit::image::link::frames",
    "audit::image::link::controller",
    "audit::image::link::host",
    "audit::image::link::live",
    "audit::image::link::telemetry",
    "audit::image::storage::tables",
    "audit::image::storage::items",
    "audit::image::storage::uploads",
    "audit::image::storage::faults",
    "audit::image::supervisor::states",
    "audit::image::supervisor::faults",
    "audit::image::supervisor::detectors",
    "audit::image::supervisor::guard",
    "audit::image::controller::ticks",
    "audit::image::node::nodes",
];

/// Faults that must be found in the image of faults, each with its function.
const FAULTS: [(Rule, &str); 6] = [
    (Rule::Panic, "faults::image::index"),
    (Rule::DoublePrecision, "faults::image::double"),
    (Rule::FusedMultiplyAdd, "faults::image::fused"),
    (Rule::Formatting, "faults::image::text"),
    (Rule::Recursion, "faults::image::factorial"),
    (Rule::IndirectCall, "faults::image::pointer"),
];

/// Links the image, reads it, and fails if it has forbidden content.
pub(crate) fn run() -> Result<()> {
    let links = build(IMAGE)?;
    let path = IMAGE.path();
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
        "public functions are not in the image; call them in dev/audit/src/image:\n  {}",
        left_out.join("\n  ")
    );
    println!(
        "The image links without a panic handler, has every public function, and holds nothing that it must not."
    );
    Ok(())
}

/// Links the image of faults, and fails if one of them is not found.
pub(crate) fn self_test() -> Result<()> {
    ensure!(
        !build(FAULTY)?,
        "the image of faults links without a panic handler, with a panic in it"
    );
    let path = FAULTY.path();
    let elf = Elf::load(&path)?;
    let mut findings = rules::findings(&elf);
    let name_of = |finding: &Finding| elf.functions()[finding.function].name.as_str();
    findings.retain(|finding| FAULTS.contains(&(finding.rule, name_of(finding))));
    println!("\n{}", report::findings(&findings, &elf, &Lines::of(&path)?, &[]));
    for fault in FAULTS {
        let found = findings.iter().any(|finding| (finding.rule, name_of(finding)) == fault);
        ensure!(found, "the audit does not find the {} of {}", fault.0.name(), fault.1);
    }
    println!(
        "The image of faults does not link without a panic handler, and each of them is found."
    );
    Ok(())
}

/// Builds an image. Returns `false` if it does not link because of a reachable panic. Then it is linked with a
/// handler, so that it can be examined.
fn build(image: Image) -> Result<bool> {
    eprintln!("\n== link {} without a panic handler", image.name);
    let output = image.cargo("rustc")?.output()?;
    if output.status.success() {
        return Ok(true);
    }
    let problem = String::from_utf8_lossy(&output.stderr);
    ensure!(problem.contains(MISSING), "the image does not build:\n{problem}");
    step::run(
        "a panic can be reached: link with a handler, to see where",
        image.cargo("rustc")?.args(["--", "-C", &format!("link-arg=--defsym={MISSING}=0")]),
    )?;
    Ok(false)
}
