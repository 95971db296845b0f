//! Converts a description to a mechanism: numbers the bodies, and merges those on fixed joints.

use glam::{DQuat, DVec3};

use super::mass::Mass;
use super::{Base, Body, BodyShape, Description, DescriptionError, Joint, JointType, LinkedLimit};
use crate::actuation::JointDefaults;
use crate::mechanism::{JointModel, Link, LinkedRange, Mechanism, MergedBody, Pose};

impl Description {
    /// Returns the bodies and joints by index. They are numbered depth first in the order of the joints; body 0 is the
    /// base; every body on a fixed joint is merged into its parent. If other joints follow a joint, its range, speed
    /// and acceleration are narrowed to values that the followers allow.
    ///
    /// # Errors
    /// Those of [`Self::check`].
    pub fn mechanism(&self) -> Result<Mechanism, DescriptionError> {
        let shape = self.checked()?;
        let of_servos = self.actuation()?.joint_defaults(self);
        let mut links = vec![self.base_link(&self.bodies[shape.base])];
        // Bodies whose joints are not yet visited, the next one last; each with its link, and its frame in that
        // link.
        let mut to_follow = vec![(shape.base, 0, Pose::IDENTITY)];
        // Joints in the order of the file, the next one last.
        let mut to_visit: Vec<(usize, usize, Pose)> = Vec::new();
        loop {
            for (body, link, frame) in to_follow.drain(..) {
                let joints = shape.joints_on[body].iter().rev();
                to_visit.extend(joints.map(|joint| (*joint, link, frame)));
            }
            let Some((index, parent, parent_frame)) = to_visit.pop() else { break };
            let joint = &self.joints[index];
            let body = &self.bodies[shape.child[index]];
            let frame = parent_frame.child(joint.position_m.into(), unit(joint.rotation_xyzw));
            if joint.kind == JointType::Fixed {
                merge(&mut links[parent], body, frame);
                to_follow.push((shape.child[index], parent, frame));
            } else {
                to_follow.push((shape.child[index], links.len(), Pose::IDENTITY));
                let servos = of_servos.get(index).copied().flatten();
                links.push(moved_link(joint, servos, body, parent, frame));
            }
        }
        let linked = self.limits.iter().filter_map(|limit| linked_range(limit, &links)).collect();
        let mut mechanism = Mechanism { bodies: links, linked };
        mechanism.narrow_leaders();
        Ok(mechanism)
    }

    fn base_link(&self, base: &Body) -> Link {
        let (joint, home) = match self.mount.base {
            Base::Fixed => (JointModel::Fixed, Vec::new()),
            Base::Driven => (JointModel::Free, JointModel::Free.zero()),
        };
        let rotation = unit(self.mount.rotation_xyzw);
        let frame = Pose { rotation, position_m: self.mount.position_m.into() };
        Link { joint, home, ..link(base, &base.name, None, frame) }
    }
}

/// Creates the link of a body on a joint. Values that the joint leaves out are those of its servos.
fn moved_link(
    joint: &Joint,
    servos: Option<JointDefaults>,
    body: &Body,
    parent: usize,
    frame: Pose,
) -> Link {
    let or_servos = |own: Option<f64>, of: fn(JointDefaults) -> f64, neither: f64| {
        own.or(servos.map(of)).unwrap_or(neither)
    };
    Link {
        joint: dof(joint),
        rotor_inertia: or_servos(joint.rotor_inertia, |servos| servos.rotor_inertia, 0.0),
        friction: joint.friction + servos.map_or(0.0, |servos| servos.friction),
        damping: joint.damping + servos.map_or(0.0, |servos| servos.damping),
        ranges: joint.range_m.map_or_else(|| joint.range_rad.clone(), |range| vec![range]),
        home: joint.home(),
        speed: or_servos(
            joint.speed_rad_s.or(joint.speed_m_s),
            |servos| servos.speed,
            f64::INFINITY,
        ),
        acceleration: joint
            .acceleration_rad_s2
            .or(joint.acceleration_m_s2)
            .unwrap_or(f64::INFINITY),
        effort: or_servos(joint.effort, |servos| servos.effort, f64::INFINITY),
        ..link(body, &joint.name, Some(parent), frame)
    }
}

