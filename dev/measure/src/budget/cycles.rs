//! Estimates the cycles of a Cortex-M4F from the executed instructions.
//!
//! The timings are those of Arm's Cortex-M4 Technical Reference Manual (DDI 0439), with 2 cycles to refill the
//! pipeline after a branch (the manual says 1 to 3), and 7 for an integer division (2 to 12). Not included: wait
//! states of the flash and the effect of its prefetch and cache, the cycle that an arithmetic instruction waits for
//! the floating-point result right before it, integer work in parallel with a division or a square root, instructions
//! that an `it` block skips, and interrupts.

use crate::elf::Instruction;

/// Kind of an instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Load,
    Store,
    /// Addition, subtraction, multiplication, and similar operations on floats.
    Float,
    /// Product and sum in one instruction, rounded once or (`vmla`) twice. It takes three cycles.
    FloatProductSum,
    /// Division and square root of floats.
    FloatDivision,
    /// Comparison, conversion and moves of floats.
    FloatMove,
    Integer,
    Branch,
}

impl Kind {
    /// All kinds, with their names in tables.
    pub(crate) const ALL: [(Self, &'static str); 8] = [
        (Self::Load, "load"),
        (Self::Store, "store"),
        (Self::Float, "+ - ×"),
        (Self::FloatProductSum, "a + b c"),
        (Self::FloatDivision, "/ √"),
        (Self::FloatMove, "other float"),
        (Self::Integer, "integer"),
        (Self::Branch, "branch"),
    ];

    pub(crate) fn of(instruction: &Instruction) -> Self {
        let operation = instruction.operation.as_str();
        match operation {
            "vadd" | "vsub" | "vmul" | "vnmul" | "vabs" | "vneg" => Self::Float,
            "vmla" | "vmls" | "vnmla" | "vnmls" | "vfma" | "vfms" | "vfnma" | "vfnms" => {
                Self::FloatProductSum
            }
            "vdiv" | "vsqrt" => Self::FloatDivision,
            "b" | "bl" | "blx" | "bx" | "cbz" | "cbnz" | "tbb" | "tbh" => Self::Branch,
            _ if is_any(operation, &["ldr", "ldm", "vldr", "vldm", "pop", "vpop"]) => Self::Load,
            _ if is_any(operation, &["str", "stm", "vstr", "vstm", "push", "vpush"]) => Self::Store,
            _ if operation.starts_with('v') => Self::FloatMove,
            _ => Self::Integer,
        }
    }
}

/// Cycles to refill the pipeline after a branch that is taken.
pub(crate) const REFILL: u64 = 2;

/// Returns the cycles of consecutive instructions without a taken branch.
pub(crate) fn of_block(instructions: &[&Instruction]) -> u64 {
    let mut cycles = 0;
    let mut follows_access = false;
    for instruction in instructions {
        let is_access = is_single_access(instruction);
        // The address phase overlaps with the data phase of the previous access.
        cycles += if is_access && follows_access { 1 } else { of(instruction) };
        follows_access = is_access;
    }
    cycles
}

/// Returns the cycles of an instruction without stalls and taken branches.
fn of(instruction: &Instruction) -> u64 {
    let operation = instruction.operation.as_str();
    match operation {
        "sdiv" | "udiv" => 7,
        "it" | "nop" => 1,
        // Moves between two core registers and a double, or two singles.
        "vmov" => words_moved(instruction),
        "ldrd" | "strd" => 3,
        "mla" | "mls" | "tbb" | "tbh" => 2,
        _ if is_any(operation, &["ldm", "stm", "vldm", "vstm", "push", "pop", "vpush", "vpop"]) => {
            1 + words_listed(instruction)
        }
        "vldr" | "vstr" if has_doubles(instruction) => 3,
        _ => match Kind::of(instruction) {
            Kind::Load | Kind::Store => 2,
            Kind::FloatProductSum => 3,
            Kind::FloatDivision => 14,
            Kind::Float | Kind::FloatMove | Kind::Integer | Kind::Branch => 1,
        },
    }
}

/// Returns whether an instruction loads or stores at most one word.
fn is_single_access(instruction: &Instruction) -> bool {
    let operation = instruction.operation.as_str();
    let is_word = is_any(operation, &["ldr", "str", "vldr", "vstr"])
        && !matches!(operation, "ldrd" | "strd")
        && !has_doubles(instruction);
    // A jump through memory prevents the overlap.
    is_word && !instruction.operands.starts_with("pc")
}

fn is_any(operation: &str, beginnings: &[&str]) -> bool {
    beginnings.iter().any(|beginning| operation.starts_with(beginning))
}

fn has_doubles(instruction: &Instruction) -> bool {
    instruction.operands.starts_with('d')
}

/// Returns the number of words in a register list such as `r0!, {r4, d8}`.
fn words_listed(instruction: &Instruction) -> u64 {
    let operands = instruction.operands.as_str();
    let list = operands.split_once('{').map_or("", |(_, list)| list.trim_end_matches('}'));
    list.split(',').map(|register| if register.trim_start().starts_with('d') { 2 } else { 1 }).sum()
}

/// Returns the number of words that a move transfers: two if it has three registers (two core registers, and a double
/// or a pair of singles).
fn words_moved(instruction: &Instruction) -> u64 {
    if instruction.operands.split(',').count() > 2 { 2 } else { 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cycles(lines: &[&str]) -> u64 {
        let instructions: Vec<Instruction> = lines
            .iter()
            .map(|line| {
                let (operation, operands) = line.split_once(' ').unwrap_or((line, ""));
                Instruction {
                    address: 0,
                    operation: operation.to_owned(),
                    mnemonic: operation.to_owned(),
                    operands: operands.to_owned(),
                    bytes: Vec::new(),
                }
            })
            .collect();
        of_block(&instructions.iter().collect::<Vec<_>>())
    }

    #[test]
    fn instructions_take_what_the_manual_says() {
        for (line, expected) in [
            ("vadd s0, s1, s2", 1),
            ("vfma s0, s1, s2", 3),
            ("vdiv s0, s1, s2", 14),
            ("vsqrt s0, s1", 14),
            ("vldr s0, [r0]", 2),
            ("vldr d8, [r0]", 3),
            ("vldmia r0!, {s0, s1, s2}", 4),
            ("vpush {d8, d9}", 5),
            ("push {r4, r5, lr}", 4),
            ("ldrd r0, r1, [r2]", 3),
            ("vmov d0, r0, r1", 2),
            ("vmov s0, r0", 1),
            ("add r0, r1, r2", 1),
            ("beq #0x10", 1),
        ] {
            assert_eq!(cycles(&[line]), expected, "{line}");
        }
    }

    #[test]
    fn loads_one_after_the_other_take_a_cycle_each() {
        let load = "ldr r0, [r1]";
        assert_eq!(cycles(&[load, load, load]), 4);
        assert_eq!(cycles(&[load, "add r0, r0, r1", load]), 5);
        assert_eq!(cycles(&[load, "vstr s0, [r1]", "ldrd r2, r3, [r1]"]), 6);
    }
}
