//! The list of boards.

/// A board that there is an image for. Its crate has the same name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Board {
    /// The name of its crate and its image.
    pub name: &'static str,
    /// The folder of its crate, from the top of the repository.
    pub folder: &'static str,
    /// QEMU's machine that is this board: its image performs a show by itself. Other boards run the node, and get their
    /// shows from a host.
    pub qemu_machine: Option<&'static str>,
}

/// All boards, a line each.
pub const BOARDS: &[Board] = &[
    Board { name: "mps2_an386", folder: "dev/qemu-board", qemu_machine: Some("mps2-an386") },
    Board { name: "nucleo_f446re", folder: "firmware/boards/nucleo_f446re", qemu_machine: None },
    Board { name: "nucleo_g474re", folder: "firmware/boards/nucleo_g474re", qemu_machine: None },
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
