//! Records a performance as a Parquet file: one row per tick.

use std::io::{BufWriter, IntoInnerError};
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, FloatType};
use parquet::errors::ParquetError;
use parquet::file::metadata::{
    FileMetaData, KeyValue, ParquetMetaData, ParquetMetaDataWriter, RowGroupMetaData,
};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;
use sinew_host_util::output::Pending;
use sinew_servo_sim::load::Plant;

use super::checksum::{self, Summed};
use super::rig_parts::RigParts;
use super::simulated_rig::SimulatedRig;

/// Schema of a recording.
pub const SCHEMA: &str = "sinew-recording/2";
/// Schema of recordings without a checksum.
pub(super) const SCHEMA_UNSUMMED: &str = "sinew-recording/1";
/// Version of the Parquet format: its writer uses the first one.
const VERSION: i32 = 1;
const CREATED_BY: &str = concat!("sinew ", env!("CARGO_PKG_VERSION"));
/// Number of rows in a part, which are written at once: 5 s at 500 Hz.
const GROUP: usize = 2_500;
/// Key of the metadata that marks an end between two parts.
pub(super) const UNFINISHED: &str = "unfinished";
/// Another end is written only when the new data is this many times as long as the last end.
const END_SHARE: usize = 5;

/// Columns of each joint.
pub(super) const OF_JOINT: [&str; 4] = ["commanded", "measured", "error", "effort"];
/// A column of each joint that old recordings lack.
pub(super) const SWINGS: &str = "swings";
/// Columns of each servo.
pub(super) const OF_SERVO: [&str; 3] = ["current", "temperature", "voltage"];

/// Writes a recording.
///
/// Columns: `time_s`, `state`, `runs` (whether the show ran) and `faults` (new faults of the tick, and warnings); of
/// each joint `JOINT.commanded`, `.measured`, `.error` (rad, or m), `.effort` (N m, or N), `.limiter` and `.swings`;
/// of each servo `SERVO.current` (A), `.temperature` (degC) and `.voltage` (V). Unknown values are null. Joints are
/// dofs; positions of a ball joint are those of the rotation vector.
///
/// The end of a Parquet file is its index, so a file without an end is lost. Therefore an end is also written between
/// the parts, where readers ignore it: if a file is cut off, its data is readable up to the last end. Each end has
/// the checksum of all bytes before it and of itself: see `checksum.rs`.
pub struct Recorder {
    writer: SerializedFileWriter<Summed<BufWriter<Pending>>>,
    kept: Vec<KeyValue>,
    /// Bytes up to the last end, and the length of that end.
    ended: usize,
    end_len: usize,
    time_s: Vec<Option<f64>>,
    state: Vec<Option<ByteArray>>,
    runs: Vec<Option<bool>>,
    faults: Vec<Option<ByteArray>>,
    joints: Vec<Joint>,
    servos: Vec<[Vec<Option<f32>>; 3]>,
}

#[derive(Default)]
struct Joint {
    numbers: [Vec<Option<f32>>; 4],
    limiter: Vec<Option<ByteArray>>,
    swings: Vec<Option<bool>>,
}

/// State of a rig in one row of a recording. Unknown values are `None`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tick {
    /// Time since the start, s. All ticks have equal intervals.
    pub time_s: f64,
    /// State of the supervisor.
    pub state: Option<String>,
    /// Whether the clock of a show runs.
    pub runs: bool,
    /// Names of new faults and warnings, separated by commas.
    pub faults: Option<String>,
    /// All dofs of the rig.
    pub joints: Vec<TickOfJoint>,
    /// Current (A), temperature (degC) and voltage (V) of each servo.
    pub servos: Vec<[Option<f32>; 3]>,
}

/// State of a dof in a [`Tick`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TickOfJoint {
    /// Commanded position, measured position, following error (rad or m), and effort (N m or N).
    pub numbers: [Option<f32>; 4],
    /// Limit that acts on the effort at present.
    pub limiter: Option<String>,
    /// Whether the joint oscillates.
    pub swings: Option<bool>,
}

