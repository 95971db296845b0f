//! `sinew evaluate sweep`: killed and resumed, or sharded and merged, it writes the same bytes.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::Field;
use tempfile::TempDir;

use crate::common;

const SWEEP: &str = "
setup.plant.kind = 'articulated'

[[grid]]
controller.method = ['local', 'world', 'linear_compensation']
dimensions.scale = [0.9, 1.0, 1.1]

[[grid]]
controller.method = 'world'
disturbance.torque_limit_nm = [inf, 300.0, 1.0]
";

const TABLES: [&str; 4] = ["sweep.csv", "sweep.parquet", "sweep_clips.csv", "sweep_clips.parquet"];

/// Creates a folder with the sweep file.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("sweep.toml"), SWEEP).unwrap();
    folder
}

fn command(folder: &Path, out: &str, options: &[&str]) -> Command {
    let mut command = common::command();
    command
        .current_dir(folder)
        .args(["evaluate", "sweep", "sweep.toml", "--seconds", "0.4", "--output", out])
        .args(options);
    command
}

fn sweep(folder: &Path, out: &str, options: &[&str]) -> Output {
    command(folder, out, options).output().unwrap()
}

fn succeed(folder: &Path, out: &str, options: &[&str]) -> String {
    let output = sweep(folder, out, options);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    String::from_utf8(output.stdout).unwrap()
}

fn refuse(folder: &Path, out: &str, options: &[&str]) -> String {
    let output = sweep(folder, out, options);
    assert_eq!(output.status.code(), Some(2));
    String::from_utf8(output.stderr).unwrap().lines().last().unwrap_or_default().to_owned()
}

fn assert_same_tables(folder: &Path, a: &str, b: &str) {
    for table in TABLES {
        let [a, b] = [a, b].map(|out| fs::read(folder.join(out).join(table)).unwrap());
        assert!(a == b, "{table} differs");
    }
}

