//! The features of the renderer that a scene requires.

use crate::bitmap::FORMATS;
use crate::material::{EXTENSIONS, ExtensionKind, Lobe, MATERIALS, Material};
use crate::options::{FeatureSet, Integrator, RenderOptions};
use crate::shape::KINDS;
use crate::texture::TEXTURES;

pub use crate::shape::{BOUNDARIES, PRIMITIVES};
/// The files of the backgrounds under shaders/background. Kernels switch on the indices.
pub const BACKGROUNDS: &[&str] = &["solid", "gradient", "image"];

/// The reason for features that only `--features all` requires.
pub const EVERY_FEATURE: &str = "--features all";

/// The emitters that are not sampled, so that only BSDF sampling finds them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotSampled {
    /// The number of these lights.
    pub lights: u64,
    /// The number of all lights.
    pub total: u64,
    /// The first of these emitters.
    pub reason: String,
}

/// The features of the renderer that a scene requires, each with the first object that needs it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Features {
    /// Kinds of primitive, by the indices of `PRIMITIVES`.
    pub primitives: [Option<String>; PRIMITIVES.len()],
    /// Kinds of material on objects, by the indices of `MATERIALS`. Unused materials do not count.
    pub materials: [Option<String>; MATERIALS.len()],
    /// Kinds of material on objects that have a lobe that is not specular.
    pub non_specular: [Option<String>; MATERIALS.len()],
    /// Kinds of material on objects that have a specular lobe.
    pub specular: [Option<String>; MATERIALS.len()],
    /// Kinds of material on objects that have a narrow lobe (`Lobe::Narrow`).
    pub narrow: [Option<String>; MATERIALS.len()],
    /// Media with a narrow phase function.
    pub narrow_media: Option<String>,
    /// Kinds of primitive with a smooth pane as material, by the indices of `PRIMITIVES`.
    pub panes: [Option<String>; PRIMITIVES.len()],
    /// Kinds of convex primitive with an alpha.
    pub alpha_bodies: [Option<String>; PRIMITIVES.len()],
    /// Kinds of material on objects that have an extension, by its kind (`ExtensionKind`).
    pub extensions: [[Option<String>; MATERIALS.len()]; EXTENSIONS],
    /// Kinds of transmissive material on objects that have a colour.
    pub tinted: [Option<String>; MATERIALS.len()],
    /// Kinds of material on objects that absorb light inside.
    pub absorbing: [Option<String>; MATERIALS.len()],
    /// Kinds of texture, by the indices of `TEXTURES`.
    pub textures: [Option<String>; TEXTURES.len()],
    /// Formats of texels, by the indices of `FORMATS`.
    pub texel_formats: [Option<String>; FORMATS.len()],
    /// Meshes with vertex normals, which have smooth shading.
    pub smooth: Option<String>,
    /// Images that use further tables of a mesh: other texture coordinates, or tangents.
    pub uv_tables: Option<String>,
    /// Normal maps on meshes with vertex normals, which have tangents.
    pub vertex_tangents: Option<String>,
    /// Boundaries of media, by the indices of `BOUNDARIES`.
    pub boundaries: [Option<String>; BOUNDARIES.len()],
    /// Media whose albedo is a texture.
    pub textured_media: Option<String>,
    /// Kinds of primitive that are sampled as lights, by the indices of `PRIMITIVES`.
    pub emitters: [Option<String>; PRIMITIVES.len()],
    /// Kinds of primitive whose lights are cut into parts.
    pub parted: [Option<String>; PRIMITIVES.len()],
    /// Convex bodies that emit on both sides and have an alpha.
    pub crossed_lights: Option<String>,
    /// Sampled lights whose radiance is a texture.
    pub textured_lights: Option<String>,
    /// Lights without size that are sampled, and those of them that are directional.
    pub delta_lights: Option<String>,
    pub directional_lights: Option<String>,
    /// The background's image, if it is sampled as a light.
    pub emitting_sky: Option<String>,
    /// Columns and rows of the grid over this image, from which directions are sampled.
    pub sky_grid: (u32, u32),
    /// The number of lights.
    pub lights: u32,
    /// A surface that can be specular, if light paths can be traced to such.
    pub light_paths: Option<String>,
    /// The index of the first light without size.
    pub first_delta_light: u32,
    /// The number of boxes at which light paths are aimed.
    pub aims: u32,
    /// The solid angle of the lights at which light paths start, seen from these boxes, in sr: that of one light with the power of all of them, by which
    /// BSDF sampling is as noisy. 0 if one of them has no size.
    pub solid_angle_of_lights: f64,
    /// Emitters that are not sampled, because there are too many.
    pub not_sampled: Option<NotSampled>,
    /// The index of the sky among the lights.
    pub sky_light: u32,
    /// Whether an invocation may have two walks, the second one for a shadow ray. It depends only on the scene, even with
    /// `--features all`.
    pub shadow_rays: bool,
    /// Whether steps of a walk may read a texture, because an alpha has one. It depends only on the scene, too.
    pub alpha_textures: bool,
    /// Whether steps of a walk may look at both sides of a body, because it has an alpha. It depends only on the scene, too.
    pub alpha_on_bodies: bool,
    /// Whether passing a pane may read a texture. It depends only on the scene, too.
    pub pane_textures: bool,
    /// Kinds of primitive that move, and kinds of boundaries of media that do, by the indices of `PRIMITIVES`.
    pub motions: [Option<String>; PRIMITIVES.len()],
    pub moving_boundaries: [Option<String>; PRIMITIVES.len()],
    /// Lights without size that move, media whose texture moves, and a camera that moves.
    pub moving_lights: Option<String>,
    pub moving_media: Option<String>,
    pub moving_camera: Option<String>,
    /// The loop iterations that finding a pose takes at most. It depends only on the scene, too.
    pub motion_iterations: u32,
    /// The number of media.
    pub media: u32,
    /// Kinds of background, by the indices of `BACKGROUNDS`. A scene itself has one.
    pub backgrounds: [Option<String>; BACKGROUNDS.len()],
    /// A lens with a diameter.
    pub thin_lens: Option<String>,
    /// Whether pixels are so narrow that render space has the camera's axes instead of the world's.
    pub camera_axes: Option<String>,
    /// Whether every ray tests all primitives without a hierarchy, because they are few and none is a mesh.
    pub brute_force: bool,
    /// The largest number of nodes on the stack in a walk through the BVH.
    pub stack_size: u32,
    /// The largest number of nodes on the stack in a walk through a mesh that bounds a medium.
    pub boundary_stack_size: u32,
}