impl Tick {
    /// Returns the state of a simulated rig after a tick.
    fn of<P: Plant>(sim: &SimulatedRig<'_, P>) -> Self {
        let report = sim.report();
        let faults: Vec<String> = report.raised.iter().map(|fault| fault.to_string()).collect();
        let [commanded, measured] = sim.dofs();
        let joint = |index: usize| {
            let dof = report.dofs[index];
            let told = |number| (!sim.parts.tells_nothing(index)).then_some(number);
            let [measured, error] = [measured[index], dof.error].map(told);
            TickOfJoint {
                numbers: [Some(commanded[index]), measured, error, Some(dof.effort)],
                limiter: sim.limiter(index),
                swings: Some(dof.swings),
            }
        };
        let servo = |index: usize| {
            let told = &report.servos[index];
            [sim.current_a(index), told.temperature_c, told.voltage_v]
        };
        Self {
            time_s: sim.time_s(),
            state: Some(report.state.to_string()),
            runs: sim.runs(),
            faults: (!faults.is_empty()).then(|| faults.join(", ")),
            joints: (0..sim.parts.names.len()).map(joint).collect(),
            servos: (0..sim.parts.servos.len()).map(servo).collect(),
        }
    }
}

impl Recorder {
    /// Creates the file. `rate_hz`: ticks per second; `rig`: the text of the rig's `rig.toml`, with which a report can
    /// draw the rig; `notes`: other metadata.
    ///
    /// # Errors
    /// An I/O error.
    pub fn new(
        path: &Path,
        (parts, rate_hz): (&RigParts, f64),
        rig: &str,
        notes: &[(&str, &str)],
    ) -> Result<Self, ParquetError> {
        let file = Summed::new(BufWriter::new(Pending::begin_kept(path)?));
        let field = |name: &str, kind: PhysicalType| {
            let logical = (kind == PhysicalType::BYTE_ARRAY).then_some(LogicalType::String);
            Type::primitive_type_builder(name, kind)
                .with_repetition(Repetition::OPTIONAL)
                .with_logical_type(logical)
                .build()
                .map(Arc::new)
        };
        let mut fields = vec![field("time_s", PhysicalType::DOUBLE)?];
        fields.push(field("state", PhysicalType::BYTE_ARRAY)?);
        fields.push(field("runs", PhysicalType::BOOLEAN)?);
        fields.push(field("faults", PhysicalType::BYTE_ARRAY)?);
        for name in &parts.names {
            for of in OF_JOINT {
                fields.push(field(&format!("{name}.{of}"), PhysicalType::FLOAT)?);
            }
            fields.push(field(&format!("{name}.limiter"), PhysicalType::BYTE_ARRAY)?);
            fields.push(field(&format!("{name}.{SWINGS}"), PhysicalType::BOOLEAN)?);
        }
        for servo in &parts.servos {
            for of in OF_SERVO {
                fields.push(field(
                    &format!("{}.{of}", servo_name(parts, servo)),
                    PhysicalType::FLOAT,
                )?);
            }
        }
        let schema = Arc::new(Type::group_type_builder("recording").with_fields(fields).build()?);
        let note = |key: &str, value: &str| KeyValue::new(key.to_owned(), value.to_owned());
        let mut kept = vec![note("schema", SCHEMA), note("rig", rig)];
        kept.push(note("rate_hz", &rate_hz.to_string()));
        kept.extend(notes.iter().map(|(key, value)| note(key, value)));
        let properties = WriterProperties::builder().set_created_by(CREATED_BY.to_owned()).build();
        Ok(Self {
            writer: SerializedFileWriter::new(file, schema, Arc::new(properties))?,
            kept,
            ended: 0,
            end_len: 0,
            time_s: Vec::new(),
            state: Vec::new(),
            runs: Vec::new(),
            faults: Vec::new(),
            joints: parts.names.iter().map(|_| Joint::default()).collect(),
            servos: parts.servos.iter().map(|_| Default::default()).collect(),
        })
    }

    /// Adds the state of a simulated rig as a row.
    ///
    /// # Errors
    /// An I/O error.
    pub fn note<P: Plant>(&mut self, sim: &SimulatedRig<'_, P>) -> Result<(), ParquetError> {
        self.put(&Tick::of(sim))
    }

    /// Adds a row. Values of dofs and servos that are missing in `tick` are unknown.
    ///
    /// # Errors
    /// An I/O error.
    pub fn put(&mut self, tick: &Tick) -> Result<(), ParquetError> {
        self.time_s.push(Some(tick.time_s));
        self.state.push(tick.state.as_deref().map(Into::into));
        self.runs.push(Some(tick.runs));
        self.faults.push(tick.faults.as_deref().map(Into::into));
        let nothing = TickOfJoint::default();
        for (index, joint) in self.joints.iter_mut().enumerate() {
            let told = tick.joints.get(index).unwrap_or(&nothing);
            for (column, number) in joint.numbers.iter_mut().zip(told.numbers) {
                column.push(number);
            }
            joint.limiter.push(told.limiter.as_deref().map(Into::into));
            joint.swings.push(told.swings);
        }
        for (index, columns) in self.servos.iter_mut().enumerate() {
            let told = tick.servos.get(index).copied().unwrap_or_default();
            for (column, number) in columns.iter_mut().zip(told) {
                column.push(number);
            }
        }
        if self.time_s.len() == GROUP {
            self.write()?;
            self.end_between()?;
        }
        Ok(())
    }

