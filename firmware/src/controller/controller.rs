//! The controller: a tick in two halves, with the board's bus exchange between them.

use heapless::Vec;
use sinew_core::tracker::Timing;
use sinew_rig::board::BoardRig;
use sinew_servo_bus::{EncodeError, Health, Schedule, ServoBus};
use sinew_show::{ShowError, ShowFrames};

use super::belief::Belief;
use super::coordinates::{number, put};
use super::error::{ControllerError, Incomplete};
use super::feed::{Jog, LiveSource, SoftStart, Sources, plays_show};
use super::lowering::{Lowering, Parts};
use super::output::Output;
use super::path::Path;
use super::performance::{Carried, Performance};
use super::pose::Pose;
use super::registers::Comparison;
use super::report::{DofReport, Report, ServoReport, filled};
use super::settings::{ControllerSettings, ServoSetup, Start};
use super::stop_test::StopTest;
use super::watch::Watch;
use crate::drives::{Condition, Measured};
use crate::supervisor::{
    Command, Fault, FaultSet, Findings, Inputs as Supervised, Outcome, Overload, Permission,
    Registers, Source, State, Supervisor,
};
use crate::watchdog::Complete;

/// Maximum length of a packet that switches the torque of all servos, bytes: fixed part, and part per servo.
const SWITCH: (u32, u32) = (14, 2);

/// Number of parts of the way to a show's first pose. The servos must be able to hold the rig at both ends of each
/// part.
const WAY: u8 = 4;

/// Inputs of a tick from outside of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Inputs {
    /// Time since the board's start, µs. It never decreases.
    pub now_us: u64,
    /// Whether a valid and *new* message of the host arrived since the last tick.
    pub heard: bool,
    /// A command, if one arrived. Only one command is handled in a tick.
    pub command: Option<Command>,
    /// Faults that the board detects: the line of the emergency stop, settings that cannot be read.
    pub found: FaultSet,
    /// The joint that a user moves.
    pub jog: Option<Jog>,
}

/// A tick in progress, to be passed to [`MotionController::end`].
#[derive(Debug)]
#[must_use = "a tick that is not ended is not whole"]
pub struct Begun {
    result: Result<(), Incomplete>,
}

/// The control loop of a rig with at most `BODIES` bodies, `DOFS` dofs, `SERVOS` servos and `COORDS` coordinates. It
/// contains all of its memory, and is therefore large.
#[derive(Debug)]
pub struct MotionController<
    'a,
    const BODIES: usize,
    const DOFS: usize,
    const SERVOS: usize,
    const COORDS: usize,
> {
    rig: &'a BoardRig<BODIES, DOFS, SERVOS>,
    rig_crc: u32,
    dt_s: f32,
    tick_us: u32,
    /// Time of the last tick, µs, and number of ticks that were left out before it.
    last: (u64, u32),
    supervisor: Supervisor,
    watch: Watch<DOFS, SERVOS>,
    path: Path<DOFS, COORDS>,
    sources: Sources<'a, DOFS, COORDS>,
    performance: Performance<'a, BODIES, DOFS, SERVOS>,
    output: Output<SERVOS>,
    stop_test: StopTest,
    comparison: Comparison<SERVOS>,
    readings: Readings<DOFS, SERVOS, COORDS>,
    permission: Permission,
    state: State,
    is_there: bool,
    lowering: Lowering<DOFS>,
    /// Faults of the tick before, or of the board's start, to be reported in the next tick.
    pending: FaultSet,
    was_late: bool,
    report: Report<DOFS, SERVOS>,
}

/// Readings of the servos from the tick before.
#[derive(Debug)]
pub(super) struct Readings<const DOFS: usize, const SERVOS: usize, const COORDS: usize> {
    pub(super) healths: Vec<Health, SERVOS>,
    /// Conditions with the believed readings.
    pub(super) conditions: Vec<Condition, SERVOS>,
    pub(super) beliefs: Vec<Belief, SERVOS>,
    pub(super) dofs: Vec<Option<Measured>, DOFS>,
    /// Measured positions and velocities; dofs without a measurement have their commanded values.
    pose: Pose<DOFS, COORDS>,
    /// The measured pose for the tracker. Joints whose servos close their own loop have their commanded position: the
    /// tracker cannot correct them, and its corrections would add efforts in other joints for accelerations that
    /// never happen.
    pub(super) tracked: Pose<DOFS, COORDS>,
}

