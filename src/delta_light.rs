//! Delta lights: lights without size, which only light sampling can find. This file has everything that the host knows about them.

use std::f64::consts::PI;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::data::{self, f32s, luminance};
use crate::error::Result;
use crate::shape::similarity::Similarity;
use crate::shape::{Aabb, RenderSpace};
use crate::source::form::Checked;
use crate::source::{SMALLEST, ValuePath};
use crate::texture::Colour;

/// How the light of a spot falls between its angles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum Falloff {
    /// By the square of the share of the cosine, as in glTF.
    #[default]
    Gltf,
    /// By the share of the angle, as in Mitsuba.
    Linear,
    /// By the smoothstep of the share of the cosine, as in pbrt.
    Smooth,
}

impl Checked for Falloff {}

/// A light without size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DeltaLight {
    Point { at: DVec3, intensity: Colour },
    Spot { at: DVec3, towards: DVec3, intensity: Colour, inner: f64, outer: f64, falloff: Falloff },
    Directional { direction: DVec3, irradiance: Colour },
}

fn unit(v: DVec3) -> DVec3 {
    // Divided by its largest component first, because the squares of a short vector would underflow.
    (v / v.abs().max_element()).normalize_or_zero()
}

/// 1 - cos, with its digits.
fn height(degrees: f64) -> f64 {
    2.0 * (0.5 * degrees).to_radians().sin().powi(2)
}

impl DeltaLight {
    /// Checks its numbers, each of which is in its own range.
    pub fn check(&self, above: &ValuePath) -> Result<()> {
        match *self {
            DeltaLight::Spot { at, towards, .. } if (towards - at).length() < SMALLEST => {
                Err(above.field("towards").error("towards and at are the same point"))
            }
            DeltaLight::Spot { inner, outer, .. } if inner > outer => {
                let message = format!("expected an inner angle of at most outer ({outer}), found {inner}");
                Err(above.field("inner").error(message))
            }
            DeltaLight::Directional { direction, .. } if direction.length() < SMALLEST => {
                let message = "the direction has no length: expected a direction such as (0, -1, 0)";
                Err(above.field("direction").error(message))
            }
            _ => Ok(()),
        }
    }

    /// The warning about numbers with which it emits no light.
    pub fn warning(&self, above: &ValuePath) -> Option<String> {
        let message = "an outer angle of 0 has no cone, so that it emits no light: write an angle above 0";
        matches!(self, DeltaLight::Spot { outer: 0.0, .. }).then(|| above.field("outer").warning(message))
    }

    /// The intensity, or the irradiance of a directional light.
    pub fn colour(&self) -> Colour {
        match *self {
            DeltaLight::Point { intensity, .. } | DeltaLight::Spot { intensity, .. } => intensity,
            DeltaLight::Directional { irradiance, .. } => irradiance,
        }
    }

    /// Its distance from the origin.
    pub fn distance(&self) -> f64 {
        match *self {
            DeltaLight::Point { at, .. } | DeltaLight::Spot { at, .. } => at.length(),
            DeltaLight::Directional { .. } => 0.0,
        }
    }

    /// The light in the world.
    pub fn in_world(&self, to_world: &Similarity) -> WorldLight {
        let turned = |v: DVec3| to_world.rotation * unit(v);
        match *self {
            DeltaLight::Point { at, intensity } => {
                WorldLight { position: Some(to_world.point(at)), axis: DVec3::Z, colour: intensity, beam: None }
            }
            DeltaLight::Spot { at, towards, intensity, inner, outer, falloff } => WorldLight {
                position: Some(to_world.point(at)),
                axis: turned(towards - at),
                colour: intensity,
                // Between equal angles nothing falls.
                beam: Some(Beam { inner, outer, falloff: if inner < outer { falloff } else { Falloff::Gltf } }),
            },
            DeltaLight::Directional { direction, irradiance } => {
                WorldLight { position: None, axis: turned(direction), colour: irradiance, beam: None }
            }
        }
    }
}

