//! Reads the content of an image word by word.

use anyhow::Result;
use object::{File, Object, ObjectSection, SectionKind};

/// Name of the section with the addresses of a Cortex-M's handlers.
const VECTOR_TABLE: &str = ".vector_table";

/// Bytes of the sections that are loaded into memory.
pub(super) struct Words {
    sections: Vec<Section>,
}

struct Section {
    address: u64,
    is_vector_table: bool,
    bytes: Vec<u8>,
}

impl Words {
    pub(super) fn of(file: &File<'_>) -> Result<Self> {
        let kinds = [
            SectionKind::Text,
            SectionKind::Data,
            SectionKind::ReadOnlyData,
            SectionKind::ReadOnlyString,
        ];
        let mut sections = Vec::new();
        for section in file.sections().filter(|section| kinds.contains(&section.kind())) {
            sections.push(Section {
                address: section.address(),
                is_vector_table: section.name()? == VECTOR_TABLE,
                bytes: section.data()?.to_vec(),
            });
        }
        Ok(Self { sections })
    }

    /// Returns the word at an address.
    pub(super) fn at(&self, address: u64) -> Option<u32> {
        self.sections.iter().find_map(|section| {
            let from = usize::try_from(address.checked_sub(section.address)?).ok()?;
            section.bytes.get(from..)?.first_chunk().map(|bytes| u32::from_le_bytes(*bytes))
        })
    }

    /// Returns all words of the vector table, or all other words.
    pub(super) fn all(&self, of_table: bool) -> impl Iterator<Item = u32> {
        let sections = self.sections.iter().filter(move |it| it.is_vector_table == of_table);
        sections.flat_map(|section| {
            let (words, _) = section.bytes.as_chunks::<4>();
            words.iter().map(|bytes| u32::from_le_bytes(*bytes))
        })
    }
}
