//! Sounds of shows, which pages play.

use std::sync::{Arc, Mutex, PoisonError};

/// Sound of a show.
#[derive(Debug, Clone)]
pub struct OwnSound {
    /// SHA-256 of the file as hexadecimal text. Pages request the sound by it.
    pub hash: String,
    /// Name of the file.
    pub name: String,
    /// Time of the sound at the start of the show, s.
    pub offset_s: f64,
    /// Bytes of the WAV file.
    pub bytes: Arc<[u8]>,
}

/// Sounds that pages can request by their hash. Only pages with the token receive the hashes.
#[derive(Debug, Default)]
pub(crate) struct Sounds(Mutex<Vec<(String, Arc<[u8]>)>>);

impl Sounds {
    pub(crate) fn add(&self, sound: &OwnSound) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if all.iter().all(|(hash, _)| *hash != sound.hash) {
            all.push((sound.hash.clone(), Arc::clone(&sound.bytes)));
        }
    }

    /// Returns the sound at a path such as `/sound/9f86..`, if the hash is known.
    pub(crate) fn at(&self, path: &str) -> Option<Arc<[u8]>> {
        let wanted = path.strip_prefix("/sound/")?;
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.iter().find(|(hash, _)| hash == wanted).map(|(_, bytes)| Arc::clone(bytes))
    }
}
