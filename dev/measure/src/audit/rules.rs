//! Rules for the content of an image of everything that boards may call.

use crate::elf::{Elf, Function, Target, last_part};

/// A reason why something is forbidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Rule {
    /// A panic can be reached.
    Panic,
    /// 64-bit floats: a Cortex-M4F computes them in software, 10 to 50 times slower, and with other bits.
    DoublePrecision,
    /// Fused multiply-add rounds once, multiplication and addition round twice: the bits differ from the host's.
    FusedMultiplyAdd,
    /// Text is formatted.
    Formatting,
    /// Memory is allocated from a heap.
    Allocation,
    /// A function calls itself: the stack has no bound.
    Recursion,
    /// A call by pointer: the called function and its stack are unknown.
    IndirectCall,
    /// A call to an address without a function.
    Nowhere,
}

impl Rule {
    pub(super) const ALL: [Self; 8] = [
        Self::Panic,
        Self::DoublePrecision,
        Self::FusedMultiplyAdd,
        Self::Formatting,
        Self::Allocation,
        Self::Recursion,
        Self::IndirectCall,
        Self::Nowhere,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Panic => "panic",
            Self::DoublePrecision => "f64",
            Self::FusedMultiplyAdd => "fused multiply-add",
            Self::Formatting => "core::fmt",
            Self::Allocation => "allocation",
            Self::Recursion => "recursion",
            Self::IndirectCall => "indirect call",
            Self::Nowhere => "call to no function",
        }
    }
}

/// A violation of a rule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Finding {
    pub(super) rule: Rule,
    /// The symbol, instruction or cycle of calls.
    pub(super) what: String,
    /// Index of the function that contains it.
    pub(super) function: usize,
    /// Address of the instruction.
    pub(super) at: u64,
}

/// Returns all violations, by rule and then by address.
pub(super) fn findings(elf: &Elf) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (index, function) in elf.functions().iter().enumerate() {
        let finding = |rule, what: String, at| Finding { rule, what, function: index, at };
        for call in &function.calls {
            let found = match call.to {
                Target::Function(callee) => {
                    let callee = &elf.functions()[callee];
                    // Within library code that panics or formats, only the first call counts.
                    of_function(callee)
                        .filter(|(rule, _)| {
                            of_function(function).is_none_or(|(own, _)| own != *rule)
                        })
                        .map(|(rule, name)| finding(rule, name.to_owned(), call.at))
                }
                Target::Indirect => {
                    Some(finding(Rule::IndirectCall, "by a register".to_owned(), call.at))
                }
                // The target of a panic, in an image that was linked only for examination: calls that lead there are
                // found anyway.
                Target::Nowhere(_) if of_function(function).is_some() => None,
                Target::Nowhere(address) => {
                    Some(finding(Rule::Nowhere, format!("{address:#x}"), call.at))
                }
            };
            findings.extend(found);
        }
        for instruction in &function.instructions {
            let what = format!("{} {}", instruction.mnemonic, instruction.operands);
            if matches!(instruction.operation.as_str(), "vfma" | "vfms" | "vfnma" | "vfnms") {
                findings.push(finding(Rule::FusedMultiplyAdd, what, instruction.address));
            } else if instruction.mnemonic.contains(".f64") {
                findings.push(finding(Rule::DoublePrecision, what, instruction.address));
            }
        }
        if let Some(circle) = elf.cycle_through(index) {
            let names: Vec<_> =
                circle.iter().map(|at| elf.functions()[*at].name.as_str()).collect();
            findings.push(finding(Rule::Recursion, names.join(" > "), function.address));
        }
        // A function without callers by name is in the image nevertheless: it handles an interrupt, or is called by
        // pointer.
        if let Some((rule, name)) = of_function(function)
            && elf.callers_of(index).is_empty()
        {
            findings.push(finding(rule, name.to_owned(), function.address));
        }
    }
    findings.sort_by_key(|finding| (finding.rule, finding.at));
    findings
}

/// Returns the rule that a function violates by its presence, and the name that shows it.
fn of_function(function: &Function) -> Option<(Rule, &str)> {
    function.names().find_map(|name| Some((of_name(name)?, name)))
}

fn of_name(name: &str) -> Option<Rule> {
    // Only the method of names such as `<T as core::fmt::Debug>::fmt` and `core::option::Option<T>::expect`.
    let last = last_part(name);
    let is_of = |library: &str| name.starts_with(library) || name.contains(&format!("<{library}"));
    let panics = ["panic", "begin_unwind"].iter().any(|part| last.contains(part))
        || (is_of("core::") && ["_fail", "_failed"].iter().any(|end| last.ends_with(end)));
    let allocates = last.starts_with("__rust_alloc")
        || ["__rust_dealloc", "__rust_realloc"].contains(&last)
        || ["malloc", "calloc", "realloc", "free"].contains(&name);
    if name.contains("core::fmt::") {
        Some(Rule::Formatting)
    } else if panics || name.contains("core::panicking::") {
        Some(Rule::Panic)
    } else if allocates || is_of("alloc::") {
        Some(Rule::Allocation)
    } else if is_of_doubles(last) {
        Some(Rule::DoublePrecision)
    } else if ["fma", "fmaf"].contains(&last) {
        Some(Rule::FusedMultiplyAdd)
    } else {
        None
    }
}

