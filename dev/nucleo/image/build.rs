//! Links the image for the reference board.

fn main() {
    let board = sinew_image::BOARDS.iter().find(|board| board.name == "nucleo_f446re");
    sinew_image::link(*board.expect("it is the reference board"), &[]);
}
