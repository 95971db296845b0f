//! A call of a function.

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
