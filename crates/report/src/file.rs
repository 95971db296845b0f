//! Writes pictures to files.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::{fs, io};

use maud::Markup;
use sinew_host_util::output::Pending;

use super::{palette, png};

/// Checks that a picture can be written with this name, before it is made.
///
/// # Errors
/// [`io::ErrorKind::InvalidInput`] if the name is not `*.svg` or `*.png`, [`io::ErrorKind::NotFound`] if its
/// folder does not exist.
pub(super) fn check(path: &Path) -> io::Result<()> {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    if extension != "svg" && extension != "png" {
        let expected = "expected a picture named *.svg or *.png";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, expected));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if folder.is_some_and(|folder| !folder.is_dir()) {
        return Err(io::Error::new(io::ErrorKind::NotFound, "expected an existing folder"));
    }
    Ok(())
}

/// Writes a picture as SVG or PNG, selected by the file's extension.
///
/// # Errors
/// The error of the operating system, and those of [`check`].
pub(super) fn write(path: &Path, picture: &Markup) -> io::Result<()> {
    check(path)?;
    let svg = alone(&picture.0);
    let is_png = path.extension().unwrap_or_default().eq_ignore_ascii_case("png");
    let bytes = if is_png { png::png(&svg) } else { svg.into_bytes() };
    let mut file = Pending::begin(path)?;
    file.write_all(&bytes)?;
    file.finish()
}

/// Writes pictures as SVG and PNG to a folder. Returns their paths.
///
/// # Errors
/// The error of the operating system.
pub fn write_all(pictures: &[(String, Markup)], folder: &Path) -> io::Result<Vec<PathBuf>> {
    fs::create_dir_all(folder)?;
    let mut written = Vec::new();
    for (name, picture) in pictures {
        let svg = alone(&picture.0);
        for (extension, bytes) in [("png", png::png(&svg)), ("svg", svg.into_bytes())] {
            let path = folder.join(format!("{name}.{extension}"));
            fs::write(&path, bytes)?;
            written.push(path);
        }
    }
    Ok(written)
}

/// Returns a picture as a file of its own: with its colours, and with a background for charts. A stage has its own
/// background.
pub(super) fn alone(svg: &str) -> String {
    let (head, content) = svg.split_at(svg.find('>').expect("a picture is an element") + 1);
    let style = palette::picture();
    let ground = if svg.contains("class=\"stage\"") {
        ""
    } else {
        "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>"
    };
    let svg = format!("{head}<style>{style}</style>{ground}{content}\n");
    // Names from files may contain characters that XML cannot represent, even escaped.
    let no_xml = |c: char| {
        c.is_control() && !matches!(c, '\t' | '\n' | '\r') || matches!(c, '\u{fffe}' | '\u{ffff}')
    };
    if svg.contains(no_xml) { svg.replace(no_xml, "\u{fffd}") } else { svg }
}
