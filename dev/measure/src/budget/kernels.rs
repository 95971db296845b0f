//! Measures each kernel and each kind of tick, with the images `kernels`, `servos`, `show`, `bus`, `drives` and
//! `whole_loop`.

use std::collections::BTreeMap;
use std::panic::resume_unwind;
use std::thread;

use anyhow::{Context, Result, bail, ensure};
use sinew_image::EMULATED;

use super::figures::{FigureKey, Figures};
use super::hashes;
use super::images::{BUS, DRIVES, KERNELS, SERVOS, SHOW, WHOLE_LOOP};
use super::printed::{field, number};
use super::stack::{Depth, Frames, deepest};
use super::trace::{Mix, Trace, qemu, trace};
use crate::elf::Elf;
use sinew_steps::image::Image;

/// Instructions of the whole kernel, mean of its runs.
const INSTRUCTIONS: &str = "instructions";

/// Instructions of the longest run of a tick.
const WORST: &str = "worst_instructions";

/// Cycles of the mean run.
const CYCLES: &str = "estimated_cycles";

const STATIC_STACK: &str = "static_stack_bytes";
const PAINTED_STACK: &str = "painted_stack_bytes";
const TYPES: &str = "type_bytes";

/// Sums of types: the row of the sum, and its parts.
const SUMS: [(&str, &[&str]); 2] = [
    // Data that a tick changes: the RAM that it needs besides the controller, which could be in flash.
    ("state_and_workspace", &["JointTargets", "JointStates", "Workspace"]),
    // All RAM of the loop except its stack.
    ("loop_ram", &["loop_controller", "loop_rig", "loop_bus"]),
];

/// An image that is measured.
struct Measured {
    image: Image,
    callers: &'static [Caller],
    /// Numbers of bodies of its rigs.
    sizes: &'static [&'static str],
    /// Returns the hashes that the image prints, computed by the host.
    hashes: fn() -> Result<Vec<(&'static str, u64)>>,
}

/// A function that calls whole ticks: its stack is that of the tick.
struct Caller {
    name: &'static str,
    /// Prefix of the rows of its ticks.
    rows: &'static str,
}

/// All measured images. No two have a row or a caller of the same name.
const MEASURED: [Measured; 6] = [
    Measured {
        image: KERNELS,
        callers: &[
            Caller { name: "core_tick", rows: "tick_" },
            Caller { name: "board_tick", rows: "board_" },
        ],
        sizes: &["6", "18", "32"],
        hashes: || Ok(Vec::new()),
    },
    Measured {
        image: SERVOS,
        callers: &[
            Caller { name: "core_tick_of_rig", rows: "tick_" },
            Caller { name: "rig_tick", rows: "rig_" },
        ],
        sizes: &["6", "12", "20"],
        hashes: || Ok(Vec::new()),
    },
    Measured {
        image: SHOW,
        callers: &[Caller { name: "show_frame", rows: "show_frame" }],
        sizes: &["20"],
        hashes: || Ok(sinew_bench::show::hashes()?.to_vec()),
    },
    // Tests of the crates check the results of this code; here only its instructions are counted.
    Measured { image: BUS, callers: &[], sizes: &["18"], hashes: || Ok(Vec::new()) },
    Measured { image: DRIVES, callers: &[], sizes: &["18"], hashes: || Ok(Vec::new()) },
    Measured {
        image: WHOLE_LOOP,
        callers: &[Caller { name: "loop_tick", rows: "loop_" }],
        sizes: &LOOPS,
        hashes: || Ok(Vec::new()),
    },
];

/// Numbers of servos of the whole loop.
pub(super) const LOOPS: [&str; 3] = ["6", "20", "40"];

/// Largest stack of the image's own closures between the painted area and the tick, which the call graph does not
/// count, bytes.
const CLOSURES_BYTES: u64 = 128;

/// Largest difference between `SysTick` and the trace, in instructions: `SysTick` also counts the marks (about 20),
/// and each reading is up to 40 off.
const SYSTICK_TOLERANCE: u64 = 80;

/// Measured numbers of an image, and their parts.
pub(crate) struct Kernels {
    pub(crate) elf: Elf,
    pub(crate) figures: Figures,
    pub(crate) executed: Vec<Kernel>,
    /// Deepest stack of each kind of tick.
    pub(crate) stacks: Vec<(FigureKey, Depth)>,
}