/// Creates the link of a single body on a fixed joint without limits.
fn link(body: &Body, joint_name: &str, parent: Option<usize>, frame: Pose) -> Link {
    let mass = Mass::of(body);
    Link {
        name: body.name.clone(),
        joint_name: joint_name.to_owned(),
        rotation: frame.rotation,
        mass_kg: mass.kg,
        center_of_mass_m: mass.center_m,
        inertia_kg_m2: mass.inertia_kg_m2,
        shapes: shapes(body, Pose::IDENTITY),
        ..Link::on(parent, JointModel::Fixed, frame.position_m)
    }
}

/// Converts a linked limit; `None` if one of its joints does not move, which `check` refuses.
fn linked_range(limit: &LinkedLimit, links: &[Link]) -> Option<LinkedRange> {
    let body = |joint: &str| links.iter().skip(1).position(|link| link.joint_name == joint);
    Some(LinkedRange {
        body: 1 + body(&limit.joint)?,
        other: 1 + body(&limit.other)?,
        factor: limit.factor,
        other_factor: limit.other_factor,
        range: [
            limit.least_rad.or(limit.least_m).unwrap_or(f64::NEG_INFINITY),
            limit.most_rad.or(limit.most_m).unwrap_or(f64::INFINITY),
        ],
    })
}

/// Normalizes a quaternion. `check` has ensured a length near 1.
fn unit(rotation_xyzw: [f64; 4]) -> DQuat {
    DQuat::from_array(rotation_xyzw).normalize()
}

/// Adds a body that is bolted to a link; `frame` is the body's frame in the link's frame.
fn merge(link: &mut Link, body: &Body, frame: Pose) {
    let Pose { rotation, position_m } = frame;
    let so_far = Mass {
        kg: link.mass_kg,
        center_m: link.center_of_mass_m,
        inertia_kg_m2: link.inertia_kg_m2,
    };
    let mass = so_far.plus(Mass::of(body).seen_from(rotation, position_m));
    link.mass_kg = mass.kg;
    link.center_of_mass_m = mass.center_m;
    link.inertia_kg_m2 = mass.inertia_kg_m2;
    link.shapes.extend(shapes(body, frame));
    link.merged.push(MergedBody { name: body.name.clone(), position_m, rotation });
}

/// Returns the solids of a body whose frame is `frame` in a link. A body without solids is drawn as the box that has
/// its inertia.
fn shapes(body: &Body, frame: Pose) -> Vec<BodyShape> {
    let of_inertia = body
        .box_m
        .filter(|_| body.shapes.is_empty())
        .map(|size_m| BodyShape { position_m: body.center_of_mass_m, ..BodyShape::cuboid(size_m) });
    let all = body.shapes.iter().cloned().chain(of_inertia);
    all.map(|shape| {
        let Pose { rotation, position_m } =
            frame.child(shape.position_m.into(), unit(shape.rotation_xyzw));
        shape.at(position_m.to_array(), rotation.to_array())
    })
    .collect()
}

