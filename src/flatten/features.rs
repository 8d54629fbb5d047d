//! The features of the renderer that a scene requires: facts, each with the object that brings it, and quantities.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use crate::bitmap::FORMATS;
use crate::lobe::transmission::TRANSMISSION;
use crate::lobe::{lobe_of, rows};
use crate::material::{LobeWidth, MATERIALS, Material, MaterialKind};
use crate::options::{FeatureSet, Integrator, RenderOptions};
use crate::shape::{KINDS, ShapeKind};
use crate::texture::TEXTURES;

pub use crate::shape::{BOUNDARIES, PRIMITIVES};
/// The files of the backgrounds under shaders/background. Kernels switch on the indices.
pub const BACKGROUNDS: &[&str] = &["solid", "gradient", "image", "octahedral"];

/// The files of the densities that vary under shaders/medium. Kernels switch on the indices plus 1.
pub const FIELDS: &[&str] = &["height", "grid"];

/// The films that are no plane at distance 1.
const PROJECTIONS: &[&str] = &["orthographic", "equirectangular", "fisheye", "calibrated", "calibrated_fisheye"];

/// The reason for features that only `--features all` requires.
pub const EVERY_FEATURE: &str = "--features all";

/// Whether `--features all` adds facts. It adds none that chooses between algorithms.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Added {
    Never,
    Always,
    /// Where light is sampled.
    Lit,
}

/// A fact that scenes bring, or a group of facts.
pub struct Declared {
    pub name: &'static str,
    /// The kinds that may have it: that quads move is the fact `moves.quad`. None for a single fact.
    pub kinds: Vec<&'static str>,
    /// The group of which the same kind holds, too: what moves is a shape of the scene.
    needs: Option<&'static str>,
    /// The feature's name in `plan`, and the module that is linked for it alone; `{}` stands for the kind.
    pub feature: Option<(&'static str, &'static str)>,
    added: Added,
}

