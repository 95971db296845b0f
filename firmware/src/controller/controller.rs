//! The controller: one tick in two halves, with the board's wire between them.

use heapless::Vec;
use sinew_core::tracker::Timing;
use sinew_rig::board::BoardRig;
use sinew_servo_bus::{EncodeError, Health, Schedule, ServoBus};
use sinew_show::{ShowError, ShowFrames};

use super::coordinates::{number, put};
use super::error::{ControllerError, Incomplete};
use super::feed::{Jog, LiveSource, SoftStart, Sources, plays_show};
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
    Command, Fault, FaultSet, Findings, Inputs as Supervised, Outcome, Permission, Registers,
    Settings, Source, State, Supervisor,
};
use crate::watchdog::Complete;

/// Bytes of a packet that switches the torque of all servos, at most: head, and two for each.
const SWITCH: (u32, u32) = (14, 2);

/// A rig is lowered at this part of the speed that it may have: friction lets go of a joint all at once.
const PACE: f32 = 0.7;
/// A goal is led down at this part of the pace: a servo that sticks catches up.
const LED: f32 = 0.7;
/// So fast more of the weight is carried again where a joint is too fast by all of the pace, 1/s.
const BACK_PER_S: f32 = 3.0;
/// More than the weight by the model is carried by this part at most: a rig may be heavier.
const LEAST_LOWERED: f32 = -0.25;
/// A rig rests below this part of the pace; a third of the fading time of that, and it is down.
const RESTS: f32 = 0.1;
const RESTED: f32 = 1.33;
/// A goal that is led down is ahead of its servo by this at most, rad.
const LEAD_RAD: f32 = 0.07;
/// Below this part of its effort, and below so many N m or N, a joint's weight is slight: its goal is led slower.
const SLIGHT: f32 = 0.003;
const SLIGHT_MOST: f32 = 0.03;
/// No weight is as slight as this, N m or N.
const LEAST_NM: f32 = 1e-6;

/// What a tick brings from outside.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Inputs {
    /// Time since the board's start, µs; it never goes back.
    pub now_us: u64,
    /// A valid and *new* message of the host came since the last tick.
    pub heard: bool,
    /// A command, if one came. Others wait for their own tick.
    pub command: Option<Command>,
    /// Faults that the board finds: the line of the emergency stop, settings that cannot be read.
    pub found: FaultSet,
    /// The joint that somebody moves.
    pub jog: Option<Jog>,
}

/// A tick that has begun: to be given to [`MotionController::end`].
#[derive(Debug)]
#[must_use = "a tick that is not ended is not whole"]
pub struct Begun {
    result: Result<(), Incomplete>,
}

/// The loop of a rig of at most `BODIES` bodies, `DOFS` dofs, `SERVOS` servos and `COORDS` coordinates. All memory is
/// in here: put it in a static.
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
    /// By dof, how much of its weight is let go of while the rig is lowered.
    lowered: [f32; DOFS],
    /// Faults of the tick before, or of the board's start: found in the next tick.
    pending: FaultSet,
    was_late: bool,
    report: Report<DOFS, SERVOS>,
}

/// What servos said in the tick before.
#[derive(Debug)]
struct Readings<const DOFS: usize, const SERVOS: usize, const COORDS: usize> {
    servos: Vec<(Condition, Health), SERVOS>,
    conditions: Vec<Condition, SERVOS>,
    dofs: Vec<Option<Measured>, DOFS>,
    /// Positions and speeds; what is not measured is where it was commanded.
    pose: Pose<DOFS, COORDS>,
    /// The same for the tracker: a joint whose servo closes its own loop is where it was commanded. The tracker cannot
    /// correct it; what it would do about it would be in the efforts of the others, for accelerations that never come.
    tracked: Pose<DOFS, COORDS>,
}

impl<const DOFS: usize, const SERVOS: usize, const COORDS: usize> Readings<DOFS, SERVOS, COORDS> {
    /// Before any.
    #[inline(never)]
    fn new(dofs: usize, pose: &Pose<DOFS, COORDS>) -> Self {
        Self {
            servos: Vec::new(),
            conditions: Vec::new(),
            dofs: filled(dofs, None),
            pose: pose.clone(),
            tracked: pose.clone(),
        }
    }
}

