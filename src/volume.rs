//! What fills space: grids of densities.

pub mod grid;
