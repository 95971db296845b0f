//! Programs with foreign libraries (`dev/bench/peers`), which `cargo xtask peers` builds. Each is a process that
//! answers line by line, because these libraries are written in C and C++. They measure their own time, so
//! communication is not included.

use std::fmt::Write as _;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use sinew_core::glam::{DQuat, DVec3};
use sinew_core::{Body, JointKind};

use crate::motion::{RigMotion, together};

type Failure = Box<dyn std::error::Error>;

/// A kernel that is timed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kernel {
    /// Inverse dynamics.
    Rnea,
    /// Forward dynamics.
    Aba,
    /// Mass matrix.
    Crba,
    /// Forward kinematics with velocities.
    Kinematics,
}

impl Kernel {
    /// All kernels, by their numbers.
    pub(crate) const ALL: [Self; 4] = [Self::Rnea, Self::Aba, Self::Crba, Self::Kinematics];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Rnea => "RNEA",
            Self::Aba => "ABA",
            Self::Crba => "CRBA",
            Self::Kinematics => "forward kinematics",
        }
    }
}

/// A peer program with a rig.
pub(crate) struct Peer {
    pub(crate) name: String,
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
}

impl Peer {
    /// Starts a program. Its name is that of its file.
    pub(crate) fn new(program: &Path, bodies: &[Body]) -> Result<Self, Failure> {
        let cannot = |error| format!("cannot start {}: {error}", program.display());
        let mut child = Command::new(program)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(cannot)?;
        let (Some(to), Some(from)) = (child.stdin.take(), child.stdout.take()) else {
            return Err("a program without its pipes".into());
        };
        let name = program.file_stem().unwrap_or_default().to_string_lossy().replace('_', " ");
        let mut peer = Self { name, child, to, from: BufReader::new(from) };
        peer.ask(&rig(bodies)?)?;
        Ok(peer)
    }

    pub(crate) fn set(&mut self, motion: &RigMotion) -> Result<(), Failure> {
        self.ask(&numbers_of(motion)?).map(|_| ())
    }

    /// Returns the result of a kernel: see `dev/bench/peers/peer.hpp`.
    pub(crate) fn found(&mut self, kernel: Kernel) -> Result<Vec<f64>, Failure> {
        let answer = self.ask(&format!("found {}", kernel as usize))?;
        let numbers = answer.split_whitespace().skip(1).map(str::parse);
        Ok(numbers.collect::<Result<_, _>>()?)
    }

    /// Returns the time of a call, ns.
    pub(crate) fn time_ns(&mut self, kernel: Kernel, calls: u32) -> Result<f64, Failure> {
        let answer = self.ask(&format!("time {} {calls}", kernel as usize))?;
        Ok(answer.trim().parse()?)
    }

    fn ask(&mut self, what: &str) -> Result<String, Failure> {
        writeln!(self.to, "{what}")?;
        self.to.flush()?;
        let mut answer = String::new();
        if self.from.read_line(&mut answer)? == 0 {
            return Err(format!("{} has ended: {}", self.name, self.child.wait()?).into());
        }
        Ok(answer)
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // The program would also end by itself when its input ends, but later.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn rig(bodies: &[Body]) -> Result<String, Failure> {
    let mut text = format!("rig {}", bodies.len());
    for body in bodies {
        let (joint, axis) = match body.joint {
            JointKind::Free => (0, DVec3::X),
            JointKind::Spherical => (1, DVec3::X),
            JointKind::Revolute { axis } => (2, axis.as_dvec3()),
            other => return Err(format!("no {other:?} in this bench").into()),
        };
        let parent = body.parent.map_or(Ok(-1), i64::try_from)?;
        let (placement, inertia) = (body.placement, &body.inertia);
        let i = &inertia.rotational_kg_m2;
        write!(text, "\n{parent} {joint}")?;
        list(&mut text, axis.to_array())?;
        list(&mut text, placement.translation_m.as_dvec3().to_array())?;
        list(&mut text, placement.rotation.as_dquat().normalize().to_array())?;
        list(&mut text, [f64::from(inertia.mass_kg)])?;
        list(&mut text, inertia.center_of_mass_m.as_dvec3().to_array())?;
        list(&mut text, [i.xx, i.xy, i.xz, i.yy, i.yz, i.zz].map(f64::from))?;
    }
    Ok(text)
}

fn numbers_of(motion: &RigMotion) -> Result<String, Failure> {
    let mut text = String::from("motion");
    let root = &motion.root;
    let to_body = root.rotation.conjugate();
    list(&mut text, root.rotation.to_array())?;
    list(&mut text, root.translation_m.to_array())?;
    for in_world in [
        root.angular_velocity,
        root.linear_velocity,
        root.angular_acceleration,
        root.linear_acceleration,
    ] {
        list(&mut text, (to_body * in_world).to_array())?;
    }
    for turns in &motion.turns {
        let (mut turned, mut alone) = (DQuat::IDENTITY, [0.0; 3]);
        let (mut omega, mut alpha) = (DVec3::ZERO, DVec3::ZERO);
        if let [turn] = turns.as_slice() {
            alone = [turn.angle_rad, turn.velocity_rad_s, turn.acceleration_rad_s2];
        } else {
            let ball = together(turns);
            turned = ball.rotation;
            (omega, alpha) = (ball.velocity, ball.acceleration);
        }
        list(&mut text, turned.to_array())?;
        list(&mut text, omega.to_array())?;
        list(&mut text, alpha.to_array())?;
        list(&mut text, alone)?;
    }
    Ok(text)
}

fn list<const N: usize>(text: &mut String, numbers: [f64; N]) -> std::fmt::Result {
    numbers.iter().try_for_each(|number| write!(text, " {number:?}"))
}
