//! The starter arm follows built-in clips, as with `sinew play`.

use std::path::Path;

use rayon::prelude::*;
use sinew_mocap::files::ClipFile;
use sinew_performance::play::Drive;
use sinew_performance::rig::LoadedRig;
use sinew_performance::{
    ClipSettings, MotionChoices, PreparedClip, RigPerformance, ShowChoices, retarget_clip,
};
use sinew_servo_sim::variation::Variation;

use super::run::Rig;

const MEAN_DEG: f64 = 0.27;
const LARGEST_DEG: f64 = 2.5;
const CURRENT_A: f64 = 0.6;

/// Returns a function that makes a show of a built-in clip for the rig with a CRC.
pub(super) fn clip_show<'r>(rig: &'r Rig, name: &'r str) -> impl FnOnce(u32) -> Vec<u8> + 'r {
    move |rig_crc| {
        let loaded = LoadedRig {
            description: rig.description.clone(),
            mechanism: rig.mechanism.clone(),
            world: None,
            notes: Vec::new(),
            doubts: Vec::new(),
        };
        let clip = PreparedClip::read(&ClipFile::new(Path::new(name)), ClipSettings::default());
        let clip = clip.unwrap();
        let retargeted = retarget_clip(&rig.mechanism, &clip, None, false).unwrap();
        let choices = MotionChoices { fit: true, ..MotionChoices::default() };
        let performance = RigPerformance::new(&loaded, name, clip.start_s, retargeted, choices);
        let choices = ShowChoices { rig_crc, ..ShowChoices::default() };
        performance.unwrap().bake(&rig.mechanism, &choices).unwrap().0.written.bytes
    }
}

#[test]
fn the_starter_arm_follows_kicks_and_punches() {
    let clips = ["kicks_01", "punches_01"];
    let rows: Vec<_> = [Drive::Current, Drive::Voltage]
        .par_iter()
        .flat_map(|drive| clips.par_iter().map(move |name| (*drive, *name)))
        .map(|(drive, name)| {
            let rig = Rig { drive: Some(drive), ..Rig::new_arm() };
            let run = rig.perform(clip_show(&rig, name), Variation::default(), |_, _| {});
            let all = || run.samples.iter().flatten();
            let error = |sample: &super::run::Sample| sample.error_rad.abs().to_degrees();
            let mean_deg = all().map(error).sum::<f64>() / all().count() as f64;
            let largest_deg = all().map(error).fold(0.0, f64::max);
            let most_a = all().map(|sample| sample.current_a.abs()).fold(0.0, f64::max);
            let limited = all().filter(|sample| sample.is_limited).count();
            (drive, name, mean_deg, largest_deg, most_a, limited)
        })
        .collect();
    for row in &rows {
        println!("{row:.3?}");
    }
    for (drive, name, mean_deg, largest_deg, most_a, limited) in rows {
        assert!(mean_deg <= MEAN_DEG && largest_deg <= LARGEST_DEG, "{name}, {drive:?}");
        assert!(most_a <= CURRENT_A && limited == 0, "{name}, {drive:?}");
    }
}
