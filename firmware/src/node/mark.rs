//! The version of the link that an image speaks, as bytes that a host finds in the image before it flashes it.

use sinew_link::message::Version;

const NAME: [u8; 11] = *b"sinew-link:";

/// The mark in each image that has a node: name, major and minor version.
#[used]
static MARK: ([u8; 11], [u8; 2]) = (NAME, [Version::CURRENT.major, Version::CURRENT.minor]);

/// Returns the version of the link that an image speaks; `None` if it has no node.
pub fn link_version(image: &[u8]) -> Option<Version> {
    let at = image.windows(NAME.len()).position(|bytes| bytes == NAME)?;
    match image.get(at.checked_add(NAME.len())?..)? {
        [major, minor, ..] => Some(Version { major: *major, minor: *minor }),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mark_is_found_and_nothing_else() {
        let image = [b"\x7fELF sinew-lin ".as_slice(), &MARK.0, &MARK.1, b"more"].concat();
        assert_eq!(link_version(&image), Some(Version::CURRENT));
        // The image is cut off within the version.
        assert_eq!(link_version(image.get(..27).unwrap_or_default()), None);
        assert_eq!(link_version(b""), None);
    }
}
