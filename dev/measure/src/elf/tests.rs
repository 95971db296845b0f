//! Tests with handmade images.

use object::Architecture;

use super::fixture::*;
use super::*;

/// Makes an image: `root` calls `middle`, which ends in `leaf`; `again` recurs through `root`; `open` calls pointers.
fn graph() -> Elf {
    let symbols =
        [(0, "$t"), (0, "root"), (8, "middle"), (12, "leaf"), (14, "again"), (18, "open")];
    let ([a, b], [c, d], [e, f]) =
        (branch(2, 8, true), branch(8, 12, false), branch(14, 14 + 8, true));
    let halves = [PUSH_LR, a, b, POP_PC, c, d, BX_LR, e, f, BLX_R3, BX_R3, NOP, NOP];
    Elf::parse(&object(&symbols, &halves)).unwrap()
}

#[test]
fn calls_tail_calls_and_pointers_are_told_apart() {
    let elf = graph();
    let call = |at, to, is_tail| Call { at, to, is_tail };
    let calls = |name| elf.functions()[elf.named(name).unwrap()].calls.clone();
    assert_eq!(calls("root"), [call(2, Target::Function(1), false)]);
    assert_eq!(calls("middle"), [call(8, Target::Function(2), true)]);
    assert_eq!(calls("leaf"), [], "a return is no call");
    assert_eq!(
        calls("open"),
        [call(18, Target::Indirect, false), call(20, Target::Indirect, true)]
    );
    assert_eq!(calls("again"), [call(14, Target::Function(4), false)], "into the middle of it");
}

#[test]
fn ways_through_the_graph() {
    let elf = graph();
    assert_eq!(elf.path_from(0, 2), Some(vec![0, 1, 2]));
    assert_eq!(elf.path_from(2, 0), None);
    assert_eq!(elf.path_from(2, 2), Some(vec![2]));
    assert_eq!(elf.callers_of(2), [1]);
    assert_eq!(elf.reachable_from(&[1]), BTreeSet::from([1, 2]));
    assert_eq!(elf.cycle_through(0), None);
    let [a, b] = branch(0, 4, true);
    let [c, d] = branch(4, 0, false);
    let circle = Elf::parse(&object(&[(0, "a"), (4, "b")], &[a, b, c, d])).unwrap();
    assert_eq!(circle.cycle_through(1), Some(vec![1, 0, 1]));
}

#[test]
fn a_branch_within_a_function_is_no_call() {
    let [a, b] = branch(0, 6, false);
    let elf = Elf::parse(&object(&[(0, "jump"), (8, "next")], &[a, b, NOP, BX_LR, NOP])).unwrap();
    assert_eq!(elf.functions()[0].calls, []);
    let [a, b] = branch(0, 400, true);
    let elf = Elf::parse(&object(&[(0, "lost")], &[a, b])).unwrap();
    assert_eq!(elf.functions()[0].calls[0].to, Target::Nowhere(400));
}

#[test]
fn data_amid_code_is_not_read_as_instructions() {
    let vfma = [0xeea0, 0x0a81];
    let symbols =
        [(0, "$t.1"), (0, "f"), (4, "$d.2"), (8, "$t.3"), (10, "$d"), (12, "$t"), (12, "g")];
    let halves = [NOP, NOP, vfma[0], vfma[1], BX_LR, 0xffff, BX_LR];
    let elf = Elf::parse(&object(&symbols, &halves)).unwrap();
    let addresses = |index: usize| -> Vec<u64> {
        elf.functions()[index].instructions.iter().map(|found| found.address).collect()
    };
    assert_eq!((addresses(0), addresses(1)), (vec![0, 2, 8], vec![12]));
    assert_eq!(elf.functions()[0].size, 12, "to the next function, data included");
}

#[test]
fn instructions_of_the_fpu_and_conditions_are_named() {
    // it eq; vmlaeq.f32 s0, s1, s2; vfma.f32; vfnms.f32; vadd.f64 d0, d1, d2; vsqrt.f32; bne.n .
    let halves = [
        0xbf08, 0xee00, 0x0a81, 0xeea0, 0x0a81, 0xee90, 0x0a81, 0xee31, 0x0b02, 0xeeb1, 0x0ae0,
        0xd1fe,
    ];
    let elf = Elf::parse(&object(&[(0, "f")], &halves)).unwrap();
    let instructions = &elf.functions()[0].instructions;
    let read: Vec<_> =
        instructions.iter().map(|i| (i.operation.as_str(), i.mnemonic.as_str())).collect();
    assert_eq!(
        read,
        [
            ("it", "it"),
            ("vmla", "vmlaeq.f32"),
            ("vfma", "vfma.f32"),
            ("vfnms", "vfnms.f32"),
            ("vadd", "vadd.f64"),
            ("vsqrt", "vsqrt.f32"),
            ("b", "bne"),
        ]
    );
    assert_eq!(instructions[4].operands, "d0, d1, d2");
    assert_eq!(instructions[4].bytes, [0x31, 0xee, 0x02, 0x0b]);
}

#[test]
fn names_are_demangled_and_aliases_kept() {
    let symbols = [(0, "_ZN4core9panicking9panic_fmt17h0123456789abcdefE"), (0, "memcpy")];
    let elf = Elf::parse(&object(&symbols, &[BX_LR])).unwrap();
    let found = &elf.functions()[0];
    assert_eq!(found.names().collect::<Vec<_>>(), ["core::panicking::panic_fmt", "memcpy"]);
    assert_eq!(found.symbol, symbols[0].1);
    assert_eq!((elf.named("memcpy"), elf.named(symbols[0].1)), (Some(0), Some(0)));
}

#[test]
fn what_cannot_be_read_is_refused() {
    let problem = |file: &[u8]| format!("{:#}", Elf::parse(file).unwrap_err());
    assert_eq!(
        problem(&object(&[(0, "broken")], &[NOP, 0xffff, 0xffff])),
        "broken at 0x0: what lies at 0x2 is no instruction"
    );
    assert_eq!(
        problem(&object(&[(0, "$a"), (0, "f")], &[NOP])),
        "there are instructions that are not Thumb at 0x0"
    );
    assert_eq!(problem(&object(&[], &[NOP])), "it has no symbols of functions");
    assert_eq!(problem(&object_for(Architecture::X86_64, &[], &[])), "it is for X86_64");
    assert!(Elf::parse(b"no image").is_err());
}

#[test]
fn the_last_part_of_a_name_is_the_function_in_both_manglings() {
    for (name, last) in [
        ("main", "main"),
        ("sinew_core::math::sqrt", "sqrt"),
        ("sinew_core::tree::Tree<_>::push", "push"),
        ("<sinew_core::tree::Tree<18>>::push", "push"),
        ("<f32 as core::ops::Shl<u8>>::shl", "shl"),
        ("run::perform::<18, tick::parity::{closure#0}, tick::parity::{closure#1}>", "perform"),
        ("outer::<fn(u8) -> a::B<18>>", "outer"),
        ("tick::parity::{{closure}}", "{{closure}}"),
    ] {
        assert_eq!(last_part(name), last, "{name}");
    }
}