impl Features {
    /// The features that a render with these options requires; with `--features all`, everything that a scene can have.
    pub fn with_options(&self, options: &RenderOptions) -> Features {
        let mut features = self.clone();
        if options.features == FeatureSet::All {
            features.add_all(options.integrator == Integrator::Mis);
        }
        features
    }

    /// Adds all features, for `--features all`. Features that select one of two algorithms, such as
    /// the number of lights, do not change, nor do approximations.
    fn add_all(&mut self, sample_lights: bool) {
        let add = |used: &mut Option<String>| {
            used.get_or_insert_with(|| EVERY_FEATURE.to_string());
        };
        let emitters = if sample_lights { self.emitters.as_mut_slice() } else { &mut [] };
        let lists: [&mut [Option<String>]; 10] = [
            &mut self.primitives,
            &mut self.motions,
            &mut self.moving_boundaries,
            &mut self.panes,
            &mut self.alpha_bodies,
            &mut self.materials,
            &mut self.textures,
            &mut self.texel_formats,
            &mut self.boundaries,
            &mut self.backgrounds,
        ];
        lists.into_iter().flatten().chain(emitters).for_each(add);
        [&mut self.smooth, &mut self.textured_media, &mut self.thin_lens, &mut self.camera_axes]
            .into_iter()
            .for_each(add);
        [&mut self.uv_tables, &mut self.vertex_tangents].into_iter().for_each(add);
        [&mut self.moving_media, &mut self.moving_camera].into_iter().for_each(add);
        if sample_lights {
            [&mut self.textured_lights, &mut self.crossed_lights].into_iter().for_each(add);
            KINDS.iter().zip(&mut self.parted).filter(|(kind, _)| kind.has_parts).for_each(|(_, used)| add(used));
            [&mut self.emitting_sky, &mut self.delta_lights, &mut self.directional_lights].into_iter().for_each(add);
            add(&mut self.moving_lights);
            for (lobe, used) in [
                (Lobe::Wide, &mut self.non_specular),
                (Lobe::Narrow, &mut self.narrow),
                (Lobe::Specular, &mut self.specular),
            ] {
                let materials = Material::KINDS.iter().zip(used);
                materials.filter(|(kind, _)| kind.lobes.contains(&lobe)).for_each(|(_, used)| add(used));
            }
            add(&mut self.narrow_media);
        }
        for (number, kind) in Material::KINDS.iter().enumerate() {
            kind.extensions.iter().for_each(|extension| add(&mut self.extensions[*extension as usize][number]));
            if kind.is_transmissive {
                add(&mut self.tinted[number]);
                add(&mut self.absorbing[number]);
            }
        }
        self.brute_force = false;
        // The sky that `require_all` adds is an additional light, which is never chosen.
        if sample_lights && self.sky_grid == (0, 0) {
            self.sky_grid = (1, 1);
            self.sky_light = self.lights;
            self.lights = self.lights.max(1);
        }
        // The stacks for meshes and boundaries are as large as a mesh of millions of faces needs.
        const DEEP: u32 = 16;
        self.stack_size = self.stack_size.max(DEEP);
        self.boundary_stack_size = self.boundary_stack_size.max(DEEP);
    }

    /// Whether a material has an extension.
    pub(super) fn has_extensions(&self) -> bool {
        self.extensions.iter().flatten().chain(&self.absorbing).any(Option::is_some)
    }

    /// Whether a material has an extension of this kind.
    pub(super) fn has_extension(&self, kind: ExtensionKind) -> bool {
        self.extensions[kind as usize].iter().any(Option::is_some)
    }

    /// Whether kernels have code for media.
    pub fn crosses_media(&self) -> bool {
        self.media > 0 || self.boundaries.iter().any(Option::is_some)
    }

    /// Whether anything in the scene has a lobe that is not specular. If nothing does, no light is sampled.
    pub(super) fn samples_light_anywhere(&self) -> bool {
        self.media > 0 || self.non_specular.iter().any(Option::is_some)
    }
}
