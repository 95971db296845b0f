//! Settings that the next start would refuse are refused at once, with their bounds.

use sinew_firmware::node::{SETTING_NAMES, SettingsError};
use sinew_firmware::supervisor::State;
use sinew_link::message::{Applied, Command, Item, Kind as ItemKind, Outcome, Refusal, Value};

use super::decoders;
use super::line::{Trouble, random};
use super::stored::{item, rig, settings, show};
use super::test_rig::Kind;
use super::world::World;

fn write(key: u16, value: f32) -> Command {
    Command::WriteSetting { key, value: Value::Number(value) }
}

/// Returns the key of a refused setting, and its bounds.
fn bounds(outcome: &Outcome, value: f32) -> (u16, [f32; 2]) {
    let Outcome::Refused(Refusal::Setting { key, found, least, most }) = *outcome else {
        panic!("{value} is not refused as a setting: {outcome:?}")
    };
    assert!(!(least..=most).contains(&found), "{found} is within {least} to {most}");
    (key, [least, most])
}

#[test]
fn what_the_next_start_would_refuse_is_refused_at_once() {
    for kind in [Kind::Current, Kind::Voltage, Kind::Position] {
        let mut world = World::ready(kind, Trouble::default(), 31, &show(kind, 1, false));
        let starts = world.starts;
        for key in (1..).take(SETTING_NAMES.len()) {
            for value in [-1.0, 1e9] {
                let (of, [least, most]) = bounds(&world.ask(write(key, value)), value);
                // The two time-outs of the link depend on each other: the second must be longer than the first.
                assert!(of == key, "{of} for {key}");
                assert!(least <= most, "{key}: {least} to {most}");
            }
        }
        // A reading must be valid for at least a tick, and longer where the bus reads a servo less often.
        let tick_s = 1.0 / kind.rate_hz() as f32;
        let (key, [least_s, _]) = bounds(&world.ask(write(13, 0.9 * tick_s)), 0.9 * tick_s);
        assert!(key == 13 && least_s >= tick_s, "{least_s}");
        // The time-out for a lost link must be longer than that for a late link.
        assert_eq!(bounds(&world.ask(write(1, 2.0)), 2.0), (2, [2.01, 60.0]));
        // An upload of all settings together finds this error, too.
        let mut bytes = settings(kind).bytes();
        // Each setting has a key of two bytes and a value of four; they are in order, from key 1.
        let at = 12 * 6 + 2;
        bytes[at..at + 4].copy_from_slice(&(0.9 * tick_s).to_le_bytes());
        let of: Item = item(ItemKind::Settings, &bytes, rig(kind).1);
        assert_eq!(bounds(&world.upload(&of, &bytes), 0.9 * tick_s).0, 13);

        assert_eq!(world.starts, starts, "nothing was stored");
        let told = world.ask(Command::ReadSetting { key: 13 });
        assert_eq!(told, Outcome::Applied(Applied::Setting(Value::Number(0.1))));
        // The bound that was reported is accepted, and the rig starts with it.
        assert!(matches!(world.ask(write(13, least_s)), Outcome::Applied(_)));
        world.connect();
        assert_eq!(world.starts, starts + 1);
        world.until(State::Limp, 2.0);
    }
}

#[test]
fn what_is_taken_is_what_a_start_takes() {
    let (mut seed, mut counts) = (32, [0; 2]);
    for _ in 0..3000 {
        let key = random(&mut seed) as u16 % (SETTING_NAMES.len() as u16 + 2);
        // Usually a value close to the current one, otherwise any number.
        let own = settings(Kind::Current).get(key).unwrap_or(1.0);
        let value = match random(&mut seed) % 3 {
            0 => f32::from_bits(random(&mut seed) as u32),
            1 => own * (random(&mut seed) % 4000) as f32 / 1000.0,
            _ => own * (random(&mut seed) % 100) as f32,
        };
        let mut bytes = key.to_le_bytes().to_vec();
        bytes.extend(value.to_le_bytes());
        counts[usize::from(decoders::settings(&bytes))] += 1;
    }
    assert!(counts.into_iter().all(|count| count > 500), "{counts:?}");
}

#[test]
fn a_refusal_names_the_setting() {
    let refused = settings(Kind::Current).with(13, 0.001).unwrap_err();
    assert_eq!(refused.to_string(), "stale_s is 0.001; it must be a number from 0.0025 to 10");
    let refused = settings(Kind::Current).with(12, f32::NAN).unwrap_err();
    assert!(matches!(refused, SettingsError::Value(_)), "{refused}");
}
