//! Reads a recording part by part: see [`Recorder`](super::Recorder) for its columns.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;
use std::sync::Arc;

use parquet::column::reader::{ColumnReaderImpl, get_column_reader, get_typed_column_reader};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, FloatType};
use parquet::errors::ParquetError;
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader, RowGroupMetaData};
use parquet::file::serialized_reader::SerializedPageReader;
use sinew_mocap::Kind;
use thiserror::Error;

use super::checksum;
use super::record::{OF_JOINT, OF_SERVO, SCHEMA, SCHEMA_UNSUMMED, SWINGS, UNFINISHED};

/// First and last bytes of a Parquet file.
const MAGIC: &[u8; 4] = b"PAR1";
/// Last bytes of an end: its length and the magic.
const TAIL_LEN: u64 = 8;
/// Number of bytes that are enough to recognize the kind of a file.
const BEGINNING_LEN: u64 = 1 << 16;
/// Number of bytes that are searched at once, from the end of the file backwards.
const BLOCK: u64 = 1 << 16;

/// Error of a recording that cannot be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// An I/O error while the file is read.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The file does not begin like a Parquet file.
    #[error("expected a recording of `sinew play --record` in Parquet, found {}", Kind::found(*.0))]
    NotParquet(Option<Kind>),
    /// A Parquet file with other content.
    #[error("is not a recording of `sinew play --record`, but another Parquet file")]
    Other,
    /// No part is complete.
    #[error("is cut off before the end of its first part: no part of it is complete")]
    Nothing,
    /// A bit of the file was changed.
    #[error("is damaged: its checksum does not match its content. Another copy may be intact")]
    Sum,
    /// The recording lacks a required column.
    #[error("has no column {0:?}, which each recording has")]
    Column(String),
    /// A part is damaged.
    #[error("part {part}: {source}")]
    Damaged {
        /// Number of the part, from 1.
        part: usize,
        /// Error of the Parquet reader.
        source: ParquetError,
    },
}

/// A recording on disk.
#[derive(Debug)]
pub struct Recording {
    file: Arc<File>,
    metadata: ParquetMetaData,
    joints: Vec<String>,
    servos: Vec<String>,
}

/// A part of the rows. Unknown numbers are NaN.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Part {
    /// Time since power-on, s.
    pub time_s: Vec<f64>,
    /// State of the supervisor.
    pub states: Vec<Option<String>>,
    /// Whether the show ran.
    pub runs: Vec<bool>,
    /// New faults and warnings of the tick.
    pub faults: Vec<Option<String>>,
    /// Rows of each joint.
    pub joints: Vec<JointRows>,
    /// Rows of each servo.
    pub servos: Vec<ServoRows>,
}

/// Rows of a joint: in rad and N m, or m and N.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct JointRows {
    /// Commanded position.
    pub commanded: Vec<f32>,
    /// Measured position.
    pub measured: Vec<f32>,
    /// Following error: the command of the previous tick minus the measured position.
    pub error: Vec<f32>,
    /// Commanded effort.
    pub effort: Vec<f32>,
    /// The limit that acted on the effort.
    pub limiter: Vec<Option<String>>,
    /// Whether the joint swings, or did within the last 5 s.
    pub swings: Vec<bool>,
}

/// Rows of a servo.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ServoRows {
    /// Current, A.
    pub current: Vec<f32>,
    /// Temperature, °C.
    pub temperature: Vec<f32>,
    /// Supply voltage, V.
    pub voltage: Vec<f32>,
}

