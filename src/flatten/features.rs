//! What a scene requires of the renderer.

use crate::data;
use crate::material::{MATERIALS, Material, Scattering};
use crate::options::{FeatureSet, Integrator, RenderOptions};
use crate::texture::TEXTURES;

pub use crate::shape::{BOUNDARIES, PRIMITIVES};
/// The kinds of background by number; each is a file of shaders/background.
pub const BACKGROUNDS: &[&str] = &["solid", "gradient", "image"];

/// What asks for everything that a scene can have.
pub const EVERY_FEATURE: &str = "--features all";

/// What emits and is left to chance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unsampled {
    /// As lights, of so many wanted.
    pub lights: u64,
    pub wanted: u64,
    /// The first of them.
    pub asked_by: String,
}

/// What of the renderer a scene requires, and for each thing the scene's object that asked first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Features {
    /// By the numbers of `PRIMITIVES`.
    pub primitives: [Option<String>; PRIMITIVES.len()],
    /// By the numbers of `MATERIALS`: of materials on objects, not of all that are defined.
    pub materials: [Option<String>; MATERIALS.len()],
    /// By the numbers of `MATERIALS`: of those that answer to lights that are sampled.
    pub non_specular: [Option<String>; MATERIALS.len()],
    /// By the numbers of `MATERIALS`: of those that send a ray one way alone.
    pub specular: [Option<String>; MATERIALS.len()],
    /// By the numbers of `TEXTURES`.
    pub textures: [Option<String>; TEXTURES.len()],
    /// Meshes with vertex normals, which are shaded smoothly.
    pub smooth: Option<String>,
    /// Boundaries of media, by their places in `BOUNDARIES`.
    pub boundaries: [Option<String>; BOUNDARIES.len()],
    /// Media whose albedo is a texture.
    pub textured_media: Option<String>,
    /// Kinds of primitive that are sampled as lights, by the numbers of `PRIMITIVES`.
    pub emitters: [Option<String>; PRIMITIVES.len()],
    /// Whether the image of the background is.
    pub emitting_sky: Option<String>,
    /// Columns and rows of the grid that directions towards it are drawn from.
    pub sky_grid: (u32, u32),
    /// How many lights there are.
    pub lights: u32,
    /// What emits and is not sampled, as there is no room.
    pub unsampled: Option<Unsampled>,
    /// The place of the sky among them.
    pub sky_light: u32,
    /// Whether paths send rays to them. Of the scene alone, also where everything is taken to be required: then an invocation has two walks.
    pub shadow_rays: bool,
    /// How many media there are.
    pub media: u32,
    /// By the numbers of `BACKGROUNDS`; a scene has one of its own.
    pub backgrounds: [Option<String>; BACKGROUNDS.len()],
    /// A lens with a diameter.
    pub thin_lens: Option<String>,
    /// Pixels so small that render space has the camera's axes and not the world's.
    pub turned: Option<String>,
    /// Whether all primitives are asked of every ray: they are few, and none of them a mesh.
    pub brute_force: bool,
    /// Codes that wait at most in a walk through the BVH.
    pub stack_size: u32,
    /// The same of a walk through a mesh that bounds a medium.
    pub boundary_stack_size: u32,
}

impl Features {
    /// What a render with these options requires: with `--features all` everything that a scene can have.
    pub fn of(&self, options: &RenderOptions) -> Features {
        let mut features = self.clone();
        if options.features == FeatureSet::All {
            features.add_all(options.integrator == Integrator::Mis);
        }
        features
    }

    /// Everything that a scene can have, as asked for by `--features all`. Of what chooses between two ways, such as the number of
    /// lights, the scene's own way stays, and so do the settings that approximate.
    fn add_all(&mut self, sample_lights: bool) {
        let add = |used: &mut Option<String>| {
            used.get_or_insert_with(|| EVERY_FEATURE.to_string());
        };
        let emitters = if sample_lights { self.emitters.as_mut_slice() } else { &mut [] };
        let lists: [&mut [Option<String>]; 5] = [
            &mut self.primitives,
            &mut self.materials,
            &mut self.textures,
            &mut self.boundaries,
            &mut self.backgrounds,
        ];
        lists.into_iter().flatten().chain(emitters).for_each(add);
        [&mut self.smooth, &mut self.textured_media, &mut self.thin_lens, &mut self.turned].into_iter().for_each(add);
        if sample_lights {
            add(&mut self.emitting_sky);
            for (way, used) in [(Scattering::Spread, &mut self.non_specular), (Scattering::OneWay, &mut self.specular)]
            {
                let materials = Material::KINDS.iter().zip(used);
                materials.filter(|(kind, _)| kind.scatters.contains(&way)).for_each(|(_, used)| add(used));
            }
        }
        self.brute_force = false;
        // The sky that `require_all` adds is a light beside the scene's, and is never chosen.
        if sample_lights && self.sky_grid == (0, 0) {
            self.sky_grid = (1, 1);
            self.sky_light = self.lights;
            self.lights = self.lights.max(1);
        }
        // Walks through meshes and their boundaries take as much as a mesh of millions of faces needs.
        const DEEP: u32 = 48;
        self.stack_size = self.stack_size.max(DEEP);
        self.boundary_stack_size = self.boundary_stack_size.max(DEEP);
    }

    /// Whether kernels have code for media.
    pub fn crosses_media(&self) -> bool {
        self.media > 0 || self.boundaries.iter().any(Option::is_some)
    }

    /// Whether anything in the scene answers to light from any direction. Where nothing does, no ray is sent to a light.
    pub(super) fn samples_light_anywhere(&self) -> bool {
        self.media > 0 || self.non_specular.iter().any(Option::is_some)
    }
}

impl super::DeviceScene {
    /// Tables for what the scene lacks that say so, since kernels with everything bind them: a light that is never chosen, a sky that
    /// sends nothing.
    pub(super) fn require_all(&mut self, sample_lights: bool) {
        if sample_lights && self.sky.is_empty() {
            self.sky.push(data::SkyCell::default());
            self.lights.push(data::Light {
                code: data::HIT_NOTHING,
                instance: data::NO_INSTANCE,
                ..data::Light::default()
            });
        }
    }
}
