//! Transition from one mode to the next: a pure function of a mode and a tick's event, without a clock.

use super::fault::{BY_COMMAND, BY_UPLOAD, Reaction, SERIOUS, TABLE, reacting};
use super::{
    Answer, Command, Event, Fault, FaultSet, Feed, Mode, Operator, Refused, Registers, State,
};

impl Mode {
    /// Returns the next mode and the answer to the command. Faults are handled first, then changes without a command,
    /// then the command.
    pub fn next(self, event: &Event) -> (Self, Option<Answer>) {
        let present = self.present(event);
        let mut mode = self;
        mode.latched = mode.latched.minus(event.uploaded.and(BY_UPLOAD).minus(present));
        let reaction = mode.react(present);
        if mode.state == self.state {
            mode.go_on(event, reaction);
        }
        let answer = event.command.map(|command| mode.obey(command, event, present, self.state));
        mode.settle();
        (mode, answer.map(|answer| answer.map(|()| mode.state)))
    }

    /// Returns all faults of a tick: those that were found, and those that follow from the event itself.
    pub(super) fn present(self, event: &Event) -> FaultSet {
        let mut present = event.present;
        if event.command == Some(Command::EStop) {
            present = present.with(Fault::EStop);
        }
        if self.state.is_on() && !event.measured {
            present = present.with(Fault::ServoSilent);
        }
        present
    }

    /// Latches faults, and applies and returns the strongest of their reactions.
    fn react(&mut self, present: FaultSet) -> Reaction {
        let from = self.state;
        let mut most = Reaction::Note;
        if present.is_empty() {
            return most;
        }
        for row in TABLE.iter().filter(|row| present.contains(row.fault)) {
            let reaction = row.reaction(from);
            if row.latches() && reaction > Reaction::Note {
                self.latched = self.latched.with(row.fault);
            }
            most = most.max(reaction);
        }
        self.state = match most {
            Reaction::Hold if from == State::Playing => State::Holding,
            Reaction::Note | Reaction::Hold => from,
            Reaction::Stop => State::Stopping,
            Reaction::Lower => State::Lowering,
            Reaction::Limp => State::Faulted,
        };
        most
    }

    /// Applies changes that need no command, in a state that no fault has ended.
    fn go_on(&mut self, event: &Event, reaction: Reaction) {
        match self.state {
            State::Off if event.measured && event.registers != Registers::Unread => {
                self.state = State::Limp;
            }
            State::Arming if event.time_over => self.state = State::Holding,
            State::Playing => {
                let is_fed = self.feed.is_some_and(|feed| event.feeds.gives(feed));
                if !is_fed {
                    self.state = State::Holding;
                }
                self.is_soft &= !event.arrived;
            }
            State::Maintenance => {
                let moves = event.enabled && event.feeds.jog && reaction < Reaction::Hold;
                self.feed = moves.then_some(Feed::Jog);
            }
            State::Stopping if event.time_over || event.arrived => self.state = State::Lowering,
            State::Lowering if event.time_over || event.arrived => self.state = State::Limp,
            _ => {}
        }
    }

    fn obey(
        &mut self,
        command: Command,
        event: &Event,
        present: FaultSet,
        was: State,
    ) -> Result<(), Refused> {
        match command {
            // The command was handled as a fault.
            Command::EStop => Ok(()),
            Command::Disarm => {
                self.end(State::Lowering);
                Ok(())
            }
            Command::Stop => {
                use State::{Holding, Playing, Stopping};
                let is_free = matches!(self.state, Holding | Playing | Stopping);
                self.end(if is_free { Stopping } else { State::Lowering });
                Ok(())
            }
            Command::ClearFaults => self.clear(present),
            Command::Maintain(operator) => self.maintain(operator, present),
            Command::Enable(operator) => match self.operator {
                Some(other) if other != operator => Err(Refused::InMaintenance(other)),
                Some(_) if self.state == State::Maintenance => Ok(()),
                _ => Err(Refused::InState(self.state)),
            },
            Command::Leave(operator) => self.leave(operator),
            Command::Arm
            | Command::Play(_)
            | Command::Hold
            | Command::Calibrate
            | Command::Teach
            | Command::Float => {
                if let Some(operator) = self.operator {
                    return Err(Refused::InMaintenance(operator));
                }
                match command {
                    // In the tick in which the rig becomes limp, torque was not off before.
                    Command::Arm if was.is_on() => Err(Refused::InState(was)),
                    Command::Arm => self.arm(event, present),
                    Command::Play(feed) => self.play(feed, event, present),
                    Command::Calibrate => self.by_hand(State::Calibrating),
                    Command::Teach => self.by_hand(State::Teaching),
                    // In the tick before the rig was not holding yet: it was arming, or it played.
                    Command::Float if !matches!(was, State::Holding | State::Floating) => {
                        Err(Refused::InState(was))
                    }
                    Command::Float => self.float(event, present),
                    _ => self.hold(),
                }
            }
        }
    }

