//! The robots of `SINEW_DATA`, and files that broke readers.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use sinew_rig::import::{self, ImportError, Imported, Options};

fn read(file: &str, options: &Options) -> Result<Imported, ImportError> {
    let data = std::env::var_os("SINEW_DATA").expect("SINEW_DATA names the folder of the data");
    let text = std::fs::read_to_string(PathBuf::from(data).join(file)).expect("the file");
    import::urdf(&text, options)
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn robots_are_imported_by_name_and_with_notes() {
    let repair = Options { repair_inertia: true, ..Options::default() };
    let open = Options { open_loops: true, ..Options::default() };
    for (file, options, bodies, moving) in [
        ("urdf/poppy-humanoid/Poppy_Humanoid.urdf", &Options::default(), 26, 25),
        ("urdf/robotis-op3/robotis_op3.urdf", &Options::default(), 25, 20),
        ("urdf/open-duck-mini/open_duck_mini_v2.urdf", &Options::default(), 21, 16),
        ("urdf/reachy-mini/reachy_mini.urdf", &open, 45, 30),
        ("foreign/urdf/so100.urdf", &Options::default(), 7, 6),
        ("foreign/urdf/panda.urdf", &Options::default(), 13, 9),
        ("foreign/urdf/h1.urdf", &Options::default(), 58, 51),
        ("foreign/urdf/reachy.URDF", &Options::default(), 31, 20),
        ("foreign/urdf/allegro_left.urdf", &repair, 21, 16),
        ("foreign/urdf/anymal_c.urdf", &repair, 78, 12),
        ("foreign/urdf/talos_reduced.urdf", &repair, 60, 32),
        ("deepmimic/humanoid.urdf", &Options::default(), 16, 12),
    ] {
        let imported = read(file, options).unwrap_or_else(|error| panic!("{file}:{error}"));
        println!("{file}");
        imported.notes.iter().for_each(|note| println!("  {note}"));
        assert_eq!(imported.description.bodies.len(), bodies, "{file}");
        let mechanism = imported.description.mechanism().unwrap_or_else(|e| panic!("{file}: {e}"));
        assert_eq!(mechanism.bodies.len(), moving + 1, "{file}");
        mechanism.tree::<64>().unwrap_or_else(|error| panic!("{file}: {error}"));
    }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn what_cannot_be_is_refused_in_words() {
    for (file, expected, found) in [
        ("foreign/urdf/allegro_left.urdf", "repair-inertia", "also refused: `link_10.0`"),
        ("foreign/urdf/anymal_c.urdf", "repair-inertia", "`depth_camera_rear_camera`"),
        ("foreign/urdf/unitree_a1.xacro", "xacro FILE", "`xacro:arg`"),
        ("urdf/reachy-mini/reachy_mini.urdf", "open-loops", "5 closed loops"),
        ("urdf/open-duck-mini/open_duck_mini_v2.mjcf.xml", "`robot`", "`mujoco`"),
    ] {
        let error = read(file, &Options::default()).expect_err(file);
        println!("{file}:{error}");
        assert!(error.expected.contains(expected) && error.found.contains(found), "{file}:{error}");
    }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn files_that_broke_readers_are_refused_at_once() {
    for (file, expected) in [
        ("attack/urdf_links20k.urdf", "one link that no joint moves"),
        ("attack/urdf_xmlns_nest.urdf", "`robot`"),
    ] {
        let start = Instant::now();
        let error = read(file, &Options::default()).expect_err(file);
        println!("{file}: {:?}", start.elapsed());
        assert!(error.expected.contains(expected), "{file}:{error}");
        // Milliseconds; ten seconds on a machine that is busy with something else.
        assert!(start.elapsed() < Duration::from_secs(10), "{file}: {:?}", start.elapsed());
    }
}
