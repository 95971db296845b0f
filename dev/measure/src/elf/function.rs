//! A function of an image.

use super::call::Call;
use super::disassembly::Instruction;

/// A function in flash.
#[derive(Debug, Clone)]
pub(crate) struct Function {
    /// Demangled name, without the compiler's hash.
    pub(crate) name: String,
    /// Other names of the same code: the linker merges equal functions, and libraries define aliases.
    pub(crate) aliases: Vec<String>,
    /// Symbol of the linker.
    pub(crate) symbol: String,
    /// Address of the first instruction, without the Thumb bit.
    pub(crate) address: u64,
    /// Size in bytes, including literal pools.
    pub(crate) size: u64,
    /// Instructions in the order of addresses, without the data between them.
    pub(crate) instructions: Vec<Instruction>,
    /// Calls in the order of their addresses.
    pub(crate) calls: Vec<Call>,
}

impl Function {
    /// Returns its name and aliases.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        std::iter::once(&self.name).chain(&self.aliases).map(String::as_str)
    }
}
