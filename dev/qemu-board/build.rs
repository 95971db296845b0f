//! As for all boards.

fn main() {
    sinew_image::board(&[]);
}