/// Instructions that the runs of a kernel executed.
pub(crate) struct Kernel {
    /// Key of its instructions.
    pub(crate) place: FigureKey,
    pub(crate) runs: u64,
    /// Executed instructions of all runs together, by function.
    pub(crate) mixes: BTreeMap<usize, Mix>,
    /// Instructions of the longest run.
    worst: u64,
}

/// Measures all images in parallel: each QEMU uses one core.
pub(crate) fn measure() -> Result<Vec<Kernels>> {
    thread::scope(|scope| {
        let measuring = MEASURED.each_ref().map(|measured| scope.spawn(|| measured.kernels()));
        measuring
            .map(|image| image.join().unwrap_or_else(|panic| resume_unwind(panic)))
            .into_iter()
            .collect()
    })
}

impl Measured {
    /// Runs the image twice: with a clock that counts instructions, and with a log of them.
    fn kernels(&self) -> Result<Kernels> {
        let image = &self.image.path();
        let elf = Elf::load(image)?;
        let counted = qemu(EMULATED, image, &["-icount", "shift=0"])?
            .output()
            .context("cannot start qemu-system-arm; run `cargo xtask setup`")?;
        let text = String::from_utf8_lossy(&counted.stdout);
        let errors = String::from_utf8_lossy(&counted.stderr);
        ensure!(counted.status.success(), "QEMU: {}\n{text}{errors}", counted.status);
        let trace =
            trace(image, &elf, ["sinew_bench::emulated::begin", "sinew_bench::emulated::end"])?;

        let executed = executed(&elf, &trace, &text)?;
        let stacks = self.stacks(&elf)?;
        let mut figures = Figures::default();
        let at = |section, place: &FigureKey| FigureKey::new(section, &place.row, &place.column);
        figures.extend(executed.iter().map(|kernel| (kernel.place.clone(), kernel.instructions())));
        let ticks = executed.iter().filter(|kernel| self.caller(&kernel.place.row).is_some());
        figures.extend(ticks.map(|tick| (at(WORST, &tick.place), tick.worst)));
        figures.extend(executed.iter().map(|kernel| (at(CYCLES, &kernel.place), kernel.cycles())));
        figures.extend(stacks.iter().map(|(place, depth)| (place.clone(), depth.bytes)));
        figures.extend(printed(&text)?);
        hashes::compare(&text, &(self.hashes)()?)?;
        self.check_stacks(&figures)?;
        Ok(Kernels { elf, figures, executed, stacks })
    }

    /// Returns the caller for a row of whole ticks with successive frames; `None` for rows that repeat the same work.
    fn caller(&self, row: &str) -> Option<&Caller> {
        self.callers.iter().find(|caller| row.starts_with(caller.rows))
    }

    fn stacks(&self, elf: &Elf) -> Result<Vec<(FigureKey, Depth)>> {
        let frames = Frames::load(&self.image.path())?;
        let mut stacks = Vec::new();
        for Caller { name, .. } in self.callers {
            for &bodies in self.sizes {
                let symbol = format!("{}::{name}::<{bodies}>", self.image.name);
                let root = elf.named(&symbol);
                let root = root.with_context(|| format!("the image has no `{symbol}`"))?;
                let place = FigureKey::new(STATIC_STACK, name, bodies);
                stacks.push((place, deepest(elf, &frames, root)?));
            }
        }
        Ok(stacks)
    }

    /// Checks that no tick used more stack than the call graph allows.
    fn check_stacks(&self, figures: &Figures) -> Result<()> {
        for (place, painted) in figures.iter().filter(|(at, _)| at.section == PAINTED_STACK) {
            let caller = self.caller(&place.row);
            let tick = caller.with_context(|| format!("{place} is of no known tick"))?.name;
            let bound = figures.get(&FigureKey::new(STATIC_STACK, tick, &place.column));
            ensure!(
                bound.is_some_and(|bound| painted <= bound + CLOSURES_BYTES),
                "{place} is {painted} bytes, more than the frames of {tick} allow ({bound:?})"
            );
        }
        Ok(())
    }
}

