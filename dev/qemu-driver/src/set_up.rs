//! Sets up the node before it plays: power-on with the built-in parts of its board, then uploads of rig, show and
//! settings over the host link.

use sha2::{Digest as _, Sha256};
use sinew_firmware::node::{RIG_SCHEMA, SETTINGS_SCHEMA, SHOW_SCHEMA};
use sinew_link::message::{Item, Kind};
use sinew_performance::play::RigParts;
use sinew_qemu_node::built_in::{BuiltIn, Rig};
use sinew_qemu_node::limits::{CAPACITY, LINES, RIG_ROOM};
use sinew_qemu_node::message::ToNode;

use super::error::QemuError;
use super::node::Node;

/// Name of the approver that the node stores with the uploads.
const APPROVER: &str = "sinew play";

/// Powers on a board whose built-in lines and servos are those of this rig.
pub(super) fn power_on(node: &mut Node, parts: &RigParts) -> Result<(), QemuError> {
    fits("lines of servos", parts.lines.len(), LINES)?;
    fits("servos", parts.servos.len(), CAPACITY)?;
    let wiring = parts.wiring().map_err(QemuError::Wiring)?;
    node.put(&ToNode::PowerOn(BuiltIn::Rig(Rig {
        lines: wiring.lines.len(),
        servos: wiring.servos.len(),
        rate_hz: wiring.rate_hz,
        latest: wiring.latest,
        tracker: wiring.tracker,
    })))?;
    for line in wiring.lines {
        node.put(&ToNode::Line(line))?;
    }
    for servo in wiring.servos {
        node.put(&ToNode::Servo(servo))?;
    }
    Ok(())
}

/// Uploads rig, show and settings. After the settings the node restarts with all of them.
pub(super) fn upload(node: &mut Node, parts: &RigParts, show: &[u8]) -> Result<(), QemuError> {
    let holds = node.connect()?.about.capacities;
    let tree = parts.compact().tree();
    fits("bodies", tree.len(), holds.bodies.into())?;
    fits("degrees of freedom", parts.compact().dofs().len(), holds.dofs.into())?;
    fits("coordinates", tree.coordinate_count(), holds.coordinates.into())?;
    let mut rig = vec![0; RIG_ROOM];
    let large = |_| QemuError::Holds { what: "more bytes than", found: RIG_ROOM, holds: RIG_ROOM };
    let len = parts.compact().encode(&mut rig).map_err(large)?;
    rig.truncate(len);
    node.upload("rig", &item(Kind::Rig, &rig, 0), &rig)?;
    let crc = node.restart()?.about.rig;
    node.upload("show", &item(Kind::Show, show, parts.rig_crc()), show)?;
    let settings = parts.node_settings().bytes();
    node.upload("settings", &item(Kind::Settings, &settings, crc), &settings)?;
    node.restart().map(|_| ())
}

fn fits(what: &'static str, found: usize, holds: usize) -> Result<(), QemuError> {
    (found <= holds).then_some(()).ok_or(QemuError::Holds { what, found, holds })
}

fn item(kind: Kind, content: &[u8], rig: u32) -> Item {
    Item {
        kind,
        schema: match kind {
            Kind::Rig => RIG_SCHEMA,
            Kind::Settings => SETTINGS_SCHEMA,
            Kind::Show => SHOW_SCHEMA,
        },
        length: u32::try_from(content.len()).unwrap_or(u32::MAX),
        hash: Sha256::digest(content).into(),
        rig,
        approver: APPROVER.try_into().unwrap_or_default(),
    }
}
