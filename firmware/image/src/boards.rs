//! The list of boards.

/// A board that there is an image for. Its crate has the same name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Board {
    /// The name of its crate and its image.
    pub name: &'static str,
    /// The folder of its crate, from the top of the repository.
    pub folder: &'static str,
    /// The show that its image performs by itself; none of a board that runs the node, and gets its shows from a host.
    pub baked: Option<Baked>,
    /// QEMU's machine that is this board.
    pub qemu_machine: Option<&'static str>,
}

/// A show of the human figure that is part of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Baked {
    /// Bodies that the image holds.
    pub bodies: usize,
    /// How long a show its flash holds.
    pub seconds: u32,
}

/// All boards, a line each.
pub const BOARDS: &[Board] = &[
    Board {
        name: "mps2_an386",
        folder: "dev/qemu-board",
        baked: Some(Baked { bodies: 18, seconds: 21 }),
        qemu_machine: Some("mps2-an386"),
    },
    Board {
        name: "nucleo_f446re",
        folder: "firmware/boards/nucleo_f446re",
        baked: None,
        qemu_machine: None,
    },
    Board {
        name: "nucleo_g474re",
        folder: "firmware/boards/nucleo_g474re",
        baked: None,
        qemu_machine: None,
    },
];

/// The board that all images for measuring and comparing are linked for: QEMU's Cortex-M4.
pub const EMULATED: Board = BOARDS[0];

impl Board {
    /// The board of that name.
    pub(crate) fn named(name: &str) -> Self {
        let board = BOARDS.iter().find(|board| board.name == name);
        *board.unwrap_or_else(|| panic!("{name} is not in the list of boards, {}", file!()))
    }
}
