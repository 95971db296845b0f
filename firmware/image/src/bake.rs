//! The show that is baked into an image.

use std::path::{Path, PathBuf};
use std::{env, fs};

use sinew_firmware::show::Show;

use crate::link;

/// Puts the show where the image includes it from: a show that the board could perform, or the build ends.
pub(crate) fn bake(board: &str, capacity: usize) {
    const HELP: &str = "make a show with `cargo run --release -- bake --output FILE`, or build the images with \
        `cargo xtask firmware`";
    println!("cargo:rerun-if-env-changed=SINEW_SHOW");
    let Some(path) = env::var_os("SINEW_SHOW").map(PathBuf::from) else {
        panic!("SINEW_SHOW must name a show: {HELP}");
    };
    let name = format!("SINEW_SHOW={}", path.display());
    // Cargo runs this in the package's folder, not in the caller's.
    assert!(path.is_absolute(), "{name} must be a whole path, such as $PWD/FILE");
    println!("cargo:rerun-if-changed={}", path.display());
    let bytes = fs::read(&path).unwrap_or_else(|error| panic!("{name}: {error}; {HELP}"));
    let show = Show::parse(&bytes).unwrap_or_else(|error| panic!("{name}: {error}; {HELP}"));
    let bodies = show.body_count();
    assert!(bodies <= capacity, "{name} has {bodies} bodies, and {board} holds {capacity}");

    let out = link::variable("OUT_DIR");
    let write = |file: &str, bytes: &[u8]| {
        fs::write(Path::new(&out).join(file), bytes).expect("cargo's folder can be written to");
    };
    write("show.snws", &bytes);
    let source = format!(
        "/// Bodies that the board holds.\n\
         const CAPACITY: usize = {capacity};\n\
         /// The show that the image performs.\n\
         static SHOW: &[u8] = include_bytes!(\"show.snws\");\n"
    );
    write("baked.rs", source.as_bytes());
}
