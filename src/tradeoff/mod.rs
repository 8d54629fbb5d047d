//! Measuring what a render's settings trade: seconds against noise and bias, setting by setting, beside each other.
//!
//! [`sweep`] renders, [`replicates`] says what the images tell, [`model`] what follows for the time to an error, [`judge`] joins the two for
//! all settings, and [`page`] draws the report.

pub mod judge;
pub mod model;
pub mod page;
pub mod replicates;
pub mod report;
pub mod sweep;
