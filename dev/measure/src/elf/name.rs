//! Names of functions.

/// A symbol as its programmer wrote it, without the compiler's hash.
pub(super) fn demangled(symbol: &str) -> String {
    format!("{:#}", rustc_demangle::demangle(symbol))
}

/// The last part of a function's name, without what a generic one is an instance of.
///
/// From Rust 1.96 on symbols have that (the mangling v0): `run::perform::<18, tick::parity::{closure#0}>`.
pub(crate) fn last_part(name: &str) -> &str {
    let generic = without_instance(name);
    generic.rsplit("::").next().unwrap_or(generic)
}

/// The name without arguments such as `::<18>` at its end.
fn without_instance(name: &str) -> &str {
    let mut depth = 0;
    for (at, letter) in name.char_indices().rev() {
        match letter {
            // `->` of a function's type closes nothing.
            '>' if !name[..at].ends_with('-') => depth += 1,
            '<' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            let arguments = letter == '<';
            return name[..at].strip_suffix("::").filter(|_| arguments).unwrap_or(name);
        }
    }
    name
}
