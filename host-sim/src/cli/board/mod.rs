//! Commands for a controller at a serial port, and a simulated one.

mod arm;
mod cycles;
mod doctor;
mod faults;
mod flash;
mod monitor;
mod port;
mod settings;
#[cfg(unix)]
mod simulate;
mod upload;
mod words;

pub(super) use arm::{READY, arm, check_rig};
pub(super) use doctor::{DoctorArgs, run as doctor};
pub(super) use faults::{FaultsArgs, run as faults};
pub(super) use flash::{FlashArgs, run as flash};
pub(super) use monitor::{MonitorArgs, run as monitor};
pub(super) use port::{BoardPort, PortBoard, open};
pub(super) use settings::{SettingsArgs, run as settings};
#[cfg(unix)]
pub(super) use simulate::{SimulateArgs, run as simulate};
pub(super) use upload::{UploadArgs, put, put_show, run as upload};
pub(super) use words::{named, remedy, tell_faults};
