//! A board with flash, bus line and servos, and its host.

use std::cell::RefCell;

use sinew_firmware::node::{BackgroundTask, ControlLoop, Mail, Next, NodeSettings, Setup, start};
use sinew_firmware::supervisor::{Fault, FaultSet, State};
use sinew_link::message::{Applied, Command, Item, Kind as ItemKind, Outcome, Refusal};
use sinew_qemu_node::limits::{LINE_BPS, RIG_ROOM};
use sinew_qemu_node::node::{ABOUT, commanded, first_session};
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::load::Arm;

use super::emulated::Emulated;
use super::hardware::{Chip, HostPort, Locked, Pins, Servos, TABLE};
use super::host::{Host, next_of_upload};
use super::ideal::{Ideal, NoServos};
use super::line::Trouble;
use super::stored::{item, rig};
use super::test_rig::{Bus, HASH_BEGIN, Kind, bench, figure, hash_of, setup};
use super::told::Told;

type Loop = ControlLoop<'static, 8, 8, 8, 8>;

/// The board from a power-on to the next.
pub(crate) struct Board {
    pub(crate) control: Option<(Loop, Bus)>,
    pub(crate) background: BackgroundTask<'static, Chip, 8, 8, 8, 8>,
    pub(crate) mail: Locked,
}

pub(crate) struct World {
    pub(crate) kind: Kind,
    pub(crate) chip: Chip,
    pub(crate) bench: Bench<'static, Vec<Arm>>,
    pub(crate) pins: Pins,
    pub(crate) board: Board,
    pub(crate) host: Host,
    pub(crate) hash: u64,
    pub(crate) starts: u16,
    pub(crate) ticks: u64,
    /// Whether the board did not start because its flash has no power.
    pub(crate) is_dead: bool,
    /// Ideal servos that replace the simulated ones.
    pub(crate) ideal: Option<Ideal>,
    /// An emulated board that replaces the one in process.
    pub(crate) emulated: Option<Emulated>,
    /// Hash of all that the loop has [`commanded`].
    pub(crate) commanded: u64,
    /// Number of the background task's steps per tick.
    pub(crate) steps: u32,
    /// False readings of servo 0.
    pub(crate) told: Told,
    /// Bytes that were sent to servos in the last tick.
    pub(crate) sent: Vec<u8>,
    /// Time by which each tick of the loop is longer, us.
    pub(crate) late_us: u64,
}

fn boot(kind: Kind, chip: &Chip, first_session: u16, causes: FaultSet) -> Option<Board> {
    let parts = setup(kind);
    let defaults = NodeSettings::new(parts.settings, parts.schedule);
    let mut room = vec![0; RIG_ROOM];
    let slot = Box::leak(Box::new_uninit());
    let chip = chip.clone();
    let found = start::<_, 8, 8, 8>(chip, TABLE, |_| defaults, causes, &mut room, slot).ok()?;
    let rig = found.rig;
    let (tick_s, line_bps) = (1e-6 * parts.schedule.tick_us() as f32, LINE_BPS);
    let control = rig.and_then(|(rig, _)| {
        let (settings, start) = (&found.settings, found.start);
        let control =
            ControlLoop::new(rig, settings, &parts.servos, &parts.schedule, start).ok()?;
        Some((control, parts.bus.into()))
    });
    let rig = rig.filter(|_| control.is_some());
    let (settings, is_bad) = (found.settings, found.is_bad);
    let setup = Setup { about: ABOUT, settings, is_bad, rig, tick_s, line_bps };
    Some(Board {
        control,
        background: BackgroundTask::new(found.store, setup, first_session),
        mail: Locked(RefCell::new(Mail::new(found.disarmed))),
    })
}

impl World {
    pub(crate) fn new(kind: Kind, trouble: Trouble, seed: u64) -> Self {
        Self::with(kind, Chip::new(), trouble, seed)
    }

    /// Creates a world whose board has this flash.
    pub(crate) fn with(kind: Kind, chip: Chip, trouble: Trouble, seed: u64) -> Self {
        let board = boot(kind, &chip, first_session(1), FaultSet::EMPTY).unwrap();
        Self {
            kind,
            chip,
            bench: bench(kind, &setup(kind)),
            pins: Pins::default(),
            board,
            host: Host::new(trouble, seed),
            hash: HASH_BEGIN,
            starts: 1,
            ticks: 0,
            is_dead: false,
            ideal: None,
            emulated: None,
            commanded: HASH_BEGIN,
            steps: 4,
            told: Told::default(),
            sent: Vec::new(),
            late_us: 0,
        }
    }

