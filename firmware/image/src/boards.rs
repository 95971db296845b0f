//! The list of boards.

/// A board for which an image exists. Its crate has the same name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Board {
    /// Name of the board's crate and of its image.
    pub name: &'static str,
    /// Folder of the board's crate, from the top of the repository.
    pub folder: &'static str,
    /// QEMU's machine for this board: its image performs a show by itself. Other boards run the node and receive
    /// their shows from a host.
    pub qemu_machine: Option<&'static str>,
}

/// All boards.
pub const BOARDS: &[Board] = &[
    Board { name: "mps2_an386", folder: "dev/qemu-board", qemu_machine: Some("mps2-an386") },
    Board { name: "nucleo_f446re", folder: "firmware/boards/nucleo_f446re", qemu_machine: None },
    Board { name: "nucleo_g474re", folder: "firmware/boards/nucleo_g474re", qemu_machine: None },
];

/// The board for which all images for measuring and comparing are linked: QEMU's Cortex-M4.
pub const EMULATED: Board = BOARDS[0];

impl Board {
    /// Returns the board with this name. Panics if there is none.
    pub(crate) fn named(name: &str) -> Self {
        let board = BOARDS.iter().find(|board| board.name == name);
        *board.unwrap_or_else(|| panic!("{name} is not in the list of boards, {}", file!()))
    }
}
