//! Puts the parts of an MJCF that are in other files in the places of their `include` elements.

use std::cell::RefCell;
use std::collections::BTreeSet;

use roxmltree::Node;

use super::super::error::ImportError;
use super::super::xml;

/// Maximum depth of parts in parts. The next constant is the maximum size of the whole text in bytes. No robot is near
/// these bounds.
const DEPTH_MAX: usize = 8;
const BYTES_MAX: usize = 16 << 20;

/// Reads the text of a part by its name in the file, which is a relative path without `..`.
pub type LoadPart<'a> = &'a dyn Fn(&str) -> Result<String, String>;

/// State of the expansion.
struct Parts<'a> {
    load: LoadPart<'a>,
    /// Files that are included. MuJoCo, too, includes each file once.
    names: RefCell<BTreeSet<String>>,
}

/// Returns the text with all its parts.
pub(super) fn expand(text: &str, load: LoadPart<'_>) -> Result<String, ImportError> {
    Parts { load, names: RefCell::default() }.expand(text, 0)
}

impl Parts<'_> {
    fn expand(&self, text: &str, depth: usize) -> Result<String, ImportError> {
        let text = &*xml::with_declaration_first(text);
        let document = xml::document(text)?;
        let mut whole = String::with_capacity(text.len());
        let mut end = 0;
        for node in document.descendants().filter(|node| node.has_tag_name("include")) {
            let range = node.range();
            // An element within an include has no meaning.
            if range.start < end {
                continue;
            }
            whole.push_str(text.get(end..range.start).unwrap_or_default());
            whole.push_str(&self.part(node, depth)?);
            end = range.end;
            if whole.len() > BYTES_MAX {
                let expected = format!("at most {BYTES_MAX} bytes with all parts");
                return Err(xml::refuse(node, expected, format!("{} bytes", whole.len())));
            }
        }
        whole.push_str(text.get(end..).unwrap_or_default());
        Ok(whole)
    }

    /// Returns the content of a part's first element.
    fn part(&self, node: Node<'_, '_>, depth: usize) -> Result<String, ImportError> {
        let name = xml::required(node, "file")?.trim();
        let steps = name.split(['/', '\\']);
        let is_below =
            !name.contains(':') && steps.clone().all(|step| !step.is_empty() && step != "..");
        if !is_below {
            return Err(xml::refuse_value(node, "file", "a file in the same folder or below"));
        }
        if depth >= DEPTH_MAX {
            let expected = format!("parts in parts down to a depth of {DEPTH_MAX}");
            return Err(xml::refuse(node, expected, "a deeper one"));
        }
        if !self.names.borrow_mut().insert(name.to_owned()) {
            return Err(xml::refuse(node, "each file once", format!("`{name}` a second time")));
        }
        let text = (self.load)(name).map_err(|reason| {
            xml::refuse(node, "a file that can be read", format!("`{name}`: {reason}"))
        })?;
        if text.len() > BYTES_MAX {
            let expected = format!("at most {BYTES_MAX} bytes with all parts");
            return Err(xml::refuse(node, expected, format!("{} bytes in `{name}`", text.len())));
        }
        let of_part =
            |error: ImportError| ImportError { item: format!("{name}: {}", error.item), ..error };
        let text = self.expand(&text, depth + 1).map_err(of_part)?;
        let document = xml::document(&text).map_err(of_part)?;
        let root = document.root_element();
        if !root.has_tag_name("mujoco") && !root.has_tag_name("mujocoinclude") {
            let found = format!("`{}` in {name}", root.tag_name().name());
            return Err(xml::refuse(
                node,
                "a part of an MJCF (`mujoco` or `mujocoinclude`)",
                found,
            ));
        }
        let ends = root.first_child().zip(root.last_child());
        let range = ends.map(|(first, last)| first.range().start..last.range().end);
        Ok(range.and_then(|range| text.get(range)).unwrap_or_default().to_owned())
    }
}
