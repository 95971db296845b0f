//! Demangles and shortens names of functions.

/// Returns the name of a symbol in the source, without the compiler's hash.
pub(super) fn demangled(symbol: &str) -> String {
    format!("{:#}", rustc_demangle::demangle(symbol))
}

/// Returns the last part of a function's name, without the arguments of a generic function.
///
/// Since Rust 1.96 symbols contain these arguments (the mangling v0): `run::perform::<18,
/// tick::parity::{closure#0}>`.
pub(crate) fn last_part(name: &str) -> &str {
    let generic = without_instance(name);
    generic.rsplit("::").next().unwrap_or(generic)
}

/// Returns the name without arguments such as `::<18>` at its end.
fn without_instance(name: &str) -> &str {
    let mut depth = 0;
    for (at, letter) in name.char_indices().rev() {
        match letter {
            // `->` of a function's type is not a closing bracket.
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
