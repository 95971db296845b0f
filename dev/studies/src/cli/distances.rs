//! `sinew-studies distances`: distances of all pairs of poses of a data set.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context as _, ensure};
use sinew_host_util::command::{ThreadArgs, note, print, with_progress};
use sinew_host_util::output::{self, Folder};
use sinew_pose_metrics::spatial::{MeasureArgs, MeasuredPose, RigMeasure, SpatialRig};
use sinew_studies::recordings::{RATE_HZ, Recordings};
use sinew_studies::spatial::write_distances;

use super::data::RecordingArgs;

/// Write the distances of all pairs of poses of a data set, for your own programs.
///
/// The file is a NumPy file: f32 in the order of SciPy's `pdist`, so that `squareform(numpy.load(FILE))` is the
/// matrix. Beside it, FILE.csv identifies the poses. Poses are at 12 Hz and on one skeleton; the root's place and
/// orientation do not count. Distances are written to a folder beside the file while they are computed: besides the
/// poses (3 kB each), at most 16 MB are in memory. CMU's poses make 730 MB, Bandai's 1.2 GB.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    recordings: RecordingArgs,

    #[command(flatten)]
    measure: MeasureArgs,

    /// The file to write, *.npy.
    #[arg(long, value_name = "FILE.npy")]
    out: PathBuf,

    #[command(flatten)]
    threads: ThreadArgs,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let path = &args.out;
    ensure!(
        path.extension().is_some_and(|extension| extension == "npy"),
        "--out {}: expected a file named *.npy",
        path.display()
    );
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    ensure!(folder.is_dir(), "{}: expected an existing folder", folder.display());
    let name = path.file_name().unwrap_or_default();
    let names = path.with_extension("csv");
    let indices = args.recordings.indices();
    let inputs: Vec<_> = indices.iter().map(|index| ("index", Some(index.as_path()))).collect();
    output::distinct(&[path.as_path(), &names], &inputs)?;
    let measure = args.measure.measure()?;
    let recordings = args.recordings.read()?;
    let rig = SpatialRig::new(&recordings.skeleton, args.measure.root.as_deref())?;
    // Opened before the work. Both files belong to one run; a reader finds both complete or neither.
    let results = Folder::open(folder, &format!("distances {}", name.display()), &inputs)?;
    let stage = results.stage();
    let measuring = RigMeasure::new(&rig, measure);
    let mut poses: Vec<MeasuredPose> = Vec::new();
    for sequence in &recordings.sequences {
        for (frame, pose) in sequence.frames.iter().enumerate() {
            let pose = measuring.pose(pose);
            poses.push(pose.with_context(|| format!("{}: frame {frame}", sequence.file))?);
        }
    }
    let pairs = poses.len() * poses.len().saturating_sub(1) / 2;
    let megabytes = 4e-6 * pairs as f64;
    note(format_args!("{} poses, {pairs} pairs, {megabytes:.1} MB", poses.len()));
    let part = stage.join(name);
    let cannot = |path: &Path| format!("{}: cannot be written", path.display());
    let file = File::create(&part).with_context(|| cannot(&part))?;
    let start = Instant::now();
    let written = with_progress(pairs, |done| {
        args.threads
            .install(|| Ok(write_distances(&measuring, &poses, BufWriter::new(file), done)?))
    })
    .with_context(|| cannot(&part))?;
    let seconds = start.elapsed().as_secs_f64();
    let part = part.with_extension("csv");
    write_names(&recordings, &part).with_context(|| cannot(&part))?;
    results.finish()?;
    note(format_args!("{seconds:.1} s, {:.0} ns a distance", 1e9 * seconds / pairs.max(1) as f64));

    let unit = measuring.measure().metric.unit();
    let spread = written.distances.map_or(String::new(), |spread| {
        let (least, mean, most) = (spread.least, spread.mean, spread.most);
        format!(": from {least:.4} to {most:.4} {unit}, {mean:.4} {unit} on average")
    });
    print(&format!(
        "{} poses of {} recordings at {RATE_HZ} Hz, {} joints: {} pairs\n{}{spread}\n{}\n{}\n",
        poses.len(),
        recordings.sequences.len(),
        recordings.skeleton.joints.len(),
        written.pairs,
        measuring.measure(),
        path.display(),
        names.display(),
    ))?;
    Ok(())
}

/// Writes the file, frame and time of each pose.
fn write_names(recordings: &Recordings, path: &Path) -> csv::Result<()> {
    let mut csv = csv::Writer::from_path(path)?;
    csv.write_record(["pose", "file", "frame", "seconds"])?;
    let poses = recordings.sequences.iter().flat_map(|sequence| {
        (0..sequence.frames.len()).map(move |frame| (sequence.file.as_str(), frame))
    });
    for (pose, (file, frame)) in poses.enumerate() {
        csv.serialize((pose, file, frame, format!("{:.3}", frame as f64 / RATE_HZ)))?;
    }
    Ok(csv.flush()?)
}