/// The angles of a spot light, in degrees.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    inner: f64,
    outer: f64,
    pub falloff: Falloff,
}

/// A delta light in the world.
#[derive(Clone, Copy, Debug)]
pub struct WorldLight {
    /// None of a directional light.
    pub position: Option<DVec3>,
    /// Unit vector: where the light, or the middle of its beam, goes.
    axis: DVec3,
    /// Its intensity, or the irradiance of a directional light.
    pub colour: Colour,
    pub beam: Option<Beam>,
}

/// The distance in render space to which farther lights are moved. From there, all of the scene sees them in one direction.
const FARTHEST: f64 = (1u64 << 30) as f64;

/// Added to the angle of a beam in the light tree: more than the rounding of an angle there, so that no part of the beam is lost.
const MARGIN: f64 = 2e-3;

impl WorldLight {
    /// Render space as it is for this light: nearer to the camera, if the light would be too far away.
    pub fn own_space(&self, space: RenderSpace) -> RenderSpace {
        let distance = self.position.map_or(0.0, |at| space.point(at).length());
        RenderSpace {
            scale: if distance > FARTHEST { space.scale * FARTHEST / distance } else { space.scale },
            ..space
        }
    }

    /// Its position in render space, or the direction to a directional light; and its intensity there per unit of the world's.
    fn in_space(&self, space: RenderSpace) -> (DVec3, f64) {
        let own = self.own_space(space);
        let Some(at) = self.position.map(|at| own.point(at)) else { return (-self.axis, 1.0) };
        (at, own.scale.powi(2))
    }

    /// The struct that kernels read.
    pub fn on_device(&self, space: RenderSpace, radiance_scale: f64) -> data::DeltaLight {
        let (position, factor) = self.in_space(space);
        let colour = radiance_scale * (factor * self.colour);
        // Without a beam, the falloff is 1 in all directions.
        let (height, slope) = self.beam.map_or((4.0, 1.0), |Beam { inner, outer, falloff }| {
            let measure = if falloff == Falloff::Linear { f64::to_radians } else { height };
            let (inner, outer) = (measure(inner), measure(outer));
            let slope = (1.0 / (outer - inner).max(f64::MIN_POSITIVE)).min(f64::from(f32::MAX));
            match falloff {
                Falloff::Gltf => (outer, slope),
                Falloff::Linear => (-outer, slope),
                Falloff::Smooth => (outer, -slope),
            }
        });
        data::DeltaLight {
            position: f32s(position),
            has_position: f32::from(u8::from(self.position.is_some())),
            colour: f32s(colour.min(DVec3::splat(f64::from(f32::MAX)))),
            height: height as f32,
            axis: f32s(self.axis),
            slope: slope as f32,
        }
    }

    /// How bright it is to the light tree: its intensity in render space, or the irradiance of a directional light.
    pub fn brightness(&self, space: RenderSpace) -> f64 {
        self.in_space(space).1 * luminance(self.colour.to_array())
    }

    /// A box around its position in render space.
    pub fn around(&self, space: RenderSpace) -> Aabb {
        Aabb::around([self.in_space(space).0])
    }

    /// Whether it emits no light.
    pub fn is_dark(&self) -> bool {
        self.colour == Colour::ZERO || self.beam.is_some_and(|beam| beam.outer == 0.0)
    }

    /// Where its light goes, for the light tree: an axis, and an angle from it beyond which there is no light.
    pub fn cone(&self) -> (DVec3, Option<f64>) {
        (self.axis, self.beam.map(|beam| (beam.outer.to_radians() + MARGIN).min(PI)))
    }

    /// The radiance of a white diffuse surface that faces it at a distance.
    pub fn brightest_reflection(&self, distance: f64) -> f64 {
        let irradiance = match self.position {
            Some(_) => self.colour / distance / distance,
            None => self.colour,
        };
        irradiance.max_element() / PI
    }
}
