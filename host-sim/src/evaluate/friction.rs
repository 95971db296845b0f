//! Friction that the drives know and feed forward.

use sinew_core::Wrench;
use sinew_core::coordinates::DofCommand;
use sinew_core::glam::Vec3;
use sinew_rig::drive::Friction;
use sinew_rig::mechanism::{Freedom, Link};

use super::controller::narrow;
use super::setup::RigTick;

/// The drives of a rig whose joints have friction.
pub(super) struct FrictionFeed {
    /// Of each body's joint: its friction along every freedom, and the most that its drive gives.
    joints: Vec<(Friction, f32)>,
    commands: Vec<DofCommand>,
}

impl FrictionFeed {
    /// That of a rig; `None` if no joint has friction.
    pub(super) fn of(links: &[Link], torque_limit_nm: f64) -> Option<Self> {
        let joint = |link: &Link| {
            let friction = Friction::new(narrow(link.friction), narrow(link.damping));
            let most = match link.joint {
                Freedom::Prismatic(_) => link.effort,
                _ => link.effort.min(torque_limit_nm),
            };
            (friction.unwrap_or_default(), narrow(most))
        };
        let joints: Vec<_> = links.iter().map(joint).collect();
        if joints.iter().all(|(friction, _)| friction.is_none()) {
            return None;
        }
        let freedoms = links.iter().map(|link| link.joint.kind().degrees_of_freedom()).sum();
        Some(Self { joints, commands: vec![DofCommand::default(); freedoms] })
    }

    /// Adds to the wrenches of the joints, body axes, what their friction takes at the speeds that they are to have, as
    /// far as the drives can.
    pub(super) fn add(&mut self, links: &[Link], tick: &mut RigTick<'_>, wrenches: &mut [Wrench]) {
        tick.dof_commands(&mut self.commands).expect("one for each degree of freedom");
        let mut commands = self.commands.iter();
        for ((link, wrench), (friction, most)) in links.iter().zip(wrenches).zip(&self.joints) {
            let count = link.joint.kind().degrees_of_freedom();
            let own: Vec<&DofCommand> = commands.by_ref().take(count).collect();
            if friction.is_none() || link.joint == Freedom::Free {
                continue;
            }
            // Where the axes of a universal joint are follows from where it is to be: a little beside where it is.
            let at: Vec<f64> = own.iter().map(|command| f64::from(command.position)).collect();
            let (turns, slides) = link.joint.axes(&at);
            let axes = |axes: Vec<glam::DVec3>| axes.into_iter().map(|axis| axis.as_vec3());
            let (turns, slides): (Vec<Vec3>, Vec<Vec3>) =
                (axes(turns).collect(), axes(slides).collect());
            for (axis, command) in turns.iter().zip(&own) {
                let wanted = axis.dot(wrench.moment_nm);
                wrench.moment_nm += *axis * more(wanted, friction.effort(command.velocity), *most);
            }
            for (axis, command) in slides.iter().zip(&own) {
                let wanted = axis.dot(wrench.force_n);
                wrench.force_n += *axis * more(wanted, friction.effort(command.velocity), *most);
            }
        }
    }
}

/// What of `effort` goes on top of `wanted`, which is within the limits.
fn more(wanted: f32, effort: f32, most: f32) -> f32 {
    (wanted + effort).clamp(-most, most) - wanted
}
