//! Sounds of the shows, which pages play.

use std::sync::{Arc, Mutex, PoisonError};

/// The sound of a show.
#[derive(Debug, Clone)]
pub struct OwnSound {
    /// SHA-256 of the file, as text: also its address for pages.
    pub hash: String,
    /// Name of the file.
    pub name: String,
    /// Place in the sound at the start of the show, s.
    pub offset_s: f64,
    /// Bytes of the WAV file.
    pub bytes: Arc<[u8]>,
}

/// Sounds that the server has, by their hash. Only a page that knows the token knows a hash.
#[derive(Debug, Default)]
pub(crate) struct Sounds(Mutex<Vec<(String, Arc<[u8]>)>>);

impl Sounds {
    pub(crate) fn add(&self, sound: &OwnSound) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if all.iter().all(|(hash, _)| *hash != sound.hash) {
            all.push((sound.hash.clone(), Arc::clone(&sound.bytes)));
        }
    }

    /// Returns the sound at a path such as `/sound/9f86..`.
    pub(crate) fn at(&self, path: &str) -> Option<Arc<[u8]>> {
        let wanted = path.strip_prefix("/sound/")?;
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.iter().find(|(hash, _)| hash == wanted).map(|(_, bytes)| Arc::clone(bytes))
    }
}
