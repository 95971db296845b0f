//! Targets besides the host's and the boards'.

/// 32-bit x86 with its own C library, if this machine can run it. It needs no linker except Rust's.
pub(crate) const X86_32: Option<&str> = if cfg!(all(target_arch = "x86_64", target_os = "linux")) {
    Some("i686-unknown-linux-musl")
} else {
    None
};
