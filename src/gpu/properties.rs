//! The properties of a driver that a shader may rely on. The linker knows the names, and the probe tests which of them hold.

/// A property that a shader may rely on: `//@ relies on NAME`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    Loops,
    Uniforms,
    Bits,
    Logarithm,
    Signs,
}

/// All properties that a shader may rely on.
pub const PROPERTIES: [Property; 5] =
    [Property::Loops, Property::Uniforms, Property::Bits, Property::Logarithm, Property::Signs];

impl Property {
    /// Its name in shaders.
    pub fn name(self) -> &'static str {
        match self {
            Property::Loops => "loops",
            Property::Uniforms => "uniforms",
            Property::Bits => "bits",
            Property::Logarithm => "logarithm",
            Property::Signs => "signs",
        }
    }

    /// What a driver without it does, in words.
    pub fn without(self) -> &'static str {
        match self {
            Property::Loops => "ends loops before 65,535 iterations",
            Property::Uniforms => "converts integers of 24 bits inexactly, so that random numbers could be 1",
            Property::Bits => "does not tell NaN and infinity from numbers by their bits",
            Property::Logarithm => "computes log between 0.5 and 1 with a larger error than the 2^-21 that WGSL allows",
            Property::Signs => "gets signs of differences of products wrong, which would leave gaps in meshes",
        }
    }
}
