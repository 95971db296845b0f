//! Computes the deepest stack of a function with all its callees, from the compiler's frame sizes and the call graph.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use object::{Object, ObjectSection};

use crate::elf::{Elf, Function, Target};

/// Frame sizes by the function's address, as `-Z emit-stack-sizes` stores them in the image.
#[derive(Debug)]
pub(crate) struct Frames(BTreeMap<u64, u64>);

/// The deepest path of calls.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Depth {
    pub(crate) bytes: u64,
    /// Functions from the outermost inwards, with their frames in bytes.
    pub(crate) path: Vec<(usize, u64)>,
}

impl Frames {
    pub(crate) fn load(image: &Path) -> Result<Self> {
        let bytes = fs::read(image).with_context(|| image.display().to_string())?;
        let file = object::File::parse(&*bytes)?;
        let section = file
            .section_by_name(".stack_sizes")
            .with_context(|| format!("{} has no section .stack_sizes", image.display()))?;
        Self::parse(section.data()?)
    }

    /// Parses entries of a 4-byte address and a number in LEB128.
    fn parse(mut bytes: &[u8]) -> Result<Self> {
        let mut frames = BTreeMap::new();
        while let Some((address, rest)) = bytes.split_first_chunk::<4>() {
            let mut frame = 0;
            let mut length = 0;
            loop {
                let byte = *rest.get(length).context(".stack_sizes ends within a number")?;
                frame |= u64::from(byte & 0x7f) << (7 * length);
                length += 1;
                if byte & 0x80 == 0 {
                    break;
                }
                ensure!(length < 5, ".stack_sizes has a frame beyond 2^32");
            }
            // The lowest bit marks Thumb code.
            frames.insert(u64::from(u32::from_le_bytes(*address) & !1), frame);
            bytes = &rest[length..];
        }
        ensure!(bytes.is_empty(), ".stack_sizes ends within an address");
        Ok(Self(frames))
    }

    /// Returns the largest frame of a function, bytes.
    fn of(&self, function: &Function) -> u64 {
        self.0.get(&function.address).copied().unwrap_or_else(|| pushed_by(function))
    }
}

/// Returns the frame of a function without a known frame size, such as those of the standard library: the sum of all
/// bytes that it pushes and subtracts from the stack pointer.
fn pushed_by(function: &Function) -> u64 {
    function
        .instructions
        .iter()
        .map(|instruction| {
            let operands = instruction.operands.as_str();
            match instruction.operation.as_str() {
                "push" => 4 * operands.split(',').count() as u64,
                "vpush" => 8 * operands.split(',').count() as u64,
                "stmdb" if operands.starts_with("sp!") => {
                    4 * operands.split(',').skip(1).count() as u64
                }
                "str" if operands.contains("[sp, #-") && operands.ends_with('!') => 8,
                "sub" | "subw" if operands.starts_with("sp") => {
                    immediate(operands).unwrap_or_default()
                }
                _ => 0,
            }
        })
        .sum()
}

/// Returns the number at the end of operands such as `sp, sp, #0x18`.
fn immediate(operands: &str) -> Option<u64> {
    let number = operands.rsplit('#').next()?;
    match number.strip_prefix("0x") {
        Some(hexadecimal) => u64::from_str_radix(hexadecimal, 16).ok(),
        None => number.parse().ok(),
    }
}

/// Returns the deepest stack from `root`.
///
/// # Errors
/// If a function that can be reached recurs, calls through a pointer, or calls an address without a function: then
/// there is no bound.
pub(crate) fn deepest(elf: &Elf, frames: &Frames, root: usize) -> Result<Depth> {
    Search { elf, frames, pointers: &[], known: BTreeMap::new() }.depth(root, &mut Vec::new())
}

/// Returns the deepest stack of a whole image: that of its program, plus those of the two deepest interrupts, one of
/// which may interrupt the other.
///
/// # Errors
/// If a function recurs by name. A call by pointer may go to any function whose address is in data; recursion through
/// such a call is not checked.
pub(crate) fn of_image(image: &Path) -> Result<u64> {
    let elf = Elf::load(image)?;
    let mut search = Search {
        elf: &elf,
        frames: &Frames(BTreeMap::new()),
        pointers: elf.named_by_data(),
        known: BTreeMap::new(),
    };
    let main = elf.named("main").context("the image has no `main`")?;
    let program = search.depth(main, &mut Vec::new())?;
    let is_reset = |handler: &usize| elf.functions()[*handler].names().any(|name| name == "Reset");
    let handlers = elf.handlers().iter().filter(|handler| !is_reset(handler));
    let mut interrupts = handlers
        .map(|handler| Ok(search.depth(*handler, &mut Vec::new())?.bytes))
        .collect::<Result<Vec<_>>>()?;
    interrupts.sort_unstable_by(|a, b| b.cmp(a));
    let of_interrupts: u64 = interrupts.iter().take(2).map(|bytes| bytes + EXCEPTION_BYTES).sum();
    Ok(program.bytes + of_interrupts)
}

/// Largest number of bytes that the processor pushes for an exception, with FPU registers and alignment (ARMv7-M,
/// B1.5.7).
const EXCEPTION_BYTES: u64 = 26 * 4 + 4;

struct Search<'a> {
    elf: &'a Elf,
    frames: &'a Frames,
    /// Possible targets of a pointer. If empty, a call through a pointer is an error.
    pointers: &'a [usize],
    known: BTreeMap<usize, Depth>,
}

