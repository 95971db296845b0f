//! Reads the solids that are drawn for a body.

use glam::DVec3;
use roxmltree::Node;

use super::super::xml;
use super::defaults::Element;
use super::mass::solid;
use super::model::Model;
use super::parts::Parts;
use super::pose::Pose;
use crate::description::BodyShape;

/// Groups from this one on are hidden in MuJoCo's viewer: models keep their geoms for contacts there.
const HIDDEN_FROM: f64 = 3.0;

/// Returns the solids of a body's visible geoms. If none of these is a solid (meshes are not read), returns the solids
/// of all geoms. Solids that cannot be drawn are left out. `shift_m` is the origin of the rig's body in the frame of
/// the file's body.
pub(super) fn of_body(
    parts: &Parts<'_, '_>,
    shift_m: DVec3,
    model: &Model<'_, '_, '_>,
) -> Vec<BodyShape> {
    let of = |is_drawn: fn(f64) -> bool| -> Vec<BodyShape> {
        let group = |geom: &Element<'_, '_>| geom.number("group").ok().flatten().unwrap_or(0.0);
        let drawn = parts.geoms.iter().filter(|(geom, _)| is_drawn(group(geom)));
        drawn.filter_map(|(geom, frame)| shape(geom, *frame, shift_m, model)).collect()
    };
    let seen = of(|group| group < HIDDEN_FROM);
    if seen.is_empty() { of(|_| true) } else { seen }
}

fn shape(
    geom: &Element<'_, '_>,
    frame: Pose,
    shift_m: DVec3,
    model: &Model<'_, '_, '_>,
) -> Option<BodyShape> {
    let (solid, pose) = solid(geom, model).ok().flatten()?;
    let shape = solid.shape()?;
    let pose = frame.then(pose);
    let position_m = (pose.position_m - shift_m).to_array();
    Some(BodyShape {
        color_rgb: color(geom),
        ..shape.at(position_m, xml::tidy(pose.rotation).to_array())
    })
}

/// Returns the colour of a geom: its own, or that of its material.
fn color(geom: &Element<'_, '_>) -> Option<[f64; 3]> {
    let own = || geom.vector("rgba").ok().flatten();
    let of_material = || {
        let name = geom.text("material")?;
        let root = geom.node().document().root_element();
        let materials = root.descendants().filter(|node| node.has_tag_name("material"));
        let mut named =
            materials.filter(|node: &Node<'_, '_>| node.attribute("name") == Some(name));
        xml::vector(named.next()?, "rgba").ok().flatten()
    };
    let [red, green, blue, _]: [f64; 4] = own().or_else(of_material)?;
    Some([red, green, blue].map(|share| share.clamp(0.0, 1.0)))
}

#[cfg(test)]
mod tests {
    use crate::description::BodyShape;
    use crate::import::mjcf;

    #[test]
    fn a_body_is_drawn_by_its_seen_geoms_or_else_by_all() {
        let text = r#"<mujoco><asset><material name="green" rgba="0 1 0 1"/></asset><worldbody>
            <body name="a"><freejoint/>
              <geom type="box" size="0.5 1 2" material="green"/>
              <geom type="sphere" size="0.9" group="3"/>
              <body name="b" pos="0 0 1"><joint axis="0 0 1" pos="0 0 0.25"/>
                <geom type="capsule" size="0.1 0.5" pos="0 0 1" group="3" rgba="1 0 0 1"/>
              </body>
            </body></worldbody></mujoco>"#;
        let bodies = mjcf(text, &crate::import::Options::default()).unwrap().description.bodies;
        let level = [0.0, 0.0, 0.0, 1.0];
        let block = BodyShape::cuboid([1.0, 2.0, 4.0]).colored([0.0, 1.0, 0.0]);
        assert_eq!(bodies[0].shapes, [block]);
        // The body's frame is at its joint.
        let rod = BodyShape::capsule(0.1, 1.0).at([0.0, 0.0, 0.75], level);
        assert_eq!(bodies[1].shapes, [rod.colored([1.0, 0.0, 0.0])]);
    }
}
