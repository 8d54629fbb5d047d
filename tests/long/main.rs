//! What takes minutes: `make test-long`.

#[path = "../common/mod.rs"]
mod common;

mod fuzz;
mod hidden_light;
mod long;
mod long_paths;
mod soak;