    /// Ends the current motion by a state that leads to limp. Never changes from a state that is closer to limp.
    fn end(&mut self, by: State) {
        self.state = match self.state {
            State::Calibrating | State::Teaching => State::Limp,
            State::Stopping if by == State::Lowering => by,
            state if state.is_on() && !matches!(state, State::Stopping | State::Lowering) => by,
            state => state,
        };
    }

    fn arm(&mut self, event: &Event, present: FaultSet) -> Result<(), Refused> {
        if let Some(fault) = self.latched.and(SERIOUS).first() {
            return Err(Refused::Fault(fault));
        }
        // Checked before its possible consequences: a servo that answers late is not measured.
        if let Registers::Differ(differs) = event.registers {
            return Err(Refused::RegisterDiffers(differs));
        }
        if self.state != State::Limp {
            return Err(Refused::InState(self.state));
        }
        if !event.measured {
            return Err(Refused::NotMeasured);
        }
        if event.registers == Registers::Unread {
            return Err(Refused::RegistersUnread);
        }
        if !event.stop_tested {
            return Err(Refused::StopUntested);
        }
        if let Some(moving) = event.moving {
            return Err(Refused::Moving(moving));
        }
        if let Some(overload) = event.overload {
            return Err(Refused::Overload(overload));
        }
        self.enter(State::Arming, present)?;
        self.is_soft = true;
        Ok(())
    }

    fn play(&mut self, feed: Feed, event: &Event, present: FaultSet) -> Result<(), Refused> {
        if !matches!(self.state, State::Holding | State::Playing) {
            return Err(Refused::InState(self.state));
        }
        if feed == Feed::Show
            && let Some(fault) = self.latched.first()
        {
            return Err(Refused::Fault(fault));
        }
        if !event.feeds.gives(feed) {
            return Err(Refused::FeedSilent(feed));
        }
        self.enter(State::Playing, present)?;
        // The motion starts softly, from standstill and from another feed: the distance to the new feed is not known.
        self.is_soft |= self.feed != Some(feed);
        self.feed = Some(feed);
        Ok(())
    }

    fn hold(&mut self) -> Result<(), Refused> {
        match self.state {
            State::Playing | State::Floating => self.state = State::Holding,
            State::Arming | State::Holding => {}
            state => return Err(Refused::InState(state)),
        }
        Ok(())
    }

    fn by_hand(&mut self, state: State) -> Result<(), Refused> {
        if self.state == State::Limp {
            self.state = state;
            Ok(())
        } else {
            Err(Refused::InState(self.state))
        }
    }

    /// Changes to floating. This is possible only from holding, so that a person has the rig in hand before it yields.
    fn float(&mut self, event: &Event, present: FaultSet) -> Result<(), Refused> {
        match self.state {
            State::Floating => Ok(()),
            State::Holding if !event.carries => Err(Refused::NoEffort),
            State::Holding => self.enter(State::Floating, present),
            state => Err(Refused::InState(state)),
        }
    }

    fn maintain(&mut self, operator: Operator, present: FaultSet) -> Result<(), Refused> {
        match (self.operator, self.state) {
            (Some(other), _) if other != operator => Err(Refused::InMaintenance(other)),
            (Some(_), State::Maintenance) => Ok(()),
            (None, State::Holding) => {
                self.enter(State::Maintenance, present)?;
                (self.operator, self.feed) = (Some(operator), None);
                Ok(())
            }
            (_, state) => Err(Refused::InState(state)),
        }
    }

    fn leave(&mut self, operator: Operator) -> Result<(), Refused> {
        match self.operator {
            Some(same) if same == operator => {}
            Some(other) => return Err(Refused::InMaintenance(other)),
            None => return Err(Refused::InState(self.state)),
        }
        self.operator = None;
        if self.state == State::Maintenance {
            self.state = State::Holding;
        }
        Ok(())
    }

    /// Clears all faults or none, so that it is always clear which faults are left.
    fn clear(&mut self, present: FaultSet) -> Result<(), Refused> {
        let to_clear = self.latched.and(BY_COMMAND);
        if let Some(fault) = to_clear.and(present).first() {
            return Err(Refused::StillThere(fault));
        }
        if to_clear.is_empty() {
            return Err(self.latched.first().map_or(Refused::NoFault, Refused::NeedsUpload));
        }
        self.latched = self.latched.minus(to_clear);
        Ok(())
    }

    /// Enters a state unless a fault of this tick would end it.
    fn enter(&mut self, state: State, present: FaultSet) -> Result<(), Refused> {
        if let Some(fault) = reacting(present, state).first() {
            return Err(Refused::Fault(fault));
        }
        self.state = state;
        Ok(())
    }

    /// Sets limp or faulted by the latched faults, and discards data that the state does not use.
    fn settle(&mut self) {
        if matches!(self.state, State::Limp | State::Faulted) {
            let is_faulted = !self.latched.and(SERIOUS).is_empty();
            self.state = if is_faulted { State::Faulted } else { State::Limp };
        }
        if !matches!(self.state, State::Playing | State::Maintenance) {
            self.feed = None;
        }
        self.is_soft &= self.state.is_on();
    }
}
