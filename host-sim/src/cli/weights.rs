//! `sinew clip weights`: the importance of each joint of a character.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, ensure};
use clap::ValueEnum;
use sinew_host_util::command::{note, print};
use sinew_pose_metrics::character::{self, Mesh, Options, VertexArea};
use sinew_pose_metrics::weights::radii::{self, Radii};
use sinew_pose_metrics::weights::{Method, Settings, Weighing, table, weigh};
use sinew_report::weights as picture;

use super::output::OutputPath;
use super::unit_args::UnitArgs;

/// Compute the importance of a character's joints: how much of the character each joint moves, and how far.
///
/// FILE is a skinned character (Geno.bin; glTF 2.0 as *.glb or *.gltf), a rig (*.urdf), or
/// a motion, whose skeleton is used (*.bvh, *.amc with its ASF, humanoid3d_*.txt).
///
/// The method is by D. Holden, "Joint Error Propagation" (2025). Every joint starts with a
/// base value and gets
///
///   by lengths    (m)   D (L + w) of each child: its distance L and its own weight w;
///   by cylinders  (m³)  the integral of the distance over the surfaces of all bones below it;
///   by mesh       (m³)  area times distance of all skin that moves with it.
///
/// The printed weights are divided by their sum, so they have no unit.
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// The character, rig or motion.
    #[arg(value_name = "FILE")]
    character: PathBuf,

    /// Methods to use. `all`: those that the file allows. A skeleton has no mesh, and a mesh of points has no
    /// surface.
    #[arg(long, value_name = "METHOD,..", value_delimiter = ',', default_value = "all")]
    method: Vec<MethodArg>,

    /// Base value of every joint, for all selected methods: in m for `lengths`, in m³ for `cylinders` and `mesh`.
    /// Default: the values of the article's list for Geno: 0.1 m for `lengths`; 0.002 m³ for `cylinders`; 0.00183 m³
    /// for `mesh` (0.001 with `--vertex-area article`). They suit a figure 1.7 m tall. For a figure half as tall, use
    /// half of the value in m, or an eighth of the value in m³, to get the same weights.
    #[arg(long, value_name = "B", allow_negative_numbers = true)]
    base: Option<f64>,

    /// Method `lengths`: discount D of a bone for each joint further up, 0 to 1.
    #[arg(long, value_name = "D", default_value_t = 0.9, allow_negative_numbers = true)]
    discount: f64,

    /// Method `mesh`: the area of a vertex.
    #[arg(long, value_enum, default_value_t = VertexAreaArg::Surface)]
    vertex_area: VertexAreaArg,

    /// Method `cylinders`: radius of all bones in m, or a CSV with the columns `joint` and `radius_m`, as `--format
    /// csv` prints it. Default: with a skin, the mean distance of the skin from the bone; otherwise a quarter of the
    /// bone's length. A bone has the name of the joint in which it ends.
    #[arg(long, value_name = "R|FILE", allow_negative_numbers = true)]
    radii: Option<String>,

    #[command(flatten)]
    units: UnitArgs,

    /// Use the pose of this frame of a motion as the rest pose. Frames count from 0. Default: the skeleton with all
    /// joints at zero.
    #[arg(long, value_name = "N")]
    frame: Option<usize>,

    /// Format of the output.
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,

    /// Also draw the weights into this file: as discs on the figure at rest (the area of a disc is the joint's
    /// weight), and as bars.
    #[arg(long, value_name = "FILE.svg|FILE.png")]
    picture: Option<OutputPath>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MethodArg {
    /// By the length of the bones below the joint.
    Lengths,
    /// By the surface of the bones below the joint, as cylinders.
    Cylinders,
    /// By the skin that moves with the joint.
    Mesh,
    /// All methods that the file allows.
    All,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum VertexAreaArg {
    /// A third of the areas of the vertex's triangles: the sum over all vertices is the area of the surface.
    Surface,
    /// The mean area of the vertex's triangles, as in the article's list: the sum over all vertices is about half of
    /// the surface's area.
    Article,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// An aligned table.
    Table,
    /// One JSON object, schema `sinew-weights/1`.
    Json,
    /// A row per joint, with the length and the radius of the bone that ends in it.
    Csv,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let options = Options { units: args.units.overrides(), frame: args.frame };
    let character = character::read(&args.character, &options)?;
    for line in character.notes() {
        note(format_args!("note: {}: {line}", character.name()));
    }
    let methods = methods(&args.method, character.mesh());
    ensure!(
        args.radii.is_none() || methods.contains(&Method::Cylinders),
        "--radii: expected only with the method cylinders"
    );
    ensure!(
        args.vertex_area == VertexAreaArg::Surface || methods.contains(&Method::Mesh),
        "--vertex-area article: expected only with the method mesh"
    );
    let settings = Settings {
        base: args.base,
        discount: args.discount,
        vertex_area: match args.vertex_area {
            VertexAreaArg::Surface => VertexArea::Surface,
            VertexAreaArg::Article => VertexArea::Article,
        },
        radii: args.radii.as_deref().map_or(Ok(Radii::Estimated), radii_of)?,
    };
    let of_file = || args.character.display().to_string();
    let radii_m = if methods.contains(&Method::Cylinders) {
        Some(settings.radii.of(&character).with_context(of_file)?)
    } else {
        None
    };
    let weighings: Vec<Weighing> = methods
        .iter()
        .map(|method| weigh(&character, *method, &settings))
        .collect::<Result<_, _>>()
        .with_context(of_file)?;
    if let Some(path) = &args.picture {
        picture::write(path, &character, &weighings)
            .with_context(|| format!("--picture {}", path.display()))?;
    }
    let radii_m = radii_m.as_deref();
    print(&match args.format {
        Format::Table => table::text(&character, radii_m, &weighings),
        Format::Json => table::json(&character, &weighings),
        Format::Csv => table::csv(&character, radii_m, &weighings),
    })?;
    Ok(())
}

/// Returns the requested methods, each once, in the order in which they are printed.
fn methods(asked: &[MethodArg], mesh: Option<&Mesh>) -> Vec<Method> {
    let all = asked.contains(&MethodArg::All);
    let why_not_mesh = match mesh {
        None => Some("the file has a skeleton only"),
        Some(mesh) if !mesh.has_surface() => Some("the file's mesh has no surface"),
        Some(_) => None,
    };
    if let (true, Some(why)) = (all, why_not_mesh) {
        note(format_args!("method mesh is left out: {why}"));
    }
    let is_asked = |method: &Method| {
        let (one, possible) = match method {
            Method::Lengths => (MethodArg::Lengths, true),
            Method::Cylinders => (MethodArg::Cylinders, true),
            Method::Mesh => (MethodArg::Mesh, why_not_mesh.is_none()),
        };
        asked.contains(&one) || all && possible
    };
    Method::ALL.into_iter().filter(is_asked).collect()
}

/// Parses radii: a number is a radius, every other text is a file.
fn radii_of(text: &str) -> anyhow::Result<Radii> {
    Ok(match text.trim().parse() {
        Ok(radius_m) => Radii::Uniform(radius_m),
        Err(_) => Radii::Given(radii::read(Path::new(text))?),
    })
}
