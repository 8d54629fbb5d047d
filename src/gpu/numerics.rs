//! The findings of the numerics probe about a driver.

use serde::Serialize;

/// The iterations of the loop that tests whether loops have a limit.
pub const LOOPS: u32 = 70_000;
/// The steps that a walk may take if the driver does not limit loops.
pub const MOST_STEPS: u32 = 1 << 18;
/// The iterations that kernels are designed for: the number that Mesa 22.3 allows an invocation in all of its loops together.
pub const LOOPS_NEEDED: u32 = 65_535;

/// The error of log that WGSL allows on [0.5, 1).
pub const LOG_ERROR: f64 = 1.0 / 2_097_152.0;

/// The findings of the probe about a driver.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Numerics {
    /// Knuth's two-sum, in its plain form, gives the rounding error. False if the compiler simplifies `(x + y) - x` to `y`.
    pub two_sum: bool,
    /// Two-sum gives the rounding error if a uniform 0 is added to its intermediate values.
    pub two_sum_barrier: bool,
    /// Dekker's two-product gives the rounding error in the same form.
    pub two_product_barrier: bool,
    /// `fma(x, y, z)` rounds once.
    pub fma_fused: bool,
    /// `x * y - z` is contracted to an fma.
    pub contraction: bool,
    /// `x != x` is true for a NaN. False if the compiler assumes that NaNs do not occur.
    pub nan_compares: bool,
    /// For a NaN, `<` and `>=` are false, and the negation of `>=` is true.
    pub nan_fails_comparisons: bool,
    /// The tests by bits (lib/float) distinguish NaN and infinity from numbers.
    pub nan_by_bits: bool,
    /// The number of iterations that a loop of 70 000 completed. If it completed all, the driver has no known limit.
    pub loop_iterations: u32,
    /// Subnormal numbers (below 2^-126) are kept as inputs and as results. Otherwise they are flushed to 0 somewhere.
    pub subnormals: bool,
    /// The rounding of 32-bit words to floats.
    pub conversion: Rounding,
    /// A random word times 2^-32 can be 1, because the conversion rounds up.
    pub words_reach_one: bool,
    /// The upper 24 bits of a word times 2^-24 are exact, and therefore below 1.
    pub uniforms_exact: bool,
    /// The largest absolute error of log on [0.5, 1). WGSL guarantees 2^-21 = 4.8e-7.
    pub log_error: f64,
    /// The largest relative error of log there. It is large for arguments near 1, where few digits are left.
    pub log_relative_error: f64,
    /// The largest absolute error of sin on [-pi, pi]. WGSL guarantees 2^-11 = 4.9e-4.
    pub sin_error: f64,
    /// The largest error for arguments up to 1e6, for which WGSL guarantees nothing.
    pub sin_error_far: f64,
    /// Edge functions (geometry/sheared_triangle) have the sign of the exact difference of products.
    pub edge_signs: bool,
}

/// The rounding of integers to floats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rounding {
    #[default]
    /// Ties to even.
    Nearest,
    TowardsZero,
    Neither,
}

impl Rounding {
    pub fn name(self) -> &'static str {
        match self {
            Rounding::Nearest => "to nearest",
            Rounding::TowardsZero => "towards zero",
            Rounding::Neither => "in a way of its own",
        }
    }
}

impl Serialize for Rounding {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl Numerics {
    /// The largest number of steps of a walk through the tree, if loops have no limit. No scene should need so many;
    /// the bound ensures that a dispatch ends. None if loops have a limit: the kernels' own defaults then apply.
    pub fn most_steps(&self) -> Option<u32> {
        (self.loop_iterations >= LOOPS).then_some(MOST_STEPS)
    }

    /// The properties that a driver with these findings lacks.
    pub fn lacking(&self) -> impl Iterator<Item = Property> {
        PROPERTIES.into_iter().filter(|property| !(property.holds)(self))
    }
}

/// A property that a shader may rely on: `//@ relies on NAME`.
#[derive(Clone, Copy, Debug)]
pub struct Property {
    /// Its name in shaders.
    pub name: &'static str,
    /// What a driver without it does, in words.
    pub without: &'static str,
    holds: fn(&Numerics) -> bool,
}

/// All properties that a shader may rely on.
pub const PROPERTIES: [Property; 5] = [
    Property {
        name: "loops",
        without: "ends loops before 65,535 iterations",
        holds: |found| found.loop_iterations >= LOOPS_NEEDED.min(LOOPS),
    },
    Property {
        name: "uniforms",
        without: "converts integers of 24 bits inexactly, so that random numbers could be 1",
        holds: |found| found.uniforms_exact,
    },
    Property {
        name: "bits",
        without: "does not tell NaN and infinity from numbers by their bits",
        holds: |found| found.nan_by_bits,
    },
    Property {
        name: "logarithm",
        without: "computes log between 0.5 and 1 with a larger error than the 2^-21 that WGSL allows",
        holds: |found| found.log_error <= LOG_ERROR,
    },
    Property {
        name: "signs",
        without: "gets signs of differences of products wrong, which would leave gaps in meshes",
        holds: |found| found.edge_signs,
    },
];