/// All facts that scenes bring.
pub static DECLARED: LazyLock<Vec<Declared>> = LazyLock::new(|| {
    let none = Vec::new;
    let shapes = || PRIMITIVES.to_vec();
    let group = |name, kinds, added| Declared { name, kinds, needs: None, feature: None, added };
    let named =
        |name, kinds, added, label, module| Declared { feature: Some((label, module)), ..group(name, kinds, added) };
    let those_shapes =
        |can: fn(&ShapeKind) -> bool| KINDS.iter().filter(|kind| can(kind)).map(|kind| kind.shader).collect::<Vec<_>>();
    let of_shapes = |name, can, added| Declared { needs: Some("shape"), ..group(name, those_shapes(can), added) };
    let of_materials = |name, added, can: &dyn Fn(&MaterialKind) -> bool| {
        let those = Material::KINDS.iter().filter(|kind| can(kind)).map(|kind| kind.shader);
        Declared { needs: Some("material"), ..group(name, those.collect(), added) }
    };
    let labelled = |declared, label, module| Declared { feature: Some((label, module)), ..declared };
    let boundaries = || BOUNDARIES.iter().map(|(name, _)| *name).collect();
    use Added::{Always, Lit, Never};
    let mut all = vec![
        named("shape", shapes(), Always, "{}", "geometry/{}"),
        // Meshes with vertex normals.
        named("smooth", none(), Always, "smooth shading", "scene/smooth_shading"),
        named("material", MATERIALS.to_vec(), Always, "{}", "material/{}"),
        // Materials on objects, by the lobes that they have.
        of_materials("wide_lobe", Lit, &|kind| kind.widths.contains(&LobeWidth::Wide)),
        of_materials("narrow_lobe", Lit, &|kind| kind.widths.contains(&LobeWidth::Narrow)),
        of_materials("specular_lobe", Lit, &|kind| kind.widths.contains(&LobeWidth::Specular)),
        // Transmissive materials with a colour; materials that absorb light inside.
        of_materials("tinted", Always, &|kind| kind.is_transmissive),
        of_materials("absorbing", Always, &|kind| kind.is_transmissive || kind.can_have(TRANSMISSION)),
        // Shapes whose material is a smooth pane; panes with a texture.
        labelled(of_shapes("smooth_pane", |_| true, Always), "{} pane", "step/panes"),
        group("textured_pane", none(), Always),
        // Convex shapes with an alpha.
        of_shapes("body_with_alpha", |kind| kind.encloses(), Always),
        named("texture", TEXTURES.to_vec(), Always, "{} texture", "texture/{}"),
        // Materials with a number that is that of an image.
        group("number_images", none(), Always),
        // Formats of texels.
        group("texel", FORMATS.to_vec(), Always),
        // Images that use further tables of a mesh: other texture coordinates, or tangents; and those that do not repeat on a mesh.
        group("uv_tables", none(), Always),
        named("image_wrap", none(), Always, "image wrap", "scene/image_wrap"),
        // Normal maps on meshes with vertex normals, which have tangents.
        group("vertex_tangents", none(), Always),
        named("boundary", boundaries(), Always, "{} medium", "medium/{}"),
        // Media with a narrow phase function, and media whose albedo is a texture.
        group("narrow_medium", none(), Lit),
        named("textured_medium", none(), Always, "textured medium", "scene/textured_medium"),
        // Densities that vary.
        named("varying", FIELDS.to_vec(), Never, "{} density", "medium/{}"),
        // Media that emit; those that do as black bodies.
        named("medium_emission", none(), Never, "medium emission", "step/medium_emission"),
        named("blackbody", none(), Never, "blackbody", "scene/heat"),
        // Shapes that are sampled as lights; those whose lights are cut into parts; convex ones that emit on both sides and have an alpha; those
        // whose radiance is a texture.
        labelled(of_shapes("area_light", |_| true, Lit), "{} light", "light/{}"),
        named("textured_light", none(), Lit, "textured light", "scene/textured_light"),
        Declared {
            needs: Some("area_light"),
            ..named("parted", those_shapes(|kind| kind.has_parts), Lit, "light in parts", "scene/light_parts")
        },
        named("crossed_light", none(), Lit, "light with two sides and an alpha", "scene/light_crossings"),
        // Lights without size that are sampled, those of them that are directional, and beams with another falloff than glTF's.
        named("delta_light", none(), Lit, "delta light", "light/delta"),
        group("directional_light", none(), Lit),
        named("falloff", none(), Lit, "falloff", "light/falloff"),
        // The background's image, if it is sampled as a light.
        named("sky_light", none(), Lit, "sky light", "scene/sky"),
        // Emitters that are not sampled, because there are too many.
        group("not_sampled", none(), Always),
        // A surface that can be specular, if light paths can be traced to such.
        group("light_paths", none(), Never),
        named("background", BACKGROUNDS.to_vec(), Always, "{} background", "background/{}"),
        named("lens", none(), Always, "thin lens", "camera/thin_lens"),
        // Films that are no plane at distance 1: each scene has one.
        named("projection", PROJECTIONS.to_vec(), Never, "{} camera", "camera/{}"),
        // The camera of a page, which its reader moves.
        named("placed", none(), Always, "camera of a page", "camera/placed"),
        // Pixels are so narrow that render space has the camera's axes instead of the world's, or the background is turned.
        named("camera_axes", none(), Always, "turned axes", "scene/camera_axes"),
        // What moves: shapes, boundaries of media, lights without size, media with a texture, and the camera.
        labelled(of_shapes("moves", |_| true, Always), "{} motion", "motion/{}"),
        named(
            "boundary_moves",
            those_shapes(|kind| kind.boundary.is_some()),
            Always,
            "{} boundary motion",
            "motion/boundaries",
        ),
        named("moving_light", none(), Lit, "delta light motion", "motion/delta_light"),
        named("moving_medium", none(), Always, "medium motion", "motion/medium"),
        named("moving_camera", none(), Always, "camera motion", "camera/moving"),
    ];
    all.extend(rows().map(|row| Declared {
        feature: lobe_of(row.name).and_then(|lobe| Some((lobe.label?, "lobe/{}"))),
        ..of_materials(row.name, Always, &|own| own.can_have(row))
    }));
    all
});

impl Declared {
    /// The group, or the fact, of this name.
    pub fn of(name: &str) -> Option<&'static Declared> {
        DECLARED.iter().find(|declared| declared.name == name)
    }

    /// Whether the kinds are those of materials.
    pub fn is_of_materials(&self) -> bool {
        self.name == "material" || self.needs == Some("material")
    }

    /// The facts of the group, or the fact alone.
    pub fn facts(&self) -> impl Iterator<Item = String> {
        let alone = self.kinds.is_empty().then(|| self.name.to_string());
        alone.into_iter().chain(self.kinds.iter().map(|kind| format!("{}.{kind}", self.name)))
    }
}

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

