//! Tests the tools for any servo: find it, read and write it, set id and baud rate, identify it.
#![expect(clippy::unwrap_used, reason = "a test may fail by panicking")]

use std::io;
use std::time::Duration;

use sinew_servo_sim::fault::{Fault, FaultKind};
use sinew_servo_tools::registers::{self, Number};
use sinew_servo_tools::{
    Client, Exchange, Protocol, Registers, ScanEvent, ScanSettings, ServiceError, Servo, Settings,
    address, find, identify, scan, watch,
};

use crate::common::{KINDS, SimLine, client};

/// Returns a client and its first servo.
fn one(kind: &str) -> (Client<SimLine>, Servo) {
    let mut client = client(&[(kind, 1)]);
    let servo = client.open(1, None).unwrap();
    (client, servo)
}

fn read(client: &mut Client<SimLine>, servo: &Servo, name: &str) -> i32 {
    registers::read(client, servo, &[name.to_owned()]).unwrap()[0].quantity.raw
}

#[test]
fn a_scan_finds_servos_at_all_their_rates_and_says_what_they_are() {
    let mut client = client(&[("XL330-M288-T", 3), ("XL430-W250-T", 7), ("STS3215-7.4V", 9)]);
    client.line_mut().bench.servos_mut()[1].set_baud(3_000_000).unwrap();
    let mut rates = 0;
    let found = scan(&mut client, &ScanSettings::default(), &mut |event| {
        rates += u32::from(matches!(event, ScanEvent::Rate(..)));
    })
    .unwrap();
    let seen: Vec<_> = found.iter().map(|found| (found.id, found.baud, found.model)).collect();
    assert_eq!(
        seen,
        [
            (3, 57_600, Some("XL330-M288")),
            (7, 3_000_000, Some("XL430-W250")),
            (9, 1_000_000, Some("STS3215")),
        ]
    );
    assert_eq!(found[0].model_number, 1200);
    assert_eq!(found[0].firmware, "52");
    assert_eq!(rates, 16);
}

#[test]
fn a_rate_that_the_adapter_does_not_do_is_told_and_the_scan_goes_on() {
    let mut client = client(&[("XL330-M288-T", 3)]);
    client.line_mut().most_baud = 1_000_000;
    let settings = ScanSettings { protocols: vec![Protocol::Dynamixel], ..ScanSettings::default() };
    let mut refused = Vec::new();
    let found = scan(&mut client, &settings, &mut |event| {
        if let ScanEvent::NoRate(baud, _) = event {
            refused.push(baud);
        }
    });
    assert_eq!(found.unwrap().len(), 1);
    assert_eq!(refused, [2_000_000, 3_000_000, 4_000_000, 4_500_000]);
}

/// A line with two servos that have the same id and answer at the same time: the answer is not a packet.
struct Collision(Protocol);

impl Exchange for Collision {
    fn exchange(
        &mut self,
        bytes: &[u8],
        _: Duration,
        take: &mut dyn FnMut(&[u8]) -> bool,
    ) -> io::Result<()> {
        let id = if self.0 == Protocol::Dynamixel { bytes[4] } else { bytes[2] };
        if id == 1 || id == 0xFE {
            take(&[0xFF, 0xFF, 0xF1, 0x00, 0x01, 0x07, 0x81, 0x55, 0x7F]);
        }
        Ok(())
    }

    fn set_baud(&mut self, _: u32) -> io::Result<()> {
        Ok(())
    }

    fn pause(&mut self, _: Duration) {}
}

#[test]
fn two_servos_of_one_id_are_told_from_none() {
    for protocol in Protocol::ALL {
        let mut client =
            Client::new(Collision(protocol), protocol, 1_000_000, Settings::default()).unwrap();
        let settings = ScanSettings {
            protocols: vec![protocol],
            bauds: vec![1_000_000],
            ..ScanSettings::default()
        };
        let mut collisions = Vec::new();
        let found = scan(&mut client, &settings, &mut |event| {
            if let ScanEvent::Collision(_, _, id) = event {
                collisions.push(id);
            }
        });
        assert_eq!((found.unwrap().len(), collisions), (0, vec![1]), "{protocol:?}");
        assert!(matches!(client.open(1, None), Err(ServiceError::Noise { id: 1 })));
        assert!(matches!(client.open(2, None), Err(ServiceError::Silent { id: 2, .. })));
    }
}