/// Returns whether a name is that of a function for f64 in software, by Arm's run-time ABI (chapter 4.1) or by GCC.
fn is_of_doubles(name: &str) -> bool {
    if let Some(of_abi) = name.strip_prefix("__aeabi_") {
        return of_abi.starts_with('d')
            || ["cdcmp", "cdrcmp"].iter().any(|start| of_abi.starts_with(start))
            || ["f2d", "i2d", "ui2d", "l2d", "ul2d", "h2d"].contains(&of_abi);
    }
    name.strip_prefix("__").is_some_and(|gcc| {
        [
            "add", "sub", "mul", "div", "neg", "eq", "ne", "lt", "le", "gt", "ge", "cmp", "unord",
            "pow",
        ]
        .iter()
        .any(|operation| gcc.strip_prefix(operation).is_some_and(|rest| rest.starts_with("df")))
            || ["extend", "trunc", "float", "fix"]
                .iter()
                .any(|start| gcc.strip_prefix(start).is_some_and(|rest| rest.contains("df")))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elf::fixture::{BX_LR, NOP, branch, object};

    #[test]
    fn what_a_function_is_for_is_told_by_its_name() {
        for (rule, names) in [
            (
                Some(Rule::Panic),
                &[
                    "core::panicking::panic_bounds_check",
                    "core::option::unwrap_failed",
                    "core::slice::index::slice_end_index_len_fail",
                    "core::slice::<impl [T]>::copy_from_slice::len_mismatch_fail",
                    "core::cell::panic_already_borrowed",
                    "__rustc::rust_begin_unwind",
                    "core::panicking::assert_failed::<usize, usize>",
                ][..],
            ),
            (
                Some(Rule::DoublePrecision),
                &[
                    "__aeabi_dadd",
                    "__aeabi_dcmplt",
                    "__aeabi_cdrcmple",
                    "__aeabi_f2d",
                    "__aeabi_ul2d",
                    "__aeabi_d2iz",
                    "__adddf3",
                    "__extendsfdf2",
                    "__truncdfsf2",
                    "__fixunsdfsi",
                    "compiler_builtins::float::mul::__muldf3",
                ],
            ),
            (Some(Rule::FusedMultiplyAdd), &["fmaf", "libm::math::fma::fma"]),
            (
                Some(Rule::Formatting),
                &[
                    "core::fmt::write",
                    "<f32 as core::fmt::Display>::fmt",
                    "core::fmt::Formatter::pad",
                ],
            ),
            (
                Some(Rule::Allocation),
                &["malloc", "free", "__rustc::__rust_alloc_zeroed", "alloc::raw_vec::finish_grow"],
            ),
            (
                None,
                &[
                    "main",
                    "__aeabi_memcpy",
                    "__aeabi_uidiv",
                    "__aeabi_idiv0",
                    "__aeabi_fadd",
                    "__aeabi_f2iz",
                    "__addsf3",
                    "__udivmoddi4",
                    "libm::math::sqrtf::sqrtf",
                    "sinew_core::joint::free",
                    "heapless::vec::Vec<T,_>::push",
                    "core::slice::<impl [T]>::rotate_left",
                    "__floatsisf",
                ],
            ),
        ] {
            for name in names {
                assert_eq!(of_name(name), rule, "{name}");
            }
        }
    }

    #[test]
    fn a_call_or_an_instruction_is_found_where_it_stands() {
        let symbols = [(0, "tick"), (8, "__aeabi_dmul"), (10, "fine"), (16, "loops")];
        let ([a, b], [c, d]) = (branch(2, 8, true), branch(16, 16, true));
        let halves = [NOP, a, b, BX_LR, BX_LR, 0xeea0, 0x0a81, BX_LR, c, d];
        let elf = Elf::parse(&object(&symbols, &halves)).unwrap();
        let finding =
            |rule, what: &str, function, at| Finding { rule, what: what.to_owned(), function, at };
        assert_eq!(
            findings(&elf),
            [
                finding(Rule::DoublePrecision, "__aeabi_dmul", 0, 2),
                finding(Rule::FusedMultiplyAdd, "vfma.f32 s0, s1, s2", 2, 10),
                finding(Rule::Recursion, "loops > loops", 3, 16),
            ]
        );
    }

    #[test]
    fn calls_by_register_and_into_the_void_are_found() {
        let [a, b] = branch(2, 400, true);
        let elf = Elf::parse(&object(&[(0, "f")], &[0x4798, a, b])).unwrap();
        let rules: Vec<_> =
            findings(&elf).iter().map(|finding| (finding.rule, finding.at)).collect();
        assert_eq!(rules, [(Rule::IndirectCall, 0), (Rule::Nowhere, 2)]);
    }

    #[test]
    fn what_nobody_calls_by_name_is_found_too() {
        let elf = Elf::parse(&object(&[(0, "f"), (2, "malloc")], &[BX_LR, BX_LR])).unwrap();
        assert_eq!(findings(&elf)[0].rule, Rule::Allocation);
    }
}
