//! The acceleration structure.