impl Recording {
    /// Opens a recording. If it is cut off, its complete parts are readable.
    ///
    /// # Errors
    /// [`RecordingError`] if the file is not a recording, is damaged, or has no complete part.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let mut file = File::open(path)?;
        let mut start = Vec::new();
        (&mut file).take(BEGINNING_LEN).read_to_end(&mut start)?;
        if !start.starts_with(MAGIC) {
            return Err(RecordingError::NotParquet(Kind::of(path, &start)));
        }
        let (metadata, place) = last_end(&mut file)?;
        let sums = file.try_clone()?;
        let mut recording =
            Self { file: Arc::new(file), metadata, joints: Vec::new(), servos: Vec::new() };
        match recording.note("schema") {
            Some(SCHEMA) if checksum::fits(&mut { sums }, place)? => {}
            Some(SCHEMA) => return Err(RecordingError::Sum),
            Some(SCHEMA_UNSUMMED) => {}
            _ => return Err(RecordingError::Other),
        }
        let names: Vec<&str> = recording.columns().collect();
        let of = |ending: &str| -> Vec<String> {
            let ending = format!(".{ending}");
            names.iter().filter_map(|name| name.strip_suffix(&ending)).map(str::to_owned).collect()
        };
        (recording.joints, recording.servos) = (of(OF_JOINT[0]), of(OF_SERVO[0]));
        Ok(recording)
    }

    fn columns(&self) -> impl Iterator<Item = &str> {
        self.metadata.file_metadata().schema_descr().columns().iter().map(|column| column.name())
    }

    /// Returns the value of a key of the metadata, such as `rig`, `show` and `rate_hz`; `None` if the key is missing.
    pub fn note(&self, key: &str) -> Option<&str> {
        let kept = self.metadata.file_metadata().key_value_metadata()?;
        kept.iter().find(|note| note.key == key)?.value.as_deref()
    }

    /// Returns whether the recording was written to its end.
    pub fn is_whole(&self) -> bool {
        self.note(UNFINISHED).is_none()
    }

    /// Returns the names of the joints (dofs).
    pub fn joints(&self) -> &[String] {
        &self.joints
    }

    /// Returns the names of the servos' columns.
    pub fn servos(&self) -> &[String] {
        &self.servos
    }

    /// Returns the number of rows (ticks).
    pub fn rows(&self) -> usize {
        let rows = self.metadata.row_groups().iter().map(RowGroupMetaData::num_rows);
        rows.map(|rows| usize::try_from(rows).unwrap_or_default()).sum()
    }

    /// Reads all complete parts, in order of time.
    pub fn parts(&self) -> impl Iterator<Item = Result<Part, RecordingError>> {
        (0..self.metadata.num_row_groups()).map(|group| self.part(group))
    }

    fn part(&self, group: usize) -> Result<Part, RecordingError> {
        let float = |name: &str| -> Result<Vec<f32>, RecordingError> {
            let numbers = self.column::<FloatType>(group, name)?;
            Ok(numbers.into_iter().map(|number| number.unwrap_or(f32::NAN)).collect())
        };
        let text = |name: &str| -> Result<Vec<Option<String>>, RecordingError> {
            let texts = self.column::<ByteArrayType>(group, name)?;
            let own = |bytes: ByteArray| String::from_utf8_lossy(bytes.data()).into_owned();
            Ok(texts.into_iter().map(|text| text.map(own)).collect())
        };
        let flags = |name: &str| -> Result<Vec<bool>, RecordingError> {
            match self.column::<BoolType>(group, name) {
                Ok(flags) => Ok(flags.into_iter().map(|flag| flag == Some(true)).collect()),
                Err(RecordingError::Column(_)) => Ok(vec![false; self.count(group)]),
                Err(why) => Err(why),
            }
        };
        let joint = |name: &String| -> Result<JointRows, RecordingError> {
            let [commanded, measured, error, effort] = OF_JOINT.map(|of| format!("{name}.{of}"));
            Ok(JointRows {
                commanded: float(&commanded)?,
                measured: float(&measured)?,
                error: float(&error)?,
                effort: float(&effort)?,
                limiter: text(&format!("{name}.limiter"))?,
                swings: flags(&format!("{name}.{SWINGS}"))?,
            })
        };
        let servo = |name: &String| -> Result<ServoRows, RecordingError> {
            let [current, temperature, voltage] = OF_SERVO.map(|of| format!("{name}.{of}"));
            Ok(ServoRows {
                current: float(&current)?,
                temperature: float(&temperature)?,
                voltage: float(&voltage)?,
            })
        };
        let time_s = self.column::<DoubleType>(group, "time_s")?;
        let runs = self.column::<BoolType>(group, "runs")?;
        Ok(Part {
            time_s: time_s.into_iter().map(|time_s| time_s.unwrap_or(f64::NAN)).collect(),
            states: text("state")?,
            runs: runs.into_iter().map(|runs| runs == Some(true)).collect(),
            faults: text("faults")?,
            joints: self.joints.iter().map(joint).collect::<Result<_, _>>()?,
            servos: self.servos.iter().map(servo).collect::<Result<_, _>>()?,
        })
    }

    /// Returns the number of rows in a part.
    fn count(&self, group: usize) -> usize {
        usize::try_from(self.metadata.row_group(group).num_rows()).unwrap_or_default()
    }

    fn column<T: DataType>(
        &self,
        group: usize,
        name: &str,
    ) -> Result<Vec<Option<T::T>>, RecordingError> {
        let missing = || RecordingError::Column(name.to_owned());
        let place = self.columns().position(|column| column == name).ok_or_else(missing)?;
        let damaged = |source| RecordingError::Damaged { part: group + 1, source };
        let rows = self.metadata.row_group(group);
        let count = self.count(group);
        let chunk = rows.column(place);
        if chunk.column_type() != T::get_physical_type() {
            return Err(missing());
        }
        let pages = SerializedPageReader::new(Arc::clone(&self.file), chunk, count, None);
        let reader = get_column_reader(chunk.column_descr_ptr(), Box::new(pages.map_err(damaged)?));
        let mut reader: ColumnReaderImpl<T> = get_typed_column_reader(reader);
        let (mut levels, mut values) = (Vec::new(), Vec::new());
        let read = reader.read_records(count, Some(&mut levels), None, &mut values);
        let (records, ..) = read.map_err(damaged)?;
        if records != count {
            let short = format!("{name:?} has {records} of {count} rows");
            return Err(damaged(ParquetError::EOF(short)));
        }
        // A column that cannot be null has no levels, and is not written by this program.
        if levels.len() != count {
            return Err(missing());
        }
        let mut values = values.into_iter();
        // Definition level 0 is null.
        Ok(levels.iter().map(|level| (*level > 0).then(|| values.next()).flatten()).collect())
    }
}

