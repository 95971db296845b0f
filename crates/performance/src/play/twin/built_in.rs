//! What the node is told before it plays: what its board has built in, then over the link rig, settings and show.

use sha2::{Digest as _, Sha256};
use sinew_firmware::node::{NodeSettings, RIG_SCHEMA, SETTINGS_SCHEMA, SHOW_SCHEMA};
use sinew_link::message::{Item, Kind};
use sinew_qemu_node::built_in::{BuiltIn, Line, Rig, Servo};
use sinew_qemu_node::message::ToNode;
use sinew_qemu_node::node::{CAPACITY, LINES, RIG_ROOM};

use super::error::TwinError;
use super::node::Node;
use crate::play::Parts;
use crate::play::line::OfLine;

/// Who stands for what is uploaded.
const APPROVER: &str = "sinew play";

/// Power-on of a board with this rig's lines and servos.
pub(super) fn tell(node: &mut Node, parts: &Parts) -> Result<(), TwinError> {
    let fits = |what, found, holds| {
        (found <= holds).then_some(()).ok_or(TwinError::Holds { what, found, holds })
    };
    fits("lines of servos", parts.lines.len(), LINES)?;
    fits("servos", parts.servos.len(), CAPACITY)?;
    let latest = parts.schedules.iter().position(|of| *of == parts.schedule);
    node.put(&ToNode::PowerOn(BuiltIn::Rig(Rig {
        lines: parts.lines.len(),
        servos: parts.servos.len(),
        rate_hz: parts.rate_hz,
        latest: latest.unwrap_or_default(),
        tracker: parts.settings.tracker,
    })))?;
    let of_lines: Vec<OfLine> = parts.lines.iter().map(|line| parts.of_line(line)).collect();
    for (line, of_line) in parts.lines.iter().zip(&of_lines) {
        let load = line.load(&parts.servos);
        let (protocol, timing, traffic) = (of_line.protocol(), load.timing, load.traffic);
        node.put(&ToNode::Line(Line { protocol, timing, traffic }))?;
    }
    for (part, setup) in parts.servos.iter().zip(&parts.setups) {
        let (line, place) = part.place;
        let Some(on_line) = of_lines[line].on_line(place) else { continue };
        node.put(&ToNode::Servo(Servo { line, on_line, setup: *setup }))?;
    }
    Ok(())
}

/// Rig, show and settings, over the link; behind the settings it begins anew with all of them.
pub(super) fn upload(node: &mut Node, parts: &Parts, show: &[u8]) -> Result<(), TwinError> {
    let holds = node.connect()?.about.capacities;
    let (tree, dofs) = (parts.board.tree(), parts.board.dofs());
    for (what, found, holds) in [
        ("bodies", tree.len(), holds.bodies),
        ("degrees of freedom", dofs.len(), holds.dofs),
        ("coordinates", tree.coordinate_count(), holds.coordinates),
    ] {
        let holds = holds.into();
        (found <= holds).then_some(()).ok_or(TwinError::Holds { what, found, holds })?;
    }
    let mut rig = vec![0; RIG_ROOM];
    let holds = rig.len();
    let len = parts.board.encode(&mut rig);
    let large = |_| TwinError::Holds { what: "more bytes than", found: holds, holds };
    rig.truncate(len.map_err(large)?);
    node.upload("rig", &item(Kind::Rig, &rig, 0), &rig)?;
    let crc = node.restart()?.about.rig;
    let of = parts.rig_crc();
    node.upload("show", &item(Kind::Show, show, of), show)?;
    let settings = NodeSettings::new(parts.settings.clone(), parts.schedule).bytes();
    node.upload("settings", &item(Kind::Settings, &settings, crc), &settings)?;
    node.restart().map(|_| ())
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
