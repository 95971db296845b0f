//! Tests of a PCA9685 and its hobby servos.

use sinew_servo_bus::pca9685::{Bus, ChannelSetup, Device, Prescale, all_off, start};
use sinew_servo_bus::{Command, CommandError, Limit, Request, ServoBus, SetupError};

fn setup(channel: u8) -> ChannelSetup {
    ChannelSetup { channel, pulse_us: [1000.0, 2000.0], range_rad: [-0.8, 0.8] }
}

fn started(prescale: Prescale) -> Device {
    let mut chip = Device::new(25e6);
    for transfer in start(&prescale) {
        chip.write(transfer.bytes());
    }
    chip
}

/// Source: formula of the data sheet: oscillator rate / (4096 * pulse rate), rounded, minus 1.
#[test]
fn prescales() {
    for (rate_hz, divider) in [(50.0, 121), (60.0, 101), (100.0, 60), (200.0, 30), (333.0, 17)] {
        assert_eq!(Prescale::new(25e6, rate_hz).unwrap().divider(), divider);
    }
    let fifty = Prescale::new(25e6, 50.0).unwrap();
    assert!((fifty.step_us() - 4.88).abs() < 1e-3 && (fifty.rate_hz() - 50.03).abs() < 1e-2);
    for rate_hz in [0.0, -1.0, 20.0, 2000.0, f32::NAN, f32::INFINITY] {
        assert!(Prescale::new(25e6, rate_hz).is_err(), "{rate_hz}");
    }
}

#[test]
fn pulses_arrive() {
    let prescale = Prescale::new(25e6, 50.0).unwrap();
    let mut chip = started(prescale);
    let mut bus = Bus::new(&[setup(0), setup(3), setup(15)], prescale, 400_000).unwrap();
    let mut out = [0; 80];
    assert_eq!(bus.plan(&mut out), Ok(Request::default()));
    for (servo, rad) in [0.0, -0.8, 2.0].into_iter().enumerate() {
        let limit = bus.command(servo, Command::Position(rad)).unwrap();
        assert_eq!(limit, (servo == 2).then_some(Limit::Position));
    }
    // Positions alone cause no pulses.
    let request = bus.plan(&mut out).unwrap();
    chip.write(&out[..request.len]);
    assert!((0..16).all(|channel| chip.pulse_us(channel).is_none()));
    for servo in 0..3 {
        bus.command(servo, Command::Torque(true)).unwrap();
    }
    let request = bus.plan(&mut out).unwrap();
    assert_eq!((request.len, request.reply_len, request.time_us), (65, 0, 1490));
    chip.write(&out[..request.len]);
    for (channel, us) in [(0, 1500.0), (3, 1000.0), (15, 2000.0)] {
        assert!(
            (chip.pulse_us(channel).unwrap() - us).abs() <= prescale.step_us() / 2.0,
            "channel {channel}"
        );
    }
    assert_eq!(chip.pulse_us(1), None);
    // Only changed channels are written: 4 bytes and the address.
    bus.command(1, Command::Position(0.4)).unwrap();
    let request = bus.plan(&mut out).unwrap();
    assert_eq!((request.len, out[0]), (5, 0x06 + 12));
    chip.write(&out[..request.len]);
    assert!((chip.pulse_us(3).unwrap() - 1750.0).abs() <= prescale.step_us() / 2.0);
    assert_eq!(bus.command(1, Command::Position(0.4)), Ok(None));
    assert_eq!(bus.plan(&mut out), Ok(Request::default()));
    chip.write(all_off().bytes());
    assert!((0..16).all(|channel| chip.pulse_us(channel).is_none()));
}

#[test]
fn what_cannot_be_is_refused() {
    let prescale = Prescale::new(25e6, 50.0).unwrap();
    let refused = |setups: &[ChannelSetup]| Bus::new(setups, prescale, 400_000).unwrap_err();
    assert_eq!(refused(&[setup(16)]), SetupError::Id(16));
    assert_eq!(refused(&[setup(1), setup(1)]), SetupError::Shared(1));
    let pulse = SetupError::Setting { id: 2, what: "pulse_us" };
    for pulse_us in [[0.0, 2000.0], [1000.0, f32::NAN], [1000.0, 20_000.0]] {
        assert_eq!(refused(&[ChannelSetup { pulse_us, ..setup(2) }]), pulse);
    }
    let mut bus = Bus::new(&[setup(2)], prescale, 400_000).unwrap();
    assert_eq!(
        bus.command(0, Command::Position(f32::NAN)),
        Err(CommandError::NotFinite("position"))
    );
    assert_eq!(bus.command(0, Command::Current(1.0)), Err(CommandError::Unsupported("current")));
    assert!(bus.plan(&mut [0; 4]).is_ok());
    bus.command(0, Command::Torque(true)).unwrap();
    assert!(
        bus.plan(&mut [0; 4]).is_err() && bus.plan(&mut [0; 5]).unwrap().len == 5,
        "no room, and no command lost"
    );
}

/// Every command stays within the calibrated pulses.
#[test]
fn mirrored_servos_and_all_positions() {
    let prescale = Prescale::new(26.1e6, 100.0).unwrap();
    let mut chip = Device::new(26.1e6);
    for transfer in start(&prescale) {
        chip.write(transfer.bytes());
    }
    let mirrored = ChannelSetup { channel: 7, pulse_us: [2400.0, 600.0], range_rad: [0.0, 3.0] };
    let mut bus = Bus::new(&[mirrored], prescale, 400_000).unwrap();
    bus.command(0, Command::Torque(true)).unwrap();
    let mut out = [0; 80];
    for step in -50..=350_i16 {
        let rad = f32::from(step) * 0.01;
        bus.command(0, Command::Position(rad)).unwrap();
        let request = bus.plan(&mut out).unwrap();
        chip.write(&out[..request.len]);
        let us = chip.pulse_us(7).unwrap();
        let expected = 2400.0 - 600.0 * rad.clamp(0.0, 3.0);
        assert!((us - expected).abs() <= prescale.step_us() * 0.51, "{rad}: {us}");
    }
}

/// A write to the test mode, the last register, changes no other register. Before it are PRESCALE and the four
/// registers that write all channels at once.
#[test]
fn nothing_but_channels_is_written_by_a_packet_that_is_none() {
    let prescale = Prescale::new(25e6, 50.0).unwrap();
    let mut chip = started(prescale);
    let mut bus = Bus::new(&[setup(0)], prescale, 400_000).unwrap();
    let mut out = [0; 80];
    bus.command(0, Command::Position(0.0)).unwrap();
    bus.command(0, Command::Torque(true)).unwrap();
    let request = bus.plan(&mut out).unwrap();
    chip.write(&out[..request.len]);
    let (pulse_us, mut before, mut behind) = (chip.pulse_us(0), [0; 70], [0; 70]);
    chip.write(&[0]);
    chip.read(&mut before);
    chip.write(&[0xFF, 0x10]);
    chip.write(&[0]);
    chip.read(&mut behind);
    assert!(pulse_us.is_some() && chip.pulse_us(0) == pulse_us);
    assert_eq!(before, behind);
}