impl<'a, const BODIES: usize, const DOFS: usize, const SERVOS: usize, const COORDS: usize>
    MotionController<'a, BODIES, DOFS, SERVOS, COORDS>
{
    /// A controller at the board's start: torque is off. `schedule`: of the bus that it will be given; its servos are
    /// the rig's, in its order.
    ///
    /// # Errors
    /// [`ControllerError`] says in words what does not fit: the rig, the rate, a setting.
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
        // Nothing is heard yet, and nothing asked: what is permitted before the first tick.
        let Outcome { state, permission, .. } = supervisor.step(&Supervised::default());
        let path = Path::uninit();
        Self {
            rig,
            rig_crc: 0,
            dt_s: 0.0,
            tick_us: 0,
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
            lowered: [0.0; DOFS],
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
        // By itself: it takes most of the stack that all of this takes.
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
        self.comparison = Comparison::new(rig.servos(), servos);
        self.pending = start.causes;
        Ok(())
    }

    /// The same with another rest pose than the rig's home.
    ///
    /// # Errors
    /// [`ControllerError::Rest`] if there is not a number from -1e6 to 1e6 for each coordinate,
    /// [`ControllerError::RestRange`] if one is outside of its joint's range.
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
        // Half a millionth of a turn is rounding of whoever wrote it.
        match self.path.beyond(q, 3e-6) {
            Some(dof) => Err(ControllerError::RestRange { dof }),
            None => Ok(self),
        }
    }

    /// Another show, read where it lies, or none. The one before is let go of in any case; if it plays, the rig holds.
    /// O(size).
    ///
    /// # Errors
    /// [`ShowError`] if it cannot be read, or is of another rig. While a show plays that is a fault besides.
    pub fn load_show(&mut self, bytes: Option<&'a [u8]>) -> Result<(), ShowError> {
        let plays = plays_show(self.state, self.permission.source);
        self.sources.load(bytes, (self.rig, self.rig_crc), self.dt_s, plays)
    }

    /// Another show, which [`open_show`](super::open_show) has opened in the background, or none. If one plays, it ends,
    /// and the rig holds. O(1).
    pub fn put_show(&mut self, show: Option<ShowFrames<'a, COORDS>>) {
        self.sources.put(show, plays_show(self.state, self.permission.source));
    }

    /// Time between two ticks, s.
    pub fn dt_s(&self) -> f32 {
        self.dt_s
    }

    /// The first half of a tick: what servos said in the tick before, what is wrong, what may be done, and commands for
    /// the bus, which are to be [exchanged](super::exchange) now. O(dofs).
    pub fn begin(
        &mut self,
        inputs: &Inputs,
        live: &mut impl LiveSource,
        bus: &mut impl ServoBus,
    ) -> Begun {
        let is_finite = self.read(bus);
        let mut findings = self.find(inputs, is_finite);
        let jog = inputs.jog.filter(|jog| jog.speed.is_finite());
        if !self.sources.listen(inputs.now_us, live) || jog.is_some() != inputs.jog.is_some() {
            findings.note(Fault::NotFinite);
        }
        if !self.permission.torque {
            let (watch, read) = (&self.watch, &self.readings.servos);
            self.comparison.step(bus, |servo| {
                read.get(servo).is_some_and(|(_, health)| watch.is_silent(health))
            });
        }
        let outcome = self.supervise(inputs, jog, findings);
        let before = core::mem::replace(&mut self.permission, outcome.permission);
        self.state = outcome.state;
        if self.state != State::Lowering {
            self.lowered = [0.0; DOFS];
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
            // In this very tick, and as a fault in the next.
            if why == Incomplete::NotFinite {
                self.pending = self.pending.with(Fault::NotFinite);
            }
            return Begun { result: self.output.release(bus, &self.permission).and(Err(why)) };
        }
        Begun { result }
    }

    /// The second half of a tick, behind the exchange. `took_us`: from its beginning until now.
    ///
    /// # Errors
    /// [`Incomplete`] says what was missing. The watchdog is not fed then.
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

    /// Somebody has talked to servos beside the loop: what was known of their registers counts no more.
    pub fn forget_registers(&mut self, bus: &mut impl ServoBus) {
        self.comparison.stop(bus);
    }

    /// Returns the report of the last tick.
    pub fn report(&self) -> &Report<DOFS, SERVOS> {
        &self.report
    }

    /// Returns the report of the first servo that moves a dof.
    pub(crate) fn first_servo(&self, dof: usize) -> Option<&ServoReport> {
        self.report.servos.get(self.watch.servo(dof)?)
    }

    /// The supervisor, with the log of faults.
    pub fn supervisor(&self) -> &Supervisor {
        &self.supervisor
    }

    /// What drives may do.
    pub fn permission(&self) -> &Permission {
        &self.permission
    }

    /// The pose that is commanded, in the rig's coordinates: positions, and speeds of the dofs.
    pub fn commanded(&self) -> (&[f32], &[f32]) {
        (self.path.now().q(), self.path.now().qd())
    }

    /// The pose that was measured last, in the rig's coordinates; what no servo tells is where it was commanded.
    pub fn measured(&self) -> &[f32] {
        self.readings.pose.q()
    }

    /// Takes what the bus knows; says whether all of it are numbers.
    fn read(&mut self, bus: &impl ServoBus) -> bool {
        let Readings { servos, conditions, dofs, pose, tracked } = &mut self.readings;
        servos.clear();
        conditions.clear();
        for servo in 0..self.rig.servos().len() {
            let condition = Condition::of(bus, servo);
            // Servos of a rig are counted: there is room.
            let _ = servos.push((condition, bus.health(servo).unwrap_or_default()));
            let _ = conditions.push(condition);
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
        self.watch.servos(self.permission.torque, &self.readings.servos, &mut findings, servos);
        self.watch.range(&self.path, self.readings.pose.q(), &mut findings);
        let mut errors = [0.0; DOFS];
        self.path.errors(self.readings.pose.q(), &mut errors);
        let dofs = &self.readings.dofs;
        for ((report, error), measured) in self.report.dofs.iter_mut().zip(errors).zip(dofs) {
            let measured_effort = measured.and_then(|measured| measured.effort);
            *report = DofReport { error, measured_effort, ..DofReport::default() };
        }
        let torque = self.permission.torque;
        // What is lowered is to sink.
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
        // What was wrong with a show that plays no more is no fault.
        if let Some(fault) = self.sources.take_fault().filter(|_| plays_show) {
            findings.note(fault);
        }
        let registers =
            if self.permission.torque { Registers::Unread } else { self.comparison.result() };
        self.report.registers = registers;
        // With torque on it moves because it is to.
        let moving = if self.permission.torque {
            None
        } else {
            self.path.moving(self.readings.pose.qd(), self.watch.rest_rad_s)
        };
        self.report.moving = moving;
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
            feeds: self.sources.feeds(jog, plays_show),
            carries: self.performance.carries(),
            is_there: self.is_there,
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

    /// Torque comes on where the rig is; or another source begins where the last one is left.
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
        let Readings { tracked, conditions, .. } = &self.readings;
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
        self.output.send(bus, (commands, conditions), permission, switch_on, servos)
    }

    /// Lets go of the weight of each joint while it is slow, and carries more of it while it is fast. Goals of servos by
    /// position are led down, no farther ahead than a servo that yields. Writes the speed of each dof: the trusted one
    /// of what is braked, and that of its goal of what is led. What has no trusted reading is let go of by time.
    // Not within its caller, whose frame on the stack is deep.
    #[inline(never)]
    fn lower(&mut self, speeds: &mut [f32; DOFS]) {
        let Self { rig, path, sources, performance, readings, watch, lowered, dt_s, .. } = self;
        let Settings { lower_s, lower_rad_s, .. } = *self.supervisor.settings();
        let pace = PACE * lower_rad_s;
        let (mut to, mut led) = ([0.0; DOFS], [0.0; DOFS]);
        path.positions(readings.tracked.q(), &mut to);
        self.is_there = true;
        let dofs = rig.dofs().iter().zip(&readings.dofs).zip(speeds).zip(lowered);
        for (index, (((dof, measured), speed), lowered)) in dofs.enumerate() {
            let measured = measured.filter(|measured| watch.is_fresh(measured));
            if performance.corrects(index) {
                *speed = measured.map_or(0.0, |measured| measured.velocity);
            } else {
                let least = (SLIGHT * dof.effort).clamp(LEAST_NM, SLIGHT_MOST);
                let down = (-performance.weight(index) / least).clamp(-1.0, 1.0);
                let at = number(&to, index);
                let ahead = measured.map_or(0.0, |measured| at - measured.position);
                let is_held = ahead * down > LEAD_RAD * down.abs();
                let down = if is_held { 0.0 } else { LED * pace * down };
                put(&mut led, index, down);
                put(&mut to, index, at + *dt_s * down);
                *speed = number(path.now().qd(), index);
            }
            let share = path.share(index, *speed, pace);
            // Nothing is carried from 1 on: there it must rest for a while.
            let most = if share < RESTS { RESTED } else { 1.0 };
            // What goes up, as by a hand, is not helped.
            let left = if *speed * performance.weight(index) > 0.0 { 1.0 } else { 1.0 - share };
            let is_slow = left > 0.0 && *lowered >= 0.0;
            let rate = if is_slow { 1.0 / lower_s.max(*dt_s) } else { BACK_PER_S };
            *lowered = (*lowered + *dt_s * rate * left).clamp(LEAST_LOWERED, most);
            self.is_there &= *lowered >= RESTED;
        }
        let goal = sources.lower();
        path.coordinates(&to, goal.q_mut());
        let [_, qd, _] = goal.all_mut();
        qd.iter_mut().zip(led).for_each(|(qd, led)| *qd = led);
        path.step(goal, 1.0, Some(pace));
    }

    /// The rig carries itself, or is lowered. What is commanded follows it: as long as it is no faster than it may be,
    /// so that what runs away is found by its following error.
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
            lowered: &self.lowered,
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
        self.output.send(bus, (commands, &readings.conditions), permission, false, servos)
    }
}

/// The pose of what is measured of the dofs that count; the others are where they were commanded.
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

/// That a tick has time for a bus with all its servos switched, and for what it takes the board, µs. The one check: of
/// a controller, and of a rig before a board stores it. O(1).
///
/// # Errors
/// [`ControllerError::Budget`] names all three times.
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
