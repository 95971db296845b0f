//! Runs every reader of files with its corpus, and with damaged copies of the corpus. A reader must read a file or
//! refuse it with a message. The targets also accept inputs that bolero generates.

mod targets;

use std::fs;

use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng as _;
use sinew_evaluation::sweep::Journal;
use sinew_verification::verify_folder;
use targets::TARGETS;

/// Number of damaged copies of each file in a run. They are the same in every run, so that a failure is reproducible.
const DAMAGED: u64 = 60;

/// Returns the names and contents of a target's files.
fn corpus(name: &str) -> Vec<(String, Vec<u8>)> {
    let folder = sinew_fuzz::corpus("readers").join(name);
    let mut files: Vec<_> = fs::read_dir(&folder)
        .unwrap_or_else(|_| panic!("{}", folder.display()))
        .collect::<Result<_, _>>()
        .unwrap();
    files.sort_by_key(fs::DirEntry::file_name);
    let read = |file: &fs::DirEntry| {
        (file.file_name().to_string_lossy().into_owned(), fs::read(file.path()).unwrap())
    };
    files.iter().map(read).collect()
}

/// Returns a damaged copy of the bytes: parts are changed, cut off, removed or doubled, or a number is replaced by
/// an odd one.
fn damaged(bytes: &[u8], seed: u64) -> Vec<u8> {
    const ODD: [&[u8]; 8] = [
        b"nan",
        b"-1e999",
        b"1e308",
        b"-0",
        b"99999999999999999999",
        b"{",
        b"\xff",
        b"0.0000000001",
    ];
    let mut random = Pcg64::new(u128::from(seed), 1);
    let mut below = |count: usize| usize::try_from(random.next_u64() % count as u64).unwrap();
    let mut bytes = bytes.to_vec();
    for _ in 0..=below(4) {
        let at = below(bytes.len().max(1));
        let to = (at + below(40)).min(bytes.len());
        match below(5) {
            0 => bytes.truncate(at),
            1 => {
                let part = bytes[at.min(to)..to].to_vec();
                bytes.splice(at.min(to)..at.min(to), part);
            }
            2 => drop(bytes.drain(at.min(to)..to)),
            3 => {
                let is_digit = |k: &usize| bytes.get(*k).is_some_and(u8::is_ascii_digit);
                let Some(first) = (at..bytes.len()).find(is_digit) else { continue };
                let last = (first..bytes.len()).find(|k| !is_digit(k)).unwrap_or(bytes.len());
                bytes.splice(first..last, ODD[below(ODD.len())].iter().copied());
            }
            _ => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte = u8::try_from(below(256)).unwrap();
                }
            }
        }
    }
    bytes
}

/// The undamaged files must be accepted: otherwise the damaged copies would test refusals only.
#[test]
fn seeds_of_journal_and_golden_files_are_believed() {
    let folder = tempfile::tempdir().unwrap();
    let plan = targets::plan();
    drop(Journal::open(folder.path(), &plan).unwrap());
    for (_, rows) in corpus("journal") {
        let file = folder.path().join("journal.jsonl");
        fs::write(&file, [fs::read(&file).unwrap(), rows].concat()).unwrap();
    }
    let (journal, _) = Journal::open(folder.path(), &plan).unwrap();
    assert!(plan.units().all(|unit| journal.has(unit)));

    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in corpus("golden").into_iter().filter(|(name, _)| name != "verify_zero.json")
    {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    let report = verify_folder(folder.path(), &[]).unwrap();
    assert!(report.passed() && report.files.len() == 7, "{report:?}");
}

#[test]
fn every_reader_takes_its_corpus_and_damaged_copies_of_it() {
    for target in &TARGETS {
        let files = corpus(target.0);
        assert!(!files.is_empty(), "{}", target.0);
        for (name, bytes) in files {
            (target.1)(&bytes);
            for seed in 0..DAMAGED {
                let damaged = damaged(&bytes, seed);
                let run = std::panic::catch_unwind(|| (target.1)(&damaged));
                let shown = String::from_utf8_lossy(&damaged);
                assert!(run.is_ok(), "{} {name}, seed {seed}:\n{shown}", target.0);
            }
        }
    }
}

/// Runs the target that `SINEW_TARGET` names; without a name, the target that the first byte selects.
#[cfg(feature = "bolero")]
#[test]
fn readers() {
    let wanted = std::env::var("SINEW_TARGET").ok();
    bolero::check!().for_each(|bytes: &[u8]| {
        let Some((first, rest)) = bytes.split_first() else { return };
        match &wanted {
            Some(wanted) => {
                let named = targets::TARGETS.iter().find(|(name, _)| name == wanted);
                named.expect("SINEW_TARGET names a target").1(bytes);
            }
            None => targets::TARGETS[usize::from(*first) % targets::TARGETS.len()].1(rest),
        }
    });
}