#[test]
fn killed_in_the_middle_it_ends_with_the_bytes_of_an_unbroken_run() {
    let folder = folder();
    let folder = folder.path();
    succeed(folder, "unbroken", &["--threads", "2"]);

    let mut killed = command(folder, "killed", &["--threads", "1"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    // Waits until the journal has its head and some runs.
    let journal = folder.join("killed/journal.jsonl");
    let lines = || fs::read_to_string(&journal).map_or(0, |text| text.lines().count());
    while lines() < 10 {
        assert!(killed.try_wait().unwrap().is_none(), "too fast to be killed");
        std::thread::sleep(Duration::from_millis(1));
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    let finished = lines() - 1;
    assert!(!folder.join("killed/sweep.csv").exists(), "it was killed too late");

    // Also imitates the effect of a full disk or a system crash on the last line.
    let mut bytes = fs::read(&journal).unwrap();
    // The line ends inside a character.
    bytes.extend(b"{\"cell\":3,\"cl\xc3");
    fs::write(&journal, bytes).unwrap();

    let told = succeed(folder, "killed", &["--threads", "2"]);
    assert!(told.contains(&format!("{finished} taken over")), "{told}");
    assert_same_tables(folder, "unbroken", "killed");
    let again = succeed(folder, "killed", &[]);
    assert!(again.contains(" 0 runs made"), "{again}");
}

#[test]
fn shards_merged_are_the_whole_whatever_the_threads() {
    let folder = folder();
    let folder = folder.path();
    succeed(folder, "whole", &["--threads", "1"]);
    succeed(folder, "first", &["--shard", "1/2", "--threads", "2"]);
    let incomplete = refuse(folder, "merged", &["--merge", "first"]);
    assert!(incomplete.contains("runs are in none of the shards"), "{incomplete}");
    succeed(folder, "second", &["--shard", "2/2", "--threads", "2"]);
    succeed(folder, "merged", &["--merge", "first", "second"]);
    assert_same_tables(folder, "whole", "merged");
}

#[test]
fn the_parquet_file_says_what_the_csv_says() {
    let folder = folder();
    let folder = folder.path();
    succeed(folder, "out", &[]);
    for name in ["sweep", "sweep_clips"] {
        let out = folder.join("out").join(name);
        let mut csv = csv::Reader::from_path(out.with_extension("csv")).unwrap();
        let header: Vec<String> = csv.headers().unwrap().iter().map(str::to_owned).collect();
        let reader =
            SerializedFileReader::new(fs::File::open(out.with_extension("parquet")).unwrap());
        let reader = reader.unwrap();
        let metadata = reader.metadata().file_metadata();
        assert_eq!(metadata.created_by(), Some(concat!("sinew ", env!("CARGO_PKG_VERSION"))));
        let notes = metadata.key_value_metadata().unwrap();
        let note = |key| notes.iter().find(|note| note.key == key).unwrap().value.as_deref();
        assert_eq!((note("sweep_file"), note("seconds")), (Some(SWEEP), Some("0.4")));
        assert!(note("clips").unwrap().contains("punches_01"));
        let mut rows = reader.get_row_iter(None).unwrap();
        for record in csv.records() {
            let (record, row) = (record.unwrap(), rows.next().unwrap().unwrap());
            for ((name, (column, field)), text) in
                header.iter().zip(row.get_column_iter()).zip(record.iter())
            {
                assert_eq!(name, column);
                let same = match field {
                    Field::Null => text.is_empty(),
                    Field::Str(value) => value == text,
                    Field::Long(value) => value.to_string() == text,
                    Field::Double(value) => {
                        text.parse::<f64>().unwrap().to_bits() == value.to_bits()
                    }
                    other => panic!("{other:?}"),
                };
                assert!(same, "{name}: {field:?} {text}");
            }
        }
        assert!(rows.next().is_none());
    }
}

#[test]
fn a_lost_figure_is_a_row_that_says_why() {
    let folder = folder();
    let folder = folder.path();
    let told = succeed(folder, "out", &[]);
    // World without limits is in both grids: it runs once. No figure stands with joint limits of 1 N m.
    assert!(told.contains("11 cells") && told.contains("the figure was lost in"), "{told}");
    let mut csv = csv::Reader::from_path(folder.join("out/sweep.csv")).unwrap();
    let header = csv.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = csv.records().map(Result::unwrap).collect();
    let last = rows.last().unwrap();
    let field = |name: &str| &last[header.iter().position(|column| column == name).unwrap()];
    assert_eq!(field("disturbance.torque_limit_nm"), "1");
    assert_eq!((field("status"), field("all_linear_mean_cm")), ("lost", ""));
    assert!(field("reason").contains("diverged at frame"), "{}", field("reason"));
}

#[test]
fn a_folder_of_another_sweep_is_left_alone() {
    let folder = folder();
    let folder = folder.path();
    succeed(folder, "out", &[]);
    let before = fs::read(folder.join("out/journal.jsonl")).unwrap();
    fs::write(folder.join("sweep.toml"), SWEEP.replace("1.1", "1.2")).unwrap();
    // An incomplete last line of another sweep's journal must not be cut off either.
    let torn = [&before[..], b"{\"cell\":3"].concat();
    fs::write(folder.join("out/journal.jsonl"), &torn).unwrap();
    let error = refuse(folder, "out", &[]);
    assert!(error.contains("journal.jsonl: belongs to another sweep: its grids differ"), "{error}");
    assert_eq!(fs::read(folder.join("out/journal.jsonl")).unwrap(), torn);
    let error = refuse(folder, "merged", &["--merge", "out"]);
    assert!(
        error.contains("out/journal.jsonl: belongs to another sweep: its grids differ"),
        "{error}"
    );

    fs::write(folder.join("sweep.toml"), SWEEP).unwrap();
    let before = String::from_utf8(before).unwrap();
    let lines: Vec<&str> = before.lines().collect();
    let changed = |line: usize, new: &str| {
        let mut lines = lines.clone();
        lines[line] = new;
        lines.join("\n") + "\n"
    };
    // An unknown key; changed digits that still form a number; a row that is there twice.
    let digits = lines[1].to_owned();
    let place = digits.find("e-").or_else(|| digits.find('.')).unwrap() - 1;
    let digit = if digits.as_bytes()[place] == b'7' { "8" } else { "7" };
    let digits = format!("{}{digit}{}", &digits[..place], &digits[place + 1..]);
    for (journal, told) in [
        (changed(1, &lines[1].replacen("{\"cell\"", "{\"cull\"", 1)), "journal.jsonl:2: "),
        (changed(1, &digits), "journal.jsonl:2: its checksum is of other contents"),
        (changed(2, lines[1]), "journal.jsonl:3: cell"),
    ] {
        fs::write(folder.join("out/journal.jsonl"), journal).unwrap();
        let error = refuse(folder, "out", &[]);
        assert!(error.contains(told), "{error}");
    }
}

#[test]
fn the_summary_ranks_the_cells_by_what_they_do_not_share() {
    let folder = folder();
    let told = succeed(folder.path(), "out", &[]);
    let (_, ranking) = told.split_once("smallest and largest:\n").unwrap();
    let errors: Vec<f64> = ranking
        .lines()
        .filter_map(|line| line.split_once(" cm "))
        .map(|(error, _)| error.trim().parse().unwrap())
        .collect();
    assert_eq!(errors.len(), 6, "{told}");
    assert!(errors.is_sorted(), "{told}");
    assert!(ranking.contains("dimensions.scale = ") && !ranking.contains("plant.kind"), "{told}");
}

#[test]
fn the_front_is_told_of_the_whole_sweep_and_of_no_shard() {
    let folder = folder();
    let folder = folder.path();
    let told = succeed(folder, "out", &[]);
    let (_, fronts) = told.split_once("front of mean linear over mean angular error").unwrap();
    // Rows are compared only with rows of the same scale and the same limits: three tasks of three methods.
    assert_eq!(fronts.matches(" of 3 cells; dimensions.scale = ").count(), 2, "{told}");
    assert_eq!(fronts.matches(" of 3 cells; nothing else set").count(), 1, "{told}");
    assert!(succeed(folder, "shard", &["--shard", "1/2"]).find("front").is_none());

    let on_front = |out: &str, table: &str| -> Vec<[String; 2]> {
        let mut csv = csv::Reader::from_path(folder.join(out).join(table)).unwrap();
        let header = csv.headers().unwrap().clone();
        let place = |name| header.iter().position(|column| column == name).unwrap();
        let places = ["status", "on_front"].map(place);
        csv.records().map(Result::unwrap).map(|row| places.map(|at| row[at].to_owned())).collect()
    };
    for table in ["sweep.csv", "sweep_clips.csv"] {
        for [status, on_front] in on_front("out", table) {
            assert_eq!(on_front.is_empty(), status == "lost", "{table}: {status} {on_front}");
        }
        assert!(on_front("shard", table).iter().all(|[_, on_front]| on_front.is_empty()));
    }
    // No other row of its task is better.
    let limited = &on_front("out", "sweep.csv")[9];
    assert_eq!(*limited, ["ok", "yes"].map(str::to_owned));
}

#[test]
fn what_cannot_be_is_refused_before_anything_runs() {
    let folder = folder();
    let folder = folder.path();
    for (text, told) in [
        ("[[grid]]\ncontroller.method = ['lokal']", "controller.method"),
        ("[[grid]]\ncontroller.beta = [0.5, nan]", "controller.beta"),
        ("[[grid]]\ncontroller.beta = []", "expected a list of values"),
        ("[[grid]]\nplant.substeps = [1, 0]", "plant.substeps = 0"),
        ("[[grid]]\nplant = ['rapier']", "plant"),
        ("setup.body = 3\n[[grid]]", "[setup]"),
        ("grid = []", "at least one [[grid]]"),
        ("[grids]", "grids"),
        ("[[grid", "line 1"),
    ] {
        fs::write(folder.join("sweep.toml"), text).unwrap();
        let output = sweep(folder, "out", &[]);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(error.contains("sweep.toml") && error.contains(told), "{text}: {error}");
    }
    assert!(!folder.join("out").exists());
    for shard in ["0/2", "3/2", "1", "a/b", "1/0"] {
        assert_eq!(sweep(folder, "out", &["--shard", shard]).status.code(), Some(2), "{shard}");
    }
}

#[test]
fn a_journal_in_use_is_refused() {
    let folder = folder();
    let folder = folder.path();
    succeed(folder, "out", &[]);
    let journal = fs::File::open(folder.join("out/journal.jsonl")).unwrap();
    journal.lock().unwrap();
    let error = refuse(folder, "out", &[]);
    assert!(error.contains("another sweep is writing to it"), "{error}");
}
