//! Shows of clips on rigs: the node of boards, as an Arm image in QEMU, sends the same bytes as the controller in
//! this process.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use sinew_firmware::supervisor::State;
use sinew_mocap::files::ClipFile;
use sinew_performance::play::{
    Director, Drive, Ended, Memory, Options, RigParts, SimulatedRig, Tally, put_servos,
};
use sinew_performance::rig::load;
use sinew_performance::{Baker, ClipSettings, PreparedClip, ShowMarks, retarget_clip};
use sinew_qemu_driver::{Emulator, IMAGE, QemuController};
use sinew_retarget::feasibility::{FitSettings, Limits, fit};
use sinew_retarget::mapping::Mapping;
use sinew_rig::import;
use sinew_rig::new::arm;
use sinew_rig::review::Servos;
use sinew_rig::{Description, Mechanism, toml_file};
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_show::write::Settings;

/// A clip on a rig, ready to play.
struct Case {
    rig: Description,
    mechanism: Mechanism,
    parts: RigParts,
    show: Vec<u8>,
}

/// Result of a play: its table, and the tick at which each state began.
#[derive(Debug, PartialEq)]
struct Played {
    table: String,
    states: Vec<(u64, State)>,
}

impl Case {
    /// Fits a clip to a rig, as `sinew play` does. `seconds` is the part of the clip that is played.
    fn new(
        rig: Description,
        drive: Drive,
        clip: &Path,
        mapping: Option<&Mapping>,
        seconds: Option<f64>,
    ) -> Self {
        let mechanism = rig.mechanism().unwrap();
        let options = Options { drive: Some(drive), ..Options::default() };
        let parts = RigParts::new(&rig, &mechanism, options).unwrap();
        let mut clip = PreparedClip::read(&ClipFile::new(clip), ClipSettings::default()).unwrap();
        if let Some(seconds) = seconds {
            clip.cut(seconds);
        }
        let given = retarget_clip(&mechanism, &clip, mapping, false).unwrap().motion;
        let limits = Limits::of(&mechanism, &Servos::of(&rig, &mechanism).unwrap());
        let fitted = fit(&mechanism, &limits, &given, FitSettings::default()).unwrap();
        let baker =
            Baker { mechanism: &mechanism, rig: parts.rig_crc(), settings: Settings::default() };
        let (_, baked, _) =
            baker.bake_within(&limits, &given, fitted, |_, _| Ok(()), ShowMarks::of_none).unwrap();
        Self { rig, mechanism, parts, show: baked.written.bytes }
    }

    /// Plays to the end. `peer` is a controller in QEMU that runs beside the controller in this process, and whose
    /// packets the servos get.
    fn play(&self, peer: Option<&Rc<RefCell<QemuController>>>) -> Played {
        let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; self.parts.servos.len()];
        let plant = self.parts.plant(&self.rig, &self.mechanism).unwrap();
        let mut sim =
            SimulatedRig::new(&self.parts, Some(&self.show), &mut memories, plant).unwrap();
        if let Some(peer) = peer {
            sim = sim.with_peer(peer.clone());
        }
        let (mut director, mut tally) = (Director::default(), Tally::new(&self.parts));
        let mut states: Vec<(u64, State)> = Vec::new();
        let ended = loop {
            let ended = director.tick(&mut sim, false);
            peer.map(|peer| peer.borrow().compared()).transpose().unwrap();
            tally.note(&sim);
            let state = sim.report().state;
            if states.last().is_none_or(|(_, last)| *last != state) {
                states.push((sim.ticks(), state));
            }
            if let Some(ended) = ended {
                break ended;
            }
        };
        assert_eq!(ended, Ended::Done);
        Played { table: tally.table(&sim, director.raised()), states }
    }

    /// Plays in this process, then in QEMU: table, hash and states must be equal. Returns the hash, and the numbers of
    /// compared ticks and packets.
    fn is_same_in_qemu(&self) -> (String, [u64; 2]) {
        let image: PathBuf = std::env::var_os(IMAGE)
            .unwrap_or_else(|| panic!("{IMAGE}: `cargo xtask node` sets it"))
            .into();
        let own = self.play(None);
        assert!(own.table.contains("faults: none"), "{}", own.table);
        assert!(own.table.contains(" 0 not whole"), "{}", own.table);
        let emulator = Emulator::start(&image).unwrap();
        let peer = QemuController::new(emulator, &self.parts, &self.show).unwrap();
        let peer = Rc::new(RefCell::new(peer));
        assert_eq!(self.play(Some(&peer)), own);
        let compared = peer.borrow().compared().unwrap();
        let hash = own.table.split("hash ").nth(1).expect(&own.table).trim().to_owned();
        (hash, compared)
    }
}