/// Returns the instructions that the runs of each kernel executed, after a comparison with the counts of the other
/// run.
fn executed(elf: &Elf, trace: &Trace, counted: &str) -> Result<Vec<Kernel>> {
    let lines = |text: &str| -> Vec<String> {
        text.lines().filter(|line| line.starts_with("kernel=")).map(str::to_owned).collect()
    };
    let (traced, counted) = (lines(&trace.output), lines(counted));
    ensure!(traced.len() == counted.len(), "QEMU ran other kernels the second time");
    let mut left = trace.runs.as_slice();
    let mut kernels = Vec::new();
    for (line, counted) in traced.iter().zip(&counted) {
        let (name, bodies) = (field(line, "kernel")?, field(line, "bodies")?);
        let runs = number(line, "runs")?;
        let (these, others) = left
            .split_at_checked(usize::try_from(runs)?)
            .with_context(|| format!("QEMU's log has too few runs of {name}"))?;
        left = others;
        let kernel = Kernel {
            place: FigureKey::new(INSTRUCTIONS, name, bodies),
            runs,
            mixes: trace.mixes(elf, these)?,
            worst: these.iter().map(|run| run.instructions).max().unwrap_or_default(),
        };
        let (by_log, by_clock) = (kernel.instructions(), number(counted, "instructions")?);
        ensure!(
            by_log.abs_diff(by_clock) <= SYSTICK_TOLERANCE,
            "{name} of {bodies} bodies executes {by_log} instructions by QEMU's log, and {by_clock} by its clock"
        );
        kernels.push(kernel);
    }
    ensure!(left.is_empty(), "QEMU's log has {} runs that no kernel made", left.len());
    Ok(kernels)
}

/// Parses the stacks and types that the image printed.
fn printed(text: &str) -> Result<Figures> {
    let (mut figures, mut sums) = (Figures::default(), Figures::default());
    for line in text.lines() {
        let (what, section) = match line.split_once('=') {
            Some(("kernel" | "hash", _)) => continue,
            Some(("stack", _)) => ("stack", PAINTED_STACK),
            Some(("type", _)) => ("type", TYPES),
            _ => bail!("QEMU printed: {line}"),
        };
        let (name, bodies) = (field(line, what)?, field(line, "bodies")?);
        let bytes = number(line, "bytes")?;
        figures.add(FigureKey::new(section, name, bodies), bytes);
        for (sum, parts) in SUMS {
            if section == TYPES && parts.contains(&name) {
                sums.add(FigureKey::new(section, sum, bodies), bytes);
            }
        }
    }
    figures.extend(sums);
    Ok(figures)
}

impl Kernel {
    /// Returns the mean number of instructions of a run.
    fn instructions(&self) -> u64 {
        Mix::sum(self.mixes.values()).instructions.div_ceil(self.runs)
    }

    /// Returns the mean number of cycles of a run.
    fn cycles(&self) -> u64 {
        Mix::sum(self.mixes.values()).cycles.div_ceil(self.runs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stacks_and_types_are_read_and_what_a_tick_changes_is_added_up() {
        let figures = printed(
            "kernel=limits bodies=18 runs=16 instructions=1910\n\
             stack=tick_world bodies=18 bytes=792\n\
             type=JointTargets bodies=18 bytes=2000\n\
             type=Tree bodies=18 bytes=2752\n\
             type=JointStates bodies=18 bytes=940\n\
             type=Workspace bodies=18 bytes=2500\n",
        )
        .unwrap();
        let figure = |place: &str| figures.get(&FigureKey::parse(place).unwrap());
        assert_eq!(figure("painted_stack_bytes.tick_world.18"), Some(792));
        assert_eq!(figure("type_bytes.Tree.18"), Some(2752));
        assert_eq!(figure("type_bytes.state_and_workspace.18"), Some(2000 + 940 + 2500));
        assert_eq!(figures.iter().count(), 6);
    }

    #[test]
    fn what_is_printed_in_another_form_is_an_error() {
        for bad in ["panicked at", "stack=tick bytes=7", "type=Tree bodies=18 bytes=many"] {
            assert!(printed(bad).is_err(), "{bad}");
        }
    }
}
