//! Objects for tests, made instruction by instruction.

use object::write::{Object, StandardSection, Symbol, SymbolSection};
use object::{Architecture, BinaryFormat, Endianness, SymbolFlags, SymbolKind, SymbolScope};

/// Makes an object. `symbols` contains start addresses and names of functions and data, `halves` the content from
/// address 0.
pub(crate) fn object(symbols: &[(u64, &str)], halves: &[u16]) -> Vec<u8> {
    object_for(Architecture::Arm, symbols, halves)
}

pub(crate) fn object_for(
    architecture: Architecture,
    symbols: &[(u64, &str)],
    halves: &[u16],
) -> Vec<u8> {
    let mut object = Object::new(BinaryFormat::Elf, architecture, Endianness::Little);
    let text = object.section_id(StandardSection::Text);
    let bytes: Vec<u8> = halves.iter().flat_map(|half| half.to_le_bytes()).collect();
    object.append_section_data(text, &bytes, 4);
    for (address, name) in symbols {
        let is_mapping = name.starts_with('$');
        object.add_symbol(Symbol {
            name: name.as_bytes().to_vec(),
            value: address | u64::from(!is_mapping),
            size: 0,
            kind: if is_mapping { SymbolKind::Label } else { SymbolKind::Text },
            scope: SymbolScope::Compilation,
            weak: false,
            section: SymbolSection::Section(text),
            flags: SymbolFlags::None,
        });
    }
    object.write().unwrap()
}

/// Encodes `bl`, or with `links = false` `b.w`, from one address to another.
pub(crate) fn branch(from: i32, to: i32, links: bool) -> [u16; 2] {
    let offset = (to - from - 4) / 2;
    let bits = |count: u32, shift: u32| {
        u16::try_from((offset >> shift) & ((1 << count) - 1)).expect("at most 11 bits")
    };
    let sign = u16::from(offset < 0);
    let (j1, j2) = (1 ^ bits(1, 22) ^ sign, 1 ^ bits(1, 21) ^ sign);
    let second = if links { 0xd000 } else { 0x9000 };
    [0xf000 | sign << 10 | bits(10, 11), second | j1 << 13 | j2 << 11 | bits(11, 0)]
}

pub(crate) const PUSH_LR: u16 = 0xb500;
pub(crate) const POP_PC: u16 = 0xbd00;
pub(crate) const BX_LR: u16 = 0x4770;
pub(crate) const BLX_R3: u16 = 0x4798;
pub(crate) const BX_R3: u16 = 0x4718;
pub(crate) const NOP: u16 = 0xbf00;
