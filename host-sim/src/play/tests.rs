use sinew_bus::dynamixel::table::address;
use sinew_bus::feetech::table::address as feetech_address;
use sinew_firmware::supervisor::{Refused, RegisterDiffers};
use sinew_retarget::feasibility::RigMotion;
use sinew_rig::new::arm;
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_show::write::Settings;

use super::*;
use crate::performance::{Baker, Marks};

/// What a performance of an arm at rest on two buses ends with, after `wrong` has set one register of a servo.
fn ended(wrong: Option<(usize, u16, i32)>) -> Ended {
    let mut rig = arm(3).unwrap();
    // Of two voltages: no supply for both.
    rig.supply = None;
    "STS3215-7.4V".clone_into(&mut rig.servos[1].model);
    "tip".clone_into(&mut rig.servos[1].bus);
    let mechanism = rig.mechanism().unwrap();
    let parts = Parts::new(&rig, &mechanism, Options::default()).unwrap();
    let motion = RigMotion { dt_s: 0.1, rows: vec![mechanism.home(); 11] };
    let (rig_crc, settings) = (parts.rig_crc(), Settings::default());
    let baker = Baker { mechanism: &mechanism, rig: rig_crc, settings };
    let show = baker.bake(&motion, &Marks::default());
    let show = show.unwrap().written.bytes;
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
    let plant = parts.plant(&rig, &mechanism).unwrap();
    let mut stand = Stand::new(&parts, Some(&show), &mut memories, plant).unwrap();
    if let Some((servo, register, raw)) = wrong {
        stand.set_register(servo, register, raw);
    }
    let mut director = Director::default();
    // Power-on to limp takes 10 s: arming, the show, stopping and lowering.
    let most = 20 * parts.rate_hz;
    (0..most).find_map(|_| director.tick(&mut stand, false)).expect("it ends")
}

#[test]
fn a_rig_whose_registers_are_as_asked_plays_on_two_buses() {
    assert_eq!(ended(None), Ended::Done);
}

/// On either bus, the second servo of the first and the only one of the other.
#[test]
fn a_wrong_register_refuses_with_what_is_wrong() {
    let dynamixel = (2, address::TEMPERATURE_LIMIT, 80);
    let feetech = (1, u16::from(feetech_address::UNLOADING), 0);
    for ((servo, address, found), item, expected) in
        [(dynamixel, "Temperature Limit", 70), (feetech, "Unloading Condition", 44)]
    {
        let Ended::Refused(Refused::RegisterDiffers(differs)) =
            ended(Some((usize::from(servo), address, found)))
        else {
            panic!("{item} does not refuse")
        };
        assert_eq!(differs, RegisterDiffers { servo, item, address, found, expected });
    }
}
