//! A node from a blank board to a performance, over a bad line.

use sinew_firmware::supervisor::State;
use sinew_link::message::{
    self, Applied, Command, Feed, Kind as ItemKind, Location, Outcome, Refusal, TelemetryParts,
    TelemetrySetting, Value,
};

use super::line::BAD;
use super::stored::{item, rig, settings, show};
use super::test_rig::{Kind, SERVOS};
use super::world::World;

fn led_to(state: message::State) -> Outcome {
    Outcome::Applied(Applied::State(state))
}

#[test]
fn a_blank_board_gets_a_rig_settings_and_a_show_and_plays_it() {
    let kind = Kind::Current;
    let mut world = World::new(kind, BAD, 7);
    world.connect();
    assert_eq!(world.host.welcome.unwrap().about.rig, 0);
    // Without a rig there is no torque: fault 13.
    assert_eq!(world.ask(Command::Arm), Outcome::Refused(Refusal::Fault(13)));
    let (bytes, crc) = rig(kind);
    let rig_item = item(ItemKind::Rig, &bytes, 0);
    let stored = Outcome::Applied(Applied::Stored(Some(rig_item.clone())));
    assert_eq!(world.upload(&rig_item, &bytes), stored);
    world.connect();
    assert_eq!((world.starts, world.host.welcome.unwrap().about.rig), (2, crc));
    assert_eq!(world.ask(Command::AskStored(Location::Rig)), stored);

    let settings = settings(kind).with(6, 8.0).unwrap().bytes();
    let settings_item = item(ItemKind::Settings, &settings, crc);
    let stored = Outcome::Applied(Applied::Stored(Some(settings_item.clone())));
    assert_eq!(world.upload(&settings_item, &settings), stored);
    world.connect();
    let eight = Outcome::Applied(Applied::Setting(Value::Number(8.0)));
    assert_eq!(world.ask(Command::ReadSetting { key: 6 }), eight);
    // A single setting is written and read back, and the others stay.
    let seven = Value::Number(7.0);
    let written = world.ask(Command::WriteSetting { key: 7, value: seven.clone() });
    assert_eq!(written, Outcome::Applied(Applied::Setting(seven.clone())));
    world.connect();
    assert_eq!(world.ask(Command::ReadSetting { key: 6 }), eight);
    let fast = world.ask(Command::WriteSetting { key: 8, value: Value::Number(9.0) });
    let Outcome::Refused(Refusal::Setting { key: 8, found: 9.0, most, .. }) = fast else {
        panic!("{fast:?}")
    };
    assert!(most < 0.35, "20 deg/s");

    let show = show(kind, 4, false);
    let show_item = item(ItemKind::Show, &show, crc);
    let stored = Outcome::Applied(Applied::Stored(Some(show_item.clone())));
    assert_eq!(world.upload(&show_item, &show), stored);
    let other = world.ask(Command::LoadShow { slot: 1 });
    assert_eq!(other, Outcome::Refused(Refusal::Unknown));
    assert_eq!(world.ask(Command::LoadShow { slot: 0 }), Outcome::Applied(Applied::Done));

    let telemetry = TelemetrySetting { rate_hz: 1e6, parts: TelemetryParts::ALL };
    let set = world.ask(Command::SetTelemetry(telemetry));
    assert!(
        matches!(set, Outcome::Limited(Applied::Telemetry(_), message::Limit::Link)),
        "{set:?}"
    );
    let telemetry = TelemetrySetting {
        rate_hz: 20.0,
        parts: TelemetryParts::ALL.and(TelemetryParts::TARGETS).and(TelemetryParts::SUPPLIES),
    };
    world.ask(Command::SetTelemetry(telemetry));
    world.until(State::Limp, 2.0);
    assert_eq!(world.servos_on(), 0);
    assert_eq!(world.arm(), led_to(message::State::Arming));
    world.until(State::Holding, 3.0);
    assert_eq!(world.servos_on(), SERVOS);
    // Nothing is erased while the rig is armed.
    let delete = world.ask(Command::DeleteShow { slot: 1 });
    assert_eq!(delete, Outcome::Refused(Refusal::State(message::State::Holding)));
    assert_eq!(world.ask(Command::Play(Feed::Show)), led_to(message::State::Playing));
    world.until(State::Holding, 20.0);
    assert_eq!(world.ask(Command::Stop), led_to(message::State::Stopping));
    world.until(State::Limp, 40.0);
    world.run(0.5);
    assert_eq!((world.servos_on(), world.pins.outputs), (0, false));
    let is_warning = message::FaultRecord::is_warning;
    assert!(world.host.faults.iter().all(is_warning), "{:?}", world.host.faults);

    let summaries = &world.host.summaries;
    // Only while the show plays: a limb that was let down moves by its weight.
    let plays = |summary: &&message::Summary| summary.state == message::State::Playing;
    let errors = || summaries.iter().filter(plays).filter_map(|summary| summary.errors);
    let most_deg = errors().map(|errors| errors.largest_deg).fold(0.0, f32::max);
    let most_cm = errors().map(|errors| errors.largest_cm).fold(0.0, f32::max);
    println!("{} summaries; largest error {most_deg:.2} deg, {most_cm:.2} cm", summaries.len());
    println!("{:?} frames there, {} back", world.host.there.frames, world.host.back.frames);
    assert!(world.host.parts.iter().all(|count| *count > 100), "{:?}", world.host.parts);
    assert!(most_deg < 15.0 && most_cm > 0.0 && most_cm < 10.0);
    assert!(summaries.iter().any(|summary| summary.show_ms > 3500));
    assert!(summaries.iter().all(|summary| summary.overruns == 0));
    assert!(summaries.last().unwrap().link_damaged > 0);
}
