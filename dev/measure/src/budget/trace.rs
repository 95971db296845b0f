//! Reads the instructions that an image executes between two marks, from QEMU's log.

use std::collections::{BTreeMap, HashMap};
use std::io::{BufRead, BufReader, Read};
use std::ops::Range;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;

use anyhow::{Context, Result, anyhow, bail, ensure};
use sinew_image::{Board, EMULATED};

use super::cycles::{self, Kind};
use crate::elf::{Elf, Instruction};

/// A run from the first mark to the second.
#[derive(Debug, Clone, Default)]
pub(crate) struct Run {
    pub(crate) instructions: u64,
    /// Executed blocks, by the address of their first instruction.
    blocks: BTreeMap<u64, Executed>,
}

/// Number of executions of a block of instructions, which only its last instruction can leave, and number of jumps of
/// that instruction.
#[derive(Debug, Clone, Copy, Default)]
struct Executed {
    times: u64,
    jumps: u64,
}

/// Addresses of the instructions of blocks, by their first.
type Blocks = HashMap<u64, Vec<u64>>;

/// Instructions of several runs together.
#[derive(Debug, Clone, Default)]
pub(crate) struct Mix {
    pub(crate) instructions: u64,
    pub(crate) cycles: u64,
    /// Numbers in the order of [`Kind::ALL`].
    pub(crate) kinds: [u64; Kind::ALL.len()],
}

/// Output of QEMU for an image: its standard output, and the runs.
pub(crate) struct Trace {
    pub(crate) output: String,
    pub(crate) runs: Vec<Run>,
    blocks: Blocks,
}

