//! The deepest stack of a function and all that it calls, from the compiler's frame sizes and the call graph.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use object::{Object, ObjectSection};

use crate::elf::{Elf, Function, Target};

/// Frame sizes by the function's address, as `-Z emit-stack-sizes` leaves them in the image.
#[derive(Debug)]
pub(crate) struct Frames(BTreeMap<u64, u64>);

/// The deepest way of calls.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Depth {
    pub(crate) bytes: u64,
    /// Functions from the outermost on, with their frames in bytes.
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

    /// Entries of four bytes of address and a number in LEB128.
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
            // The lowest bit says that it is Thumb code.
            frames.insert(u64::from(u32::from_le_bytes(*address) & !1), frame);
            bytes = &rest[length..];
        }
        ensure!(bytes.is_empty(), ".stack_sizes ends within an address");
        Ok(Self(frames))
    }

    /// Bytes that a function itself has on the stack at most.
    fn of(&self, function: &Function) -> u64 {
        self.0.get(&function.address).copied().unwrap_or_else(|| pushed_by(function))
    }
}

/// What a function that came without a frame size, as those of the standard library do, pushes and takes off the stack
/// pointer, all added up.
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

/// The number at the end of operands such as `sp, sp, #0x18`.
fn immediate(operands: &str) -> Option<u64> {
    let number = operands.rsplit('#').next()?;
    match number.strip_prefix("0x") {
        Some(hexadecimal) => u64::from_str_radix(hexadecimal, 16).ok(),
        None => number.parse().ok(),
    }
}

/// The deepest stack from `root` on.
///
/// # Errors
/// If something on the way recurs or calls through a pointer: there is then no bound.
pub(crate) fn deepest(elf: &Elf, frames: &Frames, root: usize) -> Result<Depth> {
    let mut known = BTreeMap::new();
    depth(elf, frames, root, &mut Vec::new(), &mut known)
}

fn depth(
    elf: &Elf,
    frames: &Frames,
    at: usize,
    above: &mut Vec<usize>,
    known: &mut BTreeMap<usize, Depth>,
) -> Result<Depth> {
    if let Some(depth) = known.get(&at) {
        return Ok(depth.clone());
    }
    let function = &elf.functions()[at];
    if above.contains(&at) {
        bail!("{} calls itself: its stack has no bound", function.name);
    }
    above.push(at);
    let own = frames.of(function);
    let mut deepest = Depth { bytes: own, path: vec![(at, own)] };
    for call in &function.calls {
        let Target::Function(to) = call.to else {
            bail!(
                "{} calls {:?} at {:#x}: its stack has no bound",
                function.name,
                call.to,
                call.at
            );
        };
        let below = depth(elf, frames, to, above, known)?;
        let frame = if call.is_tail { 0 } else { own };
        if frame + below.bytes > deepest.bytes {
            let mut path = vec![(at, frame)];
            path.extend(below.path);
            deepest = Depth { bytes: frame + below.bytes, path };
        }
    }
    above.pop();
    known.insert(at, deepest.clone());
    Ok(deepest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elf::by_hand::{branch, object};

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

    /// `outer` calls `middle`, which ends in a jump to `inner`.
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
        // What the compiler does not say is taken from the instructions: `inner` pushes 8 bytes and takes 16.
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
}