#[test]
fn a_servo_is_found_wherever_it_listens() {
    for (kind, baud) in [("XL430-W250-T", 2_000_000), ("STS3215-7.4V", 115_200)] {
        let mut client = client(&[(kind, 5)]);
        client.line_mut().bench.servos_mut()[0].set_baud(baud).unwrap();
        let servo = find(&mut client, 5, &Protocol::ALL, None, None).unwrap();
        assert_eq!((servo.id, client.baud()), (5, baud));
        let nobody = find(&mut client, 6, &Protocol::ALL, None, None).unwrap_err();
        assert!(nobody.to_string().contains("Dynamixel and Feetech"), "{nobody}");
    }
}

#[test]
fn an_adapter_that_gives_back_what_it_sends_is_not_a_servo() {
    for kind in KINDS {
        let mut client = client(&[(kind, 1)]);
        client.line_mut().echoes = true;
        let servo = client.open(1, None).unwrap();
        assert!(read(&mut client, &servo, "Present Temperature") > 10, "{kind}");
        assert!(matches!(client.open(2, None), Err(ServiceError::Silent { .. })));
    }
}

#[test]
fn registers_are_read_and_written_by_name_in_units() {
    let (mut client, servo) = one("XL330-M288-T");
    let all = registers::read(&mut client, &servo, &[]).unwrap();
    assert_eq!(all.len(), servo.table.items().len());
    let written =
        registers::write(&mut client, &servo, "max_position_limit", Number::Value(270.0)).unwrap();
    assert_eq!((written.quantity.raw, written.is_kept), (3072, true));
    assert_eq!(written.quantity.to_string(), "270.00 deg");
    assert_eq!(client.line_mut().bench.servos()[0].get(48), 3072);
    registers::write(&mut client, &servo, "LED", Number::Raw(1)).unwrap();
    assert_eq!(read(&mut client, &servo, "led"), 1);
}

#[track_caller]
fn refusal(client: &mut Client<SimLine>, servo: &Servo, name: &str, number: Number) -> String {
    let before = client.line_mut().writes();
    let error = registers::write(client, servo, name, number).unwrap_err().to_string();
    assert_eq!(client.line_mut().writes(), before, "nothing was written: {error}");
    error
}

#[test]
fn writes_that_cannot_be_right_are_refused_before_they_are_sent() {
    let (mut client, servo) = one("XL430-W250-T");
    let mut refused = |name: &str, number| refusal(&mut client, &servo, name, number);
    let range = refused("Goal PWM", Number::Value(101.0));
    assert_eq!(
        range,
        "Goal PWM takes -100.0 % to 100.0 % (-885 to 885 raw); found 101.0 % (894 raw)"
    );
    assert!(refused("Goal PWM", Number::Value(f64::NAN)).contains("found NaN"));
    assert!(refused("Goal PWM", Number::Value(f64::INFINITY)).contains("found inf"));
    assert!(refused("Goal Position", Number::Raw(4096)).contains("0.00 deg to 359.91 deg"));
    // The servo does not measure current, so it has no current modes.
    assert!(refused("Operating Mode", Number::Raw(5)).contains("one of 1, 3, 4, 16"));
    assert!(refused("Present Position", Number::Raw(1)).contains("only be read"));
    assert!(refused("ID", Number::Raw(2)).contains("set-id 1"));
    assert!(refused("Baud Rate", Number::Raw(2)).contains("set-baud 1"));
    assert!(refused("Protocol Type", Number::Raw(2)).contains("could not reach"));
    assert!(refused("Positon Limit", Number::Raw(2)).contains("Max Position Limit"));
    assert!(refused("xyzzy", Number::Raw(2)).contains("shows all of them"));

    registers::set_torque(&mut client, &servo, true).unwrap();
    let on = refusal(&mut client, &servo, "Return Delay Time", Number::Raw(1));
    assert!(on.contains("EEPROM") && on.contains("torque-enable 0"), "{on}");
}

