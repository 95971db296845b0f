//! `sinew report`: from a recording to a page.

use std::path::Path;

use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::Field;
use sinew_performance::play::{Part, Recording, RecordingError};

use super::play::{arm, errors};
use super::{done, refused};
use crate::common::path;

/// Returns a recording of an arm that plays for 4 s, its rig, and the table of the play.
fn recorded(folder: &Path) -> [String; 3] {
    let [rig, show] = arm(folder);
    let file = path(folder, "arm.parquet");
    let [table, _] = done(&["play", &show, "--rig", &rig, "--record", &file]);
    [file, rig, table]
}

fn rows(file: &str) -> Vec<Part> {
    Recording::open(Path::new(file)).unwrap().parts().map(Result::unwrap).collect()
}

/// Compares the recording with the rows that a general Parquet reader reads.
#[test]
fn a_recording_is_read_as_it_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let [file, ..] = recorded(folder.path());
    let recording = Recording::open(Path::new(&file)).unwrap();
    assert!(recording.is_whole());
    let reader = SerializedFileReader::new(std::fs::File::open(&file).unwrap()).unwrap();
    let mut all = reader.get_row_iter(None).unwrap();
    let mut count = 0;
    for part in recording.parts() {
        let part = part.unwrap();
        for row in 0..part.time_s.len() {
            let of_reader = all.next().unwrap().unwrap();
            let field = |wanted: &str| {
                let mut columns = of_reader.get_column_iter();
                columns.find(|(name, _)| *name == wanted).unwrap().1.clone()
            };
            let is = |name: &str, number: f32| match field(name) {
                Field::Null => assert!(number.is_nan(), "{name}: {number}"),
                Field::Float(x) => assert_eq!(x.to_bits(), number.to_bits(), "{name}"),
                other => panic!("{name}: {other}"),
            };
            assert_eq!(field("time_s"), Field::Double(part.time_s[row]));
            assert_eq!(field("runs"), Field::Bool(part.runs[row]));
            assert_eq!(field("state"), Field::Str(part.states[row].clone().unwrap()));
            for (joint, name) in part.joints.iter().zip(recording.joints()) {
                is(&format!("{name}.commanded"), joint.commanded[row]);
                is(&format!("{name}.error"), joint.error[row]);
                let limiter = joint.limiter[row].clone().map_or(Field::Null, Field::Str);
                assert_eq!(field(&format!("{name}.limiter")), limiter);
            }
            for (servo, name) in part.servos.iter().zip(recording.servos()) {
                is(&format!("{name}.current"), servo.current[row]);
                is(&format!("{name}.voltage"), servo.voltage[row]);
            }
            count += 1;
        }
    }
    assert!(all.next().is_none());
    assert_eq!(recording.rows(), count);
}

#[test]
fn a_page_is_written_beside_its_recording() {
    let folder = tempfile::tempdir().unwrap();
    let [file, rig, table] = recorded(folder.path());
    let [_, notes] = done(&["report", &file]);
    let html = path(folder.path(), "arm.html");
    assert!(notes.contains(&format!("wrote {html}")) && !notes.contains("cut off"), "{notes}");
    let page = std::fs::read_to_string(&html).unwrap();
    // The mean and largest error that the play printed.
    let [mean, most] = errors(&table, "current");
    let told = format!("were {mean:.2}° from their targets on average, and {most:.2}° at most");
    for part in [&told, "there was no fault", "bend2", "lowering", "Limited"] {
        assert!(page.contains(part), "{part}");
    }
    // Nothing is fetched: the only address is the name of SVG's elements.
    let page_without_names = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!page_without_names.contains("http://") && !page.contains("https://"));
    // With the same rig given, the page is the same.
    let other = path(folder.path(), "other.html");
    done(&["report", &file, "--rig", &rig, "-o", &other]);
    assert_eq!(std::fs::read_to_string(&other).unwrap(), page);
}

