//! The crate `dynibo`. It uses f64 and models from URDF, so a spherical joint is three revolute joints with massless
//! links between them. It is called in its fastest documented way: a robot with its own workspace, output into a
//! slice, no allocation.

use std::fmt::Write as _;
use std::hint::black_box;

use dynibo::{BaseState, FloatingRobot, Frame, Twist};
use sinew_core::glam::{DVec3, EulerRot};
use sinew_core::{Body, Inertia, Transform};

use crate::Contender;
use crate::motion::{RigMotion, Turn, axes};

pub(crate) struct Dynibo {
    robot: FloatingRobot,
    base: BaseState,
    /// For each joint in the crate's order: our joint, and the number of the turn.
    order: Vec<(usize, usize)>,
    q: Vec<f64>,
    qd: Vec<f64>,
    qdd: Vec<f64>,
    forces: Vec<f64>,
}

impl Dynibo {
    pub(crate) fn new(bodies: &[Body]) -> Result<Self, Box<dyn std::error::Error>> {
        let path = std::env::temp_dir().join(format!("sinew-bench-{}.urdf", std::process::id()));
        std::fs::write(&path, urdf(bodies)?)?;
        let robot = FloatingRobot::from_urdf(&path);
        std::fs::remove_file(&path)?;
        let robot = robot?;
        let count = robot.joint_count();
        let order = (0..count).map(|dof| indices(robot.joint_name(dof)?));
        let order = order.collect::<Result<Vec<_>, Box<dyn std::error::Error>>>()?;
        Ok(Self {
            base: BaseState::stationary(Frame::identity())?,
            order,
            q: vec![0.0; count],
            qd: vec![0.0; count],
            qdd: vec![0.0; count],
            forces: vec![0.0; robot.generalized_count()],
            robot,
        })
    }
}

impl Contender for Dynibo {
    fn name(&self) -> &'static str {
        "dynibo 0.5"
    }

    fn set(&mut self, motion: &RigMotion) {
        let root = &motion.root;
        let vector = |v: DVec3| v.to_array().into();
        let frame = Frame::new(vector(root.translation_m), vector(root.rotation.to_scaled_axis()));
        self.base = BaseState::new(
            frame,
            Twist::new(vector(root.angular_velocity), vector(root.linear_velocity)),
            Twist::new(vector(root.angular_acceleration), vector(root.linear_acceleration)),
        )
        .expect("the root's state is finite");
        for (dof, &(joint, turn)) in self.order.iter().enumerate() {
            let Turn { angle_rad, velocity_rad_s, acceleration_rad_s2, .. } =
                motion.turns[joint - 1][turn];
            self.q[dof] = angle_rad;
            self.qd[dof] = velocity_rad_s;
            self.qdd[dof] = acceleration_rad_s2;
        }
    }

    fn run(&mut self) {
        self.robot
            .inverse_dynamics(
                black_box(&self.base),
                black_box(&self.q),
                black_box(&self.qd),
                black_box(&self.qdd),
                &[],
                &mut self.forces,
            )
            .expect("its inputs are finite and of the right lengths");
        black_box(&self.forces);
    }

    fn torques(&self, motion: &RigMotion) -> Vec<f64> {
        let (root, joints) = self.forces.split_at(6);
        let mut by_turn: Vec<_> = self.order.iter().zip(joints).collect();
        by_turn.sort_by_key(|(place, _)| **place);
        debug_assert_eq!(joints.len(), motion.turns.iter().map(Vec::len).sum::<usize>());
        root.iter().copied().chain(by_turn.into_iter().map(|(_, torque)| *torque)).collect()
    }
}

/// Writes the rig as URDF: link `b3` is our body 3; joint `j3_1` is its second turn.
fn urdf(bodies: &[Body]) -> Result<String, std::fmt::Error> {
    let mut text = String::from("<robot name=\"rig\">\n");
    for (index, body) in bodies.iter().enumerate() {
        write_link(&mut text, &format!("b{index}"), &body.inertia)?;
        let Some(parent) = body.parent else { continue };
        let turns = axes(body.joint);
        let mut outer = format!("b{parent}");
        for (turn, axis) in turns.iter().enumerate() {
            let last = turn + 1 == turns.len();
            let inner = if last { format!("b{index}") } else { format!("b{index}_{turn}") };
            if !last {
                write_link(&mut text, &inner, &Inertia::default())?;
            }
            let origin = if turn == 0 { body.placement } else { Transform::IDENTITY };
            write_joint(&mut text, &format!("j{index}_{turn}"), &outer, &inner, origin, *axis)?;
            outer = inner;
        }
    }
    text.push_str("</robot>\n");
    Ok(text)
}

fn write_link(text: &mut String, name: &str, inertia: &Inertia) -> std::fmt::Result {
    let (center, about) = (inertia.center_of_mass_m.as_dvec3(), &inertia.rotational_kg_m2);
    let [xx, xy, xz, yy, yz, zz] =
        [about.xx, about.xy, about.xz, about.yy, about.yz, about.zz].map(f64::from);
    writeln!(
        text,
        "<link name=\"{name}\"><inertial><origin xyz=\"{} {} {}\"/><mass value=\"{}\"/>\
         <inertia ixx=\"{xx}\" ixy=\"{xy}\" ixz=\"{xz}\" iyy=\"{yy}\" iyz=\"{yz}\" izz=\"{zz}\"/>\
         </inertial></link>",
        center.x,
        center.y,
        center.z,
        f64::from(inertia.mass_kg),
    )
}

fn write_joint(
    text: &mut String,
    name: &str,
    outer: &str,
    inner: &str,
    origin: Transform,
    axis: DVec3,
) -> std::fmt::Result {
    let at = origin.translation_m.as_dvec3();
    let (yaw, pitch, roll) = origin.rotation.as_dquat().to_euler(EulerRot::ZYX);
    writeln!(
        text,
        "<joint name=\"{name}\" type=\"continuous\"><parent link=\"{outer}\"/><child link=\"{inner}\"/>\
         <origin xyz=\"{} {} {}\" rpy=\"{roll} {pitch} {yaw}\"/><axis xyz=\"{} {} {}\"/>\
         <limit effort=\"1\" velocity=\"1\"/></joint>",
        at.x, at.y, at.z, axis.x, axis.y, axis.z,
    )
}

/// Returns our joint and its turn from a name of [`urdf`].
fn indices(name: &str) -> Result<(usize, usize), Box<dyn std::error::Error>> {
    let (joint, turn) = name
        .strip_prefix('j')
        .and_then(|rest| rest.split_once('_'))
        .ok_or_else(|| format!("unknown joint {name}"))?;
    Ok((joint.parse()?, turn.parse()?))
}