#[test]
#[ignore = "needs the image that `cargo xtask node` builds"]
fn an_arm_says_in_qemu_what_it_says_in_process() {
    let rig = arm(3).unwrap();
    let joint = &rig.mechanism().unwrap().bodies[2].joint_name;
    let mapping = Mapping::read(&format!(
        "rig = \"arm\"\nclip = \"punches_01\"\n\n[[curve]]\nclip = \"forearm_l\"\naxis = [0, 0, 1]\nrig = \"{joint}\"\n\
         points_deg = [[-180, -60], [180, 60]]\n"
    ));
    let mapping = mapping.unwrap();
    for drive in [Drive::Current, Drive::Voltage, Drive::Position] {
        let clip = Path::new("punches_01");
        let case = Case::new(rig.clone(), drive, clip, Some(&mapping), Some(2.0));
        let (_, [ticks, packets]) = case.is_same_in_qemu();
        println!("an arm by {}: {packets} packets in {ticks} ticks are the same", drive.name());
    }
}

/// A walk and a fight on two robots. With `SINEW_NODE_ALL`, which `cargo xtask node` sets, the whole clips are
/// played, and their hashes are printed. Otherwise, since emulators are slow, each robot and clip is played
/// once, for some seconds: longer than the 4 s of a show's block.
#[test]
#[ignore = "needs SINEW_DATA, and the image that `cargo xtask node` builds"]
fn robots_say_in_qemu_what_they_say_in_process() {
    let data: PathBuf = std::env::var_os("SINEW_DATA").expect("SINEW_DATA").into();
    let imported = |file: &str, turned: Option<&str>, servo: &str| {
        let options = import::Options { repair_inertia: true, ..import::Options::default() };
        let mut rig = load(&data.join("urdf").join(file), &options).unwrap().description;
        for joint in rig.joints.iter_mut().filter(|joint| Some(joint.name.as_str()) == turned) {
            joint.axis = joint.axis.map(|axis| axis.map(|x| 0.0 - x));
        }
        // The rig is written to a file's text and read again, like a user's rig.
        let mut rig = toml_file::read(&toml_file::write(&rig)).unwrap();
        put_servos(&mut rig, &[servo.parse().unwrap()]).unwrap();
        rig
    };
    let op3 = imported("robotis-op3/robotis_op3.urdf", None, "xm430");
    let poppy = imported("poppy-humanoid/Poppy_Humanoid.urdf", Some("l_knee_y"), "mx-64");
    let is_whole = std::env::var_os("SINEW_NODE_ALL").is_some();
    let seconds = (!is_whole).then_some(5.0);
    for (is_shared, name, rig, drive, clip) in [
        (true, "OP3", &op3, Drive::Current, "walk/07_01.bvh"),
        (false, "OP3", &op3, Drive::Current, "fight/02_05.bvh"),
        (false, "Poppy", &poppy, Drive::Position, "walk/07_01.bvh"),
        (true, "Poppy", &poppy, Drive::Position, "fight/02_05.bvh"),
    ] {
        if !(is_whole || is_shared) {
            continue;
        }
        let case = Case::new(rig.clone(), drive, &data.join("cmu").join(clip), None, seconds);
        let (hash, [ticks, packets]) = case.is_same_in_qemu();
        if is_whole {
            println!("| {name} | {clip} | {} | {ticks} | {packets} | `{hash}` |", drive.name());
        }
    }
}
