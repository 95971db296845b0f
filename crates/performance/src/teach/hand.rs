//! A scripted hand at a simulated rig.

use sinew_rig::Mechanism;
use sinew_rig::mechanism::Freedom;
use sinew_servo_sim::plant::Hand;

use super::Leads;

/// A hand that holds all joints but ball joints, and leads them along a way.
#[derive(Debug, Clone)]
pub struct ScriptedHand {
    leads: Leads,
    /// Freedom and coordinate of all that it holds.
    held: Vec<(usize, usize)>,
}

impl ScriptedHand {
    /// At a rig of this mechanism.
    pub fn new(mechanism: &Mechanism, leads: Leads) -> Self {
        let (mut held, mut freedom, mut coordinate) = (Vec::new(), 0, 0);
        for link in &mechanism.bodies {
            let kind = link.joint.kind();
            let (freedoms, coordinates) = (kind.degrees_of_freedom(), kind.coordinate_count());
            if !matches!(link.joint, Freedom::Spherical | Freedom::Free) {
                held.extend((freedom..freedom + freedoms).zip(coordinate..));
            }
            (freedom, coordinate) = (freedom + freedoms, coordinate + coordinates);
        }
        Self { leads, held }
    }

    /// How long its way takes, s.
    pub fn duration_s(&self) -> f64 {
        self.leads.duration_s()
    }

    /// Holds every freedom where it leads `time_s` after the beginning: `lead` puts the hand there.
    pub fn hold(&self, time_s: f64, mut lead: impl FnMut(usize, Option<Hand>)) {
        let instant = self.leads.at(time_s);
        for (freedom, coordinate) in &self.held {
            let (position, velocity) = (instant.q[*coordinate], instant.qd[*freedom]);
            lead(*freedom, Some(Hand { position, velocity }));
        }
    }

    /// Lets go of all.
    pub fn let_go(&self, mut lead: impl FnMut(usize, Option<Hand>)) {
        self.held.iter().for_each(|(freedom, _)| lead(*freedom, None));
    }
}
