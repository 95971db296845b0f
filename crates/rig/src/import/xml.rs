//! Reads elements and attributes. Errors name the position and the part that is wrong.

use std::borrow::Cow;

use glam::DQuat;
use roxmltree::{Document, Node};

use super::error::{ImportError, SourcePosition};

/// Maximum absolute value of a number. Larger numbers are regarded as damage: squares and products must stay
/// finite, in f32 too.
const NUMBER_MAX: f64 = 1e6;

/// Parses a text as XML. First refuses texts that would keep an XML parser busy for minutes.
///
/// # Errors
/// [`ImportError`] with line and column.
pub fn document(text: &str) -> Result<Document<'_>, ImportError> {
    refuse_slow(text)?;
    Document::parse(text).map_err(|error| {
        let expected = match &error {
            roxmltree::Error::UnknownNamespace(prefix, _) if prefix == "xacro" => XACRO.to_owned(),
            roxmltree::Error::UnknownNamespace(prefix, _) => {
                format!("xmlns:{prefix}=\"...\" in the first element, for the prefix `{prefix}`")
            }
            _ => "well-formed XML".to_owned(),
        };
        ImportError {
            place: error.pos().into(),
            item: "the file".to_owned(),
            expected,
            found: error.to_string(),
        }
    })
}

/// Returns the text with blanks in place of XML declarations that are not at its very beginning, which some writers put
/// after a blank line or a comment. All other characters keep their places.
pub(super) fn with_declaration_first(text: &str) -> Cow<'_, str> {
    const BEGIN: &str = "<?xml";
    let is_declaration = |at: &usize| {
        *at > 0 && text[at + BEGIN.len()..].starts_with(|c: char| c.is_ascii_whitespace())
    };
    let mut rest = 0;
    let mut plain = String::new();
    for at in text.match_indices(BEGIN).map(|(at, _)| at).filter(is_declaration) {
        let Some(length) = text[at..].find("?>").filter(|_| at >= rest) else { continue };
        plain.push_str(&text[rest..at]);
        rest = at + length + 2;
        plain.extend(text[at..rest].chars().map(|c| if c == '\n' { '\n' } else { ' ' }));
    }
    if rest == 0 {
        return Cow::Borrowed(text);
    }
    plain.push_str(&text[rest..]);
    Cow::Owned(plain)
}

/// Maximum number of prefixes in a file, and of attributes in an element. Real robots have fewer; parsing time
/// grows with the square of these numbers.
const NAMES_MAX: usize = 256;

/// Refuses a text that would keep an XML parser busy for minutes.
fn refuse_slow(text: &str) -> Result<(), ImportError> {
    let (mut prefixes, mut attributes) = (0, 0);
    for (byte, letter) in text.bytes().enumerate() {
        match letter {
            b'<' => attributes = 0,
            b'=' if followed_by_quote(text, byte) => attributes += 1,
            b'x' if text.as_bytes()[byte..].starts_with(b"xmlns") => prefixes += 1,
            _ => continue,
        }
        let (expected, found) = if prefixes > NAMES_MAX {
            ("name spaces (xmlns)", prefixes)
        } else if attributes > NAMES_MAX {
            ("attributes in an element", attributes)
        } else {
            continue;
        };
        let before = &text[..byte];
        let line = before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|letter| *letter != '\n').count() + 1;
        let at = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        return Err(ImportError {
            place: SourcePosition { line: at(line), column: at(column) },
            item: "the file".to_owned(),
            expected: format!("at most {NAMES_MAX} {expected}"),
            found: found.to_string(),
        });
    }
    Ok(())
}

/// Returns whether an attribute's value begins after this `=`.
fn followed_by_quote(text: &str, equals: usize) -> bool {
    let behind = text.as_bytes().get(equals + 1..).unwrap_or_default();
    behind.iter().find(|byte| !byte.is_ascii_whitespace()).is_some_and(|byte| b"\"'".contains(byte))
}

/// Instruction for a user whose file contains xacro macros.
pub(super) const XACRO: &str =
    "a URDF without macros: run `xacro FILE > robot.urdf` (package ros-xacro) and import that";

/// Creates an error for an element.
pub(super) fn refuse(
    node: Node<'_, '_>,
    expected: impl Into<String>,
    found: impl Into<String>,
) -> ImportError {
    refuse_at(node, node.range().start, label(node), expected, found)
}

/// Creates an error for an attribute, with its name and value.
pub(super) fn refuse_value(
    node: Node<'_, '_>,
    name: &str,
    expected: impl Into<String>,
) -> ImportError {
    let item = format!("{}: {name}", label(node));
    match node.attribute_node(name) {
        Some(attribute) => {
            let found = format!("`{}`", shortened(attribute.value()));
            refuse_at(node, attribute.range().start, item, expected, found)
        }
        None => refuse_at(node, node.range().start, item, expected, "none"),
    }
}

fn refuse_at(
    node: Node<'_, '_>,
    byte: usize,
    item: String,
    expected: impl Into<String>,
    found: impl Into<String>,
) -> ImportError {
    let place = SourcePosition::from(node.document().text_pos_at(byte));
    ImportError { place, item, expected: expected.into(), found: found.into() }
}

