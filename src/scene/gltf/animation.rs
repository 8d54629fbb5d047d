//! The pose that the animations of a glTF file give its nodes at a time.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::{Arc, PoisonError};

use gltf::json::Index;
use gltf::json::accessor::Accessor;

use super::accessors::{ALL, Extent};
use super::channels::{Interpolation, Property, Sampler};
use super::interpolate::{Position, locate, value};
use super::nodes::{Animated, Pose};
use super::{File, GltfError, Result};
use crate::printable::{counted, quote};

/// The most keys of all samplers. A time is searched among all keys of a sampler.
const MOST_KEYS: u64 = 1 << 28;

impl File {
    /// The pose at a time, or the rest pose.
    pub fn pose(&self, seconds: Option<f64>) -> Result<Arc<Pose>> {
        let Some(seconds) = seconds else { return Ok(Arc::clone(&self.rest)) };
        let last = || self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pose) = last().as_ref().filter(|pose| pose.seconds == Some(seconds)) {
            return Ok(Arc::clone(pose));
        }
        let pose = Arc::new(self.pose_at(seconds)?);
        *last() = Some(Arc::clone(&pose));
        Ok(pose)
    }

    fn pose_at(&self, seconds: f64) -> Result<Pose> {
        let animations = self.animations.as_ref().map_err(Clone::clone)?;
        let (mut animated, mut notes) = (HashMap::<usize, Animated>::new(), Vec::new());
        // The animation that moves each property of a node, and where the time is among the keys of each accessor.
        let (mut movers, mut positions) = (HashMap::new(), HashMap::new());
        let mut keys_left = MOST_KEYS;
        let mut pointers = 0;
        for (number, animation) in animations.iter().enumerate() {
            let mut moved_before = None;
            for (index, channel) in animation.channels.iter().enumerate() {
                let at = format!("animations[{number}].channels[{index}]");
                let property = channel.target.path;
                pointers += usize::from(property == Property::Pointer);
                let is_read = !matches!(property, Property::Pointer | Property::Other);
                let Some(node) = channel.target.node.filter(|_| is_read) else { continue };
                let sampler = animation.samplers.get(channel.sampler).ok_or_else(|| {
                    GltfError::new(format!("{at}.sampler"), format!("there is no sampler {}", channel.sampler))
                })?;
                if node >= self.root().nodes.len() {
                    return Err(GltfError::new(format!("{at}.target.node"), format!("there is no node {node}")));
                }
                match movers.entry((node, property)) {
                    Entry::Occupied(mover) => {
                        moved_before = moved_before.or(Some((*mover.get(), node)));
                        continue;
                    }
                    Entry::Vacant(entry) => _ = entry.insert(number),
                }
                let at = format!("animations[{number}].samplers[{}]", channel.sampler);
                let position = match positions.entry(sampler.input) {
                    Entry::Occupied(known) => *known.get(),
                    Entry::Vacant(new) => *new.insert(self.locate(sampler, seconds, &mut keys_left, &at)?),
                };
                let width = if property == Property::Weights { self.target_count(node) } else { 1 };
                let found = self.sampled(sampler, position, property, (width, &at))?;
                set(animated.entry(node).or_default(), property, &found);
            }
            notes.extend(moved_before.map(|(mover, node)| {
                let name = |number: usize| {
                    let name = animations.get(number).and_then(|animation| animation.name.as_ref());
                    name.map_or(String::new(), |name| format!(" ({})", quote(name)))
                };
                let (this, other) = (name(number), name(mover));
                format!(
                    "animations[{number}]{this}: it moves nodes[{node}], which animations[{mover}]{other} moves too: only the first in \
                     the file counts"
                )
            }));
        }
        if pointers > 0 {
            notes.push(format!(
                "animations: KHR_animation_pointer is not read, so that what it animates stays still: {}",
                counted(pointers as u64, "channel")
            ));
        }
        if animations.is_empty() {
            notes.push("it has no animations: all frames are the same".to_owned());
        }
        let mut pose = Pose::at(self.root(), Some(seconds), animated)?;
        pose.notes = notes;
        Ok(pose)
    }

    /// The number of morph targets of a node's mesh.
    fn target_count(&self, node: usize) -> usize {
        let mesh = self.root().nodes.get(node).and_then(|node| self.root().meshes.get(node.mesh?.value()));
        let counts =
            mesh.into_iter().flat_map(|mesh| &mesh.primitives).map(|it| it.targets.as_ref().map_or(0, Vec::len));
        counts.max().unwrap_or(0)
    }

    /// Where a time is among a sampler's keys, and their number.
    fn locate(&self, sampler: &Sampler, seconds: f64, keys_left: &mut u64, at: &str) -> Result<(Position, u64)> {
        let wrong = |reason: String| GltfError::new(format!("{at}.input"), reason);
        let index = Index::<Accessor>::new(u32::try_from(sampler.input).unwrap_or(u32::MAX));
        let times = self.scalars(index, 0).map_err(wrong)?;
        let count = self.accessor(index).map_or(0, |accessor| accessor.count.0);
        *keys_left = keys_left
            .checked_sub(count)
            .ok_or_else(|| wrong(format!("expected at most {MOST_KEYS} keys of all animations, found more")))?;
        Ok((locate(times, seconds).map_err(wrong)?, count))
    }

    /// The value of a sampler at a position among its keys. An element of weights has so many numbers.
    fn sampled(
        &self,
        sampler: &Sampler,
        (position, keys): (Position, u64),
        property: Property,
        (width, at): (usize, &str),
    ) -> Result<Vec<f64>> {
        let wrong = |reason: String| GltfError::new(format!("{at}.output"), reason);
        let index = Index::<Accessor>::new(u32::try_from(sampler.output).unwrap_or(u32::MAX));
        let of_key = if sampler.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let (needed, found) = (
            keys.saturating_mul(of_key).saturating_mul(width as u64),
            self.accessor(index).map_or(u64::MAX, |accessor| accessor.count.0),
        );
        if found < needed {
            return Err(wrong(format!("expected {needed} elements for {keys} keys, found {found}")));
        }
        let element = |number: usize| {
            let extent = Extent { from: number.saturating_mul(width), ..ALL };
            let numbers: Vec<f64> = match property {
                Property::Rotation => self.elements::<4>(index, extent)?.take(1).flatten().collect(),
                Property::Weights => self.scalars(index, extent.from)?.take(width).collect(),
                _ => self.elements::<3>(index, extent)?.take(1).flatten().collect(),
            };
            match numbers.iter().find(|x| !x.is_finite()) {
                Some(x) => Err(format!("expected finite numbers, found {x} in element {number}")),
                None => Ok(numbers),
            }
        };
        value(sampler.interpolation, position, property == Property::Rotation, element).map_err(wrong)
    }
}

/// Gives a node a value, rounded as a file would have it.
fn set(animated: &mut Animated, property: Property, value: &[f64]) {
    let rounded: Vec<f32> = value.iter().map(|x| *x as f32).collect();
    let three = || <[f32; 3]>::try_from(rounded.as_slice()).ok();
    match property {
        Property::Translation => animated.translation = three(),
        Property::Scale => animated.scale = three(),
        Property::Rotation => animated.rotation = <[f32; 4]>::try_from(rounded.as_slice()).ok(),
        Property::Weights => animated.weights = Some(rounded),
        Property::Pointer | Property::Other => {}
    }
}
