//! A hash map of cells on the CPU.
