//! How far an image is from another: errors, what the eye sees of them, and whether they are more than noise.

pub mod difference;
pub mod error;
pub mod estimate;
pub mod flip;
pub mod student;
pub mod verdict;
