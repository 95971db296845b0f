//! Serialization of other crates' settings. It lists all of their fields: a new field does not build before it is
//! added to this file.

use serde::{Deserialize, Serialize};
use sinew_firmware::controller::ServoSetup;
use sinew_firmware::drives::{
    CurrentSettings, CutOff, DriveSettings, Encoder, PositionSettings, TargetSettings,
    VoltageSettings,
};
use sinew_firmware::supervisor::detect::{HeatSettings, SupplySettings, WindingSettings};
use sinew_servo_bus::pca9685::ChannelSetup;
use sinew_servo_bus::{Cost, Timing, Traffic, dynamixel, feetech};

#[derive(Serialize, Deserialize)]
#[serde(remote = "Timing")]
pub(crate) struct TimingOf {
    baud: u32,
    return_delay_us: u32,
    turnaround_us: u32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Cost")]
struct CostOf {
    fixed: u32,
    each: u32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Traffic")]
pub(crate) struct TrafficOf {
    servos: u32,
    #[serde(with = "CostOf")]
    write: Cost,
    #[serde(with = "CostOf")]
    ask: Cost,
    #[serde(with = "CostOf")]
    answer: Cost,
    delay_each: bool,
    ask_each: bool,
    extra: u32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "dynamixel::Settings")]
pub(crate) struct DynamixelOf {
    fast: bool,
    retries: u8,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "dynamixel::Mode")]
pub(crate) enum DynamixelModeOf {
    Current,
    Position,
    ExtendedPosition,
    CurrentPosition,
    Pwm,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "feetech::Family")]
enum FamilyOf {
    Sts,
    Scs,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "feetech::Settings")]
pub(crate) struct FeetechOf {
    #[serde(with = "FamilyOf")]
    family: feetech::Family,
    echo: bool,
    retries: u8,
    speed_counts: u8,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "feetech::Mode")]
enum FeetechModeOf {
    Position,
    Pwm,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "feetech::ServoSetup")]
pub(crate) struct FeetechServoOf {
    id: u8,
    #[serde(with = "FeetechModeOf")]
    mode: feetech::Mode,
    range_rad: [f32; 2],
    pwm: f32,
    speed_rad_s: f32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "ChannelSetup")]
pub(crate) struct ChannelOf {
    channel: u8,
    pulse_us: [f32; 2],
    range_rad: [f32; 2],
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "ServoSetup")]
pub(crate) struct ServoSetupOf {
    #[serde(with = "DriveOf")]
    drive: DriveSettings,
    bandwidth_rad_s: f32,
    rest_rad: f32,
    #[serde(with = "HeatOf")]
    heat: HeatSettings,
    #[serde(with = "SupplyOf")]
    supply: SupplySettings,
    #[serde(with = "WindingOf")]
    winding: WindingSettings,
    stall_a: f32,
    stall_nm: f32,
    shutdown_c: f32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "DriveSettings")]
enum DriveOf {
    Current(#[serde(with = "CurrentOf")] CurrentSettings),
    Position(#[serde(with = "PositionOf")] PositionSettings),
    Target(#[serde(with = "TargetOf")] TargetSettings),
    Voltage(#[serde(with = "VoltageOf")] VoltageSettings),
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "CurrentSettings")]
struct CurrentOf {
    #[serde(with = "EncoderOf")]
    encoder: Encoder,
    blind_rad: f32,
    current_a: f32,
    #[serde(with = "CutOffOf")]
    cut_off: CutOff,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "VoltageSettings")]
struct VoltageOf {
    #[serde(with = "CurrentOf")]
    current: CurrentSettings,
    resistance_ohm: f32,
    back_emf_v_s: f32,
    supply_v: f32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "PositionSettings")]
struct PositionOf {
    #[serde(with = "EncoderOf")]
    encoder: Encoder,
    gain_ratio: f32,
    drag_nm_s: f32,
    offset_rad: f32,
    offset_rad_s: f32,
    #[serde(with = "CutOffOf")]
    cut_off: CutOff,
    profile: bool,
}

/// Settings of servos without feedback. Their encoder is not stored, since nobody reads their position.
#[derive(Serialize, Deserialize)]
#[serde(remote = "TargetSettings")]
struct TargetOf {
    #[serde(skip)]
    encoder: Option<Encoder>,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Encoder")]
struct EncoderOf {
    zero_rad: f32,
    turn_rad: f32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "CutOff")]
struct CutOffOf {
    stale_s: f32,
    warm_c: f32,
    hot_c: f32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "HeatSettings")]
#[expect(clippy::struct_field_names, reason = "they are the other struct's")]
struct HeatOf {
    warn_c: f32,
    derate_c: f32,
    off_c: f32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "SupplySettings")]
struct SupplyOf {
    warn_v: f32,
    derate_v: f32,
    low_v: f32,
    high_v: f32,
    filter_s: f32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "WindingSettings")]
struct WindingOf {
    continuous_a: f32,
    winding_s: f32,
    case_s: f32,
    winding_share: f32,
}
