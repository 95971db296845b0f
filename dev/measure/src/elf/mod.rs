//! Reads an image for Arm: its functions, their Thumb-2 instructions, and their calls.

mod call;
mod calls;
mod disassembly;
mod function;
mod lines;
mod name;
mod symbols;
mod text;

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use object::{Architecture, Object};

pub(crate) use call::{Call, Target};
pub(crate) use disassembly::Instruction;
pub(crate) use function::Function;
pub(crate) use lines::{Lines, SourceLine};
pub(crate) use name::last_part;

use disassembly::Disassembler;
use text::Words;

/// A linked image. Functions are identified by their index, in the order of addresses.
#[derive(Debug)]
pub(crate) struct Elf {
    functions: Vec<Function>,
    named_by_data: Vec<usize>,
    handlers: Vec<usize>,
}

impl Elf {
    /// Reads an image.
    ///
    /// # Errors
    /// If the file is not an ELF file for Arm with symbols, or contains code other than Thumb-2.
    pub(crate) fn load(path: &Path) -> Result<Self> {
        let name = || path.display().to_string();
        Self::parse(&fs::read(path).with_context(name)?).with_context(name)
    }

    /// Reads an image in memory.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self> {
        let file = object::File::parse(bytes)?;
        ensure!(file.architecture() == Architecture::Arm, "it is for {:?}", file.architecture());
        let disassembler = Disassembler::new()?;
        let mut functions = symbols::functions(&file)?
            .into_iter()
            .map(|found| {
                let instructions = disassembler
                    .instructions(&found.code)
                    .with_context(|| format!("{} at {:#x}", found.name, found.address))?;
                Ok(Function {
                    name: found.name,
                    aliases: found.aliases,
                    symbol: found.symbol,
                    address: found.address,
                    size: found.size,
                    instructions,
                    calls: Vec::new(),
                })
            })
            .collect::<Result<Vec<_>>>()?;
        ensure!(!functions.is_empty(), "it has no symbols of functions");
        let words = Words::of(&file)?;
        let word = |address| words.at(address);
        let calls: Vec<_> =
            functions.iter().map(|function| calls::of(function, &functions, &word)).collect();
        for (function, calls) in functions.iter_mut().zip(calls) {
            function.calls = calls;
        }
        let resolve = |(index, function): (usize, &Function)| -> Vec<Call> {
            let mut calls = Vec::new();
            for call in &function.calls {
                let open = call.is_tail && call.to == Target::Indirect;
                let known = open.then(|| calls::of_callers(index, call, &functions, &word));
                calls.extend(known.flatten().unwrap_or_else(|| vec![*call]));
            }
            calls
        };
        let resolved: Vec<_> = functions.iter().enumerate().map(resolve).collect();
        for (function, calls) in functions.iter_mut().zip(resolved) {
            function.calls = calls;
        }
        let starts: BTreeMap<u64, usize> =
            functions.iter().enumerate().map(|(index, found)| (found.address | 1, index)).collect();
        let among = |is_table: bool| -> Vec<usize> {
            let named = words.all(is_table).filter_map(|word| starts.get(&u64::from(word)));
            named.copied().collect::<BTreeSet<_>>().into_iter().collect()
        };
        let (named_by_data, handlers) = (among(false), among(true));
        Ok(Self { functions, named_by_data, handlers })
    }

    /// Returns the functions whose address is in data, including data among the code: a pointer can have no other
    /// target.
    pub(crate) fn named_by_data(&self) -> &[usize] {
        &self.named_by_data
    }

    /// Returns the functions in the vector table: handlers of reset, exceptions and interrupts.
    pub(crate) fn handlers(&self) -> &[usize] {
        &self.handlers
    }

    /// Returns all functions, in the order of their addresses.
    pub(crate) fn functions(&self) -> &[Function] {
        &self.functions
    }

    /// Returns the function with this name, symbol or alias.
    pub(crate) fn named(&self, name: &str) -> Option<usize> {
        self.functions.iter().position(|function| {
            function.symbol == name || function.names().any(|known| known == name)
        })
    }

    /// Returns the functions that `function` calls by name, each once, in rising order.
    pub(crate) fn callees_of(&self, function: usize) -> BTreeSet<usize> {
        self.functions[function].calls.iter().filter_map(|call| call.to.function()).collect()
    }

    /// Returns the functions that call `function` by name, in rising order.
    pub(crate) fn callers_of(&self, function: usize) -> Vec<usize> {
        (0..self.functions.len())
            .filter(|caller| self.callees_of(*caller).contains(&function))
            .collect()
    }

    /// Returns the functions that may run when `roots` are called, including the roots; indirect calls are not
    /// followed.
    pub(crate) fn reachable_from(&self, roots: &[usize]) -> BTreeSet<usize> {
        let mut reached: BTreeSet<usize> = roots.iter().copied().collect();
        let mut pending: Vec<usize> = roots.to_vec();
        while let Some(function) = pending.pop() {
            pending
                .extend(self.callees_of(function).into_iter().filter(|next| reached.insert(*next)));
        }
        reached
    }

    /// Returns a shortest path of calls from `root` to `function`, including both.
    pub(crate) fn path_from(&self, root: usize, function: usize) -> Option<Vec<usize>> {
        let mut came_from = vec![None; self.functions.len()];
        let mut pending = VecDeque::from([root]);
        while let Some(at) = pending.pop_front() {
            if at == function {
                let mut path = vec![at];
                while let Some(before) = path.last().and_then(|last| came_from[*last]) {
                    path.push(before);
                }
                path.reverse();
                return Some(path);
            }
            for next in self.callees_of(at) {
                if next != root && came_from[next].is_none() {
                    came_from[next] = Some(at);
                    pending.push_back(next);
                }
            }
        }
        None
    }

    /// Returns a shortest path of calls from `function` back to itself, if it recurs; both ends are the function.
    pub(crate) fn cycle_through(&self, function: usize) -> Option<Vec<usize>> {
        self.callees_of(function)
            .into_iter()
            .filter_map(|next| self.path_from(next, function))
            .min_by_key(Vec::len)
            .map(|path| std::iter::once(function).chain(path).collect())
    }
}

#[cfg(test)]
pub(crate) mod fixture;
#[cfg(test)]
mod tests;
