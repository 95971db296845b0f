//! Converts messages of serde and toml to sentences for the author of the file.

use std::fmt::Display;

/// Names of types in serde's messages, each with the words that replace it for the author of a file.
const PLAIN: [(&str, &str); 13] = [
    ("u8", "a whole number from 0 to 255"),
    ("u16", "a whole number from 0 to 65535"),
    ("u32", "a whole number from 0 to 4294967295"),
    ("u64", "a whole number, 0 or more"),
    ("usize", "a whole number, 0 or more"),
    ("i64", "a whole number"),
    ("f32", "a number"),
    ("f64", "a number"),
    ("a boolean", "true or false"),
    ("a string", "a text in quotes"),
    ("a sequence", "a list in square brackets"),
    ("string only", "a name in quotes"),
    ("a map", "a table of keys"),
];

/// Returns the message of an error of serde or toml, without names of types.
pub fn parse_message(error: &impl Display) -> String {
    let message = error.to_string().replace("wanted string or table", "expected a name in quotes");
    let Some((told, expected)) = message.rsplit_once("expected ") else { return message };
    let (expected, rest) = expected.split_once('\n').map_or((expected, ""), |(a, b)| (a, b));
    let words = PLAIN.iter().find(|(name, _)| *name == expected).map(|(_, words)| *words);
    let words = match words {
        Some(words) => words,
        None if expected.starts_with("struct ") => "a table of keys",
        None => return message,
    };
    let end = if rest.is_empty() { String::new() } else { format!("\n{rest}") };
    let line = if message.ends_with('\n') && end.is_empty() { "\n" } else { "" };
    format!("{told}expected {words}{end}{line}")
}
