//! Elements of a body in an MJCF.

use roxmltree::Node;

use super::defaults::Element;
use super::model::Model;
use super::pose::Pose;
use crate::import::error::ImportError;

/// The elements of a body, including those in its `frame` elements, each with the frame's pose in the body.
pub(super) struct Parts<'a, 'd> {
    pub(super) node: Node<'a, 'd>,
    pub(super) inertial: Option<(Node<'a, 'd>, Pose)>,
    pub(super) geoms: Vec<(Element<'a, 'd>, Pose)>,
    pub(super) joints: Vec<(Element<'a, 'd>, Pose)>,
    /// Child bodies, with their class.
    pub(super) bodies: Vec<(Node<'a, 'd>, Pose, usize)>,
}

impl<'a, 'd> Parts<'a, 'd> {
    pub(super) fn name(&self) -> Option<&'a str> {
        self.node.attribute("name").filter(|name| !name.is_empty())
    }

    /// Returns the names of the body and its joints.
    pub(super) fn names(&self) -> impl Iterator<Item = &'a str> {
        let joints = self.joints.iter().map(|(joint, _)| joint.node());
        std::iter::once(self.node).chain(joints).filter_map(|node| node.attribute("name"))
    }

    pub(super) fn read(
        node: Node<'a, 'd>,
        class: usize,
        model: &Model<'a, 'd, '_>,
    ) -> Result<Self, ImportError> {
        let (inertial, geoms, joints, bodies) = (None, Vec::new(), Vec::new(), Vec::new());
        let mut parts = Self { node, inertial, geoms, joints, bodies };
        let mut to_come = vec![(node, Pose::IDENTITY, class)];
        while let Some((outer, frame, class)) = to_come.pop() {
            let mut frames = Vec::new();
            for node in outer.children().filter(Node::is_element) {
                match node.tag_name().name() {
                    "inertial" => {
                        parts.inertial = Some((node, frame));
                    }
                    "geom" => {
                        parts.geoms.push((model.defaults.element(node, &["geom"], class)?, frame));
                    }
                    "joint" | "freejoint" => {
                        parts
                            .joints
                            .push((model.defaults.element(node, &["joint"], class)?, frame));
                    }
                    "body" => {
                        let class = model.defaults.named(node, "childclass", class)?;
                        parts.bodies.push((node, frame, class));
                    }
                    "frame" => {
                        let class = model.defaults.named(node, "childclass", class)?;
                        frames.push((node, frame.then(model.angles.pose(node)?), class));
                    }
                    _ => {}
                }
            }
            to_come.extend(frames.into_iter().rev());
        }
        Ok(parts)
    }
}
