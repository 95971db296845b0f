//! Tests of pages in a headless browser: from disk, without a network, as readers open them.

#[path = "../common/mod.rs"]
mod common;
mod console;
mod console_link;
mod console_pictures;
mod devtools;
mod feasibility;
mod page;
mod player;
mod recording;
mod report;
mod rig;
mod rig_report;
mod sound;
