//! An editor in memory.
