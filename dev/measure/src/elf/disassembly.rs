//! Decodes instructions of a Cortex-M with an FPU.

use anyhow::{Result, anyhow, ensure};
use capstone::Capstone;
use capstone::arch::BuildsCapstone;
use capstone::arch::BuildsCapstoneExtraMode;
use capstone::arch::arm::{ArchExtraMode, ArchMode};

/// A decoded instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Instruction {
    /// Address of its first byte.
    pub(crate) address: u64,
    /// Operation without condition, width and type: `vmla` for `vmlaeq.f32`, `b` for `bne.w`.
    pub(crate) operation: String,
    /// Mnemonic in assembler notation: `vmlaeq.f32`.
    pub(crate) mnemonic: String,
    /// Operands in assembler notation: `s0, s1, s2`; targets of branches as `#0x1f0`.
    pub(crate) operands: String,
    /// Bytes of the instruction, 2 or 4, in the order of memory.
    pub(crate) bytes: Vec<u8>,
}

impl Instruction {
    /// Returns the target address of a direct branch or call: its last operand.
    pub(crate) fn branch_target(&self) -> Option<u64> {
        if !matches!(self.operation.as_str(), "b" | "bl" | "blx" | "cbz" | "cbnz") {
            return None;
        }
        let address = self.operands.rsplit(' ').next()?.strip_prefix('#')?;
        // Addresses below ten are written in decimal.
        match address.strip_prefix("0x") {
            Some(hexadecimal) => u64::from_str_radix(hexadecimal, 16).ok(),
            None => address.parse().ok(),
        }
    }
}

pub(super) struct Disassembler(Capstone);

impl Disassembler {
    pub(super) fn new() -> Result<Self> {
        let capstone = Capstone::new()
            .arm()
            .mode(ArchMode::Thumb)
            .extra_mode([ArchExtraMode::MClass].into_iter())
            .build()
            .map_err(|error| anyhow!("the disassembler: {error}"))?;
        Ok(Self(capstone))
    }

    /// Decodes pieces of code.
    pub(super) fn instructions(&self, pieces: &[(u64, Vec<u8>)]) -> Result<Vec<Instruction>> {
        let mut all = Vec::new();
        for (start, bytes) in pieces {
            let decoded = self.0.disasm_all(bytes, *start).map_err(|error| anyhow!("{error}"))?;
            let mut end = *start;
            for instruction in decoded.iter() {
                all.push(Instruction {
                    address: instruction.address(),
                    operation: self.0.insn_name(instruction.id()).unwrap_or_default(),
                    mnemonic: instruction.mnemonic().unwrap_or_default().to_owned(),
                    operands: instruction.op_str().unwrap_or_default().to_owned(),
                    bytes: instruction.bytes().to_vec(),
                });
                end = instruction.address() + instruction.len() as u64;
            }
            ensure!(end == start + bytes.len() as u64, "what lies at {end:#x} is no instruction");
        }
        Ok(all)
    }
}
