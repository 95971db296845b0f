//! Classes of defaults: an attribute that an element leaves out is read from its class, then from the enclosing
//! classes.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::super::xml;
use crate::import::error::ImportError;

/// All classes of a file.
pub(super) struct Defaults<'a, 'd> {
    classes: Vec<Class<'a, 'd>>,
    places: BTreeMap<&'a str, usize>,
}

struct Class<'a, 'd> {
    around: Option<usize>,
    /// The `default` elements of this class; the last one is first, because it overrides the others.
    elements: Vec<Node<'a, 'd>>,
}

/// Index of the outermost class.
pub(super) const MAIN: usize = 0;

impl<'a, 'd> Defaults<'a, 'd> {
    pub(super) fn read(root: Node<'a, 'd>) -> Result<Self, ImportError> {
        let main = Class { around: None, elements: Vec::new() };
        let mut defaults = Self { classes: vec![main], places: BTreeMap::new() };
        let mut to_come: Vec<(Node<'a, 'd>, Option<usize>)> = Vec::new();
        to_come.extend(xml::children(root, "default").rev().map(|node| (node, None)));
        while let Some((node, around)) = to_come.pop() {
            let place = defaults.place(node, around)?;
            defaults.classes[place].elements.insert(0, node);
            to_come.extend(xml::children(node, "default").rev().map(|node| (node, Some(place))));
        }
        Ok(defaults)
    }

    /// Returns the index of a `default` element's class; creates the class if it is new.
    fn place(&mut self, node: Node<'a, 'd>, around: Option<usize>) -> Result<usize, ImportError> {
        let name = match around {
            None => node.attribute("class").unwrap_or("main"),
            Some(_) => xml::required(node, "class")?,
        };
        if let Some(place) = self.places.get(name) {
            return match around {
                None => Ok(*place),
                Some(_) => Err(xml::refuse_value(node, "class", "a name that no other class has")),
            };
        }
        if around.is_none() {
            self.places.insert(name, MAIN);
            return Ok(MAIN);
        }
        let place = self.classes.len();
        self.classes.push(Class { around, elements: Vec::new() });
        self.places.insert(name, place);
        Ok(place)
    }

    /// Returns the class that an attribute of an element names; `otherwise` without that attribute.
    pub(super) fn named(
        &self,
        node: Node<'a, 'd>,
        attribute: &str,
        otherwise: usize,
    ) -> Result<usize, ImportError> {
        let Some(name) = node.attribute(attribute) else { return Ok(otherwise) };
        match self.places.get(name) {
            Some(place) => Ok(*place),
            None if name == "main" => Ok(MAIN),
            None => Err(xml::refuse_value(node, attribute, "a class of the file's defaults")),
        }
    }

    /// Returns an element with its class's defaults for any of these tags. `around` is the class of the enclosing
    /// elements.
    pub(super) fn element(
        &self,
        node: Node<'a, 'd>,
        tags: &[&'static str],
        around: usize,
    ) -> Result<Element<'a, 'd>, ImportError> {
        let mut class = Some(self.named(node, "class", around)?);
        let mut nodes = vec![node];
        while let Some(Class { around, elements }) = class.map(|class| &self.classes[class]) {
            for tag in tags {
                let of_class =
                    elements.iter().flat_map(|element| xml::children(*element, tag).rev());
                nodes.extend(of_class);
            }
            class = *around;
        }
        Ok(Element { nodes })
    }
}

impl<'a, 'd> Defaults<'a, 'd> {
    /// Returns the defaults of an element's class for any of these tags, followed by the element itself. Later ones
    /// override earlier ones.
    pub(super) fn in_order(
        &self,
        node: Node<'a, 'd>,
        tags: &[&str],
    ) -> Result<Vec<Node<'a, 'd>>, ImportError> {
        let mut class = Some(self.named(node, "class", MAIN)?);
        let mut nodes = vec![node];
        while let Some(Class { around, elements }) = class.map(|class| &self.classes[class]) {
            for element in elements {
                let is_one = |child: &Node<'_, '_>| tags.contains(&child.tag_name().name());
                nodes.extend(element.children().rev().filter(is_one));
            }
            class = *around;
        }
        nodes.reverse();
        Ok(nodes)
    }
}

/// An element with its defaults.
pub(super) struct Element<'a, 'd> {
    /// The element itself, then the defaults of its class, then those of the enclosing classes.
    nodes: Vec<Node<'a, 'd>>,
}

impl<'a, 'd> Element<'a, 'd> {
    /// Returns the element itself.
    pub(super) fn node(&self) -> Node<'a, 'd> {
        self.nodes[0]
    }

    /// Returns the node that gives an attribute of this element; the element itself if no node does.
    pub(super) fn at(&self, name: &str) -> Node<'a, 'd> {
        self.at_any(&[name])
    }

    /// Returns the node that gives any of several attributes which exclude each other.
    pub(super) fn at_any(&self, names: &[&str]) -> Node<'a, 'd> {
        let gives = |node: &&Node<'_, '_>| names.iter().any(|name| node.has_attribute(*name));
        *self.nodes.iter().find(gives).unwrap_or(&self.nodes[0])
    }

    pub(super) fn text(&self, name: &str) -> Option<&'a str> {
        self.at(name).attribute(name).map(str::trim)
    }

    pub(super) fn number(&self, name: &str) -> Result<Option<f64>, ImportError> {
        xml::number(self.at(name), name)
    }

    pub(super) fn not_negative(&self, name: &str) -> Result<f64, ImportError> {
        Ok(xml::not_negative(self.at(name), name)?.unwrap_or(0.0))
    }

    pub(super) fn vector<const N: usize>(
        &self,
        name: &str,
    ) -> Result<Option<[f64; N]>, ImportError> {
        xml::vector(self.at(name), name)
    }

    /// Returns a range if it is a limit: if the flag `limited` is true or, without a decisive flag, if `auto_limits` is
    /// true and the range rises. Fails if the flag is true but the range does not rise.
    pub(super) fn range(
        &self,
        name: &str,
        limited: &str,
        auto_limits: bool,
    ) -> Result<Option<[f64; 2]>, ImportError> {
        let range = match xml::any_numbers(self.at(name), name, 2)?.as_deref() {
            None => None,
            Some([least, most]) => Some([*least, *most]),
            Some(_) => {
                let expected = "two numbers, the least and the most";
                return Err(xml::refuse_value(self.at(name), name, expected));
            }
        };
        let rises = range.filter(|[least, most]| least < most);
        match self.text(limited) {
            Some("false") => Ok(None),
            // MuJoCo takes a range that does not rise, such as `0 0`, as no range.
            None | Some("auto") => Ok(rises.filter(|_| auto_limits)),
            Some("true") => rises.map(Some).ok_or_else(|| {
                let expected = "two numbers, the least and the most";
                xml::refuse_value(self.at(name), name, expected)
            }),
            Some(_) => Err(xml::refuse_value(self.at(limited), limited, "true, false or auto")),
        }
    }
}