impl<const DOFS: usize, const SERVOS: usize, const COORDS: usize> Readings<DOFS, SERVOS, COORDS> {
    /// Creates readings before the first tick.
    #[inline(never)]
    fn new(dofs: usize, pose: &Pose<DOFS, COORDS>) -> Self {
        Self {
            healths: Vec::new(),
            conditions: Vec::new(),
            beliefs: Vec::new(),
            dofs: filled(dofs, None),
            pose: pose.clone(),
            tracked: pose.clone(),
        }
    }
}

impl<'a, const BODIES: usize, const DOFS: usize, const SERVOS: usize, const COORDS: usize>
    MotionController<'a, BODIES, DOFS, SERVOS, COORDS>
{
    /// Creates a controller at the board's start; torque is off. `schedule` is the schedule of the bus. The servos
    /// of the bus must be those of the rig, in the same order.
    ///
    /// # Errors
    /// [`ControllerError`] names the part that does not fit: the rig, the rate, a setting.
    pub fn new(
        rig: &'a BoardRig<BODIES, DOFS, SERVOS>,
        settings: &ControllerSettings,
        servos: &[ServoSetup],
        schedule: &Schedule,
        start: Start,
    ) -> Result<Self, ControllerError> {
        let mut controller = Self::uninit(rig);
        controller.init(settings, servos, schedule, start)?;
        Ok(controller)
    }

    /// Creates an unconfigured controller of a rig: `init` must follow.
    #[inline(never)]
    pub(crate) fn uninit(rig: &'a BoardRig<BODIES, DOFS, SERVOS>) -> Self {
        let mut supervisor = Supervisor::default();
        // No message was received yet, and no command given: this is the permission before the first tick.
        let Outcome { state, permission, .. } = supervisor.step(&Supervised::default());
        let path = Path::uninit();
        Self {
            rig,
            rig_crc: 0,
            dt_s: 0.0,
            tick_us: 0,
            last: (0, 0),
            supervisor,
            watch: Watch::default(),
            sources: Sources::new(path.now(), SoftStart::default()),
            performance: Performance::uninit(rig),
            output: Output::default(),
            stop_test: StopTest::default(),
            comparison: Comparison::default(),
            readings: Readings::new(0, path.now()),
            path,
            permission,
            state,
            is_there: false,
            lowering: Lowering::new(),
            pending: FaultSet::EMPTY,
            was_late: false,
            report: Report::new(state, permission.source, 0, 0),
        }
    }

    /// Initializes in place. The value is large, and moving it would cost its size in stack.
    #[inline(never)]
    pub(crate) fn init(
        &mut self,
        settings: &ControllerSettings,
        servos: &[ServoSetup],
        schedule: &Schedule,
        start: Start,
    ) -> Result<(), ControllerError> {
        let rig = self.rig;
        let (expected, found) = (rig.servos().len(), servos.len());
        if expected != found {
            return Err(ControllerError::Servos { expected, found });
        }
        let dt_s = 1e-6 * schedule.tick_us() as f32;
        settings.check(schedule)?;
        check_budget(settings.compute_us, schedule, servos.len())?;
        let groups = usize::try_from(schedule.groups()).unwrap_or(usize::MAX);
        let timing = Timing { dt_s, latency_ticks: groups };
        // In a separate call: it takes most of the stack of this function.
        self.performance.init(settings, servos, timing)?;
        (self.rig_crc, self.dt_s, self.tick_us) = (settings.rig_crc, dt_s, schedule.tick_us());
        self.init_others(settings, servos, start)
    }

    #[inline(never)]
    fn init_others(
        &mut self,
        settings: &ControllerSettings,
        servos: &[ServoSetup],
        start: Start,
    ) -> Result<(), ControllerError> {
        let (rig, dt_s) = (self.rig, self.dt_s);
        let found = rig.tree().coordinate_count();
        self.path =
            Path::new(rig, dt_s).ok_or(ControllerError::Capacity { found, holds: COORDS })?;
        self.supervisor = Supervisor::new(settings.supervisor, start.count, start.log)?;
        let Outcome { state, permission, .. } = self.supervisor.step(&Supervised::default());
        (self.state, self.permission) = (state, permission);
        self.report = Report::new(state, permission.source, rig.dofs().len(), rig.servos().len());
        self.watch = Watch::new(rig, settings, servos, dt_s)?;
        self.output = Output::new(rig.servos(), servos, dt_s)?;
        let soft = SoftStart::new(&settings.supervisor, dt_s);
        self.sources = Sources::new(self.path.now(), soft);
        self.readings = Readings::new(rig.dofs().len(), self.path.now());
        for (own, setup) in rig.servos().iter().zip(servos) {
            // A rig's servos are counted: there is room.
            let _ = self.readings.beliefs.push(Belief::new(&own.servo, setup, dt_s));
        }
        self.comparison = Comparison::new(rig.servos(), servos);
        self.pending = start.causes;
        Ok(())
    }

    /// Sets another rest pose than the rig's home.
    ///
    /// # Errors
    /// [`ControllerError::Rest`] if the number of coordinates is wrong, or a coordinate is not from -1e6 to 1e6;
    /// [`ControllerError::RestRange`] if a coordinate is outside of its joint's range.
    pub fn with_rest(mut self, q: &[f32]) -> Result<Self, ControllerError> {
        let rest = self.sources.rest.q_mut();
        let refused = ControllerError::Rest { expected: rest.len(), found: q.len() };
        if rest.len() != q.len() {
            return Err(refused);
        }
        rest.iter_mut().zip(q).for_each(|(rest, q)| *rest = *q);
        if !self.sources.rest.is_finite() {
            return Err(refused);
        }
        // The tolerance of half a millionth of a turn allows for rounding in the caller.
        match self.path.beyond(q, 3e-6) {
            Some(dof) => Err(ControllerError::RestRange { dof }),
            None => Ok(self),
        }
    }

    /// Loads another show, which is read in place; `None` loads no show. The previous show is always released, even if
    /// the other show is refused; if it is playing, the rig holds. O(size).
    ///
    /// # Errors
    /// [`ShowError`] if the show cannot be read, is for another rig, or starts outside of a joint's range. While a show
    /// plays this is also a fault.
    pub fn load_show(&mut self, bytes: Option<&'a [u8]>) -> Result<(), ShowError> {
        let plays = plays_show(self.state, self.permission.source);
        self.sources.load(bytes, (self.rig, self.rig_crc), self.dt_s, plays)
    }

    /// Sets another show, which [`open_show`](super::open_show) has opened in the background; `None` sets no show. If a
    /// show is playing, it ends, and the rig holds. O(1).
    pub fn put_show(&mut self, show: Option<ShowFrames<'a, COORDS>>) {
        self.sources.put(show, plays_show(self.state, self.permission.source));
    }

    /// Returns the duration of a tick, s.
    pub fn dt_s(&self) -> f32 {
        self.dt_s
    }

    /// Runs the first half of a tick: evaluates the readings of the tick before, detects faults, decides the
    /// permission, and gives commands to the bus, which must be [exchanged](super::exchange) next. O(dofs).
    pub fn begin(
        &mut self,
        inputs: &Inputs,
        live: &mut impl LiveSource,
        bus: &mut impl ServoBus,
    ) -> Begun {
        let since_us = inputs.now_us.saturating_sub(self.last.0);
        let late = since_us.checked_div(self.tick_us.into()).unwrap_or(0).saturating_sub(1);
        let late = u32::try_from(late).unwrap_or(u32::MAX);
        // The readings of this tick were made in the tick before, therefore the number of left-out ticks is that of
        // the tick before, too.
        let last = core::mem::replace(&mut self.last, (inputs.now_us, late));
        let is_finite = self.read(bus, last.1);
        let mut findings = self.find(inputs, is_finite);
        let jog = inputs.jog.filter(|jog| jog.speed.is_finite());
        if !self.sources.listen(inputs.now_us, live) || jog.is_some() != inputs.jog.is_some() {
            findings.note(Fault::NotFinite);
        }
        if !self.permission.torque {
            let (watch, healths) = (&self.watch, &self.readings.healths);
            self.comparison.step(bus, |servo| {
                healths.get(servo).is_some_and(|health| watch.is_silent(health))
            });
        }
        let outcome = self.supervise(inputs, jog, findings);
        let before = core::mem::replace(&mut self.permission, outcome.permission);
        self.state = outcome.state;
        if self.state != State::Lowering {
            self.lowering.reset();
        }
        self.tell(&outcome);
        if self.permission.torque {
            self.comparison.stop(bus);
        } else {
            self.path.place(self.readings.pose.q());
            return Begun { result: self.output.release(bus, &self.permission) };
        }
        let mut result = self.change_source(&before);
        if result.is_ok() {
            let is_carried = matches!(self.state, State::Floating | State::Lowering);
            result = if is_carried { self.carry(bus) } else { self.perform(jog, bus) };
        }
        if let Err(why) = result {
            // Torque is switched off in this tick, and the next tick reports the fault.
            if why == Incomplete::NotFinite {
                self.pending = self.pending.with(Fault::NotFinite);
            }
            return Begun { result: self.output.release(bus, &self.permission).and(Err(why)) };
        }
        Begun { result }
    }

    /// Runs the second half of a tick, after the exchange. `took_us` is the time since the beginning of the tick.
    ///
    /// # Errors
    /// [`Incomplete`] is the reason why the tick was not complete. The watchdog is not fed then.
    #[expect(clippy::needless_pass_by_value, reason = "a tick ends once")]
    pub fn end(
        &mut self,
        begun: Begun,
        exchanged: Result<(), EncodeError>,
        took_us: u32,
    ) -> Result<Complete, Incomplete> {
        self.was_late = took_us > self.tick_us;
        let result = begun.result.and(exchanged.map_err(Incomplete::Exchange));
        if self.permission.torque || result.is_ok() {
            self.stop_test.sent(!self.permission.torque);
        }
        result.map(|()| Complete::new())
    }

    /// Discards the results of comparing registers, after another program has sent packets to servos.
    pub fn forget_registers(&mut self, bus: &mut impl ServoBus) {
        self.comparison.stop(bus);
    }

    /// Returns the report of the last tick.
    pub fn report(&self) -> &Report<DOFS, SERVOS> {
        &self.report
    }

    /// Returns the report of the first servo that moves a dof, or `None` if no servo moves it.
    pub(crate) fn first_servo(&self, dof: usize) -> Option<&ServoReport> {
        self.report.servos.get(self.watch.servo(dof)?)
    }

    /// Returns the supervisor, which contains the log of faults.
    pub fn supervisor(&self) -> &Supervisor {
        &self.supervisor
    }

    /// Returns the current permission for the drives.
    pub fn permission(&self) -> &Permission {
        &self.permission
    }

    /// Returns the commanded pose in the rig's coordinates, and the speeds of the dofs.
    pub fn commanded(&self) -> (&[f32], &[f32]) {
        (self.path.now().q(), self.path.now().qd())
    }

    /// Returns the last measured pose in the rig's coordinates. Dofs without a measurement have their commanded
    /// position.
    pub fn measured(&self) -> &[f32] {
        self.readings.pose.q()
    }

    /// Reads the servos' data from the bus. Returns whether all numbers are finite. `late` is the number of ticks that
    /// were left out.
    fn read(&mut self, bus: &impl ServoBus, late: u32) -> bool {
        let Readings { healths, conditions, beliefs, dofs, pose, tracked } = &mut self.readings;
        let is_on = self.permission.torque;
        healths.clear();
        // There is room: `SERVOS` is the maximum number of servos.
        let _ = conditions.resize(beliefs.len(), Condition::default());
        for (servo, (condition, belief)) in conditions.iter_mut().zip(beliefs).enumerate() {
            let before = condition.feedback;
            *condition = Condition::of(bus, servo);
            let read = condition.feedback;
            condition.feedback =
                read.map(|read| belief.step(before, read, (self.dt_s, late), is_on));
            let _ = healths.push(bus.health(servo).unwrap_or_default());
        }
        if self.performance.drives.measured(conditions, dofs).is_err() {
            return false;
        }
        read_pose(&self.path, dofs, |_| true, pose);
        read_pose(&self.path, dofs, |dof| self.performance.corrects(dof), tracked);
        true
    }

    fn find(&mut self, inputs: &Inputs, is_finite: bool) -> Findings {
        let mut findings = Findings::default();
        let pending = core::mem::take(&mut self.pending);
        pending.union(inputs.found).iter().for_each(|fault| findings.note(fault));
        if !is_finite {
            findings.note(Fault::NotFinite);
        }
        let servos = &mut self.report.servos;
        self.watch.servos(self.permission.torque, &self.readings, &mut findings, servos);
        self.watch.range(&self.path, self.readings.pose.q(), &mut findings);
        let mut errors = [0.0; DOFS];
        self.path.errors(self.readings.pose.q(), &mut errors);
        let dofs = &self.readings.dofs;
        for ((report, error), measured) in self.report.dofs.iter_mut().zip(errors).zip(dofs) {
            let measured_effort = measured.and_then(|measured| measured.effort);
            *report = DofReport { error, measured_effort, ..DofReport::default() };
        }
        let torque = self.permission.torque;
        // A rig that is lowered is intended to sink.
        let is_held = torque && self.state != State::Lowering;
        let report = &mut self.report.dofs;
        let following = self.watch.dofs(
            self.rig.dofs(),
            self.path.now().qd(),
            dofs,
            is_held,
            &mut findings,
            report,
        );
        self.report.following = torque.then_some(following);
        if let Some(fault) = self.watch.overrun.step(self.was_late) {
            findings.note(fault);
        }
        if let Some(servo) = self.comparison.torque_stuck() {
            findings.note_of(Fault::TorqueStuck, servo);
        }
        findings
    }

    fn supervise(&mut self, inputs: &Inputs, jog: Option<Jog>, mut findings: Findings) -> Outcome {
        let plays_show = plays_show(self.state, self.permission.source);
        // An error of a show that no longer plays is not a fault.
        if let Some(fault) = self.sources.take_fault().filter(|_| plays_show) {
            findings.note(fault);
        }
        let registers =
            if self.permission.torque { Registers::Unread } else { self.comparison.result() };
        self.report.registers = registers;
        // With torque on, movement is intended.
        let moving = if self.permission.torque {
            None
        } else {
            self.path.moving(self.readings.pose.qd(), self.watch.rest_rad_s)
        };
        self.report.moving = moving;
        let is_asked = inputs.command == Some(Command::Arm) && !self.permission.torque;
        let overload = if is_asked { self.overload() } else { None };
        self.stop_test.look(self.watch.telling(&self.readings.conditions));
        self.supervisor.step(&Supervised {
            now_us: inputs.now_us,
            heard: inputs.heard,
            command: inputs.command,
            findings,
            uploaded: self.sources.take_uploaded(),
            measured: self.watch.is_measured(&self.readings.conditions),
            registers,
            stop_tested: self.stop_test.is_passed(),
            moving,
            overload,
            feeds: self.sources.feeds(jog, plays_show),
            carries: self.performance.carries(),
            is_there: self.is_there,
        })
    }

    /// Returns an overload in the current pose, in the first pose of the show, or at some poses between them; `None` if
    /// there is none.
    #[inline(never)]
    fn overload(&mut self) -> Option<Overload> {
        let Self { sources, path, watch, performance, .. } = self;
        let first = sources.first();
        let to = first.unwrap_or(path.now().q());
        let poses = if first.is_some() { WAY } else { 0 };
        (0..=poses).find_map(|pose| {
            let mut q = [0.0; COORDS];
            let q = q.get_mut(..to.len()).unwrap_or_default();
            path.between(to, f32::from(pose) / f32::from(WAY), q);
            performance.overload(path, q, |servo| watch.stall_a(servo), watch.supply_a)
        })
    }

    fn tell(&mut self, outcome: &Outcome) {
        let report = &mut self.report;
        (report.state, report.source) = (outcome.state, outcome.permission.source);
        (report.present, report.raised) = (outcome.present, outcome.raised);
        (report.latched, report.answer) = (outcome.latched, outcome.answer);
        report.show = self.sources.position();
        report.overruns = self.watch.overrun.count();
    }

    /// Handles a change of the source: torque is switched on at the measured pose, or another source begins at the
    /// end of the last one.
    fn change_source(&mut self, before: &Permission) -> Result<(), Incomplete> {
        let source = self.permission.source;
        let measured = self.readings.pose.q();
        if !before.torque {
            self.path.place(measured);
            self.watch.begin();
            self.performance
                .begin(self.path.now(), &self.readings.conditions)
                .map_err(|_| Incomplete::NotFinite)?;
        }
        if before.torque && before.source == Source::Led && source != Source::Led {
            self.performance.resume(self.path.now()).map_err(|_| Incomplete::NotFinite)?;
        }
        if !before.torque || before.source != source {
            self.sources.begin(source, self.path.depart(), measured);
            self.is_there = false;
        }
        Ok(())
    }

    fn perform(&mut self, jog: Option<Jog>, bus: &mut impl ServoBus) -> Result<(), Incomplete> {
        let permission = &self.permission;
        let goal = self.sources.goal(permission, jog, &self.path, self.dt_s);
        if !goal.is_finite() {
            return Err(Incomplete::NotFinite);
        }
        self.is_there = self.path.step(goal, permission.weight, permission.speed_rad_s);
        let Readings { tracked, conditions, beliefs, .. } = &self.readings;
        let watch = &self.watch;
        let commands = self
            .performance
            .step(
                self.path.now(),
                (tracked.q(), tracked.qd()),
                conditions,
                |servo| permission.effort * watch.share(servo),
                &mut self.report.dofs,
            )
            .map_err(|_| Incomplete::NotFinite)?;
        let switch_on = self.state == State::Arming && permission.source == Source::Measured;
        let servos = &mut self.report.servos;
        self.output.send(bus, (commands, conditions, beliefs), permission, switch_on, servos)
    }

    /// Lowers the rig by a tick. Writes the speed of each dof.
    fn lower(&mut self, speeds: &mut [f32; DOFS]) {
        let parts = Parts {
            rig: self.rig,
            path: &mut self.path,
            sources: &mut self.sources,
            performance: &self.performance,
            readings: &self.readings,
            watch: &self.watch,
            settings: self.supervisor.settings(),
            dt_s: self.dt_s,
        };
        self.is_there = self.lowering.step(parts, speeds);
    }

    /// Lets the rig carry itself, or lowers it. The commanded pose follows the rig no faster than the permitted
    /// speed, so that a runaway is detected by its following error.
    fn carry(&mut self, bus: &mut impl ServoBus) -> Result<(), Incomplete> {
        let (mut speeds, mut walls) = ([0.0; DOFS], [0.0; DOFS]);
        if self.state == State::Lowering {
            self.lower(&mut speeds);
        } else {
            let led = self.sources.lead(self.readings.pose.q());
            if !led.is_finite() {
                return Err(Incomplete::NotFinite);
            }
            self.is_there = self.path.step(led, 1.0, self.permission.speed_rad_s);
            self.path.walls(self.readings.pose.q(), &mut walls);
        }
        let (permission, readings) = (&self.permission, &self.readings);
        let count = self.rig.dofs().len();
        let carried = Carried {
            q: readings.pose.q(),
            to: readings.tracked.q(),
            qd: speeds.get(..count).unwrap_or_default(),
            walls: &walls,
            lowered: self.lowering.released(),
            weight: permission.effort,
        };
        let watch = &self.watch;
        let commands = self
            .performance
            .carry(
                &self.path,
                &carried,
                &readings.conditions,
                |servo| watch.share(servo),
                &mut self.report.dofs,
            )
            .map_err(|_| Incomplete::NotFinite)?;
        let servos = &mut self.report.servos;
        let read = (commands, &*readings.conditions, &*readings.beliefs);
        self.output.send(bus, read, permission, false, servos)
    }
}

