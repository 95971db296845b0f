//! The rig as the page draws it, with the names of its parts.

use serde::Serialize;
use sinew_board_client::{TelemetryLog, pose};
use sinew_firmware::supervisor::Fault;
use sinew_link::message::{Limit, State};
use sinew_performance::play::{Drive, RigParts, Ways};
use sinew_report::rig::bodies;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{JointModel, Link, Ties};
use sinew_rig::servo::Address;

/// Range of a slider to both sides for a joint without a range: rad, and m.
const FREE: [f32; 2] = [std::f32::consts::PI, 0.1];
/// All limits, in the order of their numbers.
pub(crate) const LIMITS: [Limit; 14] = [
    Limit::Range,
    Limit::Speed,
    Limit::Acceleration,
    Limit::Effort,
    Limit::Current,
    Limit::Offset,
    Limit::Supply,
    Limit::Heat,
    Limit::Stale,
    Limit::NotFinite,
    Limit::Room,
    Limit::SoftStart,
    Limit::Maintenance,
    Limit::Link,
];

/// The kind of board that the hub uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// A board that this program simulates.
    Simulated,
    /// A board at a port.
    Board,
    /// A recording: it accepts no commands.
    Recording,
}

/// A rig, in the form that the page needs.
#[derive(Debug)]
pub struct Scene {
    /// The message `head`, which describes the rig, without the rate of the line.
    head: String,
    pub(crate) rig_crc: u32,
    pub(crate) dofs: Vec<SceneDof>,
    /// For each servo, the name of the first dof that its drive moves.
    pub(crate) joints: Vec<Option<String>>,
    /// Home pose, as coordinates.
    pub(crate) home: Vec<f32>,
    /// Index of the first coordinate and number of coordinates of each joint.
    pub(crate) blocks: Vec<(usize, usize)>,
    /// Ties, by which joints follow other joints.
    ties: Ties,
    /// Ways to the beginnings of shows; `None` without a rig.
    ways: Option<Box<Ways>>,
}

/// A dof with its slider.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct SceneDof {
    pub(crate) name: String,
    pub(crate) body: usize,
    pub(crate) axis: usize,
    pub(crate) slides: bool,
    pub(crate) range: [f32; 2],
    pub(crate) limited: bool,
    pub(crate) home: f32,
    /// Maximum speed, rad/s or m/s; `None` without a limit.
    pub(crate) speed: Option<f32>,
    /// Maximum effort, N m or N; `None` without a limit.
    pub(crate) effort: Option<f32>,
    /// Index of the coordinate in a pose; `None` for a ball joint.
    pub(crate) coordinate: Option<usize>,
    /// Index of the dof that this dof follows; `None` if it follows no dof.
    pub(crate) leader: Option<usize>,
}

#[derive(Serialize)]
struct Head<'a> {
    r#type: &'static str,
    rig: &'a str,
    source: Source,
    commands: bool,
    bodies: Vec<sinew_report::rig::Body<'a>>,
    dofs: &'a [SceneDof],
    servos: Vec<SceneServo<'a>>,
    states: Vec<String>,
    faults: std::collections::BTreeMap<u8, FaultText>,
    limits: [&'static str; LIMITS.len()],
    rate_hz: f32,
}

#[derive(Serialize)]
struct SceneServo<'a> {
    name: &'a str,
    id: u8,
    line: &'a str,
    dof: Option<usize>,
    class: &'static str,
}

#[derive(Serialize)]
struct FaultText {
    name: &'static str,
    means: &'static str,
    r#do: &'static str,
}

