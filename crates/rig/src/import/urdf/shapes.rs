//! Reads the solids that are drawn for a link.

use roxmltree::Node;

use super::super::xml;
use super::link::solid;
use crate::description::BodyShape;

/// Returns the solids of a link's `visual` elements; without any, those of `collision`, since a mesh is not read. A
/// solid that cannot be drawn is left out.
pub(super) fn of_link(link: Node<'_, '_>) -> Vec<BodyShape> {
    let of = |tag| xml::children(link, tag).filter_map(shape).collect::<Vec<_>>();
    let visual = of("visual");
    if visual.is_empty() { of("collision") } else { visual }
}

fn shape(node: Node<'_, '_>) -> Option<BodyShape> {
    let (solid, (position, rotation)) = solid(node).ok().flatten()?;
    let shape = solid.shape()?;
    Some(BodyShape {
        color_rgb: color(node),
        ..shape.at(position.to_array(), xml::tidy(rotation).to_array())
    })
}

/// Returns the colour of a `visual`: its own, or that of the robot's material with the name.
fn color(visual: Node<'_, '_>) -> Option<[f64; 3]> {
    let material = xml::children(visual, "material").next()?;
    let name = material.attribute("name");
    let mut of_robot = xml::children(visual.document().root_element(), "material");
    let named = name.and_then(|name| of_robot.find(|other| other.attribute("name") == Some(name)));
    [Some(material), named].into_iter().flatten().find_map(|material| {
        let color = xml::children(material, "color").next()?;
        let [red, green, blue, _] = xml::vector(color, "rgba").ok().flatten()?;
        Some([red, green, blue].map(|share: f64| share.clamp(0.0, 1.0)))
    })
}