#[test]
fn a_feetech_keeps_what_is_written_and_its_lock_is_shut() {
    let (mut client, servo) = one("STS3215-7.4V");
    let mut refused = |name: &str, number| refusal(&mut client, &servo, name, number);
    // 128 would move its middle, and an open lock loses settings.
    assert!(refused("Torque Enable", Number::Raw(128)).contains("0, 1, 2"));
    assert!(refused("Lock", Number::Raw(0)).contains("shut again"));
    assert!(refused("Goal Position", Number::Raw(2048)).contains("torque-enable 1 first"));

    registers::write(&mut client, &servo, "P Coefficient", Number::Raw(16)).unwrap();
    assert_eq!(read(&mut client, &servo, "Lock"), 1);
    client.reboot(&servo).unwrap();
    assert_eq!(read(&mut client, &servo, "P Coefficient"), 16, "it survives a reboot");
}

#[test]
fn lost_and_damaged_replies_are_asked_again_and_none_is_believed() {
    for kind in KINDS {
        let mut client = client(&[(kind, 1)]);
        let servo = client.open(1, None).unwrap();
        let settings = Settings { tries: 12, ..Settings::default() };
        let mut line = client.into_line();
        (line.lost, line.damaged) = (20, 20);
        let baud = line.bench.baud;
        let mut client = Client::new(line, servo.table.protocol(), baud, settings).unwrap();
        for count in 0..100 {
            let least = "Min Position Limit";
            registers::write(&mut client, &servo, least, Number::Raw(count)).unwrap();
            assert_eq!(read(&mut client, &servo, least), count, "{kind}");
        }
        // Each write takes several packets: the line was really as bad as configured.
        assert!(client.line_mut().sent.len() > 400, "{}", client.line_mut().sent.len());
    }
}

#[test]
fn late_answers_are_not_taken_for_those_to_the_next_question() {
    for kind in KINDS {
        // One wait is 34 ms plus the time of the bytes: the delays are within one, two and three waits, and longer.
        for late_us in [20_000, 50_000, 90_000, 130_000] {
            let mut client = client(&[(kind, 1)]);
            let servo = client.open(1, None).unwrap();
            let (least, most) = ("Min Position Limit", "Max Position Limit");
            registers::write(&mut client, &servo, least, Number::Raw(100)).unwrap();
            registers::write(&mut client, &servo, most, Number::Raw(200)).unwrap();
            let kind = FaultKind::Late(late_us);
            let late = Fault { servo: 0, at_s: 0.0, for_s: f64::INFINITY, kind };
            client.line_mut().bench.faults.push(late);
            let mut answered = 0;
            for (name, expected) in [(least, 100), (most, 200)].into_iter().cycle().take(20) {
                if let Ok(read) = registers::read(&mut client, &servo, &[name.to_owned()]) {
                    assert_eq!(read[0].quantity.raw, expected, "{kind:?}");
                    answered += 1;
                }
            }
            assert_eq!(answered, if late_us < 100_000 { 20 } else { 0 }, "{kind:?}");
        }
    }
}

#[test]
fn a_dead_line_is_silence_and_no_endless_wait() {
    let (mut client, servo) = one("XL330-M288-T");
    client.line_mut().lost = 100;
    client.line_mut().sent.clear();
    let error = registers::read(&mut client, &servo, &["LED".to_owned()]).unwrap_err();
    assert!(matches!(error, ServiceError::Silent { id: 1, baud: 57_600 }), "{error}");
    assert_eq!(client.line_mut().sent.len(), 6, "three reads, three pings");
}

#[test]
fn a_servo_that_answers_pings_only_says_how_it_is_woken() {
    let (mut client, servo) = one("XL330-M288-T");
    registers::write(&mut client, &servo, "Status Return Level", Number::Raw(1)).unwrap();
    // Writes are not answered now, but are verified by reading back.
    registers::write(&mut client, &servo, "LED", Number::Raw(1)).unwrap();
    client.line_mut().bench.servos_mut()[0].set(68, 0);
    let error = registers::read(&mut client, &servo, &["LED".to_owned()]).unwrap_err();
    assert!(error.to_string().contains("status-return-level 2"), "{error}");
    registers::write(&mut client, &servo, "status-return-level", Number::Raw(2)).unwrap();
    assert_eq!(read(&mut client, &servo, "LED"), 1);
}

