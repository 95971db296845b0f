//! Blend shapes of `ARKit` in the CSV of Live Link Face.
//!
//! The header is `Timecode,BlendShapeCount`, and then the 52 names. Most files also have nine rotations of head and
//! eyes; they are ignored. A time code has one of three forms: `HH:MM:SS:FF.fff` with a fraction of a frame,
//! `HH:MM:SS:FF`, or `HH:MM:SS.mmm`.

use super::error::FaceError;
use super::track::{FaceTrack, Weights};

/// Columns that are rotations, in lower case.
const ROTATIONS: [&str; 9] = [
    "headyaw",
    "headpitch",
    "headroll",
    "lefteyeyaw",
    "lefteyepitch",
    "lefteyeroll",
    "righteyeyaw",
    "righteyepitch",
    "righteyeroll",
];
/// Usual rates of cameras, frames per second. The lowest rate above the largest frame number of a file is used.
const RATES: [f64; 5] = [24.0, 25.0, 30.0, 50.0, 60.0];
const DAY_S: f64 = 86_400.0;
const FORMS: &str = "HH:MM:SS:FF.fff, HH:MM:SS:FF or HH:MM:SS.mmm";

/// Parts of a time code.
#[derive(Debug, Clone, Copy)]
struct Code {
    /// Whole seconds; in the third form, seconds with their fraction.
    seconds: f64,
    /// Frames and the fraction of a frame; `None` in the third form.
    frames: Option<f64>,
}

/// Reads the table.
pub(super) fn read(text: &str, fps: Option<f64>) -> Result<FaceTrack, FaceError> {
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(text.as_bytes());
    let header: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
    let value = |line: u64, item: &str, expected: String, found: &str| FaceError::Value {
        place: format!("line {line}"),
        item: item.to_owned(),
        expected,
        found: found.chars().take(40).collect(),
    };
    let is_count = |name: &str| name.eq_ignore_ascii_case("BlendShapeCount");
    if !header[0].eq_ignore_ascii_case("Timecode") || !header.get(1).is_some_and(|n| is_count(n)) {
        let expected = "`Timecode,BlendShapeCount,EyeBlinkLeft, ..`".to_owned();
        return Err(value(1, "the header", expected, &header.join(",")));
    }
    let names = &header[2..];
    if let Some((at, name)) =
        names.iter().enumerate().find(|(at, name)| names[..*at].contains(name))
    {
        return Err(value(1, &format!("column {}", at + 3), "each shape once".to_owned(), name));
    }
    let is_shape = |name: &String| !ROTATIONS.contains(&name.to_lowercase().as_str());
    let shapes: Vec<usize> = (0..names.len()).filter(|index| is_shape(&names[*index])).collect();
    let (mut codes, mut rows) = (Vec::new(), Vec::new());
    for record in reader.records() {
        let record = record?;
        let line = record.position().map_or(0, csv::Position::line);
        if record.iter().all(str::is_empty) {
            continue;
        }
        let field = |index: usize| record.get(index).unwrap_or_default();
        let code = parse(field(0))
            .ok_or_else(|| value(line, "column `Timecode`", FORMS.to_owned(), field(0)))?;
        let count: Option<usize> = field(1).parse().ok();
        if count != Some(names.len()) || record.len() != header.len() {
            let expected = format!(
                "{}, the number of columns after it in the header, and as many values",
                names.len()
            );
            let found = format!("{} with {} value(s)", field(1), record.len().saturating_sub(2));
            return Err(value(line, "column `BlendShapeCount`", expected, &found));
        }
        let mut row = Vec::with_capacity(shapes.len());
        for index in &shapes {
            let weight: Option<f64> = field(index + 2).parse().ok();
            let weight =
                weight.filter(|weight| (-0.5..=2.0).contains(weight)).ok_or_else(|| {
                    let item = format!("column `{}`", names[*index]);
                    value(line, &item, "a weight from 0 to 1".to_owned(), field(index + 2))
                })?;
            row.push(weight.clamp(0.0, 1.0));
        }
        codes.push((line, code));
        rows.push(row);
    }
    let times_s = times(&codes, fps)?;
    let names = shapes.iter().map(|index| names[*index].clone()).collect();
    Weights { names, times_s, rows }.checked().map(FaceTrack::Weights)
}

