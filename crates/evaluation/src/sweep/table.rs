//! The tables of a sweep: a row per cell, and a row per cell and clip, as CSV and as Parquet.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;

use sinew_host_util::output::Pending;

use super::error::{SweepError, io};
use super::journal::{Journal, Outcome};
use super::pareto;
use super::plan::{Plan, Shard, Unit};
use crate::{Errors, Setup};

/// A column: its name, and its values by row.
struct Column {
    name: String,
    values: Values,
}

enum Values {
    Text(Vec<Option<String>>),
    Integer(Vec<Option<i64>>),
    Float(Vec<Option<f64>>),
}

/// A cell, and its errors over all clips.
pub(super) type Total = (usize, Errors);

/// Content of a row.
struct Row<'a> {
    cell: usize,
    setup: &'a Setup,
    clip: Option<&'a str>,
    /// Errors, or the clip on which the figure was lost and the reason.
    result: Result<Errors, (&'a str, &'a str)>,
}

/// Writes all tables to `folder`. Returns their paths, and the cells that were not lost with their errors over all
/// clips.
pub(super) fn write(
    plan: &Plan,
    journal: &Journal,
    folder: &Path,
) -> Result<(Vec<PathBuf>, Vec<Total>), SweepError> {
    let (mut cells, mut runs) = (Vec::new(), Vec::new());
    for cell in plan.shard_cells() {
        let setup = &plan.cells[cell].setup;
        let mut total = Ok(Errors::default());
        for (clip, identity) in plan.clips.iter().enumerate() {
            let name = identity.name.as_str();
            let outcome = journal.outcome(Unit { cell, clip });
            let result = match outcome.expect("every unit is finished") {
                Outcome::Errors(errors) => Ok(*errors),
                Outcome::Lost(reason) => Err((name, reason.as_str())),
            };
            total = match (total, result) {
                (Ok(mut total), Ok(errors)) => {
                    total.merge(&errors);
                    Ok(total)
                }
                (Err(first), _) => Err(first),
                (_, Err(lost)) => Err(lost),
            };
            runs.push(Row { cell, setup, clip: Some(name), result });
        }
        cells.push(Row { cell, setup, clip: None, result: total });
    }
    let kept =
        cells.iter().filter_map(|row| row.result.ok().map(|errors| (row.cell, errors))).collect();
    let mut files = Vec::new();
    for (name, rows) in [("sweep", cells), ("sweep_clips", runs)] {
        let columns = columns(&rows, plan.shard == Shard::WHOLE);
        for (extension, bytes) in
            [("csv", csv(&columns)), ("parquet", parquet(&columns, plan, folder)?)]
        {
            let file = folder.join(name).with_extension(extension);
            replace(&file, &bytes).map_err(io(&file))?;
            files.push(file);
        }
    }
    Ok((files, kept))
}

fn replace(file: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut pending = Pending::begin(file)?;
    pending.write_all(bytes)?;
    pending.finish()
}