/// The numbers of a scene that kernels are written with.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Quantities {
    /// Columns and rows of the grid over the background's image, from which directions are sampled.
    pub sky_grid: (u32, u32),
    /// The number of lights.
    pub lights: u32,
    /// The index of the sky among the lights.
    pub sky_light: u32,
    /// The index of the first light without size.
    pub first_delta_light: u32,
    /// The number of lights without size that are sampled.
    pub delta_lights: u32,
    /// The number of boxes at which light paths are aimed.
    pub aims: u32,
    /// The solid angle of the lights at which light paths start, seen from these boxes, in sr: that of one light with the power of all of them, by which
    /// BSDF sampling is as noisy. 0 if one of them has no size.
    pub solid_angle_of_lights: f64,
    /// The model of a fisheye lens: its number in [`FisheyeModel`](crate::scene::FisheyeModel).
    pub fisheye: u32,
    /// The number of media.
    pub media: u32,
    /// Whether every ray tests all primitives without a hierarchy, because they are few and none is a mesh.
    pub brute_force: bool,
    /// The largest number of nodes on the stack in a walk through the BVH.
    pub stack_size: u32,
    /// The largest number of nodes on the stack in a walk through a mesh that bounds a medium.
    pub boundary_stack_size: u32,
    /// Whether an invocation may have two walks, the second one for a shadow ray. It and what follows depend only on the scene, even with
    /// `--features all`.
    pub shadow_rays: bool,
    /// Whether steps of a walk may read a texture, because an alpha has one.
    pub alpha_textures: bool,
    /// Whether steps of a walk may look at both sides of a body, because it has an alpha.
    pub alpha_on_bodies: bool,
    /// Whether passing a pane may read a texture.
    pub pane_textures: bool,
    /// The loop iterations that finding a pose takes at most.
    pub motion_iterations: u32,
}

/// The features of the renderer that a scene requires.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Features {
    /// The facts that hold, each with the first object that brings it.
    facts: BTreeMap<String, String>,
    pub quantities: Quantities,
    /// Emitters that are not sampled, because there are too many.
    pub not_sampled: Option<NotSampled>,
}

impl Features {
    /// Notes a fact of [`DECLARED`] and those that it needs, unless another object has brought it.
    pub fn require(&mut self, fact: impl Into<String>, by: impl FnOnce() -> String) {
        let fact = fact.into();
        if self.facts.contains_key(&fact) {
            return;
        }
        let by = by();
        let (group, kind) = fact.split_once('.').unwrap_or((&fact, ""));
        let declared = Declared::of(group);
        debug_assert!(declared.is_some_and(|own| own.facts().any(|own| own == fact)), "{fact} is not declared");
        if let Some(needed) = declared.and_then(|declared| declared.needs) {
            self.facts.entry(format!("{needed}.{kind}")).or_insert_with(|| by.clone());
        }
        self.facts.insert(fact, by);
    }

    /// Takes a fact back.
    pub fn forget(&mut self, fact: &str) {
        self.facts.remove(fact);
    }

    /// The object that brings a fact.
    pub fn reason(&self, fact: &str) -> Option<&String> {
        self.facts.get(fact)
    }

    /// The first object that brings a fact of a group.
    pub fn any(&self, group: &str) -> Option<&String> {
        Declared::of(group)?.facts().find_map(|fact| self.reason(&fact))
    }

    /// The features that a render with these options requires; with `--features all`, everything that a scene can have.
    pub fn with_options(&self, options: &RenderOptions) -> Features {
        let mut features = self.clone();
        if options.features == FeatureSet::All {
            features.add_all(options.integrator == Integrator::Mis);
        }
        features
    }

    fn add_all(&mut self, sample_lights: bool) {
        let is_added = |declared: &&Declared| match declared.added {
            Added::Never => false,
            Added::Always => true,
            Added::Lit => sample_lights,
        };
        let added = DECLARED.iter().filter(is_added).flat_map(Declared::facts);
        added.for_each(|fact| self.require(fact, || EVERY_FEATURE.to_string()));
        let own = &mut self.quantities;
        own.brute_force = false;
        // The sky that `require_all` adds is an additional light, which is never chosen.
        if sample_lights && own.sky_grid == (0, 0) {
            own.sky_grid = (1, 1);
            own.sky_light = own.lights;
            own.lights = own.lights.max(1);
        }
        // The stacks for meshes and boundaries are as large as a mesh of millions of faces needs.
        const DEEP: u32 = 16;
        own.stack_size = own.stack_size.max(DEEP);
        own.boundary_stack_size = own.boundary_stack_size.max(DEEP);
    }

    /// Whether a material has an extension.
    pub(super) fn has_extensions(&self) -> bool {
        self.any("absorbing").is_some() || rows().any(|row| self.any(row.name).is_some())
    }

    /// Whether kernels have code for media.
    pub fn crosses_media(&self) -> bool {
        self.quantities.media > 0 || self.any("boundary").is_some()
    }

    /// Whether anything in the scene has a lobe that is not specular. If nothing does, no light is sampled.
    pub(super) fn samples_light_anywhere(&self) -> bool {
        self.quantities.media > 0 || self.any("wide_lobe").is_some()
    }
}
