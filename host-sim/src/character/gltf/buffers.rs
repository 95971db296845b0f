//! The bytes that a file's numbers are in.

use std::path::{Component, Path};

use ::gltf::Document;
use ::gltf::buffer::Source;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use crate::character::error::{Refusal, refuse};

/// The bytes of every buffer: at least as many as the file says.
pub(super) struct Buffers(Vec<Vec<u8>>);

impl Buffers {
    /// Takes the binary chunk, decodes `data:` URIs and reads files in `folder`.
    ///
    /// # Errors
    /// [`Refusal`] for a buffer that is elsewhere, cannot be read, or is too short.
    pub(super) fn read(
        document: &Document,
        mut chunk: Option<Vec<u8>>,
        folder: &Path,
    ) -> Result<Self, Refusal> {
        let buffer = |buffer: ::gltf::Buffer<'_>| {
            let bytes = match buffer.source() {
                Source::Bin => chunk.take().ok_or_else(|| refuse("data", "a binary chunk", "none")),
                Source::Uri(uri) => from_uri(uri, folder),
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
    // No file reads another one's folders.
    if uri.contains("://")
        || !path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
    {
        let expected = "a file in the folder of this one or below it";
        return Err(refuse("URI", expected, format!("`{uri}`")));
    }
    let path = folder.join(path);
    std::fs::read(&path).map_err(|error| {
        refuse("URI", "a file that can be read", format!("{}: {error}", path.display()))
    })
}

/// A URI without its percent signs.
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
