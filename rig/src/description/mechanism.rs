//! From names to indices: regular numbering, and bodies on fixed joints merged.

use glam::{DQuat, DVec3};

use super::mass::Mass;
use super::{Base, Body, Description, DescriptionError, Joint, JointType};
use crate::mechanism::{Freedom, Link, Mechanism, MergedBody};

/// Where a frame is in another.
#[derive(Debug, Clone, Copy)]
struct Frame {
    rotation: DQuat,
    position_m: DVec3,
}

impl Frame {
    const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, position_m: DVec3::ZERO };

    fn new(position_m: [f64; 3], rotation_xyzw: [f64; 4]) -> Self {
        // `check` has seen a length near 1.
        let rotation = DQuat::from_array(rotation_xyzw).normalize();
        Self { rotation, position_m: position_m.into() }
    }

    /// Where a frame is that is so in this one.
    fn then(self, inner: Self) -> Self {
        Self {
            rotation: (self.rotation * inner.rotation).normalize(),
            position_m: self.position_m + self.rotation * inner.position_m,
        }
    }
}

impl Description {
    /// The bodies and joints by index: depth first in the order of the joints, body 0 the base, and every body on a
    /// fixed joint merged into the one that carries it.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn mechanism(&self) -> Result<Mechanism, DescriptionError> {
        let shape = self.checked()?;
        let mut links = vec![self.base_link(&self.bodies[shape.base])];
        // Bodies whose joints are to be followed, the next one last; each with its link, and its frame in that.
        let mut to_follow = vec![(shape.base, 0, Frame::IDENTITY)];
        // Joints in the order of the file, the next one last.
        let mut to_visit: Vec<(usize, usize, Frame)> = Vec::new();
        loop {
            for (body, link, frame) in to_follow.drain(..) {
                let joints = shape.joints_on[body].iter().rev();
                to_visit.extend(joints.map(|joint| (*joint, link, frame)));
            }
            let Some((index, parent, parent_frame)) = to_visit.pop() else { break };
            let joint = &self.joints[index];
            let body = &self.bodies[shape.child[index]];
            let frame = parent_frame.then(Frame::new(joint.position_m, joint.rotation_xyzw));
            if joint.kind == JointType::Fixed {
                merge(&mut links[parent], body, frame);
                to_follow.push((shape.child[index], parent, frame));
            } else {
                to_follow.push((shape.child[index], links.len(), Frame::IDENTITY));
                links.push(self.moved_link(joint, body, parent, frame));
            }
        }
        Ok(Mechanism { bodies: links })
    }

    fn base_link(&self, base: &Body) -> Link {
        let (joint, home) = match self.mount.base {
            Base::Fixed => (Freedom::Fixed, Vec::new()),
            Base::Driven => (Freedom::Free, vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        };
        let frame = Frame::new(self.mount.position_m, self.mount.rotation_xyzw);
        Link { joint, home, ..link(base, &base.name, None, frame) }
    }

    fn moved_link(&self, joint: &Joint, body: &Body, parent: usize, frame: Frame) -> Link {
        let limit = |turn: Option<f64>, slide| turn.or(slide).unwrap_or(f64::INFINITY);
        Link {
            joint: freedom(joint),
            rotor_inertia: self.rotor_inertia(joint),
            friction: joint.friction,
            damping: joint.damping,
            ranges: joint.range_m.map_or_else(|| joint.range_rad.clone(), |range| vec![range]),
            home: joint.home(),
            speed: limit(joint.speed_rad_s, joint.speed_m_s),
            acceleration: limit(joint.acceleration_rad_s2, joint.acceleration_m_s2),
            effort: limit(joint.effort, None),
            ..link(body, &joint.name, Some(parent), frame)
        }
    }

    /// What rotors add to the inertia of each freedom of a joint, kg m² or kg.
    #[expect(clippy::unused_self, reason = "the servos that move the joint are the rig's")]
    fn rotor_inertia(&self, joint: &Joint) -> f64 {
        joint.rotor_inertia.unwrap_or(0.0)
    }
}

/// A body alone on a joint that leaves nothing free and has no limits.
fn link(body: &Body, joint_name: &str, parent: Option<usize>, frame: Frame) -> Link {
    let mass = Mass::of(body);
    Link {
        name: body.name.clone(),
        joint_name: joint_name.to_owned(),
        parent,
        joint: Freedom::Fixed,
        position_m: frame.position_m,
        rotation: frame.rotation,
        mass_kg: mass.kg,
        center_of_mass_m: mass.center_m,
        inertia_kg_m2: mass.inertia_kg_m2,
        merged: Vec::new(),
        rotor_inertia: 0.0,
        friction: 0.0,
        damping: 0.0,
        ranges: Vec::new(),
        home: Vec::new(),
        speed: f64::INFINITY,
        acceleration: f64::INFINITY,
        effort: f64::INFINITY,
    }
}

/// Adds a body that is bolted to a link, its frame being so in the link's.
fn merge(link: &mut Link, body: &Body, frame: Frame) {
    let Frame { rotation, position_m } = frame;
    let so_far = Mass {
        kg: link.mass_kg,
        center_m: link.center_of_mass_m,
        inertia_kg_m2: link.inertia_kg_m2,
    };
    let mass = so_far.plus(Mass::of(body).seen_from(rotation, position_m));
    link.mass_kg = mass.kg;
    link.center_of_mass_m = mass.center_m;
    link.inertia_kg_m2 = mass.inertia_kg_m2;
    link.merged.push(MergedBody { name: body.name.clone(), position_m, rotation });
}

fn freedom(joint: &Joint) -> Freedom {
    // `check` has seen that the axes are there, not zero, and at right angles.
    let unit = |axis: Option<[f64; 3]>| DVec3::from(axis.unwrap_or_default()).normalize_or_zero();
    match joint.kind {
        JointType::Fixed => Freedom::Fixed,
        JointType::Revolute => Freedom::Revolute(unit(joint.axis)),
        JointType::Prismatic => Freedom::Prismatic(unit(joint.axis)),
        JointType::Universal => {
            let (first, second) = (unit(joint.axis), unit(joint.second_axis));
            Freedom::Universal([first, second.reject_from_normalized(first).normalize_or_zero()])
        }
        JointType::Spherical => Freedom::Spherical,
        JointType::Free => Freedom::Free,
    }
}
