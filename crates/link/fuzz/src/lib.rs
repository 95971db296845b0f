//! Holds nothing: the targets are tests.