fn dof(joint: &Joint) -> JointModel {
    // `check` has ensured that the axes exist, are not zero, and are perpendicular.
    let unit = |axis: Option<[f64; 3]>| DVec3::from(axis.unwrap_or_default()).normalize_or_zero();
    match joint.kind {
        JointType::Fixed => JointModel::Fixed,
        JointType::Revolute => JointModel::Revolute(unit(joint.axis)),
        JointType::Prismatic => JointModel::Prismatic(unit(joint.axis)),
        JointType::Universal => {
            let (first, second) = (unit(joint.axis), unit(joint.second_axis));
            JointModel::Universal([first, second.reject_from_normalized(first).normalize_or_zero()])
        }
        JointType::Spherical => JointModel::Spherical,
        JointType::Free => JointModel::Free,
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

    use super::*;

    fn body(name: &str, mass_kg: f64) -> Body {
        Body { name: name.to_owned(), mass_kg, ..Body::default() }
    }

    fn joint(name: &str, kind: JointType, parent: &str, child: &str) -> Joint {
        let axis = (kind == JointType::Revolute).then_some([0.0, 0.0, 1.0]);
        let [name, parent, child] = [name, parent, child].map(str::to_owned);
        Joint { name, kind, parent, child, axis, ..Joint::default() }
    }

    fn rig(bodies: Vec<Body>, joints: Vec<Joint>) -> Description {
        Description { name: "rig".to_owned(), bodies, joints, ..Description::default() }
    }

    #[test]
    fn numbers_are_depth_first_in_the_order_of_the_file() {
        let names = ["hand", "base", "thumb", "elbow", "other"];
        let turn = |name, parent, child| joint(name, JointType::Revolute, parent, child);
        let rig = rig(
            names.map(|name| body(name, 1.0)).to_vec(),
            vec![
                turn("j0", "elbow", "hand"),
                turn("j1", "base", "elbow"),
                turn("j2", "base", "other"),
                turn("j3", "elbow", "thumb"),
            ],
        );
        let mechanism = rig.mechanism().unwrap();
        let found: Vec<_> =
            mechanism.bodies.iter().map(|link| (link.name.as_str(), link.parent)).collect();
        assert_eq!(
            found,
            [
                ("base", None),
                ("elbow", Some(0)),
                ("hand", Some(1)),
                ("thumb", Some(1)),
                ("other", Some(0))
            ]
        );
        assert_eq!(mechanism.dof_names(), ["j1", "j0", "j3", "j2"]);
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "small whole numbers")]
    fn a_body_on_a_fixed_joint_is_part_of_the_one_that_carries_it() {
        // Points of 1 kg at the origin and of 3 kg at x = 2: centre at 1.5, and 1 · 1.5² + 3 · 0.5² = 3 about y and
        // z. The frame of the second body is rotated by 90 deg about z, so its own x is the first body's y.
        let mut weld = joint("weld", JointType::Fixed, "arm", "tool");
        weld.position_m = [2.0, 0.0, 0.0];
        weld.rotation_xyzw = [0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2];
        let mut finger = joint("finger", JointType::Revolute, "tool", "tip");
        finger.position_m = [1.0, 0.0, 0.0];
        let mut bodies =
            vec![body("base", 5.0), body("arm", 1.0), body("tool", 3.0), body("tip", 1.0)];
        // A rod along the tool's x: zero about x, 0.3 about y and z. In the arm's frame the rod is along y.
        bodies[2].inertia_kg_m2 =
            Some(crate::description::InertiaMatrix { yy: 0.3, zz: 0.3, ..Default::default() });
        let joints = vec![joint("hinge", JointType::Revolute, "base", "arm"), weld, finger];
        let mechanism = rig(bodies, joints).mechanism().unwrap();
        let [base, arm, tip] = &mechanism.bodies[..] else { panic!("{mechanism:?}") };
        assert_eq!((base.mass_kg, base.merged.len()), (5.0, 0));
        // Tolerance for f64 rounding in a rotation by 90 deg.
        let near = |a: DVec3, b: DVec3| (a - b).length() < 1e-15;
        assert_eq!(arm.mass_kg, 4.0);
        assert!(near(arm.center_of_mass_m, DVec3::new(1.5, 0.0, 0.0)), "{arm:?}");
        let expected = [DVec3::X * 0.3, DVec3::Y * 3.0, DVec3::Z * 3.3];
        let inertia = arm.inertia_kg_m2;
        for (column, expected) in
            [inertia.x_axis, inertia.y_axis, inertia.z_axis].iter().zip(expected)
        {
            assert!((*column - expected).length() < 1e-15, "{inertia}");
        }
        assert_eq!(arm.merged[0].name, "tool");
        assert_eq!(arm.merged[0].position_m, DVec3::new(2.0, 0.0, 0.0));
        assert_eq!(tip.parent, Some(1));
        assert!(near(tip.position_m, DVec3::new(2.0, 1.0, 0.0)), "{tip:?}");
        let quarter = DQuat::from_rotation_z(FRAC_PI_2);
        assert!(tip.rotation.angle_between(quarter) < 1e-7, "{tip:?}");
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "small whole numbers")]
    fn bodies_welded_to_the_base_and_to_each_other_are_one() {
        let joints =
            vec![joint("a", JointType::Fixed, "x", "y"), joint("b", JointType::Fixed, "y", "z")];
        let mechanism =
            rig(vec![body("x", 1.0), body("y", 2.0), body("z", 4.0)], joints).mechanism().unwrap();
        assert_eq!(mechanism.bodies.len(), 1);
        assert_eq!(mechanism.bodies[0].mass_kg, 7.0);
        let names: Vec<_> = mechanism.bodies[0].merged.iter().map(|body| &body.name).collect();
        assert_eq!(names, ["y", "z"]);
    }

    #[test]
    fn a_box_has_the_inertia_of_one() {
        let mut link = body("link", 1.2);
        link.box_m = Some([0.0, 1.0, 0.1]);
        let mechanism = rig(vec![link], Vec::new()).mechanism().unwrap();
        let inertia = mechanism.bodies[0].inertia_kg_m2;
        // About x: m (1² + 0.1²) / 12.
        assert!((inertia.x_axis.x - 0.101).abs() < 1e-15);
        assert!((inertia.y_axis.y - 0.001).abs() < 1e-15);
        assert!((inertia.z_axis.z - 0.1).abs() < 1e-15);
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "small whole numbers")]
    fn shapes_are_in_the_frame_of_the_link_that_carries_them() {
        let mut weld = joint("weld", JointType::Fixed, "arm", "tool");
        weld.position_m = [2.0, 0.0, 0.0];
        weld.rotation_xyzw = [0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2];
        let mut bodies = vec![body("base", 1.0), body("arm", 1.0), body("tool", 0.0)];
        bodies[0].box_m = Some([1.0, 2.0, 3.0]);
        bodies[0].center_of_mass_m = [0.0, 1.0, 0.0];
        bodies[1].box_m = Some([1.0; 3]);
        bodies[1].shapes.push(BodyShape::sphere(0.5));
        let tip = BodyShape::cylinder(0.1, 1.0).at([1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]);
        bodies[2].shapes.push(tip);
        let joints = vec![joint("hinge", JointType::Revolute, "base", "arm"), weld];
        let mechanism = rig(bodies, joints).mechanism().unwrap();
        let [base, arm] = &mechanism.bodies[..] else { panic!("{mechanism:?}") };
        // Without solids, the box that has the inertia.
        assert_eq!(base.shapes[0].size_m, Some([1.0, 2.0, 3.0]));
        assert_eq!(base.shapes[0].position_m, [0.0, 1.0, 0.0]);
        assert_eq!(arm.shapes.len(), 2);
        assert_eq!(arm.shapes[0], BodyShape::sphere(0.5));
        let tip = DVec3::from(arm.shapes[1].position_m);
        assert!((tip - DVec3::new(2.0, 1.0, 0.0)).length() < 1e-15, "{tip}");
    }

    #[test]
    fn homes_are_as_given_or_near_zero() {
        let mut hinge = joint("hinge", JointType::Revolute, "x", "y");
        let mut home = |range: &[[f64; 2]], given| {
            hinge.range_rad = range.to_vec();
            hinge.home_rad = given;
            hinge.home()
        };
        assert_eq!(home(&[], None), [0.0]);
        assert_eq!(home(&[[-1.0, 1.0]], None), [0.0]);
        assert_eq!(home(&[[0.5, 1.0]], None), [0.5]);
        assert_eq!(home(&[[-1.0, -0.5]], None), [-0.5]);
        assert_eq!(home(&[[-1.0, 1.0]], Some(0.25)), [0.25]);
        let mut cardan = joint("cardan", JointType::Universal, "x", "y");
        cardan.range_rad = vec![[0.5, 1.0], [-1.0, 1.0]];
        assert_eq!(cardan.home(), [0.5, 0.0]);
    }
}
