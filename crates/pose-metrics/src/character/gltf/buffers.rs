//! Reads the buffers of a file.

use std::collections::BTreeMap;
use std::path::{Component, Path};
use std::rc::Rc;

use ::gltf::Document;
use ::gltf::buffer::Source;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use crate::character::error::{Refusal, refuse};

/// Maximum number of bytes, far above any character's, to limit the memory.
const BYTES_MAX: usize = 1 << 30;

/// The bytes of every buffer: at least the number that the file declares.
pub(super) struct Buffers(Vec<Rc<[u8]>>);

impl Buffers {
    /// Collects the bytes of all buffers: from the binary chunk, from `data:` URIs, and from files in `folder`.
    ///
    /// # Errors
    /// [`Refusal`] for a buffer outside the folder, for a buffer that cannot be read or is too short, and if all
    /// buffers together are too large.
    pub(super) fn read<'a>(
        document: &'a Document,
        mut chunk: Option<Vec<u8>>,
        folder: &Path,
    ) -> Result<Self, Refusal> {
        // A file is read only once, even if several buffers name it.
        let mut by_uri: BTreeMap<&str, Rc<[u8]>> = BTreeMap::new();
        let mut total = 0;
        let buffer = |buffer: ::gltf::Buffer<'a>| {
            let bytes = match buffer.source() {
                Source::Bin => {
                    let chunk =
                        chunk.take().ok_or_else(|| refuse("data", "a binary chunk", "none"));
                    chunk.map(Rc::from)
                }
                Source::Uri(uri) => match by_uri.get(uri) {
                    Some(bytes) => Ok(Rc::clone(bytes)),
                    None => from_uri(uri, folder).and_then(|bytes| {
                        total += bytes.len();
                        if total > BYTES_MAX {
                            let expected = format!("at most {BYTES_MAX} bytes in all buffers");
                            return Err(refuse("data", expected, total));
                        }
                        let bytes: Rc<[u8]> = bytes.into();
                        by_uri.insert(uri, Rc::clone(&bytes));
                        Ok(bytes)
                    }),
                },
            };
            let bytes = bytes.and_then(|bytes| {
                if bytes.len() >= buffer.length() {
                    return Ok(bytes);
                }
                Err(refuse("data", format!("{} bytes", buffer.length()), bytes.len()))
            });
            bytes.map_err(|refusal| refusal.of(format!("buffer {}", buffer.index())))
        };
        document.buffers().map(buffer).collect::<Result<_, _>>().map(Self)
    }

    pub(super) fn get(&self, buffer: usize) -> &[u8] {
        &self.0[buffer]
    }
}

fn from_uri(uri: &str, folder: &Path) -> Result<Vec<u8>, Refusal> {
    if let Some(data) = uri.strip_prefix("data:") {
        let encoded = data.split_once(";base64,").map(|(_, encoded)| encoded);
        let encoded = encoded.ok_or_else(|| refuse("data URI", "data in base64", "other data"))?;
        return STANDARD.decode(encoded).map_err(|error| refuse("data URI", "base64", error));
    }
    let name = decoded(uri);
    let path = Path::new(&name);
    // A file may not refer to other folders.
    if uri.contains("://")
        || !path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
    {
        let expected = "a file in the folder of this one or below it";
        return Err(refuse("URI", expected, format!("`{uri}`")));
    }
    let path = folder.join(path);
    let unread =
        |error| refuse("URI", "a file that can be read", format!("{}: {error}", path.display()));
    // Symbolic links may lead out of the folder too.
    let root = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let (root, place) =
        (root.canonicalize().map_err(unread)?, path.canonicalize().map_err(unread)?);
    if !place.starts_with(root) {
        let expected = "a file in the folder of this one or below it";
        return Err(refuse("URI", expected, format!("`{uri}`, a link to elsewhere")));
    }
    sinew_mocap::read::bytes(&place).map_err(unread)
}

/// Decodes the percent escapes of a URI.
fn decoded(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((first, others)) = rest.split_first() {
        let digits = others.get(..2).filter(|_| *first == b'%');
        let byte = digits.and_then(|digits| core::str::from_utf8(digits).ok());
        let byte = byte.and_then(|digits| u8::from_str_radix(digits, 16).ok());
        bytes.push(byte.unwrap_or(*first));
        rest = if byte.is_some() { &others[2..] } else { others };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
