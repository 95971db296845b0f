//! Image for QEMU's `mps2-an386` (Cortex-M4F): ticks of rigs with servos, as their owners run them, and ticks of the
//! same rigs with ball joints. It is separate from the image `kernels`, so that inlining there does not change.

#![no_std]
#![no_main]

use core::hint::black_box;

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use sinew_bench::emulated::{self, FRAMES, LAG_FRAMES, controller, count_tick, enlarge, inverse};
use sinew_bench::rig::{DT_S, Rig};
use sinew_bench::servo::{Instant, Joints, MOST_JOINTS, rig};
use sinew_core::state_error::Method;
use sinew_core::tracker::{Frame, FrameSource, Measured, MethodName, Settings, Timing, Tracker};
use sinew_core::{StateInputError, Transform, Tree, Workspace};

/// Names of the table rows for a kind of joint.
struct Rows {
    joints: Joints,
    inverse: &'static str,
    core_tick: &'static str,
    /// Name of a tick, with its method and kind of frame.
    ticks: [(&'static str, MethodName, Kind); 4],
}

/// Format of a frame.
#[derive(Clone, Copy)]
enum Kind {
    Coordinates,
    Poses,
}

const ROWS: [Rows; 2] = [
    Rows {
        joints: Joints::Revolute,
        inverse: "rnea_revolute",
        core_tick: "tick_world_revolute",
        ticks: [
            ("rig_world_coordinates_revolute", MethodName::World, Kind::Coordinates),
            ("rig_world_poses_revolute", MethodName::World, Kind::Poses),
            ("rig_recommended_coordinates_revolute", MethodName::Recommended, Kind::Coordinates),
            ("rig_recommended_poses_revolute", MethodName::Recommended, Kind::Poses),
        ],
    },
    Rows {
        joints: Joints::Ball,
        inverse: "rnea_ball",
        core_tick: "tick_world_ball",
        ticks: [
            ("rig_world_coordinates_ball", MethodName::World, Kind::Coordinates),
            ("rig_world_poses_ball", MethodName::World, Kind::Poses),
            ("rig_recommended_coordinates_ball", MethodName::Recommended, Kind::Coordinates),
            ("rig_recommended_poses_ball", MethodName::Recommended, Kind::Poses),
        ],
    },
];

#[entry]
fn main() -> ! {
    emulated::run(|| {
        measure::<6>()?;
        measure::<12>()?;
        measure::<20>()
    })
}

/// Measures rigs of `N` joints.
#[expect(clippy::large_stack_arrays, reason = "the emulated board has megabytes for its stack")]
fn measure<const N: usize>() -> Result<(), &'static str> {
    for rows in &ROWS {
        let tree = rig::<N>(rows.joints).map_err(|_| "the rig cannot be")?;
        inverse(rows.inverse, &tree);
        let mut instants = [Instant::NOTHING; FRAMES];
        for (index, instant) in instants.iter_mut().enumerate() {
            *instant = Instant::of(&tree, DT_S * index as f32).map_err(|_| "no such motion")?;
        }
        tick_of_core(rows.core_tick, &tree, &instants)?;
        for (name, method, kind) in rows.ticks {
            tick_of_rig(name, &tree, method, Performance::new(&tree, &instants, kind))?;
        }
    }
    hprintln!("type=Tracker_without_latency bodies={} bytes={}", N, size_of::<Tracker<N>>());
    Ok(())
}

fn tick_of_core<const N: usize>(
    name: &str,
    tree: &Tree<N>,
    instants: &[Instant; FRAMES],
) -> Result<(), &'static str> {
    let frame = |index: usize| &instants[index].poses[..N];
    let first = [LAG_FRAMES, LAG_FRAMES + 1].map(frame);
    let (controller, workspace) = (controller(tree, Method::World)?, Workspace::new());
    let mut rig = Rig::new(controller, workspace, first).map_err(|_| "a frame is refused")?;
    count_tick::<N, _>(name, |run| {
        core_tick_of_rig(&mut rig, frame(run + LAG_FRAMES + 2), frame(run))
    })
}

/// Runs a tick of the core, in a separate function.
#[inline(never)]
fn core_tick_of_rig<const N: usize>(
    rig: &mut Rig<N>,
    desired: &[Transform],
    measured: &[Transform],
) -> Result<(), StateInputError> {
    rig.tick(desired, measured).map(|torques| _ = black_box(torques))
}

/// Frames that are ready in memory: the work of a source is not counted.
struct Performance<'a> {
    kind: Kind,
    /// Numbers of positions and of speeds of the rig.
    counts: [usize; 2],
    measured: &'a [Instant; FRAMES],
    /// Poses of a performer who is larger than the rig.
    poses: [[Transform; MOST_JOINTS]; FRAMES],
    joints: usize,
}

impl<'a> Performance<'a> {
    fn new<const N: usize>(tree: &Tree<N>, instants: &'a [Instant; FRAMES], kind: Kind) -> Self {
        let mut poses = instants.each_ref().map(|instant| instant.poses);
        for poses in &mut poses {
            enlarge(poses);
        }
        let counts = [tree.coordinate_count(), tree.dof_count()];
        Self { kind, counts, measured: instants, poses, joints: N }
    }

    /// Returns readings of encoders, which measure no speeds.
    fn measured(&self, index: usize) -> Measured<'a> {
        let [positions, _] = self.counts;
        Measured::Positions { q: &self.measured[index].q[..positions] }
    }
}

impl FrameSource for Performance<'_> {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        let index = usize::try_from(index).unwrap_or_default();
        let (Some(instant), Some(poses)) = (self.measured.get(index), self.poses.get(index)) else {
            // The tracker refuses an empty list. A panic here would increase the measured stack of the tick.
            return Frame::Poses(&[]);
        };
        let [positions, speeds] = self.counts;
        match self.kind {
            Kind::Coordinates => Frame::Coordinates {
                q: instant.q.get(..positions).unwrap_or_default(),
                qd: instant.qd.get(..speeds).unwrap_or_default(),
                qdd: instant.qdd.get(..speeds).unwrap_or_default(),
            },
            Kind::Poses => Frame::Poses(poses.get(..self.joints).unwrap_or_default()),
        }
    }
}

fn tick_of_rig<const N: usize>(
    name: &str,
    tree: &Tree<N>,
    method: MethodName,
    mut performance: Performance<'_>,
) -> Result<(), &'static str> {
    let settings = Settings { method, ..Settings::default() };
    let timing = Timing { dt_s: DT_S, latency_ticks: 0 };
    let mut tracker =
        Tracker::new(tree.clone(), &settings, timing).map_err(|_| "there is no such tracker")?;
    let mut efforts = [0.0; 3 * MOST_JOINTS];
    let efforts = &mut efforts[..tree.dof_count()];
    count_tick::<N, _>(name, |run| {
        let measured = performance.measured(run);
        rig_tick(&mut tracker, &mut performance, run + LAG_FRAMES, measured, efforts)
    })?;
    black_box(efforts);
    Ok(())
}

/// Runs a tick of a rig with servos, from encoders to efforts, in a separate function.
#[inline(never)]
fn rig_tick<const N: usize>(
    tracker: &mut Tracker<N>,
    performance: &mut Performance<'_>,
    index: usize,
    measured: Measured<'_>,
    efforts: &mut [f32],
) -> Result<(), &'static str> {
    let index = i32::try_from(index).unwrap_or(i32::MAX);
    let tick = tracker.step(performance, index, measured).map_err(|_| "a step is refused")?;
    tick.efforts(efforts).map_err(|_| "there is no room for the efforts")
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    hprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
