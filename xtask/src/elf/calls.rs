//! Who calls whom, from the instructions.

use super::{Function, Instruction};

/// A call, or a jump that ends in another function (a tail call).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Call {
    /// Address of the instruction.
    pub(crate) at: u64,
    /// What is called.
    pub(crate) to: Target,
    /// Whether it does not come back here: the caller's frame is off the stack by then.
    pub(crate) is_tail: bool,
}

/// What is called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Target {
    /// The function of that index.
    Function(usize),
    /// Whatever a register holds: a function pointer, or a method of a `dyn`.
    Indirect,
    /// An address where no function lies.
    Nowhere(u64),
}

impl Target {
    /// The function, if it is known.
    pub(crate) fn function(self) -> Option<usize> {
        match self {
            Self::Function(index) => Some(index),
            Self::Indirect | Self::Nowhere(_) => None,
        }
    }
}

/// All calls of a function. `all` is in the order of addresses.
pub(super) fn of(function: &Function, all: &[Function]) -> Vec<Call> {
    let target_at = |address: u64| {
        let behind = all.partition_point(|function| function.address <= address);
        let index = behind.checked_sub(1).filter(|index| {
            let Function { address: start, size, .. } = all[*index];
            address < start + size
        });
        index.map_or(Target::Nowhere(address), Target::Function)
    };
    let is_within =
        |address: u64| (function.address..function.address + function.size).contains(&address);
    function
        .instructions
        .iter()
        .filter_map(|instruction| {
            let (to, is_tail) = match instruction.operation.as_str() {
                "bl" | "blx" => (instruction.branch_target().map(target_at), false),
                "b" => {
                    let target = instruction.branch_target()?;
                    // A loop or a branch, or self-recursion that was made one.
                    if is_within(target) {
                        return None;
                    }
                    (Some(target_at(target)), true)
                }
                _ if jumps_to_a_register(instruction) => (None, true),
                _ => return None,
            };
            Some(Call { at: instruction.address, to: to.unwrap_or(Target::Indirect), is_tail })
        })
        .collect()
}

/// Whether it goes where a register says, and this is neither a return nor a jump table.
fn jumps_to_a_register(instruction: &Instruction) -> bool {
    instruction.operation == "bx" && instruction.operands != "lr"
}