impl Search<'_> {
    fn depth(&mut self, at: usize, above: &mut Vec<usize>) -> Result<Depth> {
        if let Some(depth) = self.known.get(&at) {
            return Ok(depth.clone());
        }
        let function = &self.elf.functions()[at];
        if above.contains(&at) {
            bail!("{} calls itself: its stack has no bound", function.name);
        }
        above.push(at);
        let own = self.frames.of(function);
        let mut deepest = Depth { bytes: own, path: vec![(at, own)] };
        for call in &function.calls {
            let targets = match call.to {
                Target::Function(to) => vec![to],
                Target::Indirect if !self.pointers.is_empty() => {
                    self.pointers.iter().copied().filter(|to| !above.contains(to)).collect()
                }
                Target::Indirect | Target::Nowhere(_) => bail!(
                    "{} calls {:?} at {:#x}: its stack has no bound",
                    function.name,
                    call.to,
                    call.at
                ),
            };
            let frame = if call.is_tail { 0 } else { own };
            for to in targets {
                let below = self.depth(to, above)?;
                if frame + below.bytes > deepest.bytes {
                    let mut path = vec![(at, frame)];
                    path.extend(below.path);
                    deepest = Depth { bytes: frame + below.bytes, path };
                }
            }
        }
        above.pop();
        self.known.insert(at, deepest.clone());
        Ok(deepest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elf::fixture::{BLX_R3, NOP, branch, object};

    const PUSH_R4_LR: u16 = 0xb510;
    const POP_R4_PC: u16 = 0xbd10;
    const SUB_SP_16: u16 = 0xb084;
    const BX_LR: u16 = 0x4770;

    #[test]
    fn frame_sizes_are_read() {
        let frames = Frames::parse(&[0x59, 4, 0, 0, 0xd8, 0x27, 0x99, 0, 0, 0, 8]).unwrap();
        assert_eq!(frames.0, BTreeMap::from([(0x458, 5080), (0x98, 8)]));
        for bad in
            [&[0x59, 4, 0, 0][..], &[0x59, 4, 0, 0, 0x80], &[0x59, 4], &[0x59, 4, 0, 0, 8, 1]]
        {
            assert!(Frames::parse(bad).is_err(), "{bad:?}");
        }
    }

    /// Makes an image in which `outer` calls `middle`, which ends in a jump to `inner`.
    fn image() -> Elf {
        let (call, jump) = (branch(2, 8, true), branch(10, 16, false));
        let halves = [
            // outer
            PUSH_R4_LR, call[0], call[1], POP_R4_PC, // middle
            BX_LR, jump[0], jump[1], BX_LR, // inner
            PUSH_R4_LR, SUB_SP_16, POP_R4_PC,
        ];
        Elf::parse(&object(&[(0, "outer"), (8, "middle"), (16, "inner")], &halves)).unwrap()
    }

    #[test]
    fn the_deepest_way_is_that_of_frames_and_tail_calls_leave_theirs() {
        let elf = image();
        // Missing frame sizes are derived from the instructions: `inner` pushes 8 bytes and subtracts 16.
        let frames = Frames(BTreeMap::from([(0, 8), (8, 12)]));
        let depth = deepest(&elf, &frames, 0).unwrap();
        assert_eq!(depth, Depth { bytes: 8 + 24, path: vec![(0, 8), (1, 0), (2, 24)] });
        let wide = Frames(BTreeMap::from([(0, 8), (8, 100)]));
        let depth = deepest(&elf, &wide, 0).unwrap();
        assert_eq!(depth, Depth { bytes: 108, path: vec![(0, 8), (1, 100)] });
    }

    #[test]
    fn what_calls_itself_has_no_bound() {
        let call = branch(2, 0, true);
        let halves = [PUSH_R4_LR, call[0], call[1], POP_R4_PC];
        let elf = Elf::parse(&object(&[(0, "again")], &halves)).unwrap();
        let error = deepest(&elf, &Frames(BTreeMap::new()), 0).unwrap_err();
        assert_eq!(error.to_string(), "again calls itself: its stack has no bound");
    }

    /// Loads `r3` from the word after the next two instructions.
    const LDR_R3_PC: u16 = 0x4b00;

    /// Returns the pointer to a function at `address`: bit 0 marks Thumb code.
    const fn thumb(address: u16) -> u16 {
        address | 1
    }

    #[test]
    fn a_pointer_from_amid_the_code_is_a_name() {
        // outer: `r3` is loaded with the address of `inner`.
        let halves = [PUSH_R4_LR, NOP, LDR_R3_PC, BLX_R3, thumb(12), 0, PUSH_R4_LR, POP_R4_PC];
        let symbols = [(0, "$t"), (0, "outer"), (8, "$d"), (12, "$t"), (12, "inner")];
        let elf = Elf::parse(&object(&symbols, &halves)).unwrap();
        let depth = deepest(&elf, &Frames(BTreeMap::new()), 0).unwrap();
        assert_eq!(depth, Depth { bytes: 16, path: vec![(0, 8), (1, 8)] });
    }

    #[test]
    fn any_other_pointer_is_to_what_data_names() {
        // outer calls a pointer from its caller; a word after `inner` contains its address.
        let halves = [PUSH_R4_LR, BLX_R3, POP_R4_PC, NOP, PUSH_R4_LR, SUB_SP_16, thumb(8), 0];
        let symbols = [(0, "$t"), (0, "outer"), (8, "inner"), (12, "$d")];
        let elf = Elf::parse(&object(&symbols, &halves)).unwrap();
        assert_eq!(elf.named_by_data(), [1]);
        let frames = Frames(BTreeMap::new());
        assert!(deepest(&elf, &frames, 0).is_err());
        let mut search =
            Search { elf: &elf, frames: &frames, pointers: &[1], known: BTreeMap::new() };
        assert_eq!(search.depth(0, &mut Vec::new()).unwrap().bytes, 8 + 24);
    }
}
