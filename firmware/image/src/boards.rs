//! The list of boards.

/// A board that there is an image for. Its crate has the same name, and lies in `firmware/boards/NAME`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Board {
    /// Of its folder, its crate and its image.
    pub name: &'static str,
    /// Bodies that it holds.
    pub bodies: usize,
    /// Length of the human figure's show that its flash holds.
    pub show_s: u32,
    /// QEMU's machine that is this board.
    pub qemu_machine: Option<&'static str>,
}

/// All boards, a line each.
pub const BOARDS: &[Board] = &[
    Board { name: "mps2_an386", bodies: 18, show_s: 21, qemu_machine: Some("mps2-an386") },
    Board { name: "nucleo_f446re", bodies: 18, show_s: 10, qemu_machine: None },
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
