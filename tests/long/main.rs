//! What takes minutes: `make test-long`.

#[path = "../common/mod.rs"]
mod common;

mod fuzz;
mod long;
mod long_paths;
mod soak;
