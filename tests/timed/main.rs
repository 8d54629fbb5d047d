//! Tests that measure seconds: apart, so that no others run beside them.

#[path = "../common/mod.rs"]
mod common;

mod serve;
mod startup;
mod tradeoff;

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Seconds are measured within a budget: each test has the machine for itself, as far as this program goes.
fn alone() -> MutexGuard<'static, ()> {
    static MACHINE: Mutex<()> = Mutex::new(());
    MACHINE.lock().unwrap_or_else(PoisonError::into_inner)
}
