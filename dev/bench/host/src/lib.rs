//! Holds nothing: the benches are programs.
