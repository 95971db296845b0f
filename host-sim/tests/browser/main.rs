//! Pages in a browser without a screen, as a reader has them: from disk, with no network.

#[path = "../common/mod.rs"]
mod common;
mod devtools;
mod feasibility;
mod page;
mod player;
mod recording;
mod report;
mod rig;
mod rig_report;
