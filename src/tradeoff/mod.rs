//! Measuring what a render's settings trade: seconds against noise and bias, setting by setting, beside each other.
//!
//! [`sweep`] renders, [`replicates`] says what the images tell of each other, [`truth`] what they are measured against, [`model`] what follows
//! for the time to an error, [`judge`] joins these for all settings, and [`report`] and [`page`] say it.

pub mod judge;
pub mod model;
pub mod page;
pub mod replicates;
pub mod report;
pub mod sweep;
pub mod truth;
