//! Targets beside the host's and the boards'.

/// 32-bit x86 with a C library of its own, where this machine can run it: it needs no linker but Rust's.
pub(crate) const X86_32: Option<&str> = if cfg!(all(target_arch = "x86_64", target_os = "linux")) {
    Some("i686-unknown-linux-musl")
} else {
    None
};