/// An end (footer) of a Parquet file: the metadata, and the footer's range of bytes in the file.
type End = (ParquetMetaData, [u64; 2]);

/// Finds the last complete end of a file. There are also ends between the parts: see [`super::Recorder`].
fn last_end(file: &mut File) -> Result<End, RecordingError> {
    let len = file.seek(SeekFrom::End(0))?;
    if len < TAIL_LEN {
        return Err(RecordingError::Nothing);
    }
    let mut end = len;
    // The first magic is the beginning of the file.
    while end > MAGIC.len() as u64 {
        let begin = end.saturating_sub(BLOCK).max(MAGIC.len() as u64);
        // A magic may cross the border of two blocks.
        let bytes = read(file, begin, (end + MAGIC.len() as u64 - 1).min(len))?;
        for at in (0..bytes.len().saturating_sub(MAGIC.len() - 1)).rev() {
            if bytes[at..].starts_with(MAGIC)
                && let Some(found) = end_before(file, begin + at as u64)?
            {
                return Ok(found);
            }
        }
        end = begin;
    }
    Err(RecordingError::Nothing)
}

/// Reads the end whose magic is at this position; `None` if there is no end.
fn end_before(file: &mut File, magic: u64) -> Result<Option<End>, RecordingError> {
    let Some(of_len) = magic.checked_sub(4) else { return Ok(None) };
    let len: [u8; 4] = read(file, of_len, magic)?.try_into().unwrap_or_default();
    let Some(begin) = of_len.checked_sub(u32::from_le_bytes(len).into()) else { return Ok(None) };
    if begin < MAGIC.len() as u64 {
        return Ok(None);
    }
    let metadata = ParquetMetaDataReader::decode_metadata(&read(file, begin, of_len)?).ok();
    // Data may look like an end by chance; then it has no parts.
    let metadata = metadata.filter(|metadata| metadata.num_row_groups() > 0);
    Ok(metadata.map(|metadata| (metadata, [begin, magic + MAGIC.len() as u64])))
}

fn read(file: &mut File, begin: u64, end: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = vec![0; usize::try_from(end - begin).unwrap_or_default()];
    file.seek(SeekFrom::Start(begin))?;
    file.read_exact(&mut bytes)?;
    Ok(bytes)
}