    /// Creates a world with rig and show stored, a connected host, and the show loaded.
    pub(crate) fn ready(kind: Kind, trouble: Trouble, seed: u64, show: &[u8]) -> Self {
        let mut world = Self::new(kind, Trouble::default(), seed);
        world.store(show);
        (world.host.there.trouble, world.host.back.trouble) = (trouble, trouble);
        world
    }

    /// Uploads rig and show, and loads the show.
    pub(crate) fn store(&mut self, show: &[u8]) {
        self.connect();
        let (bytes, crc) = rig(self.kind);
        self.upload(&item(ItemKind::Rig, &bytes, 0), &bytes);
        self.connect();
        self.upload(&item(ItemKind::Show, show, crc), show);
        assert_eq!(self.ask(Command::LoadShow { slot: 0 }), Outcome::Applied(Applied::Done));
    }

    pub(crate) fn tick_us(&self) -> u64 {
        u64::from(1_000_000 / self.kind.rate_hz())
    }

    pub(crate) fn now_us(&self) -> u64 {
        self.ticks * self.tick_us()
    }

    /// Restarts the board with the data in flash; its clock continues, and so does the host's. Returns whether the
    /// board started.
    pub(crate) fn restart(&mut self) -> bool {
        self.restart_after(FaultSet::EMPTY)
    }

    /// Restarts the board for these reasons. Returns whether it started.
    fn restart_after(&mut self, causes: FaultSet) -> bool {
        self.starts += 1;
        self.pins.outputs = false;
        *self.chip.lent.borrow_mut() = None;
        let board = boot(self.kind, &self.chip, first_session(self.starts), causes);
        board.map(|board| self.board = board).is_some()
    }

    /// Lets a tick of time pass without a board.
    pub(crate) fn pass_tick(&mut self) {
        self.bench.run_us(self.tick_us() as u32);
        self.ticks += 1;
    }

