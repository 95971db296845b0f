//! A call of a function.

/// A call, or a jump that ends in another function (a tail call).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Call {
    /// Address of the instruction.
    pub(crate) at: u64,
    /// Function that is called.
    pub(crate) to: Target,
    /// Whether the call does not return here: the caller's frame is already removed from the stack.
    pub(crate) is_tail: bool,
}

/// Target of a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Target {
    /// The function with that index.
    Function(usize),
    /// The content of a register: a function pointer, or a method of a `dyn`.
    Indirect,
    /// An address without a function.
    Nowhere(u64),
}

impl Target {
    /// Returns the index of the function, if it is known.
    pub(crate) fn function(self) -> Option<usize> {
        match self {
            Self::Function(index) => Some(index),
            Self::Indirect | Self::Nowhere(_) => None,
        }
    }
}
