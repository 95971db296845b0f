//! This library is empty: the benches are programs.