    /// Makes the board's program panic. The board starts again after `ticks`; `look` sees the servos after each tick.
    pub(crate) fn panic(&mut self, ticks: u32, mut look: impl FnMut(&Bench<'static, Vec<Arm>>)) {
        if let Some(emulated) = &mut self.emulated {
            emulated.panic();
        }
        for _ in 0..ticks {
            self.pass_tick();
            look(&self.bench);
        }
        if self.emulated.is_none() {
            assert!(self.restart_after(FaultSet::of(Fault::Panic)));
        }
    }

    /// Returns whether a fault is present, and whether it is latched.
    pub(crate) fn has(&self, fault: Fault) -> [bool; 2] {
        if let Some(emulated) = &self.emulated {
            return emulated.has(fault);
        }
        let (control, _) = self.board.control.as_ref().unwrap();
        let report = control.controller().report();
        [report.present, report.latched].map(|faults| faults.contains(fault))
    }

    pub(crate) fn tick(&mut self) {
        self.sent.clear();
        let (tick_us, now_us) = (self.tick_us(), self.now_us());
        let base_s = self.bench.time_s();
        let end_s = base_s + 1e-6 * tick_us as f64;
        self.pins.clock_us.set(now_us);
        self.ticks += 1;
        if let (Some((control, _)), Some(ideal)) = (&mut self.board.control, &mut self.ideal) {
            let (mail, mut wire) = (&self.board.mail, NoServos { hash: &mut self.hash });
            let ended = control.tick(&mut self.pins, mail, ideal, &mut wire, &mut [0; 1024]);
            assert!(ended.is_ok(), "{ended:?}");
            self.below();
            return self.host.step(now_us);
        }
        if let Some(mut emulated) = self.emulated.take() {
            emulated.tick(self, [base_s, end_s]);
            self.emulated = Some(emulated);
        } else if let Some((control, bus)) = &mut self.board.control {
            let clock_us = self.pins.clock_us.clone();
            let late_us = self.late_us;
            let Self { bench, hash, told, sent, .. } = self;
            let mut wire = Servos {
                bench,
                base_s,
                end_s,
                clock_us,
                start_us: now_us,
                late_us,
                hash,
                told,
                sent,
            };
            let mut out = [0; 1024];
            let ended = control.tick(&mut self.pins, &self.board.mail, bus, &mut wire, &mut out);
            assert!(ended.is_ok(), "{ended:?}");
            let controller = control.controller();
            let numbers = commanded(controller);
            numbers.for_each(|number| hash_of(&mut self.commanded, &number.to_le_bytes()));
            if controller.report().show.is_none() {
                *self.chip.lent.borrow_mut() = None;
            }
            self.check();
        }
        let left_us = ((end_s - self.bench.time_s()) * 1e6).max(0.0);
        self.bench.run_us(left_us.round() as u32);
        self.below();
        self.host.step(now_us);
    }

    /// Runs the steps of the background task; an emulated board has run them already.
    fn below(&mut self) {
        if self.emulated.is_some() {
            return;
        }
        for _ in 0..self.steps {
            let Self { host, chip, board, .. } = self;
            let mut port = HostPort {
                now_us: self.ticks * u64::from(1_000_000 / self.kind.rate_hz()),
                host,
                chip,
            };
            if board.background.step(&mut port, &board.mail) == Next::Restart {
                self.is_dead = !self.restart();
                return;
            }
        }
    }

    /// Checks what must be true in each tick, whatever the host sends.
    fn check(&mut self) {
        let Some((control, _)) = &self.board.control else { return };
        let controller = control.controller();
        let report = controller.report();
        assert_eq!(report.state.is_on(), controller.permission().torque);
        assert_eq!(self.pins.outputs, controller.permission().torque);
        let (q, qd) = controller.commanded();
        for ((q, qd), dof) in q.iter().zip(qd).zip(figure(self.kind).board.dofs()) {
            let [least, most] = dof.range;
            assert!((least..=most).contains(q), "{q}");
            assert!(qd.abs() <= dof.speed * 1.001, "{qd}");
        }
    }

    pub(crate) fn run(&mut self, seconds: f64) {
        for _ in 0..(seconds * f64::from(self.kind.rate_hz())).round() as u64 {
            self.tick();
        }
    }

    pub(crate) fn state(&self) -> Option<State> {
        if let Some(emulated) = &self.emulated {
            return emulated.state;
        }
        self.board.control.as_ref().map(|(control, _)| control.controller().report().state)
    }

    pub(crate) fn until(&mut self, state: State, seconds: f64) {
        for _ in 0..(seconds * f64::from(self.kind.rate_hz())).round() as u64 {
            if self.state() == Some(state) {
                return;
            }
            self.tick();
        }
        panic!("{state} did not come: {:?}, faults {:?}", self.state(), self.host.faults);
    }

    /// Says hello until the host is welcome.
    pub(crate) fn connect(&mut self) {
        self.host.greet();
        for _ in 0..4000 {
            self.tick();
            if self.host.welcome.is_some_and(|welcome| welcome.verdict.is_ok()) {
                return;
            }
        }
        panic!("no welcome: {:?}", self.host.welcome);
    }

    /// Sends a command and waits for its answer.
    pub(crate) fn ask(&mut self, command: Command) -> Outcome {
        self.host.ask(command, self.now_us());
        for _ in 0..20_000 {
            self.tick();
            if let Some(outcome) = self.host.outcome.take() {
                return outcome;
            }
        }
        panic!("no answer");
    }

    /// Uploads an item, block by block.
    pub(crate) fn upload(&mut self, item: &Item, content: &[u8]) -> Outcome {
        let mut outcome = None;
        loop {
            let command = next_of_upload(item, content, outcome.as_ref());
            let is_end = command == Command::EndUpload;
            let said = self.ask(command);
            if is_end || matches!(said, Outcome::Refused(_)) {
                return said;
            }
            outcome = Some(said);
        }
    }

    /// Arms as soon as the rig rests.
    pub(crate) fn arm(&mut self) -> Outcome {
        for _ in 0..300 {
            let outcome = self.ask(Command::Arm);
            if !matches!(outcome, Outcome::Refused(Refusal::Moving { .. })) {
                return outcome;
            }
            self.run(0.1);
        }
        panic!("it does not come to rest");
    }

    pub(crate) fn servos_on(&self) -> usize {
        let register = if self.kind == Kind::Position { 40 } else { 64 };
        self.bench.servos().iter().filter(|servo| servo.get(register) == 1).count()
    }
}
