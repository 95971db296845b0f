use std::convert::Infallible;
use std::io::{PipeReader, PipeWriter, Read as _, Write as _, pipe};
use std::panic::resume_unwind;
use std::thread;

use sinew_firmware::supervisor::FaultSet;
use sinew_qemu_node::message::{Bytes, End};
use sinew_qemu_node::node::{self, FLASH_LEN};
use sinew_retarget::feasibility::RigMotion;
use sinew_rig::new::arm;
use sinew_rig::{Description, Mechanism};
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::plant::RigPlant;
use sinew_show::write::Settings;

use super::*;
use crate::play::{Director, Drive, Ended, Memory, Options, Stand};
use crate::{Baker, Marks};

/// The node's end.
struct Ends(PipeReader, PipeWriter);

impl Bytes for Ends {
    type Error = Infallible;
    fn read(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        self.0.read_exact(bytes).map_err(|_| resume_unwind(Box::new("the host has left")))
    }
    fn write(&mut self, bytes: &[u8]) -> Result<(), Infallible> {
        self.1.write_all(bytes).map_err(|_| resume_unwind(Box::new("the host has left")))
    }
}

/// The node of the image, in a thread.
fn here(parts: &Parts, show: &[u8]) -> Result<Twin, TwinError> {
    let [(from_node, to_host), (from_host, to_node)] = [pipe().unwrap(), pipe().unwrap()];
    let run = || {
        let (mut flash, mut lent) = (vec![0; FLASH_LEN], vec![0; 1 << 20]);
        let host = &mut End::new(Ends(from_host, to_host));
        node::run(host, FaultSet::EMPTY, &mut flash, &mut lent)
    };
    thread::Builder::new().stack_size(64 << 20).spawn(run).unwrap();
    Twin::new(Emulator::over(from_node, to_node), parts, show)
}

/// An arm on two lines of two protocols, and a show in which it swings.
struct Swing {
    rig: Description,
    mechanism: Mechanism,
    parts: Parts,
    show: Vec<u8>,
}

impl Swing {
    fn new(drive: Option<Drive>) -> Self {
        let mut rig = arm(3).unwrap();
        // Of two voltages: no supply for both.
        rig.supply = None;
        "STS3215-7.4V".clone_into(&mut rig.servos[1].model);
        "tip".clone_into(&mut rig.servos[1].bus);
        let mechanism = rig.mechanism().unwrap();
        let parts = Parts::new(&rig, &mechanism, Options { drive, ..Options::default() }).unwrap();
        let row = |step: u32| {
            let swing = 0.2 * (f64::from(step) * std::f64::consts::TAU / 20.0).sin();
            mechanism.home().iter().map(|home| home + swing).collect()
        };
        let motion = RigMotion { dt_s: 0.1, rows: (0..=20).map(row).collect() };
        let (rig_crc, settings) = (parts.rig_crc(), Settings::default());
        let baker = Baker { mechanism: &mechanism, rig: rig_crc, settings };
        let show = baker.bake(&motion, &Marks::default());
        Self { show: show.unwrap().written.bytes, rig, mechanism, parts }
    }

    fn stand<'a>(&'a self, memories: &'a mut [Memory]) -> Stand<'a, RigPlant> {
        let plant = self.parts.plant(&self.rig, &self.mechanism).unwrap();
        Stand::new(&self.parts, Some(&self.show), memories, plant).unwrap()
    }
}

/// Plays to the end, or to the first tick in which a twin is not the same.
fn played(stand: &mut Stand<'_, RigPlant>) -> Result<Ended, TwinError> {
    let mut director = Director::default();
    loop {
        let ended = director.tick(stand, false);
        stand.check_twin()?;
        if let Some(ended) = ended {
            return Ok(ended);
        }
        assert!(stand.time_s() < 30.0, "it does not end");
    }
}

#[test]
fn a_whole_node_says_on_both_lines_what_the_controller_says() {
    for drive in [None, Some(Drive::Position)] {
        let swing = Swing::new(drive);
        let mut memories: [Vec<Memory>; 2] = [vec![[0; MEMORY_LEN]; 3], vec![[0; MEMORY_LEN]; 3]];
        let [alone, with_twin] = &mut memories;
        let mut alone = swing.stand(alone);
        let twin = here(&swing.parts, &swing.show).unwrap();
        let mut stand = swing.stand(with_twin).with_twin(twin);
        for stand in [&mut alone, &mut stand] {
            assert_eq!(played(stand).unwrap(), Ended::Done);
        }
        assert_eq!(stand.wires(), alone.wires());
        let [ticks, packets] = stand.check_twin().unwrap().unwrap();
        assert_eq!(ticks, alone.ticks());
        // Each line says something in each tick.
        assert!(packets >= 2 * ticks, "{packets} packets in {ticks} ticks");
        assert_eq!(alone.check_twin().unwrap(), None);
    }
}

#[test]
fn a_node_that_is_not_the_same_is_noticed() {
    let swing = Swing::new(None);
    let mut other = Swing::new(None).parts;
    other.setups[0].stall_a *= 1.5;
    other.settings.tracker.kp *= 1.01;
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; 3];
    let mut stand = swing.stand(&mut memories).with_twin(here(&other, &swing.show).unwrap());
    let refused = played(&mut stand).unwrap_err();
    assert!(matches!(refused, TwinError::Differs { tick: 1.., .. }), "{refused}");
    // It stays so, however often somebody asks.
    assert_eq!(stand.check_twin().unwrap_err().to_string(), refused.to_string());
}

#[test]
fn what_the_node_refuses_is_told() {
    let Swing { mut parts, show, .. } = Swing::new(None);
    parts.take_shows_of(parts.rig_crc() ^ 1);
    let Err(refused) = here(&parts, &show) else { panic!("it takes a show of another rig") };
    assert!(matches!(refused, TwinError::Refused { what: "show", .. }), "{refused}");
}
