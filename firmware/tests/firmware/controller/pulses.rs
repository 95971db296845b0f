//! Hobby servos report nothing: after a stop they are armed at the positions that they were last sent.

use sinew_firmware::controller::{Inputs, MotionController, ServoSetup, Start};
use sinew_firmware::drives::{DriveSettings, TargetSettings};
use sinew_firmware::supervisor::{Command, Feed, State};
use sinew_rig::board::BoardRig;
use sinew_rig::new;
use sinew_servo_bus::pca9685::{Bus, ChannelSetup, Device, Prescale, start};
use sinew_servo_bus::{Cost, Schedule, ServoBus, Timing, Traffic};

use super::test_rig::{Kind, Live, Parts, setup};

type Face = BoardRig<16, 16, 16>;

/// A face with its PWM chip.
struct TestRig<'f> {
    controller: MotionController<'f, 16, 16, 16, 16>,
    bus: Bus,
    chip: Device,
    live: Live,
    ticks: u64,
}

impl<'f> TestRig<'f> {
    fn new(face: &'f Face) -> Self {
        let prescale = Prescale::new(25e6, 50.0).unwrap();
        let mut chip = Device::new(25e6);
        for transfer in start(&prescale) {
            chip.write(transfer.bytes());
        }
        let channels: Vec<_> = face
            .servos()
            .iter()
            .zip(0..)
            .map(|(servo, channel)| ChannelSetup {
                channel,
                pulse_us: [1000.0, 2000.0],
                range_rad: servo.servo.settings().range_rad,
            })
            .collect();
        let timing = Timing { baud: 400_000, return_delay_us: 0, turnaround_us: 0 };
        let traffic = Traffic {
            servos: channels.len() as u32,
            write: Cost { fixed: 66, each: 0 },
            ask: Cost::default(),
            answer: Cost::default(),
            delay_each: false,
            ask_each: false,
            extra: 0,
        };
        let schedule = Schedule::new(timing, &traffic, 50).unwrap();
        let drive = DriveSettings::Target(TargetSettings { encoder: None });
        let Parts { settings, servos: [like, ..], .. } = setup(Kind::Position);
        let servo = ServoSetup { drive, ..like };
        let servos = vec![servo; channels.len()];
        let controller =
            MotionController::new(face, &settings, &servos, &schedule, Start::default()).unwrap();
        let bus = Bus::new(&channels, prescale, timing.baud).unwrap();
        Self { controller, bus, chip, live: Live::default(), ticks: 0 }
    }

    /// Runs a tick. The chip accepts a write at once.
    fn tick(&mut self, command: Option<Command>) -> State {
        let now_us = self.ticks * 20_000;
        let inputs = Inputs { now_us, heard: true, command, ..Inputs::default() };
        self.ticks += 1;
        let begun = self.controller.begin(&inputs, &mut self.live, &mut self.bus);
        let mut out = [0; 128];
        let len = self.bus.plan(&mut out).unwrap().len;
        self.chip.write(&out[..len]);
        let _fed = self.controller.end(begun, Ok(()), 1000).unwrap();
        self.controller.report().state
    }

    fn until(&mut self, state: State) {
        assert!((0..500).any(|_| self.tick(None) == state), "{:?}", self.controller.report());
    }

    /// Arms the rig and returns all pulses until it holds.
    fn arm(&mut self) -> Vec<Vec<Option<f32>>> {
        self.until(State::Limp);
        (0..500).for_each(|_| {
            self.tick(None);
        });
        let (mut all, mut state) = (vec![], self.tick(Some(Command::Arm)));
        while state == State::Arming {
            all.push(self.pulses());
            state = self.tick(None);
        }
        assert_eq!(state, State::Holding);
        all.retain(|pulses| pulses.iter().all(Option::is_some));
        all
    }

    fn pulses(&self) -> Vec<Option<f32>> {
        (0..self.bus.len()).map(|channel| self.chip.pulse_us(channel)).collect()
    }
}

#[test]
fn after_a_stop_the_first_pulses_are_the_last_ones() {
    let rig = new::face();
    let face = Face::bake(&rig, &rig.mechanism().unwrap()).unwrap();
    let mut test_rig = TestRig::new(&face);
    let home = test_rig.arm().pop().unwrap();

    // Every joint is far from home, within its range: farther than a servo turns in a tick.
    let away = face.dofs().iter().map(|dof| {
        let [least, most] = dof.range;
        let end = if dof.home < 0.5 * (least + most) { most } else { least };
        dof.home + 0.9 * (end - dof.home)
    });
    test_rig.live = Live(Some(away.collect()));
    assert_eq!(test_rig.tick(Some(Command::Play(Feed::Live))), State::Playing);
    (0..500).for_each(|_| {
        test_rig.tick(None);
    });
    let last = test_rig.pulses();
    assert!(last.iter().zip(&home).all(|(last, home)| last != home), "{last:?}, {home:?}");

    assert_eq!(test_rig.tick(Some(Command::EStop)), State::Faulted);
    assert_eq!(test_rig.pulses(), vec![None; last.len()]);
    test_rig.tick(Some(Command::ClearFaults));
    let again = test_rig.arm();
    assert!(!again.is_empty() && again.iter().all(|pulses| *pulses == last), "{last:?}, {again:?}");

    // Repeats the test in the middle of a movement. A count of the chip is 4.9 us, and positions on the path are not
    // whole counts.
    test_rig.live = Live(Some(face.dofs().iter().map(|dof| dof.home).collect()));
    test_rig.tick(Some(Command::Play(Feed::Live)));
    let on_the_way = (0..500).find_map(|_| {
        test_rig.tick(None);
        let pulses = test_rig.pulses();
        pulses.iter().zip(&last).all(|(now, last)| now != last).then_some(pulses)
    });
    test_rig.tick(Some(Command::EStop));
    test_rig.tick(Some(Command::ClearFaults));
    for (first, last) in test_rig.arm()[0].iter().zip(on_the_way.unwrap()) {
        let off_us = first.unwrap() - last.unwrap();
        assert!(off_us.abs() <= 5.0, "{off_us} us");
    }
}
