//! Compares images: errors, the visible difference (FLIP), and whether a difference is more than noise.

pub mod difference;
pub mod error;
pub mod estimate;
pub mod flip;
mod grid;
pub mod images;
pub mod pixels;
mod shift;
pub mod student;
pub mod verdict;
