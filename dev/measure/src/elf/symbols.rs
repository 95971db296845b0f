//! Finds the addresses of functions, and which of their bytes are instructions.

use std::collections::BTreeMap;

use anyhow::{Result, bail, ensure};
use object::{File, Object, ObjectSection, ObjectSymbol, SectionIndex, SectionKind, SymbolKind};

/// A function's symbol and bytes.
pub(super) struct Found {
    pub(super) name: String,
    pub(super) aliases: Vec<String>,
    pub(super) symbol: String,
    pub(super) address: u64,
    pub(super) size: u64,
    /// Its instructions without the data between them: address and bytes of each piece.
    pub(super) code: Vec<(u64, Vec<u8>)>,
}

/// Symbols of a function: there may be several for one address.
#[derive(Default)]
struct Symbols {
    size: u64,
    symbols: Vec<String>,
}

/// Returns all functions, in the order of their addresses.
pub(super) fn functions(file: &File<'_>) -> Result<Vec<Found>> {
    let mut all = Vec::new();
    for section in file.sections().filter(|section| section.kind() == SectionKind::Text) {
        let named = named(file, section.index())?;
        let mapping = mapping(file, section.index())?;
        let end_of_section = section.address() + section.size();
        let starts: Vec<u64> = named.keys().copied().collect();
        for (index, (address, Symbols { size, symbols })) in named.into_iter().enumerate() {
            // A symbol of assembly code may have no size: then the function ends at the next symbol.
            let next = starts.get(index + 1).copied().unwrap_or(end_of_section);
            let size = if size == 0 { next - address } else { size };
            let mut code = Vec::new();
            for (start, end) in code_of(address, address + size, &mapping) {
                let Some(bytes) = section.data_range(start, end - start)? else {
                    bail!("{} at {address:#x} reaches out of its section", symbols[0]);
                };
                code.push((start, bytes.to_vec()));
            }
            let mut names: Vec<String> = Vec::new();
            for symbol in &symbols {
                let name = super::name::demangled(symbol);
                if !names.contains(&name) {
                    names.push(name);
                }
            }
            let symbol = symbols.into_iter().next().unwrap_or_default();
            let name = names.remove(0);
            all.push(Found { name, aliases: names, symbol, address, size, code });
        }
    }
    all.sort_by_key(|found| found.address);
    Ok(all)
}

/// Returns the symbols of a section's functions, by address without the Thumb bit.
fn named(file: &File<'_>, section: SectionIndex) -> Result<BTreeMap<u64, Symbols>> {
    let mut named = BTreeMap::<u64, Symbols>::new();
    for symbol in file.symbols() {
        if symbol.section_index() == Some(section) && symbol.kind() == SymbolKind::Text {
            let name = symbol.name()?;
            if is_mapping(name) {
                continue;
            }
            let at = named.entry(symbol.address() & !1).or_default();
            at.size = at.size.max(symbol.size());
            at.symbols.push(name.to_owned());
        }
    }
    for Symbols { symbols, .. } in named.values_mut() {
        symbols.sort();
    }
    Ok(named)
}

/// Returns whether a symbol marks the kind of content at its address (ELF for the Arm Architecture, mapping symbols).
fn is_mapping(name: &str) -> bool {
    ["$a", "$t", "$d"].iter().any(|kind| {
        name.strip_prefix(kind).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    })
}

/// Returns the addresses from which a section has instructions (true) or data.
fn mapping(file: &File<'_>, section: SectionIndex) -> Result<BTreeMap<u64, bool>> {
    let mut mapping = BTreeMap::new();
    for symbol in file.symbols() {
        let name = symbol.name()?;
        if symbol.section_index() == Some(section) && is_mapping(name) {
            ensure!(
                !name.starts_with("$a"),
                "there are instructions that are not Thumb at {:#x}",
                symbol.address()
            );
            mapping.insert(symbol.address(), name.starts_with("$t"));
        }
    }
    Ok(mapping)
}

/// Returns the start and end of the pieces of a function that are instructions.
fn code_of(start: u64, end: u64, mapping: &BTreeMap<u64, bool>) -> Vec<(u64, u64)> {
    let at_start = mapping.range(..=start).next_back().is_none_or(|(_, is_code)| *is_code);
    let mut pieces = Vec::new();
    let (mut from, mut is_code) = (start, at_start);
    for (address, is_code_now) in mapping.range(start..end) {
        if is_code && from < *address {
            pieces.push((from, *address));
        }
        (from, is_code) = (*address, *is_code_now);
    }
    if is_code && from < end {
        pieces.push((from, end));
    }
    // Joins adjacent pieces: a mark among instructions has no meaning.
    pieces.dedup_by(|next, piece| {
        let joins = piece.1 == next.0;
        if joins {
            piece.1 = next.1;
        }
        joins
    });
    pieces
}
