//! Reads the solids that are drawn for a link.

use roxmltree::Node;

use super::super::xml;
use super::link::solid;
use crate::description::BodyShape;

/// Returns the solids of a link's `visual` elements. If none of these is a solid (meshes are not read), returns the
/// solids of the `collision` elements. Solids that cannot be drawn are left out.
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

/// Returns the colour of a `visual`: its own, or that of the robot's material of the same name.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::urdf;

    #[test]
    fn a_link_is_drawn_by_its_visuals_or_else_by_its_collisions() {
        let link = |name: &str, shapes: &str| format!("<link name='{name}'>{shapes}</link>");
        let element = |tag: &str, shape: &str| {
            format!("<{tag}><origin xyz='1 0 0'/><geometry>{shape}</geometry></{tag}>")
        };
        let ball = element("visual", "<sphere radius='2'/>");
        let painted = ball.replace("</visual>", "<material name='red'/></visual>");
        let mesh = element("visual", "<mesh filename='a.stl'/>");
        let text = format!(
            "<robot name='r'><material name='red'><color rgba='1 0 0 1'/></material>{}{}
             <joint name='j' type='revolute'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/>
             <limit lower='-1' upper='1' effort='1' velocity='1'/></joint></robot>",
            link("a", &(painted + &element("collision", "<box size='1 1 1'/>"))),
            link("b", &(mesh + &element("collision", "<cylinder radius='1' length='3'/>"))),
        );
        let bodies = urdf(&text, &crate::import::Options::default()).unwrap().description.bodies;
        let [ball] = &bodies[0].shapes[..] else { panic!("{bodies:?}") };
        assert_eq!((ball.radius_m, ball.position_m), (Some(2.0), [1.0, 0.0, 0.0]));
        assert_eq!(ball.color_rgb, Some([1.0, 0.0, 0.0]));
        let expected = BodyShape::cylinder(1.0, 3.0).at([1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]);
        assert_eq!(bodies[1].shapes, [expected]);
    }
}
