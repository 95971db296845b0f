//! The content that a host uploads: the arm's rig, its settings and a show, with their descriptions.

use sinew_firmware::node::{NodeSettings, SETTINGS_SCHEMA, SHOW_SCHEMA};
use sinew_link::message::{Item, Kind as ItemKind};
use sinew_storage::Hash;

use super::swing::swing;
use super::test_rig::{Kind, figure, setup};

/// Returns the bytes of the arm's rig, and their CRC.
pub(crate) fn rig(kind: Kind) -> (Vec<u8>, u32) {
    let mut bytes = vec![0; 16_384];
    let len = figure(kind).board.encode(&mut bytes).unwrap();
    bytes.truncate(len);
    let crc = u32::from_le_bytes(*bytes.last_chunk().unwrap());
    (bytes, crc)
}

/// Returns the board's settings.
pub(crate) fn settings(kind: Kind) -> NodeSettings {
    let parts = setup(kind);
    NodeSettings::new(parts.settings, parts.schedule)
}

/// Returns a show for the arm's rig.
pub(crate) fn show(kind: Kind, seconds: u32, is_loop: bool) -> Vec<u8> {
    swing(kind, seconds, is_loop, rig(kind).1)
}

pub(crate) fn item(kind: ItemKind, content: &[u8], rig: u32) -> Item {
    Item {
        kind,
        schema: if kind == ItemKind::Show { SHOW_SCHEMA } else { SETTINGS_SCHEMA },
        length: content.len() as u32,
        hash: Hash::of(content).0,
        rig,
        approver: "Ada, stage manager".try_into().unwrap(),
    }
}