/// Computes a pose from the measured dofs that `counts` selects; other dofs have their commanded position.
fn read_pose<const DOFS: usize, const COORDS: usize>(
    path: &Path<DOFS, COORDS>,
    dofs: &[Option<Measured>],
    counts: impl Fn(usize) -> bool,
    pose: &mut Pose<DOFS, COORDS>,
) {
    let mut at = [0.0; DOFS];
    path.positions(path.now().q(), &mut at);
    let [q, qd, _] = pose.all_mut();
    for (index, measured) in dofs.iter().enumerate() {
        let measured = measured.filter(|_| counts(index));
        let speed = number(path.now().qd(), index);
        put(qd, index, measured.map_or(speed, |measured| measured.velocity));
        if let Some(measured) = measured {
            put(&mut at, index, measured.position);
        }
    }
    path.coordinates(&at, q);
}

/// Checks that a tick has time for the bus, with all servos switched, and for the board's computation, µs. Used for a
/// controller, and for a rig before a board stores it. O(1).
///
/// # Errors
/// [`ControllerError::Budget`] contains all three times.
pub fn check_budget(
    compute_us: u32,
    schedule: &Schedule,
    servos: usize,
) -> Result<(), ControllerError> {
    let (fixed, each) = SWITCH;
    let count = u32::try_from(servos).unwrap_or(u32::MAX);
    let switch_us = schedule.timing().bytes_us(each.saturating_mul(count).saturating_add(fixed));
    let (bus_us, tick_us) = (schedule.busy_us().saturating_add(switch_us), schedule.tick_us());
    if bus_us.saturating_add(compute_us) > tick_us {
        return Err(ControllerError::Budget { bus_us, compute_us, tick_us });
    }
    Ok(())
}
