//! A node with arbitrary bytes from a host, arbitrary flash, and arbitrary commands.

use core::cell::Cell;
use core::hint::black_box;
use core::mem::MaybeUninit;
use core::ops::Range;

use sinew_firmware::controller::{ControllerSettings, ServoSetup};
use sinew_firmware::node::{
    BackgroundTask, ControlLoop, Found, Mail, Next, NodeSettings, Port, Safety, Setup, Shared,
    Spread, causes, join_rig, link_version, start,
};
use sinew_firmware::watchdog::{Complete, Watchdog};
use sinew_link::message::{ToHost, Welcome};
use sinew_servo_bus::{Schedule, pca9685};
use sinew_storage::BoardTable;

use super::controller::{Anything, BODIES, COORDINATES, DOFS, SERVOS};
use super::storage::Flash;
use super::{slice, slice_mut};

/// A board with arbitrary inputs.
struct Board;

impl Safety for Board {
    fn now_us(&self) -> u64 {
        black_box(1)
    }
    fn is_stopped(&mut self) -> bool {
        black_box(true)
    }
    fn enable_outputs(&mut self, on: bool) {
        black_box(on);
    }
    fn feed(&mut self, tick: Complete) {
        Watchdog::new(|| {
            black_box(1);
        })
        .feed(tick);
    }
}

impl Port<'static> for Board {
    fn now_us(&self) -> u64 {
        black_box(1)
    }
    fn receive(&mut self, into: &mut [u8]) -> usize {
        black_box(into);
        black_box(1)
    }
    fn send(&mut self, bytes: &[u8]) -> usize {
        black_box(bytes);
        black_box(1)
    }
    fn look<R>(&mut self, range: Range<u32>, look: impl FnOnce(&[u8]) -> R) -> Option<R> {
        black_box(range);
        Some(look(slice()))
    }
    fn lend(&mut self, range: Range<u32>) -> Option<&'static [u8]> {
        black_box(range);
        black_box(Some(slice()))
    }
}

type Letters = Mail<'static, DOFS, SERVOS, COORDINATES>;

/// A mailbox whose content is taken out during an access.
struct Locked(Cell<Option<Letters>>);

impl Shared<Letters> for Locked {
    fn with<R>(&self, act: impl FnOnce(&mut Letters) -> R) -> R {
        let Some(mut mail) = self.0.take() else {
            loop {
                black_box(1);
            }
        };
        let result = act(&mut mail);
        self.0.set(Some(mail));
        result
    }
}

#[inline(never)]
pub(crate) fn nodes() {
    let board = BoardTable { slots: slice(), ..BoardTable::NUCLEO_F446RE };
    let Some(schedule) = black_box(None::<Schedule>) else { return };
    let defaults = NodeSettings::new(black_box(ControllerSettings::default()), schedule);
    black_box((link_version(slice()), join_rig(slice_mut(), black_box(1), black_box(1))));
    black_box(black_box(Spread::default()).jitter());
    let why = causes(black_box(true), black_box(true), black_box(true));
    let flash: Flash<4> = Flash;
    let mut slot = MaybeUninit::uninit();
    let found = start::<_, BODIES, DOFS, SERVOS>(
        flash,
        black_box(board),
        |_| defaults,
        why,
        slice_mut(),
        &mut slot,
    );
    let Ok(Found { store, disarmed, settings, is_bad, start, .. }) = found else { return };
    black_box((settings.get(black_box(1)), settings.bytes(), settings.live()));
    black_box((
        settings.with(black_box(1), black_box(1.0)).is_ok(),
        settings.read(slice()).is_ok(),
    ));
    // The rig must live forever: a board moves it into a static.
    let Some(rig) = black_box(None) else { return };
    let Some(mut bus) = black_box(None::<pca9685::Bus>) else { return };
    let Some(ToHost::Welcome(Welcome { about, .. })) = black_box(None) else { return };
    let servos = slice::<ServoSetup>();
    let made = ControlLoop::<BODIES, DOFS, SERVOS, COORDINATES>::new(
        rig, &settings, servos, &schedule, start,
    );
    black_box(made.is_ok());
    let of_loop = settings.clone();
    ControlLoop::<BODIES, DOFS, SERVOS, COORDINATES>::with(
        rig,
        &of_loop,
        servos,
        &schedule,
        start,
        |control| {
            let Ok(control) = control else { return };
            let mail = Locked(Cell::new(Some(Mail::new(disarmed))));
            let (rig, tick_s, line_bps) = (Some((rig, black_box(1))), black_box(1.0), black_box(1));
            let setup = Setup { about, settings, is_bad, rig, tick_s, line_bps };
            let mut background = BackgroundTask::new(store, setup, black_box(1));
            let ended = control.tick(&mut Board, &mail, &mut bus, &mut Anything, slice_mut());
            black_box((ended.is_ok(), control.controller().report()));
            black_box(background.step(&mut Board, &mail) == Next::Restart);
            black_box(background.store().condition());
        },
    );
}