/// Returns the columns of these rows. `whole` is false if the rows are only a part of the sweep; the front is then
/// left empty.
fn columns(rows: &[Row<'_>], whole: bool) -> Vec<Column> {
    let mut columns = vec![Column {
        name: "cell".to_owned(),
        values: Values::Integer(rows.iter().map(|row| i64::try_from(row.cell).ok()).collect()),
    }];
    columns.extend(setup_columns(rows));
    let text =
        |value: fn(&Row<'_>) -> Option<String>| Values::Text(rows.iter().map(value).collect());
    let mut add = |name: &str, values| columns.push(Column { name: name.to_owned(), values });
    if rows.iter().any(|row| row.clip.is_some()) {
        add("clip", text(|row| row.clip.map(str::to_owned)));
    }
    add("status", text(|row| Some(if row.result.is_ok() { "ok" } else { "lost" }.to_owned())));
    add(
        "reason",
        text(|row| row.result.as_ref().err().map(|(clip, reason)| format!("{clip}: {reason}"))),
    );
    let integers = |value: fn(&Errors) -> u64| {
        let of =
            |row: &Row<'_>| row.result.as_ref().ok().and_then(|e| i64::try_from(value(e)).ok());
        Values::Integer(rows.iter().map(of).collect())
    };
    let floats = |value: &dyn Fn(&Errors) -> f64| {
        Values::Float(rows.iter().map(|row| row.result.as_ref().ok().map(value)).collect())
    };
    add("n_all", integers(|errors| errors.all.n));
    add("n_leaf", integers(|errors| errors.leaf.n));
    for (group, totals) in [("all", all as Group), ("leaf", leaf as Group)] {
        let metrics = ["angular_mean_deg", "linear_mean_cm", "angular_max_deg", "linear_max_cm"];
        for (index, metric) in metrics.into_iter().enumerate() {
            add(&format!("{group}_{metric}"), floats(&|errors| totals(errors)[index]));
        }
    }
    add("all_weighted_mean_cm", floats(&|errors| errors.weighted.mean_cm()));
    add("all_weighted_max_cm", floats(&|errors| errors.weighted.max_cm()));
    add("widest_gap_mm", floats(&|errors| errors.widest_gap_m * 1000.0));
    add("limited", integers(|errors| errors.limited));
    add("on_front", Values::Text(on_front(rows, whole)));
    columns
}

/// Returns "yes" or "no" for each row: whether its mean errors of all joints are on the front of the rows of its task
/// and its clip. `None` for a failed row, and for every row unless `whole`.
fn on_front(rows: &[Row<'_>], whole: bool) -> Vec<Option<String>> {
    if !whole {
        return vec![None; rows.len()];
    }
    let rows: Vec<_> =
        rows.iter().map(|row| ((row.clip, pareto::task(row.setup)), row.result.ok())).collect();
    let said = |on_front: bool| if on_front { "yes" } else { "no" }.to_owned();
    pareto::of_rows(&rows).into_iter().map(|on_front| on_front.map(said)).collect()
}

type Group = fn(&Errors) -> [f64; 4];

fn all(errors: &Errors) -> [f64; 4] {
    errors.all.figures()
}

fn leaf(errors: &Errors) -> [f64; 4] {
    errors.leaf.figures()
}

/// Returns a column for every key of the setups, even for constant keys: a table then describes its rows
/// completely. Subjects are listed by name.
fn setup_columns(rows: &[Row<'_>]) -> Vec<Column> {
    let mut template = Vec::new();
    flatten("", &Setup::default().to_table(), &mut template);
    let flat: Vec<Vec<(String, toml::Value)>> = rows
        .iter()
        .map(|row| {
            let mut values = Vec::new();
            let mut table = row.setup.to_table();
            table.remove("subject");
            flatten("", &table, &mut values);
            values
        })
        .collect();
    let mut columns: Vec<Column> = template
        .into_iter()
        .enumerate()
        .map(|(index, (name, value))| {
            let of = |row: &Vec<(String, toml::Value)>| row[index].1.clone();
            let values = match value {
                toml::Value::Integer(_) => {
                    Values::Integer(flat.iter().map(|row| of(row).as_integer()).collect())
                }
                toml::Value::Float(_) => {
                    Values::Float(flat.iter().map(|row| of(row).as_float()).collect())
                }
                _ => Values::Text(flat.iter().map(|row| Some(plain(&of(row)))).collect()),
            };
            Column { name, values }
        })
        .collect();
    let subject =
        |row: &Row<'_>| row.setup.subject.as_ref().map(|subject| subject.inputs().name.clone());
    columns.push(Column {
        name: "subject".to_owned(),
        values: Values::Text(rows.iter().map(subject).collect()),
    });
    columns
}

/// Returns a value without TOML's quotes.
fn plain(value: &toml::Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

fn flatten(prefix: &str, table: &toml::Table, values: &mut Vec<(String, toml::Value)>) {
    for (key, value) in table {
        match value {
            toml::Value::Table(inner) => flatten(&format!("{prefix}{key}."), inner, values),
            value => values.push((format!("{prefix}{key}"), value.clone())),
        }
    }
}

fn csv(columns: &[Column]) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut record = |fields: &mut dyn Iterator<Item = String>| {
        writer.write_record(fields).expect("memory takes everything");
    };
    record(&mut columns.iter().map(|column| column.name.clone()));
    let rows = columns.first().map_or(0, |column| column.values.len());
    for row in 0..rows {
        record(&mut columns.iter().map(|column| column.values.text(row)));
    }
    writer.into_inner().expect("memory takes everything")
}

impl Values {
    fn len(&self) -> usize {
        match self {
            Self::Text(values) => values.len(),
            Self::Integer(values) => values.len(),
            Self::Float(values) => values.len(),
        }
    }

    /// Returns a value as text; empty if there is none.
    fn text(&self, row: usize) -> String {
        match self {
            Self::Text(values) => values[row].clone().unwrap_or_default(),
            Self::Integer(values) => values[row].map(|value| value.to_string()).unwrap_or_default(),
            Self::Float(values) => values[row].map(|value| value.to_string()).unwrap_or_default(),
        }
    }

    fn physical_type(&self) -> PhysicalType {
        match self {
            Self::Text(_) => PhysicalType::BYTE_ARRAY,
            Self::Integer(_) => PhysicalType::INT64,
            Self::Float(_) => PhysicalType::DOUBLE,
        }
    }
}

fn parquet(columns: &[Column], plan: &Plan, folder: &Path) -> Result<Vec<u8>, SweepError> {
    parquet_bytes(columns, plan)
        .map_err(|source| SweepError::Parquet { file: folder.to_path_buf(), source })
}

fn parquet_bytes(columns: &[Column], plan: &Plan) -> Result<Vec<u8>, ParquetError> {
    let fields = columns
        .iter()
        .map(|column| {
            let logical = matches!(column.values, Values::Text(_)).then_some(LogicalType::String);
            Type::primitive_type_builder(&column.name, column.values.physical_type())
                .with_repetition(Repetition::OPTIONAL)
                .with_logical_type(logical)
                .build()
                .map(Arc::new)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let schema = Arc::new(Type::group_type_builder("sweep").with_fields(fields).build()?);
    let note = |key: &str, value: &str| KeyValue::new(key.to_owned(), value.to_owned());
    let json = "plain data turns into JSON";
    let properties = WriterProperties::builder()
        .set_created_by(concat!("sinew ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_key_value_metadata(Some(vec![
            note("schema", "sinew-sweep/1"),
            note("sweep_file", &plan.text),
            note("clips", &serde_json::to_string(&plan.clips).expect(json)),
            note("seconds", &serde_json::to_string(&plan.seconds).expect(json)),
        ]))
        .build();
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties))?;
    let mut rows = writer.next_row_group()?;
    for column in columns {
        let mut chunk = rows.next_column()?.expect("as many columns as fields");
        match &column.values {
            Values::Text(values) => {
                let bytes: Vec<Option<ByteArray>> = values
                    .iter()
                    .map(|value| value.as_ref().map(|text| text.as_bytes().to_vec().into()))
                    .collect();
                write_column::<ByteArrayType>(&mut chunk, &bytes)?;
            }
            Values::Integer(values) => write_column::<Int64Type>(&mut chunk, values)?,
            Values::Float(values) => write_column::<DoubleType>(&mut chunk, values)?,
        }
        chunk.close()?;
    }
    rows.close()?;
    writer.into_inner()
}

/// Writes a column. Definition level 1 is a value, 0 is a missing value.
fn write_column<T: parquet::data_type::DataType>(
    chunk: &mut SerializedColumnWriter<'_>,
    values: &[Option<T::T>],
) -> Result<(), ParquetError> {
    let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
    let present: Vec<T::T> = values.iter().flatten().cloned().collect();
    chunk.typed::<T>().write_batch(&present, Some(&levels), None)?;
    Ok(())
}