/// Parses a time code; returns `None` if it is invalid.
fn parse(text: &str) -> Option<Code> {
    let parts: Vec<&str> = text.split(':').collect();
    let whole = |text: &str, most: u32| -> Option<f64> {
        let is_number =
            !text.is_empty() && text.len() <= 2 && text.bytes().all(|b| b.is_ascii_digit());
        text.parse::<u32>().ok().filter(|number| is_number && *number <= most).map(f64::from)
    };
    let decimal = |text: &str, most: f64| -> Option<f64> {
        let is_number = text.bytes().all(|b| b.is_ascii_digit() || b == b'.');
        text.parse::<f64>().ok().filter(|number| is_number && *number < most)
    };
    match &parts[..] {
        [hours, minutes, seconds, frames] => Some(Code {
            seconds: 3600.0 * whole(hours, 23)? + 60.0 * whole(minutes, 59)? + whole(seconds, 59)?,
            frames: Some(decimal(frames, 240.0)?),
        }),
        [hours, minutes, seconds] => Some(Code {
            seconds: 3600.0 * whole(hours, 23)?
                + 60.0 * whole(minutes, 59)?
                + decimal(seconds, 60.0)?,
            frames: None,
        }),
        _ => None,
    }
}

/// Returns the times of all rows from the first row, s. Rows with equal time codes are spread evenly until the next
/// time code. At midnight the time continues.
fn times(codes: &[(u64, Code)], fps: Option<f64>) -> Result<Vec<f64>, FaceError> {
    let frames = codes.iter().filter_map(|(_, code)| code.frames);
    let most = frames.fold(0.0, |most: f64, frames| most.max(frames.floor()));
    let fps = match fps {
        Some(fps) => fps,
        // A file of at least one second contains all frame numbers.
        None => RATES.into_iter().find(|rate| most < *rate).unwrap_or(most + 1.0),
    };
    let mut times: Vec<f64> = Vec::new();
    let mut day_s = 0.0;
    for (index, (line, code)) in codes.iter().enumerate() {
        let wrong = |expected: String, found: String| FaceError::Value {
            place: format!("line {line}"),
            item: "column `Timecode`".to_owned(),
            expected,
            found,
        };
        if let Some(frames) = code.frames.filter(|frames| *frames >= fps) {
            let expected = format!("a frame below {fps} (`--fps`)");
            return Err(wrong(expected, frames.to_string()));
        }
        if code.frames.is_some() != codes[0].1.frames.is_some() {
            return Err(wrong("the form of the first line".to_owned(), "another form".to_owned()));
        }
        let mut time_s = day_s + code.seconds + code.frames.unwrap_or(0.0) / fps;
        if let Some(before) = times.last() {
            if time_s < before - 0.5 * DAY_S {
                day_s += DAY_S;
                time_s += DAY_S;
            }
            if time_s < before - 1e-9 {
                return Err(wrong(
                    "a time that is not before the line above".to_owned(),
                    format!("{:.3} s earlier", before - time_s),
                ));
            }
        }
        debug_assert!(index == times.len());
        times.push(time_s);
    }
    let Some(start_s) = times.first().copied() else { return Ok(times) };
    for time_s in &mut times {
        *time_s -= start_s;
    }
    let mut from = 0;
    while from < times.len() {
        let next = (from..times.len()).find(|row| times[*row] > times[from] + 1e-9);
        let to = next.unwrap_or(times.len());
        let step_s =
            next.map_or(fps.recip(), |next| times[next] - times[from]) / (to - from) as f64;
        for row in from + 1..to {
            times[row] = times[from] + (row - from) as f64 * step_s;
        }
        from = to;
    }
    Ok(times)
}
