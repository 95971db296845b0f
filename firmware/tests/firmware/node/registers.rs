//! A servo whose settings differ from the rig's requirements: the host receives the servo, the register and the
//! values.

use sinew_firmware::supervisor::State;
use sinew_link::message::{self, Applied, Command, Outcome, Refusal};

use super::line::Trouble;
use super::stored::show;
use super::test_rig::{Kind, SERVOS};
use super::world::World;

#[test]
fn the_host_hears_which_register_keeps_a_rig_from_being_armed() {
    for (kind, address, found, expected) in [
        // Position mode instead of current mode; an answer after 500 us.
        (Kind::Current, 11, 3, 0),
        (Kind::Current, 9, 250, 1),
        // Position mode instead of PWM mode.
        (Kind::Voltage, 11, 3, 16),
        (Kind::Position, 33, 1, 0),
        (Kind::Position, 21, 16, 32),
    ] {
        let mut world = World::ready(kind, Trouble::default(), 3, &show(kind, 4, false));
        world.bench.servos_mut()[4].set(address, found);
        world.until(State::Limp, 2.0);
        world.run(1.5);
        let refusal = Refusal::RegisterDiffers { servo: 4, address, found, expected };
        assert_eq!(world.ask(Command::Arm), Outcome::Refused(refusal), "{kind:?}");
        assert_eq!((world.state(), world.servos_on()), (Some(State::Limp), 0));
        world.bench.servos_mut()[4].set(address, expected);
        world.run(1.5);
        let arming = Outcome::Applied(Applied::State(message::State::Arming));
        assert_eq!(world.arm(), arming, "{kind:?}");
        world.until(State::Holding, 3.0);
        assert_eq!(world.servos_on(), SERVOS);
    }
}
