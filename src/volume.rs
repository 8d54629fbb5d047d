//! Densities and temperatures that vary in a medium. This file has everything that the scene says about them.

pub mod bricks;
pub mod grid;
pub mod heat;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, first};
use crate::source::declare::declare;
use crate::source::form::{Checked, Field, Form, PATH, number, other};
use crate::source::{NO_UNIT, Range, SCENE_UNITS, ValuePath};
use crate::texture::{Colour, Use};

/// The range of a constant density.
pub const DENSITY: Field = number(Range::NOT_NEGATIVE, "per scene unit");
/// The name of a grid in its file.
const GRID_NAME: Field = other("the name of a grid of the file in quotes");

declare! {
    /// How the density of a medium varies.
    #[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
    #[serde(deny_unknown_fields)]
    pub enum Varying {
        /// Fog that thins with height, as air does. Its height is y in the medium's own space.
        Height: height, "Height(scale_height: 8, at: 0, density: 0.1)" {
            /// The height over which the density falls to 1/e.
            scale_height: f64 = number(Range::POSITIVE, SCENE_UNITS);
            /// The height at which it is `density`.
            at: f64 = number(Range::ANY, SCENE_UNITS);
            density: f64 = DENSITY.named("density", "The extinction coefficient at that height.");
        }
        /// A grid of an OpenVDB file: clouds and smoke, trilinear between voxels. Without a boundary, the medium fills the box of the active voxels,
        /// one voxel wider on each side.
        Grid: grid_of_file, "Grid(path: \"meshes/cloud.vdb\", name: \"density\", scale: 20)" {
            /// A .vdb file.
            path: String = other(PATH);
            /// The grid, which is one of 32-bit or 16-bit numbers.
            #[serde(default = "density_name")]
            name: String = GRID_NAME.or("\"density\"");
            /// The extinction coefficient where the grid is 1. Transforms do not change it.
            #[serde(default = "one")]
            scale: f64 = DENSITY.or("1");
        }
    }
}

declare! {
    /// The emission of a medium by its temperature.
    #[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
    #[serde(deny_unknown_fields)]
    pub enum Heat {
        /// A black body of a temperature that varies: fire. Below 500 kelvins it emits nothing.
        Blackbody: blackbody, "Blackbody(path: \"meshes/cloud.vdb\", name: \"density\", scale: 2000, at: 1500, luminance: 3)" {
            /// A .vdb file.
            path: String = other(PATH);
            /// The grid of temperatures.
            #[serde(default = "temperature_name")]
            name: String = GRID_NAME.or("\"temperature\"");
            /// The kelvins where the grid is 1.
            #[serde(default = "one")]
            scale: f64 = number(Range::NOT_NEGATIVE, "kelvins").or("1");
            /// The temperature of a radiance that is known.
            #[serde(default = "reference")]
            at: f64 = number(Range::from_to(heat::COLDEST, heat::HOTTEST), "kelvins").or("1500");
            /// The luminance of that radiance.
            #[serde(default = "one")]
            luminance: f64 = number(Use::Radiance.range(), NO_UNIT).or("1");
        }
    }
}

impl Varying {
    /// The fact that it requires (src/flatten/features.rs).
    pub fn fact(&self) -> &'static str {
        match self {
            Varying::Height { .. } => "varying.height",
            Varying::Grid { .. } => "varying.grid",
        }
    }
}

fn density_name() -> String {
    "density".to_owned()
}

fn temperature_name() -> String {
    "temperature".to_owned()
}

fn one() -> f64 {
    1.0
}

fn reference() -> f64 {
    1500.0
}

/// The words for a density in error messages.
pub const ANY_DENSITY: &str = "a number, Height(..) or Grid(..)";
/// The words for an emission.
pub const ANY_EMISSION: &str = "a colour (r, g, b) or Blackbody(..)";

/// The density of a medium.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(untagged, expecting = "neither a number nor a texture")]
pub enum Density {
    Constant(f64),
    Varying(Varying),
}

/// The emission of a medium: the radiance of what absorbs light there.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(untagged, expecting = "neither a number nor a texture")]
pub enum Emission {
    Colour(Colour),
    Heat(Heat),
}

impl Checked for Density {
    fn check_as(&self, field: &Field, above: &ValuePath) -> Result<()> {
        match self {
            Density::Constant(density) => DENSITY.named(field.name, "").check(above, *density),
            Density::Varying(varying) => first(varying.check_fields(&above.field(field.name).variant(varying.name()))),
        }
    }
}

impl Checked for Emission {
    fn check_as(&self, field: &Field, above: &ValuePath) -> Result<()> {
        let at = above.field(field.name);
        match self {
            Emission::Colour(colour) => Use::Radiance.check(&at, *colour),
            Emission::Heat(heat) => first(heat.check_fields(&at.variant(heat.name()))),
        }
    }
}

impl Density {
    /// The path and the name of its grid, if it has one.
    pub fn grid(&self) -> Option<(&str, &str)> {
        match self {
            Density::Varying(Varying::Grid { path, name, .. }) => Some((path, name)),
            _ => None,
        }
    }

    /// How it varies, if it does.
    pub fn varying(&self) -> Option<&Varying> {
        match self {
            Density::Constant(_) => None,
            Density::Varying(varying) => Some(varying),
        }
    }

    /// The scale of its values: its largest density is this times the grid's largest value.
    pub fn scale(&self) -> f64 {
        match self {
            Density::Constant(density) => *density,
            Density::Varying(Varying::Height { density, .. }) => *density,
            Density::Varying(Varying::Grid { scale, .. }) => *scale,
        }
    }
}

impl Emission {
    /// Whether it is not 0.
    pub fn is_seen(&self) -> bool {
        match self {
            Emission::Colour(colour) => *colour != Colour::ZERO,
            Emission::Heat(Heat::Blackbody { luminance, scale, .. }) => luminance * scale > 0.0,
        }
    }

    /// The path and the name of its grid, if it has one.
    pub fn grid(&self) -> Option<(&str, &str)> {
        match self {
            Emission::Colour(_) => None,
            Emission::Heat(Heat::Blackbody { path, name, .. }) => Some((path, name)),
        }
    }
}
