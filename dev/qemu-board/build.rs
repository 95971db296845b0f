//! Prepares linking, as for all boards.

fn main() {
    sinew_image::board(&[]);
}