#[test]
fn an_id_changes_unless_it_is_taken() {
    for kind in KINDS {
        let mut client = client(&[(kind, 1), (kind, 2)]);
        let servo = client.open(1, None).unwrap();
        let taken = address::set_id(&mut client, &servo, 2).unwrap_err();
        assert!(matches!(taken, ServiceError::IdTaken { id: 2, .. }), "{taken}");
        assert!(matches!(address::set_id(&mut client, &servo, 253), Err(ServiceError::BadId(253))));

        registers::set_torque(&mut client, &servo, true).unwrap();
        let on = address::set_id(&mut client, &servo, 7).unwrap_err();
        assert!(matches!(on, ServiceError::Register(Registers::TorqueOn { .. })), "{on}");
        registers::set_torque(&mut client, &servo, false).unwrap();

        let moved = address::set_id(&mut client, &servo, 7).unwrap();
        assert_eq!(client.open(7, None).unwrap(), moved);
        assert!(client.open(1, None).is_err() && client.open(2, None).is_ok());
        // The id survives a reboot, and the EEPROM is shut.
        client.reboot(&moved).unwrap();
        if kind.starts_with("STS") {
            assert_eq!(read(&mut client, &moved, "Lock"), 1);
        }
    }
}

#[test]
fn a_rate_changes_and_the_client_follows() {
    for (kind, baud) in
        [("XL330-M288-T", 4_000_000), ("XL430-W250-T", 4_500_000), ("STS3215-7.4V", 500_000)]
    {
        let (mut client, servo) = one(kind);
        let none = address::set_baud(&mut client, &servo, 123_456).unwrap_err().to_string();
        assert!(none.contains("expected one of") && none.contains("115200"), "{none}");
        address::set_baud(&mut client, &servo, baud).unwrap();
        assert_eq!(client.baud(), baud);
        assert_eq!(client.open(1, None).unwrap(), servo);
    }
    let (mut client, servo) = one("XL330-M288-T");
    let too_fast = address::set_baud(&mut client, &servo, 4_500_000).unwrap_err();
    assert!(matches!(too_fast, ServiceError::NoBaud { .. }), "{too_fast}");
    client.line_mut().most_baud = 1_000_000;
    let adapter = address::set_baud(&mut client, &servo, 2_000_000).unwrap_err();
    assert!(matches!(adapter, ServiceError::Baud { .. }), "{adapter}");
    assert_eq!(client.open(1, None).unwrap(), servo, "it is where it was");
}

#[test]
fn a_servo_shows_itself_and_is_as_it_was() {
    for kind in KINDS {
        let (mut client, servo) = one(kind);
        for on in [false, true] {
            if on {
                // The servo first moves to its last goal.
                registers::set_torque(&mut client, &servo, true).unwrap();
                client.line_mut().bench.run_us(1_000_000);
            }
            let before: Vec<_> = registers::read(&mut client, &servo, &[]).unwrap();
            let place = client.line_mut().bench.servos()[0].shaft().position_rad;
            let shown = identify::identify(&mut client, &servo).unwrap();
            // Friction over the servo's stiffness shortens the motion on both sides, by 3.2 deg for an XL430; an STS
            // without a load swings beyond.
            assert!((5.0..14.0).contains(&shown.moved_deg), "{kind} {on} {shown:?}");
            assert_eq!(shown.has_light, !kind.starts_with("STS"));
            let back = client.line_mut().bench.servos()[0].shaft().position_rad;
            assert!((back - place).abs().to_degrees() < 4.0, "{kind} {on}: {place} {back}");
            let after = registers::read(&mut client, &servo, &[]).unwrap();
            for (before, after) in before.iter().zip(&after) {
                let measures = before.name.starts_with("Present")
                    || before.name.contains("Trajectory")
                    || ["Realtime Tick", "Moving", "Moving Status", "Target Position"]
                        .contains(&before.name);
                // With torque off, a goal has no effect.
                let idle_goal = !on && before.name == "Goal Position";
                assert!(
                    measures || idle_goal || before == after,
                    "{kind} {on}: {before:?} {after:?}"
                );
            }
        }
    }
}

