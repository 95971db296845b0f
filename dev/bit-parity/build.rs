//! The image is for the board that QEMU has.

fn main() {
    sinew_image::link(sinew_image::EMULATED, &[]);
}