impl Scene {
    /// Describes a rig for the page.
    pub fn new(name: &str, mechanism: &Mechanism, parts: &RigParts, source: Source) -> Self {
        let dofs = dofs(mechanism, parts);
        let of_servo = |servo: usize| {
            let drives = parts.compact().drives();
            let drive = drives
                .iter()
                .find(|drive| drive.servos.iter().any(|s| usize::from(*s) == servo))?;
            drive.dofs.first().map(|dof| usize::from(*dof))
        };
        let servos = parts.servos.iter().enumerate().map(|(index, part)| SceneServo {
            name: &part.own.name,
            id: match part.own.address {
                Address::Id(id) | Address::Channel(id) => id,
            },
            line: &part.own.bus,
            dof: of_servo(index),
            class: class(part.drive),
        });
        let faults = Fault::ALL.map(|fault| {
            let text = FaultText { name: fault.name(), means: fault.when(), r#do: fault.remedy() };
            (fault.number(), text)
        });
        let head = Head {
            r#type: "head",
            rig: name,
            source,
            commands: source != Source::Recording,
            bodies: bodies(mechanism),
            dofs: &dofs,
            servos: servos.collect(),
            states: State::ALL.map(|state| format!("{state:?}")).to_vec(),
            faults: faults.into(),
            limits: LIMITS.map(Limit::name),
            rate_hz: crate::hub::RATE_HZ,
        };
        let mut first = 0;
        let blocks = mechanism.bodies.iter().map(|link| {
            let count = link.joint.kind().coordinate_count();
            first += count;
            (first - count, count)
        });
        Self {
            head: serde_json::to_string(&head).unwrap_or_default(),
            rig_crc: parts.rig_crc(),
            joints: (0..parts.servos.len())
                .map(|servo| of_servo(servo).map(|dof| dofs[dof].name.clone()))
                .collect(),
            home: mechanism.home().into_iter().map(single).collect(),
            blocks: blocks.collect(),
            ties: mechanism.ties(),
            ways: Some(Box::new(parts.ways())),
            dofs,
        }
    }

    /// Moves all followers in a pose to the positions that their leaders require.
    pub(crate) fn follow(&self, q: &mut [f32]) {
        for tie in self.ties.each() {
            let [own, leader] = tie.places();
            q[own] = single(tie.factor * f64::from(q[leader]) + tie.offset);
        }
    }

    /// Returns the largest absolute factor among the followers of a dof; `None` if no dof follows it.
    pub(crate) fn leads(&self, dof: usize) -> Option<f32> {
        let followers = self.ties.each().filter(|tie| tie.dofs()[1] == dof);
        followers.map(|tie| single(tie.factor.abs())).reduce(f32::max)
    }

    /// Returns the reason why a dof cannot be moved by itself: it follows another dof. Otherwise returns `None`.
    pub(crate) fn follows(&self, dof: &SceneDof) -> Option<String> {
        let leader = self.dofs.get(dof.leader?)?;
        Some(format!("`{}` follows `{}`: move `{}`", dof.name, leader.name, leader.name))
    }

    /// Returns the time from the command to play a show until its clock starts, s, if the rig rests in a pose. `None`
    /// if it cannot be computed.
    pub(crate) fn way_s(&self, show: &[u8], from: &[f32]) -> Option<f32> {
        Some(self.ways.as_ref()?.approach(show, from)?.way_s)
    }

    /// Creates a scene without a rig, for a hub that has no pages and moves nothing.
    pub fn empty() -> Self {
        Self {
            head: String::new(),
            rig_crc: 0,
            dofs: Vec::new(),
            joints: Vec::new(),
            home: Vec::new(),
            blocks: Vec::new(),
            ties: Ties::default(),
            ways: None,
        }
    }

    /// Returns the pose that the board commands; `None` while torque is off.
    pub(crate) fn commanded(&self, log: &TelemetryLog) -> Option<Vec<f32>> {
        pose::commanded(&self.blocks, self.dofs.len(), log)
    }

    /// Returns the message that describes the rig. `line_rate_hz`: snapshots per second that the line can carry.
    pub(crate) fn head(&self, line_rate_hz: f32) -> String {
        let mut text = self.head.clone();
        text.pop();
        text + &format!(",\"line_rate_hz\":{line_rate_hz}}}")
    }

    /// Returns the numbers of coordinates, dofs and servos.
    pub(crate) fn counts(&self) -> [usize; 3] {
        [self.home.len(), self.dofs.len(), self.joints.len()]
    }
}

fn class(drive: Drive) -> &'static str {
    match drive {
        Drive::Current => "current",
        Drive::Voltage => "pwm",
        Drive::Position => "position",
        Drive::Pulses => "pulse",
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a page and a board have f32")]
fn single(number: f64) -> f32 {
    number as f32
}

fn dofs(mechanism: &Mechanism, parts: &RigParts) -> Vec<SceneDof> {
    let (mut dofs, mut coordinate) = (Vec::new(), 0);
    let (of_board, ties) = (parts.compact().dofs(), mechanism.ties());
    for (body, link) in mechanism.bodies.iter().enumerate() {
        let kind = link.joint.kind();
        let is_ball = kind.coordinate_count() != kind.dof_count();
        for axis in 0..kind.dof_count() {
            let index = dofs.len();
            let slides = parts.slides[index];
            let range = range(link, axis);
            let most = FREE[usize::from(slides)];
            dofs.push(SceneDof {
                name: parts.names[index].clone(),
                body,
                axis,
                slides,
                range: range.unwrap_or([-most, most]),
                limited: range.is_some(),
                home: of_board[index].home,
                speed: Some(of_board[index].speed).filter(|speed| speed.is_finite()),
                effort: Some(of_board[index].effort).filter(|effort| effort.is_finite()),
                coordinate: (!is_ball).then_some(coordinate + axis),
                leader: ties.of(body).map(|tie| tie.dofs()[1]),
            });
        }
        coordinate += kind.coordinate_count();
    }
    dofs
}

/// Returns the range of an axis; `None` without a finite range. All directions of a ball joint have the same range.
fn range(link: &Link, axis: usize) -> Option<[f32; 2]> {
    let is_ball = link.joint == JointModel::Spherical;
    let [least, most] = *link.ranges.get(if is_ball { 0 } else { axis })?;
    let range = if is_ball { [-most, most] } else { [least, most] };
    range.iter().all(|end| end.is_finite()).then(|| range.map(single))
}
