//! What a detector counts: light that leaves a body, with no picture made of it.

pub mod slab;
