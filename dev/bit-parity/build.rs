//! Links the image for the board that QEMU emulates.

fn main() {
    sinew_image::link(sinew_image::EMULATED, &[]);
}
