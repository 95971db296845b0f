//! `decode.py` was written from the format's page alone, and must read the same numbers.

use std::process::Command;

use crate::examples::example;
use sinew_show::write::Settings;
use sinew_show::{Joint, Player, Rate, Show};

const COORDS: usize = 32;

#[test]
fn a_reader_of_the_page_reads_the_same() {
    if Command::new("python3").arg("--version").output().is_err() {
        eprintln!("python3 is not installed: nothing was compared");
        return;
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/shows/decode.py");
    for (is_loop, seed) in [(false, 3), (true, 4), (true, 5)] {
        let joints = vec![
            Joint::Free,
            Joint::Spherical,
            Joint::Fixed,
            Joint::Universal,
            Joint::Prismatic,
            Joint::Spherical,
            Joint::Revolute,
        ];
        let example = example(joints, 400, Rate { samples: 30_000, seconds: 1001 }, is_loop, seed);
        let bytes = example.write(&Settings { block_s: 2.0, ..Settings::default() }).bytes;
        let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
        let file = folder.join(format!("second-reader-{seed}.show"));
        std::fs::write(&file, &bytes).expect("a folder for tests");
        let show = Show::open(&bytes).expect("a show");
        let mut player = Player::<COORDS>::new(show).expect("room");
        let times_us: Vec<u64> = (0..60).map(|k| k * 230_117).collect();
        let samples = times_us.iter().map(|us| *us as f64 * 30_000.0 / 1001.0 / 1e6);
        let output = Command::new("python3")
            .arg(script)
            .arg(&file)
            .args(samples.map(|sample| sample.to_string()))
            .output()
            .expect("python3 runs");
        let text = String::from_utf8_lossy(&output.stdout);
        assert_eq!(
            text.lines().count(),
            times_us.len(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        let (nq, nv) = (show.channel_count(), show.dof_count());
        for (line, us) in text.lines().zip(times_us) {
            let wanted: Vec<f64> = line.split(' ').map(|x| x.parse().expect("a number")).collect();
            let (mut q, mut qd, mut qdd) = ([0.0; COORDS], [0.0; COORDS], [0.0; COORDS]);
            player.state_at(show.position_at_us(us), &mut q, &mut qd, &mut qdd).expect("whole");
            let found = q[..nq].iter().chain(&qd[..nv]).chain(&qdd[..nv]);
            let largest = wanted.iter().fold(1.0f64, |most, x| most.max(x.abs()));
            assert_eq!(wanted.len(), nq + 2 * nv);
            for (wanted, found) in wanted.iter().zip(found) {
                // Tolerance: f32 rounding, mostly in accelerations.
                assert!(
                    (wanted - f64::from(*found)).abs() < 3e-6 * largest,
                    "{wanted} {found} at {us}"
                );
            }
        }
    }
}
