use std::cell::RefCell;
use std::convert::Infallible;
use std::io::{PipeReader, PipeWriter, Read as _, Write as _, pipe};
use std::panic::resume_unwind;
use std::path::Path;
use std::rc::Rc;
use std::thread;

use sinew_firmware::supervisor::FaultSet;
use sinew_performance::play::{Director, Drive, Ended, Memory, Options, RigParts, SimulatedRig};
use sinew_performance::{Baker, ShowMarks};
use sinew_qemu_node::limits::FLASH_LEN;
use sinew_qemu_node::message::{Bytes, End};
use sinew_qemu_node::node;
use sinew_retarget::feasibility::RigMotion;
use sinew_rig::new::arm;
use sinew_rig::{Description, Mechanism};
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::plant::RigPlant;
use sinew_show::write::Settings;

use super::*;

/// The node's end of the pipes.
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

/// A peer that is shared with a rig.
type Shared = Rc<RefCell<QemuController>>;

/// Starts the node of the image in a thread of this program.
fn here(parts: &RigParts, show: &[u8]) -> Result<Shared, QemuError> {
    let [(from_node, to_host), (from_host, to_node)] = [pipe().unwrap(), pipe().unwrap()];
    let run = || {
        let (mut flash, mut lent) = (vec![0; FLASH_LEN], vec![0; 1 << 20]);
        let host = &mut End::new(Ends(from_host, to_host));
        node::run(host, FaultSet::EMPTY, &mut flash, &mut lent)
    };
    thread::Builder::new().stack_size(64 << 20).spawn(run).unwrap();
    let emulator = Emulator::over(from_node, to_node);
    Ok(Rc::new(RefCell::new(QemuController::new(emulator, parts, show)?)))
}

/// An arm on two lines with two protocols, and a show in which it swings.
struct Swing {
    rig: Description,
    mechanism: Mechanism,
    parts: RigParts,
    show: Vec<u8>,
}

impl Swing {
    fn new(drive: Option<Drive>) -> Self {
        let mut rig = arm(3).unwrap();
        // Two voltages: there is no common supply.
        rig.supply = None;
        "STS3215-7.4V".clone_into(&mut rig.servos[1].model);
        "tip".clone_into(&mut rig.servos[1].bus);
        let mechanism = rig.mechanism().unwrap();
        let parts =
            RigParts::new(&rig, &mechanism, Options { drive, ..Options::default() }).unwrap();
        let row = |step: u32| {
            let swing = 0.2 * (f64::from(step) * std::f64::consts::TAU / 20.0).sin();
            mechanism.home().iter().map(|home| home + swing).collect()
        };
        let motion = RigMotion { dt_s: 0.1, rows: (0..=20).map(row).collect() };
        let (rig_crc, settings) = (parts.rig_crc(), Settings::default());
        let baker = Baker { mechanism: &mechanism, rig: rig_crc, settings };
        let show = baker.bake(&motion, &ShowMarks::default());
        Self { show: show.unwrap().written.bytes, rig, mechanism, parts }
    }

    fn sim<'a>(&'a self, memories: &'a mut [Memory]) -> SimulatedRig<'a, RigPlant> {
        let plant = self.parts.plant(&self.rig, &self.mechanism).unwrap();
        SimulatedRig::new(&self.parts, Some(&self.show), memories, plant).unwrap()
    }
}

/// Plays to the end, or to the first tick with a difference.
fn played(sim: &mut SimulatedRig<'_, RigPlant>, peer: Option<&Shared>) -> Result<Ended, QemuError> {
    let mut director = Director::default();
    loop {
        let ended = director.tick(sim, false);
        peer.map(|peer| peer.borrow().compared()).transpose()?;
        if let Some(ended) = ended {
            return Ok(ended);
        }
        assert!(sim.time_s() < 30.0, "it does not end");
    }
}

#[test]
fn a_whole_node_says_on_both_lines_what_the_controller_says() {
    for drive in [None, Some(Drive::Position)] {
        let swing = Swing::new(drive);
        let mut memories: [Vec<Memory>; 2] = [vec![[0; MEMORY_LEN]; 3], vec![[0; MEMORY_LEN]; 3]];
        let [alone, with_peer] = &mut memories;
        let mut alone = swing.sim(alone);
        let peer = here(&swing.parts, &swing.show).unwrap();
        let mut sim = swing.sim(with_peer).with_peer(peer.clone());
        assert_eq!(played(&mut alone, None).unwrap(), Ended::Done);
        assert_eq!(played(&mut sim, Some(&peer)).unwrap(), Ended::Done);
        assert_eq!(sim.wires(), alone.wires());
        let [ticks, packets] = peer.borrow().compared().unwrap();
        assert_eq!(ticks, alone.ticks());
        // Each line sends packets in each tick.
        assert!(packets >= 2 * ticks, "{packets} packets in {ticks} ticks");
    }
}

#[test]
fn a_node_that_is_not_the_same_is_noticed() {
    let swing = Swing::new(None);
    let options = Options { rate_hz: Some(250), ..Options::default() };
    let other = RigParts::new(&swing.rig, &swing.mechanism, options).unwrap();
    assert_ne!(other.rate_hz, swing.parts.rate_hz);
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; 3];
    let peer = here(&other, &swing.show).unwrap();
    let mut sim = swing.sim(&mut memories).with_peer(peer.clone());
    let refused = played(&mut sim, Some(&peer)).unwrap_err();
    assert!(matches!(refused, QemuError::Differs { tick: 1.., .. }), "{refused}");
    // The result stays the same when it is read again.
    assert_eq!(peer.borrow().compared().unwrap_err().to_string(), refused.to_string());
}

#[test]
fn what_the_node_refuses_is_told() {
    let Swing { mut parts, show, .. } = Swing::new(None);
    parts.take_shows_of(parts.rig_crc() ^ 1);
    let Err(refused) = here(&parts, &show) else { panic!("it takes a show of another rig") };
    assert!(matches!(refused, QemuError::Refused { what: "show", .. }), "{refused}");
}

#[test]
fn a_missing_image_is_told() {
    let Err(missing) = Emulator::start(Path::new("no/such/image")) else { panic!("it starts") };
    let told = "no/such/image: there is no image of the node. `cargo xtask node` builds it";
    assert!(missing.to_string().starts_with(told), "{missing}");
}