#[test]
fn a_servo_in_trouble_or_outside_of_its_limits_does_not_move() {
    let (mut client, servo) = one("XL330-M288-T");
    registers::write(&mut client, &servo, "Min Position Limit", Number::Value(200.0)).unwrap();
    let outside = identify::identify(&mut client, &servo).unwrap_err().to_string();
    assert!(outside.contains("180.00 deg") && outside.contains("200"), "{outside}");
    registers::write(&mut client, &servo, "Min Position Limit", Number::Raw(0)).unwrap();
    registers::write(&mut client, &servo, "Goal Position", Number::Value(300.0)).unwrap();
    registers::set_torque(&mut client, &servo, true).unwrap();
    let moving = identify::identify(&mut client, &servo).unwrap_err().to_string();
    assert!(moving.contains("from its goal"), "{moving}");
    registers::set_torque(&mut client, &servo, false).unwrap();
    registers::write(&mut client, &servo, "Operating Mode", Number::Raw(16)).unwrap();
    let mode = identify::identify(&mut client, &servo).unwrap_err().to_string();
    assert!(mode.contains("mode is 16"), "{mode}");
    client.line_mut().bench.servos_mut()[0].heat_mut().case_c = 90.0;
    client.line_mut().bench.run_us(10_000);
    let hot = identify::identify(&mut client, &servo).unwrap_err().to_string();
    assert!(hot.contains("too hot") && hot.contains("reboot"), "{hot}");
    assert!(!registers::torque_is_on(&mut client, &servo).unwrap());
}

#[test]
fn a_look_says_how_a_servo_is() {
    for (kind, volts) in [("XL330-M288-T", 5.0), ("XL430-W250-T", 11.1), ("STS3215-7.4V", 7.4)] {
        let (mut client, servo) = one(kind);
        client.line_mut().bench.run_us(50_000);
        let state = watch::look(&mut client, &servo).unwrap();
        assert!((state.position.value - 180.0).abs() < 0.2, "{kind} {:?}", state.position);
        assert!((state.voltage.value - volts).abs() < 0.06, "{kind} {:?}", state.voltage);
        assert!((20.0..35.0).contains(&state.temperature.value), "{kind} {:?}", state.temperature);
        assert_eq!(state.errors, Vec::<&str>::new());
        let unit = if kind.starts_with("XL430") { "%" } else { "A" };
        assert_eq!((state.position.unit, state.effort.unit), ("deg", unit));
    }
    let (mut client, servo) = one("STS3215-7.4V");
    client.line_mut().bench.supplies[0] = sinew_servo_sim::supply::Supply::stiff(15.0);
    client.line_mut().bench.run_us(100_000);
    assert_eq!(watch::look(&mut client, &servo).unwrap().errors, ["supply out of its limits"]);
}

#[test]
fn a_speed_of_an_sts_has_the_unit_of_its_phase() {
    // Degrees per second of a goal speed of 1000 counts, by Phase: bit 2 selects a count/s or 50 counts/s.
    for (phase, deg_s) in [(12, 87.9), (76, 87.9), (8, 4394.5)] {
        let (mut client, servo) = one("STS3215-7.4V");
        registers::write(&mut client, &servo, "phase", Number::Raw(phase)).unwrap();
        let servo = client.open(1, None).unwrap();
        registers::write(&mut client, &servo, "goal-velocity", Number::Raw(1000)).unwrap();
        let goal = registers::read(&mut client, &servo, &["goal-velocity".to_owned()]).unwrap();
        assert!((goal[0].quantity.value - deg_s).abs() < 1.0, "{phase}: {:?}", goal[0]);
        registers::write(&mut client, &servo, "operating-mode", Number::Raw(1)).unwrap();
        registers::write(&mut client, &servo, "torque-enable", Number::Raw(1)).unwrap();
        client.line_mut().bench.run_us(1_000_000);
        let state = watch::look(&mut client, &servo).unwrap();
        // The servo's own speed is at most 3400 counts/s.
        let expected = f64::min(deg_s, 299.0);
        let told = state.velocity.value;
        assert!((told / expected - 1.0).abs() < 0.05, "{phase}: {told} deg/s");
    }
}
