//! Links the board's image. The build script is the same for all boards.

fn main() {
    sinew_image::board(&[]);
}
