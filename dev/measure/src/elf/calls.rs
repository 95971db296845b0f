//! Finds calls in the instructions.

use super::call::{Call, Target};
use super::disassembly::Instruction;
use super::function::Function;

/// Returns the function at an address. `all` must be in the order of addresses.
fn target_at(all: &[Function], address: u64) -> Target {
    let behind = all.partition_point(|function| function.address <= address);
    let index = behind.checked_sub(1).filter(|index| {
        let Function { address: start, size, .. } = all[*index];
        address < start + size
    });
    index.map_or(Target::Nowhere(address), Target::Function)
}

/// Returns all calls of a function. `all` is in the order of addresses; `word` returns the word at an address.
pub(super) fn of(
    function: &Function,
    all: &[Function],
    word: &impl Fn(u64) -> Option<u32>,
) -> Vec<Call> {
    let target_at = |address: u64| target_at(all, address);
    let is_within =
        |address: u64| (function.address..function.address + function.size).contains(&address);
    let by_register = |index: usize| {
        let address = held(function, index, &function.instructions[index].operands, word)?;
        Some(target_at(address))
    };
    let instructions = function.instructions.iter().enumerate();
    instructions
        .filter_map(|(index, instruction)| {
            let (to, is_tail) = match instruction.operation.as_str() {
                "bl" | "blx" => {
                    let direct = instruction.branch_target().map(target_at);
                    (direct.or_else(|| by_register(index)), false)
                }
                "b" => {
                    let target = instruction.branch_target()?;
                    // A loop or a branch, or a self-recursion that became a loop.
                    if is_within(target) {
                        return None;
                    }
                    (Some(target_at(target)), true)
                }
                _ if jumps_to_a_register(instruction) => (by_register(index), true),
                _ => return None,
            };
            Some(Call { at: instruction.address, to: to.unwrap_or(Target::Indirect), is_tail })
        })
        .collect()
}

/// Returns the address of code in a register before an instruction, if the nearest earlier write of the register
/// loads it from a constant among the instructions. Compilers call frequent functions in this way to make code small.
fn held(
    function: &Function,
    before: usize,
    register: &str,
    word: &impl Fn(u64) -> Option<u32>,
) -> Option<u64> {
    let names = |instruction: &&Instruction| {
        let mut words = instruction.operands.split(|letter: char| !letter.is_alphanumeric());
        words.any(|word| word == register)
    };
    let writes = |instruction: &&Instruction| {
        let writes_two = ["ldrd", "ldm", "pop", "umull", "smull", "umlal", "smlal"];
        let reads = ["str", "cmp", "cmn", "tst", "teq", "cbz", "cbnz", "bl", "bx", "push", "stm"];
        let operation = instruction.operation.as_str();
        let is_first = instruction.operands.split(',').next() == Some(register);
        let is_read = reads.iter().any(|read| operation.starts_with(read));
        writes_two.iter().any(|write| operation.starts_with(write)) || is_first && !is_read
    };
    let mut earlier = function.instructions[..before].iter().rev().filter(names);
    let Instruction { address, operation, operands, .. } = earlier.find(writes)?;
    let offset = operands.strip_prefix(register)?.strip_prefix(", [pc, #")?.strip_suffix(']')?;
    let offset = match offset.strip_prefix("0x") {
        Some(hexadecimal) => u64::from_str_radix(hexadecimal, 16).ok()?,
        None => offset.parse().ok()?,
    };
    // The program counter is four bytes ahead, and aligned to a word.
    let found = word(((address + 4) & !3) + offset).filter(|_| operation == "ldr")?;
    // The lowest bit marks Thumb code.
    (found & 1 == 1).then_some(u64::from(found & !1))
}

/// Returns the targets of a jump to a register that the callers have loaded, as in outlined ends of functions. `None`
/// if the value is unknown for a caller.
pub(super) fn of_callers(
    to: usize,
    call: &Call,
    all: &[Function],
    word: &impl Fn(u64) -> Option<u32>,
) -> Option<Vec<Call>> {
    let own = &all[to].instructions;
    let index = own.iter().position(|instruction| instruction.address == call.at)?;
    let register = &own[index].operands;
    let mut found = Vec::new();
    for caller in all {
        for site in caller.calls.iter().filter(|site| site.to == Target::Function(to)) {
            let at = caller.instructions.iter().position(|found| found.address == site.at)?;
            let target = target_at(all, held(caller, at, register, word)?);
            found.push(Call { to: target, ..*call });
        }
    }
    found.sort_unstable_by_key(|call| call.to.function());
    found.dedup();
    (!found.is_empty()).then_some(found)
}

/// Returns whether an instruction jumps to the address in a register, and is neither a return nor a jump table.
fn jumps_to_a_register(instruction: &Instruction) -> bool {
    instruction.operation == "bx" && instruction.operands != "lr"
}