    /// Writes the remaining rows, and the end of the file.
    ///
    /// # Errors
    /// An I/O error.
    pub fn end(mut self) -> Result<(), ParquetError> {
        self.write()?;
        self.write_end(self.kept.clone())?;
        // The end that the crate writes would have no checksum.
        self.writer.flush()?;
        self.writer.inner_mut().is_over = true;
        let file = self.writer.into_inner()?.into_inner();
        file.into_inner().map_err(IntoInnerError::into_error)?.finish()?;
        Ok(())
    }

    /// Writes an end between the parts, so that the parts until now are readable even if this program is killed.
    fn end_between(&mut self) -> Result<(), ParquetError> {
        // The end grows with each part: in a long recording the ends would need more space than the parts.
        if END_SHARE * self.end_len > self.writer.bytes_written() - self.ended {
            return Ok(());
        }
        let unfinished = KeyValue::new(UNFINISHED.to_owned(), "true".to_owned());
        let len = self.write_end(self.kept.iter().cloned().chain([unfinished]).collect())?;
        self.writer.flush()?;
        (self.ended, self.end_len) = (self.writer.bytes_written(), len);
        Ok(())
    }

    /// Writes an end with its checksum. Returns its length.
    fn write_end(&mut self, mut kept: Vec<KeyValue>) -> Result<usize, ParquetError> {
        let parts = self.writer.flushed_row_groups().to_vec();
        let rows = parts.iter().map(RowGroupMetaData::num_rows).sum();
        let schema = Arc::new(self.writer.schema_descr().clone());
        // The last key, where readers look for it.
        kept.push(KeyValue::new(checksum::KEY.to_owned(), checksum::NONE.to_owned()));
        let by = Some(CREATED_BY.to_owned());
        let file = FileMetaData::new(VERSION, rows, by, Some(kept), schema, None);
        let mut end = Vec::new();
        ParquetMetaDataWriter::new(&mut end, &ParquetMetaData::new(file, parts)).finish()?;
        self.writer.flush()?;
        self.writer.inner().sign(&mut end);
        self.writer.write_all(&end)?;
        Ok(end.len())
    }

    fn write(&mut self) -> Result<(), ParquetError> {
        let mut rows = self.writer.next_row_group()?;
        let mut next = |column: Column<'_>| -> Result<(), ParquetError> {
            let Some(mut chunk) = rows.next_column()? else { return Ok(()) };
            match column {
                Column::Time(values) => put::<DoubleType>(&mut chunk, values)?,
                Column::Number(values) => put::<FloatType>(&mut chunk, values)?,
                Column::Text(values) => put::<ByteArrayType>(&mut chunk, values)?,
                Column::Flag(values) => put::<BoolType>(&mut chunk, values)?,
            }
            chunk.close()
        };
        next(Column::Time(&mut self.time_s))?;
        next(Column::Text(&mut self.state))?;
        next(Column::Flag(&mut self.runs))?;
        next(Column::Text(&mut self.faults))?;
        for joint in &mut self.joints {
            for numbers in &mut joint.numbers {
                next(Column::Number(numbers))?;
            }
            next(Column::Text(&mut joint.limiter))?;
            next(Column::Flag(&mut joint.swings))?;
        }
        for numbers in self.servos.iter_mut().flatten() {
            next(Column::Number(numbers))?;
        }
        rows.close()?;
        Ok(())
    }
}

/// Returns the name of a servo's columns: the servo's name, with a suffix if a joint has the same name.
fn servo_name(parts: &RigParts, servo: &super::ServoPart) -> String {
    let name = &servo.own.name;
    if parts.names.contains(name) { format!("{name}.servo") } else { name.clone() }
}

enum Column<'c> {
    Time(&'c mut Vec<Option<f64>>),
    Number(&'c mut Vec<Option<f32>>),
    Text(&'c mut Vec<Option<ByteArray>>),
    Flag(&'c mut Vec<Option<bool>>),
}

/// Writes a column, and empties it. Definition level 1 is a value, 0 is null.
fn put<T: DataType>(
    chunk: &mut SerializedColumnWriter<'_>,
    values: &mut Vec<Option<T::T>>,
) -> Result<(), ParquetError> {
    let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
    let present: Vec<T::T> = values.drain(..).flatten().collect();
    chunk.typed::<T>().write_batch(&present, Some(&levels), None)?;
    Ok(())
}
