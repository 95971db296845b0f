//! Data for the page's scripts.

use serde::Serialize;
use sinew_retarget::feasibility::{CheckError, Excess, Kind, Limits, Performance, Report};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;

use super::samples::Samples;
use crate::rig::{Body, bodies};

/// The drawn data: all joints except the free joint of a driven base.
pub(super) struct Drawn<'a> {
    pub(super) limits: &'a Limits,
    pub(super) report: &'a Report,
    pub(super) dofs: Vec<DrawnDof<'a>>,
    pub(super) excesses: &'a [Excess],
}

/// A dof of a joint.
#[derive(Debug, Serialize)]
pub(super) struct DrawnDof<'a> {
    /// Index in the order of `qd`.
    #[serde(skip)]
    pub(super) index: usize,
    body: usize,
    axis: usize,
    name: &'a str,
    slides: bool,
    home: f64,
    /// Range in the drawing, finite.
    range: [f64; 2],
    /// Limits in the plots; infinite limits become null.
    position: [f64; 2],
    speed: f64,
    acceleration: f64,
    pub(super) effort: f64,
    pub(super) continuous: f64,
    /// Maximum rotation of the joint, if the dof is an axis of a ball joint.
    #[serde(skip)]
    pub(super) turn: Option<f64>,
}

impl<'a> Drawn<'a> {
    pub(super) fn of(mechanism: &Mechanism, limits: &'a Limits, report: &'a Report) -> Self {
        let mut dofs = Vec::new();
        let mut all = limits.dofs.iter().enumerate();
        for (body, link) in mechanism.bodies.iter().enumerate() {
            for axis in 0..link.joint.kind().dof_count() {
                let Some((index, of)) = all.next() else { continue };
                if link.joint == JointModel::Free {
                    continue;
                }
                let turn = (link.joint == JointModel::Spherical).then(|| {
                    let most = limits.turns.iter().find(|(of, _)| *of == body);
                    most.map_or(f64::INFINITY, |(_, most)| *most)
                });
                let position = turn.map_or(of.range, |most| [f64::NEG_INFINITY, most]);
                let far = if of.slides { 0.1 } else { std::f64::consts::PI };
                dofs.push(DrawnDof {
                    index,
                    body,
                    axis,
                    name: &of.name,
                    slides: of.slides,
                    home: if turn.is_some() { 0.0 } else { link.home[axis] },
                    range: turn.map_or(of.range, |most| [-most, most]).map(|x| x.clamp(-far, far)),
                    position,
                    speed: of.speed,
                    acceleration: of.acceleration,
                    effort: of.effort,
                    continuous: of.heat.map_or(f64::INFINITY, |heat| heat.continuous),
                    turn,
                });
            }
        }
        Self { limits, report, dofs, excesses: &report.excesses }
    }

    /// Returns the scripts' data of the rig and of the show, as JSON that is safe in HTML.
    pub(super) fn json(
        &self,
        mechanism: &Mechanism,
        performance: &impl Performance,
    ) -> Result<Json, CheckError> {
        let drawn: Vec<usize> = self.dofs.iter().map(|dof| dof.index).collect();
        let samples = Samples::of(mechanism, performance, &drawn)?;
        let of_excess = |excess: &Excess| ExcessData {
            joint: drawn.iter().position(|index| *index == excess.dof),
            plot: match excess.kind {
                Kind::Range | Kind::Following => "position",
                // The sum of two joints is in no plot.
                Kind::LinkedRange => "",
                Kind::Speed => "speed",
                Kind::Acceleration => "acceleration",
                Kind::Effort | Kind::Heat => "effort",
            },
            from_s: excess.from_s,
            to_s: excess.to_s,
            worst_s: excess.worst_s,
        };
        let rig = Rig { bodies: bodies(mechanism), dofs: &self.dofs };
        let excesses = self.excesses.iter().map(of_excess).collect();
        let (dt_s, end_s) = (samples.dt_s, samples.end_s());
        let show = Show { samples, excesses };
        let json = |text: serde_json::Result<String>| {
            text.expect("numbers and names only").replace("</", "<\\/")
        };
        Ok(Json {
            rig: json(serde_json::to_string(&rig)),
            show: json(serde_json::to_string(&show)),
            dt_s,
            end_s,
        })
    }
}

/// The JSON texts for the scripts.
pub(super) struct Json {
    pub(super) rig: String,
    pub(super) show: String,
    /// Time between samples, s.
    pub(super) dt_s: f64,
    /// Time of the last sample, s.
    pub(super) end_s: f64,
}

#[derive(Debug, Serialize)]
struct Rig<'a> {
    bodies: Vec<Body<'a>>,
    dofs: &'a [DrawnDof<'a>],
}

#[derive(Debug, Serialize)]
struct Show {
    #[serde(flatten)]
    samples: Samples,
    excesses: Vec<ExcessData>,
}

#[derive(Debug, Serialize)]
struct ExcessData {
    joint: Option<usize>,
    plot: &'static str,
    from_s: f64,
    to_s: f64,
    worst_s: f64,
}