/// Returns the command of QEMU for a board, with an image.
///
/// # Errors
/// If QEMU has no such machine.
pub(crate) fn qemu(board: Board, image: &Path, arguments: &[&str]) -> Result<Command> {
    let Board { name, qemu_machine, .. } = board;
    let machine = qemu_machine.with_context(|| format!("QEMU has no {name}"))?;
    let mut command = Command::new("qemu-system-arm");
    command
        .args(["-machine", machine, "-nographic"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .args(arguments)
        .arg("-kernel")
        .arg(image)
        .stdin(Stdio::null());
    Ok(command)
}

/// Runs an image and logs the executed instructions from each return of function `begin` to the next call of `end`.
pub(crate) fn trace(image: &Path, elf: &Elf, [begin, end]: [&str; 2]) -> Result<Trace> {
    let mark = |name: &str| {
        let index = elf.named(name).with_context(|| format!("the image has no `{name}`"))?;
        let function = &elf.functions()[index];
        Ok::<_, anyhow::Error>(function.address..function.address + function.size)
    };
    let (begin, end) = (mark(begin)?, mark(end)?);
    let mut qemu = qemu(EMULATED, image, &["-d", "in_asm,exec,nochain"])?
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .context("cannot start qemu-system-arm; run `cargo xtask setup`")?;
    let mut stdout = qemu.stdout.take().context("standard output")?;
    let log = BufReader::with_capacity(1 << 20, qemu.stderr.take().context("standard error")?);
    let output = thread::spawn(move || {
        let mut text = String::new();
        stdout.read_to_string(&mut text).map(|_| text)
    });

    let (runs, blocks) = read(log, begin, end.start, |address| width(elf, address))?;
    let status = qemu.wait()?;
    let output = output.join().map_err(|_| anyhow!("standard output could not be read"))??;
    ensure!(status.success(), "QEMU: {status}\n{output}");
    Ok(Trace { output, runs, blocks })
}

/// Returns the runs in a log, and its blocks; `width` returns the length of an instruction.
fn read(
    log: impl BufRead,
    begin: Range<u64>,
    end: u64,
    width: impl Fn(u64) -> u64,
) -> Result<(Vec<Run>, Blocks)> {
    let mut log = Log { lines: log, line: String::new(), blocks: HashMap::new() };
    let mut runs: Vec<Run> = Vec::new();
    let mut state = State::Between;
    while let Some(at) = log.next_block()? {
        if let (State::Running { last: Some(last) }, Some(run)) = (&state, runs.last_mut()) {
            let addresses = &log.blocks[last];
            let next = addresses.last().map(|last| last + width(*last));
            let block = run.blocks.entry(*last).or_default();
            block.times += 1;
            block.jumps += u64::from(next != Some(at));
            run.instructions += addresses.len() as u64;
        }
        state = match state {
            State::Between if at == begin.start => {
                runs.push(Run::default());
                State::Running { last: None }
            }
            State::Between => State::Between,
            State::Running { .. } if at == end => State::Between,
            State::Running { .. } => State::Running { last: (!begin.contains(&at)).then_some(at) },
        };
    }
    Ok((runs, log.blocks))
}

enum State {
    /// Outside of a run.
    Between,
    /// Inside a run: the block that is being executed.
    Running { last: Option<u64> },
}

/// Reader for QEMU's log: blocks as they are translated, and the executed blocks.
struct Log<R> {
    lines: R,
    line: String,
    blocks: Blocks,
}

impl<R: BufRead> Log<R> {
    /// Returns the address of the next executed block, or `None` at the end.
    fn next_block(&mut self) -> Result<Option<u64>> {
        let mut translated: Vec<u64> = Vec::new();
        loop {
            self.line.clear();
            if self.lines.read_line(&mut self.line)? == 0 {
                return Ok(None);
            }
            let line = self.line.trim_end();
            if let Some(executed) = line.strip_prefix("Trace ") {
                let address = executed.split_once('[').and_then(|(_, rest)| rest.split('/').nth(1));
                let address = address.and_then(|address| u64::from_str_radix(address, 16).ok());
                let address = address.with_context(|| format!("QEMU's log: {line}"))?;
                ensure!(self.blocks.contains_key(&address), "QEMU's log lacks block {address:#x}");
                return Ok(Some(address));
            }
            if let Some(instruction) = line.strip_prefix("0x") {
                let address = instruction.split_once(':').map(|(address, _)| address);
                let address = address.and_then(|address| u64::from_str_radix(address, 16).ok());
                translated.push(address.with_context(|| format!("QEMU's log: {line}"))?);
            } else if let Some(first) = translated.first() {
                // The line after the last instruction of a block.
                self.blocks.insert(*first, std::mem::take(&mut translated));
            }
            if line.starts_with("qemu") {
                bail!("{line}");
            }
        }
    }
}

/// Returns the length of the instruction at an address, bytes.
fn width(elf: &Elf, address: u64) -> u64 {
    instruction_at(elf, address).map_or(0, |(_, instruction)| instruction.bytes.len() as u64)
}

/// Returns the instruction at an address, and the function's index.
fn instruction_at(elf: &Elf, address: u64) -> Option<(usize, &Instruction)> {
    let functions = elf.functions();
    let index = functions.partition_point(|function| function.address <= address).checked_sub(1)?;
    let instructions = &functions[index].instructions;
    let at = instructions.binary_search_by_key(&address, |known| known.address).ok()?;
    Some((index, &instructions[at]))
}

impl Trace {
    /// Returns the instructions that runs executed, by function.
    pub(crate) fn mixes(&self, elf: &Elf, runs: &[Run]) -> Result<BTreeMap<usize, Mix>> {
        let mut executed: BTreeMap<u64, Executed> = BTreeMap::new();
        for (address, block) in runs.iter().flat_map(|run| &run.blocks) {
            let sum = executed.entry(*address).or_default();
            sum.times += block.times;
            sum.jumps += block.jumps;
        }
        let mut mixes: BTreeMap<usize, Mix> = BTreeMap::new();
        for (address, Executed { times, jumps }) in executed {
            let instructions = self.blocks[&address]
                .iter()
                .map(|address| {
                    let found = instruction_at(elf, *address);
                    found.with_context(|| format!("no function has an instruction at {address:#x}"))
                })
                .collect::<Result<Vec<_>>>()?;
            let Some((function, _)) = instructions.first() else { continue };
            let mix = mixes.entry(*function).or_default();
            let instructions: Vec<&Instruction> =
                instructions.into_iter().map(|(_, instruction)| instruction).collect();
            mix.instructions += times * instructions.len() as u64;
            mix.cycles += times * cycles::of_block(&instructions) + jumps * cycles::REFILL;
            for instruction in instructions {
                let kind = Kind::of(instruction);
                let at = Kind::ALL.iter().position(|(known, _)| *known == kind);
                mix.kinds[at.context("a kind without a name")?] += times;
            }
        }
        Ok(mixes)
    }
}

impl Mix {
    pub(crate) fn sum<'a>(mixes: impl IntoIterator<Item = &'a Self>) -> Self {
        mixes.into_iter().fold(Self::default(), |sum, mix| Self {
            instructions: sum.instructions + mix.instructions,
            cycles: sum.cycles + mix.cycles,
            kinds: std::array::from_fn(|kind| sum.kinds[kind] + mix.kinds[kind]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Log in the format of QEMU 7.2: each block as it is translated, then each executed block.
    const LOG: &str = "\
----------------
IN: begin
0x00000100:  4770       bx       lr

Trace 0: 0x7f0000000100 [00800400/00000100/00000110/ff010000] begin
----------------
IN: main
0x00000200:  2a00       cmp      r2, #0
0x00000202:  f43f af00  beq.w    #0x300

Trace 0: 0x7f0000000200 [00800400/00000200/00000110/ff010000] main
----------------
IN: main
0x00000206:  e7fb       b        #0x200

Trace 0: 0x7f0000000300 [00800400/00000206/00000110/ff010000] main
Trace 0: 0x7f0000000200 [00800400/00000200/00000110/ff010000] main
----------------
IN: end
0x00000300:  4770       bx       lr

Trace 0: 0x7f0000000400 [00800400/00000300/00000110/ff010000] end
Trace 0: 0x7f0000000200 [00800400/00000200/00000110/ff010000] main
";

    #[test]
    fn runs_are_what_lies_between_the_marks() {
        let width = |address| if address == 0x202 { 4 } else { 2 };
        let (runs, blocks) = read(LOG.as_bytes(), 0x100..0x102, 0x300, width).unwrap();
        let [run] = runs.as_slice() else { panic!("{runs:?}") };
        assert_eq!(run.instructions, 2 + 1 + 2);
        let executed = |address| run.blocks.get(&address).map(|block| (block.times, block.jumps));
        assert_eq!(executed(0x200), Some((2, 1)), "the branch is taken the second time only");
        assert_eq!(executed(0x206), Some((1, 1)));
        assert_eq!(run.blocks.len(), 2, "marks do not count");
        assert_eq!(blocks[&0x200], [0x200, 0x202]);
    }

    #[test]
    fn a_log_of_another_form_is_refused() {
        for (good, bad) in [
            ("/00000206/", "/?/"),
            ("0x00000200:  2a00", "0xcmp:  2a00"),
            ("/00000206/", "/00000208/"),
        ] {
            let text = LOG.replace(good, bad);
            assert_ne!(text, LOG);
            assert!(read(text.as_bytes(), 0x100..0x102, 0x300, |_| 2).is_err(), "{bad}");
        }
    }
}
