//! A function of an image.

use super::call::Call;
use super::disassembly::Instruction;

/// A function as it lies in flash.
#[derive(Debug, Clone)]
pub(crate) struct Function {
    /// Demangled, without the compiler's hash.
    pub(crate) name: String,
    /// Further names of the same code: the linker folds functions that are equal, and libraries give aliases.
    pub(crate) aliases: Vec<String>,
    /// The symbol as the linker knows it.
    pub(crate) symbol: String,
    /// Of the first instruction, without the Thumb bit.
    pub(crate) address: u64,
    /// Bytes, literal pools among them.
    pub(crate) size: u64,
    /// In rising order, without the data between them.
    pub(crate) instructions: Vec<Instruction>,
    /// In the order of their addresses.
    pub(crate) calls: Vec<Call>,
}

impl Function {
    /// Its name and aliases.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        std::iter::once(&self.name).chain(&self.aliases).map(String::as_str)
    }
}