/// Returns a label for messages: the nearest enclosing name, then the elements inside it: ``joint `elbow`: limit``.
pub(super) fn label(node: Node<'_, '_>) -> String {
    let mut tags = Vec::new();
    for node in node.ancestors().filter(Node::is_element) {
        let tag = node.tag_name().name();
        if let Some(name) = node.attribute("name").filter(|name| !name.is_empty()) {
            tags.push(format!("{tag} `{}`", shortened(name)));
            break;
        }
        tags.push(tag.to_owned());
    }
    tags.reverse();
    tags.join(": ")
}

/// Returns the child elements with a tag.
pub(super) fn children<'a, 'd>(
    node: Node<'a, 'd>,
    tag: &'static str,
) -> impl DoubleEndedIterator<Item = Node<'a, 'd>> {
    node.children().filter(move |child| child.has_tag_name(tag))
}

/// Returns the child element with a tag, or `None`; fails if there are several.
pub(super) fn child<'a, 'd>(
    node: Node<'a, 'd>,
    tag: &'static str,
) -> Result<Option<Node<'a, 'd>>, ImportError> {
    let mut found = children(node, tag);
    let first = found.next();
    match found.next() {
        None => Ok(first),
        Some(second) => Err(refuse(second, "one element of this name", "a second one")),
    }
}

/// Reads an attribute that must be present and not empty.
pub(super) fn required<'a>(node: Node<'a, '_>, name: &str) -> Result<&'a str, ImportError> {
    node.attribute(name)
        .filter(|value| !value.trim().is_empty())
        .ok_or_else(|| refuse_value(node, name, format!("an attribute `{name}` with a value")))
}

/// Reads a number; `None` without the attribute.
pub(super) fn number(node: Node<'_, '_>, name: &str) -> Result<Option<f64>, ImportError> {
    Ok(vector::<1>(node, name)?.map(|[number]| number))
}

/// Reads a number that must not be negative; `None` without the attribute.
pub(super) fn not_negative(node: Node<'_, '_>, name: &str) -> Result<Option<f64>, ImportError> {
    match number(node, name)? {
        Some(value) if value < 0.0 => Err(refuse_value(node, name, "a number of zero or more")),
        value => Ok(value),
    }
}

/// Reads exactly `N` numbers separated by white space; `None` without the attribute.
pub(super) fn vector<const N: usize>(
    node: Node<'_, '_>,
    name: &str,
) -> Result<Option<[f64; N]>, ImportError> {
    let Some(found) = numbers(node, name, N)? else { return Ok(None) };
    match <[f64; N]>::try_from(found) {
        Ok(numbers) => Ok(Some(numbers)),
        Err(_) => {
            Err(refuse_value(node, name, counted(N) + &format!(" of at most {NUMBER_MAX:e}")))
        }
    }
}

/// Reads at most `count` numbers separated by white space; `None` without the attribute.
pub(super) fn numbers(
    node: Node<'_, '_>,
    name: &str,
    count: usize,
) -> Result<Option<Vec<f64>>, ImportError> {
    let right = |number: f64| number.abs() <= NUMBER_MAX;
    numbers_that(node, name, count, right, &format!(" of at most {NUMBER_MAX:e}"))
}

/// Reads numbers that may be of any size, or infinite, because such a number stands for "none".
pub(super) fn any_numbers(
    node: Node<'_, '_>,
    name: &str,
    count: usize,
) -> Result<Option<Vec<f64>>, ImportError> {
    numbers_that(node, name, count, |number| !number.is_nan(), "")
}

/// Reads a number of any size; `None` without the attribute.
pub(super) fn any_number(node: Node<'_, '_>, name: &str) -> Result<Option<f64>, ImportError> {
    match any_numbers(node, name, 1)?.as_deref() {
        None => Ok(None),
        Some([number]) => Ok(Some(*number)),
        Some(_) => Err(refuse_value(node, name, "a number")),
    }
}

fn numbers_that(
    node: Node<'_, '_>,
    name: &str,
    count: usize,
    right: impl Fn(f64) -> bool,
    bound: &str,
) -> Result<Option<Vec<f64>>, ImportError> {
    let Some(text) = node.attribute(name) else { return Ok(None) };
    let number = |word: &str| word.parse().ok().filter(|number| right(*number));
    let numbers: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
    match numbers.filter(|numbers| numbers.len() <= count) {
        // Adding zero converts -0 to 0.
        Some(numbers) => Ok(Some(numbers.into_iter().map(|number| number + 0.0).collect())),
        None => Err(refuse_value(node, name, counted(count) + bound)),
    }
}

/// Describes a number of numbers.
fn counted(count: usize) -> String {
    if count == 1 { "a number".to_owned() } else { format!("{count} numbers") }
}
/// Returns a unit quaternion with w >= 0 and without -0, so that each rotation has only one form.
pub(super) fn tidy(rotation: DQuat) -> DQuat {
    let unit = rotation.normalize();
    let unit = if unit.w < 0.0 { -unit } else { unit };
    DQuat::from_array(unit.to_array().map(|number| number + 0.0))
}

/// Shortens a long value for a message.
pub(super) fn shortened(text: &str) -> String {
    const SHOWN: usize = 60;
    let mut shown: String = text.chars().take(SHOWN).collect();
    if shown.len() < text.len() {
        shown.push_str("...");
    }
    shown
}
