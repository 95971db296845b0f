//! Rigs that stand still.

mod onset;
