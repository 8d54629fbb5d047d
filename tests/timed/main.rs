//! Tests that measure seconds: apart, so that no others run beside them.

#[path = "../common/mod.rs"]
mod common;

mod startup;
mod tradeoff;