/// A recording may be cut off anywhere: the rows that are read are a beginning of the whole. If it is cut between two
/// parts, the recording is valid.
#[test]
fn of_a_recording_that_is_cut_off_what_is_whole_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let [file, ..] = recorded(folder.path());
    let (bytes, whole) = (std::fs::read(&file).unwrap(), rows(&file));
    let cut = path(folder.path(), "cut.parquet");
    let mut found = std::collections::BTreeSet::new();
    for at in (0..bytes.len()).step_by(997).chain([bytes.len() - 1]) {
        std::fs::write(&cut, &bytes[..at]).unwrap();
        match Recording::open(Path::new(&cut)) {
            Ok(recording) => {
                assert!(!recording.is_whole(), "at {at}");
                if !found.insert(recording.rows()) {
                    continue;
                }
                let parts: Vec<Part> = recording.parts().map(Result::unwrap).collect();
                // NaN does not equal itself, so the texts are compared.
                let [read, written] = [&parts, &whole[..parts.len()]].map(|p| format!("{p:?}"));
                assert!(read == written, "at {at}");
            }
            Err(RecordingError::Nothing) => assert!(found.is_empty(), "at {at}"),
            Err(RecordingError::NotParquet(_)) => assert!(at < 4, "at {at}"),
            Err(why) => panic!("at {at}: {why}"),
        }
    }
    // The last part ends with the file itself.
    let lens = whole.iter().map(|part| part.time_s.len());
    let ends: Vec<usize> =
        lens.scan(0, |end, len| Some(*end + len).inspect(|to| *end = *to)).collect();
    assert!(ends.len() > 2 && found.iter().eq(&ends[..ends.len() - 1]), "{found:?} of {ends:?}");
    std::fs::write(&cut, &bytes[..bytes.len() - 1]).unwrap();
    let [_, notes] = done(&["report", &cut]);
    // Parts of 2,500 ticks at 500 Hz.
    let told = format!("is cut off. Its first {}.00 s are whole", 5 * (whole.len() - 1));
    assert!(notes.contains(&told), "{told}: {notes}");
    assert!(std::fs::read_to_string(path(folder.path(), "cut.html")).unwrap().contains(&told));
}

/// After a flip of any bit, the recording is refused, or the page says that it is cut off; then the part that is shown
/// is unchanged.
#[test]
fn each_flipped_bit_of_a_recording_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let [file, ..] = recorded(folder.path());
    let bytes = std::fs::read(&file).unwrap();
    let flipped = path(folder.path(), "flipped.parquet");
    let mut seed = 200_u64;
    let mut below = |most: u64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 20) % most
    };
    let bits = 8 * bytes.len() as u64;
    // Bits anywhere, and bits in the file's end: lengths, names, the checksum itself.
    let anywhere: Vec<u64> = (0..200).map(|_| below(bits)).collect();
    let in_end: Vec<u64> = (0..200).map(|_| bits - 1 - below(8 * 1500)).collect();
    let [mut refused, mut cut] = [0, 0];
    for bit in anywhere.into_iter().chain(in_end).chain(bits - 64..bits) {
        let mut other = bytes.clone();
        let [at, bit] = [bit / 8, bit % 8].map(|number| usize::try_from(number).unwrap());
        other[at] ^= 1 << bit;
        std::fs::write(&flipped, other).unwrap();
        match Recording::open(Path::new(&flipped)) {
            Err(_) => refused += 1,
            Ok(recording) => {
                assert!(!recording.is_whole(), "bit {bit} of byte {at} of {}", bytes.len());
                cut += 1;
            }
        }
    }
    println!("{refused} refused, {cut} shown as cut off");
    assert_eq!(refused + cut, 464);
}

#[test]
fn what_is_no_recording_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let [file, rig, _] = recorded(folder.path());
    let other = path(folder.path(), "other.toml");
    done(&["rig", "new", "--arm", "4", "-o", &other]);
    let short = path(folder.path(), "short.parquet");
    std::fs::write(&short, &std::fs::read(&file).unwrap()[..1000]).unwrap();
    let damaged = path(folder.path(), "damaged.parquet");
    let mut bytes = std::fs::read(&file).unwrap();
    // In the first pages.
    bytes[4..64].fill(0xFF);
    std::fs::write(&damaged, bytes).unwrap();
    for (arguments, part) in [
        (&["report", &rig][..], "found a rig.toml"),
        (&["report", "nothing.parquet"], "nothing.parquet: No such file"),
        (&["report", &short], "no part of it is complete"),
        (&["report", &damaged], "is damaged: its checksum"),
        (&["report", &file, "--rig", &other], "it is another rig"),
        (&["report", &file, "-o", &file], "is the recording, which would be lost"),
    ] {
        refused(arguments, part);
    }
}
