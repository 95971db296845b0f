//! `sinew evaluate figure`: bodies of a measured subject.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::ValueEnum;
use comfy_table::{CellAlignment, Table, presets};
use serde::Serialize;
use sinew_figure::plant::MassProperties;
use sinew_figure::{BODIES, BodyModel, Subject, de_leva_mass_fraction};
use sinew_host_util::command::print;

use super::evaluate::scale;

/// Print the bodies of a measured subject in the Hanavan-Kwon model.
///
/// The table has a row for each of the figure's 18 bodies: its solid, mass, share of the total mass, the share by de
/// Leva's table, density, centre of mass in m, and moments of inertia about the centre of mass in kg m².
///
/// Frames: the subject stands upright with its arms down. In every body's frame x points to the subject's left, y up
/// and z forward. The origin is the body's joint: the middle of the hips for the pelvis; the lower end for the
/// trunk's parts and the head; the top of the upper trunk for the clavicles; the upper end for limbs; the ankles for
/// feet. These axes are principal axes of every solid: its products of inertia are zero.
///
/// On a clip's skeleton (as the evaluation uses it) the masses are the same, limbs are as long as the clip's, and the
/// inertia is along the clip's bones.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Measures of the subject, in TOML. Default: the built-in subject, of 1.80 m and 75 kg.
    subject: Option<PathBuf>,

    /// Factor on all dimensions, at the same density, 0.1 to 10.
    #[arg(long, value_name = "F", default_value = "1.0", value_parser = scale, allow_negative_numbers = true)]
    scale: f64,

    /// Format of the output.
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// An aligned table.
    Table,
    /// One JSON object, schema `sinew-figure/1`, with full matrices of inertia.
    Json,
}

/// The printed numbers.
#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    subject: &'a str,
    scale: f64,
    /// Whether the masses were scaled to sum to the given mass.
    normalised: bool,
    bodies: Vec<Row>,
    /// Sum of the bodies' masses, kg.
    sum_kg: f64,
    /// Sum of the masses by the regressions, kg.
    regression_sum_kg: f64,
    /// The given mass times the cube of the scale, kg.
    mass_kg: f64,
}

#[derive(Serialize)]
struct Row {
    body: &'static str,
    solid: &'static str,
    mass_kg: f64,
    fraction: f64,
    de_leva_fraction: f64,
    density_kg_m3: f64,
    center_of_mass_m: [f64; 3],
    rotational_kg_m2: [[f64; 3]; 3],
}

/// Runs the subcommand.
///
/// # Errors
/// If the subject's file cannot be read or contains a measure that is impossible for a body.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let read = args.subject.as_deref().map(Subject::read).transpose()?;
    let subject = read.as_ref().unwrap_or_else(|| Subject::built_in());
    let document =
        document(subject, &BodyModel::from_subject(subject)?.scaled(args.scale), args.scale);
    print(&match args.format {
        Format::Table => text(&document),
        Format::Json => serde_json::to_string_pretty(&document)? + "\n",
    })?;
    Ok(())
}

fn document<'a>(subject: &'a Subject, figure: &BodyModel, scale: f64) -> Document<'a> {
    let (sum_kg, volume) = (figure.mass_kg(), scale * scale * scale);
    let row = |(body, properties): (usize, &MassProperties)| {
        let segment = subject.segment(body);
        Row {
            body: BODIES[body].name,
            solid: segment.shape.name(),
            mass_kg: properties.mass_kg,
            fraction: properties.mass_kg / sum_kg,
            de_leva_fraction: de_leva_mass_fraction(body),
            density_kg_m3: segment.density_kg_m3(),
            center_of_mass_m: properties.center_of_mass_m.to_array(),
            rotational_kg_m2: properties.rotational_kg_m2.to_cols_array_2d(),
        }
    };
    Document {
        schema: "sinew-figure/1",
        subject: &subject.inputs().name,
        scale,
        normalised: subject.inputs().normalise,
        bodies: figure.bodies.iter().enumerate().map(row).collect(),
        sum_kg,
        regression_sum_kg: subject.regression_sum_kg() * volume,
        mass_kg: subject.inputs().mass_kg.get() * volume,
    }
}

fn text(document: &Document<'_>) -> String {
    let Document { scale, sum_kg, regression_sum_kg, mass_kg, .. } = document;
    let mut out = String::new();
    let mut line = |text: std::fmt::Arguments<'_>| {
        writeln!(out, "{text}").expect("a string takes everything");
    };
    line(format_args!("{}, dimensions times {scale}", document.subject));
    line(format_args!(
        "mass in kg and in % of the sum, beside de Leva's %; centre of mass x y z in m;"
    ));
    line(format_args!(
        "moments of inertia about it in kg m²; x left, y up, z forward, origin in the body's joint\n"
    ));
    line(format_args!("{}\n", table(document).trim_fmt()));
    let percent = 100.0 * (regression_sum_kg / mass_kg - 1.0);
    line(format_args!("sum of the masses        {sum_kg:.3} kg"));
    if document.normalised {
        line(format_args!("sum by the regressions   {regression_sum_kg:.3} kg"));
    }
    line(format_args!("mass of the subject      {mass_kg:.3} kg"));
    line(format_args!(
        "regressions off by       {:+.3} kg ({percent:+.1} %){}",
        regression_sum_kg - mass_kg,
        if document.normalised { ", scaled away" } else { "" }
    ));
    out
}

fn table(document: &Document<'_>) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header([
        "body", "solid", "kg", "%", "de Leva", "kg/m³", "x", "y", "z", "Ixx", "Iyy", "Izz",
    ]);
    for row in &document.bodies {
        let mut cells = vec![row.body.to_owned(), row.solid.to_owned()];
        cells.push(format!("{:.3}", row.mass_kg));
        cells.push(format!("{:.2}", 100.0 * row.fraction));
        cells.push(format!("{:.2}", 100.0 * row.de_leva_fraction));
        cells.push(format!("{:.0}", row.density_kg_m3));
        cells.extend(row.center_of_mass_m.map(|x| format!("{x:.3}")));
        let moments: [f64; 3] = core::array::from_fn(|axis| row.rotational_kg_m2[axis][axis]);
        cells.extend(moments.map(|moment| format!("{moment:.2e}")));
        table.add_row(cells);
    }
    for (index, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 1));
        if index > 1 {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}
