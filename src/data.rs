//! The host's side of the structs under shaders/data, and the little that all of the host shares. WGSL is the source of the
//! structs; tests/kernels/layout.rs compares every field here with naga's reflection of it.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// The bit of a primitive's code that distinguishes it from a BVH node's index.
pub const PRIMITIVE_BIT: u32 = 0x8000_0000;
/// The bit position of the kind within a primitive's code.
pub const PRIMITIVE_KIND_SHIFT: u32 = 27;
/// The most primitives of one kind.
pub const MAX_PRIMITIVES: usize = 1 << PRIMITIVE_KIND_SHIFT;
/// The kinds of codes that have to do with meshes: a face, and an instance of a mesh.
pub const KIND_TRIANGLE: u32 = 3;
pub const KIND_INSTANCE: u32 = 14;
/// The kind of codes of lights without size.
pub const KIND_DELTA_LIGHT: u32 = 13;
/// The instance of what is no part of a mesh.
pub const NO_INSTANCE: u32 = 0xffff_ffff;
/// `Instance::to_uvs` of a mesh without texture coordinates.
pub const NO_UVS: u32 = 0xffff_ffff;
/// The normal of a vertex of a flat-shaded mesh.
pub const NO_NORMAL: u32 = 0x8000_8000;
/// The code of no primitive: a ray that leaves the scene; the root of a scene without objects.
pub const HIT_NOTHING: u32 = 0xffff_ffff;
/// The code of a slot without a run.
pub const SLOT_IDLE: u32 = 0xffff_fffd;
/// Instead of a primitive's index among the lights: it emits, and is not sampled.
pub const NOT_SAMPLED: u32 = 0x8000_0000;
/// `Light::part` of an entry that stands for the parts of its shape, and of a convex body whose sides both emit and let light pass.
pub const PARTS: u32 = 0xffff_ffff;
pub const CROSSED: u32 = 0x8000_0000;
/// In the order of an object: it moves.
pub const MOVES: u32 = 0x8000_0000;
/// `Material::texture` where the colour is the material's own.
pub const NO_TEXTURE: u32 = 0xffff_ffff;
/// Instead of the second face of a `FacePair` that has one.
pub const NO_FACE: u32 = 0;
/// Instead of the index of a row that the material does not have.
pub const NO_EXTENSION: u32 = 0xffff_ffff;
/// Of `LightNode::child`: it is a light, not a pair of nodes; what it leads to shines on both sides; it is the sky or
/// directional lights.
pub const LIGHT_NODE_LEAF: u32 = 0x8000_0000;
pub const LIGHT_NODE_TWO_SIDED: u32 = 0x4000_0000;
pub const LIGHT_NODE_SKY: u32 = 0x2000_0000;
/// Samples of a run at most; runs are cut at multiples of it.
pub const RUN_LENGTH: u32 = 8;
/// Rows of the strips in which pixels are handed out.
pub const STRIP_ROWS: u32 = 8;
/// In the counts of a run: it is an odd one.
pub const ODD_RUN: u32 = 0x8000_0000;
/// The indices in `Counters::counts` of camera samples, rays, paths that max_depth ended, the throughput of these, and light paths of even
/// runs; those of odd runs follow.
pub const PATHS: u32 = 0;
pub const RAYS: u32 = 1;
pub const TOO_DEEP: u32 = 2;
pub const TOO_DEEP_THROUGHPUT: u32 = 3;
pub const LIGHT_PATHS: u32 = 4;
/// Bits after the binary point of the film's sums of radiance, in device units, and of its sums of squares, in device units squared.
pub const SUM_FRACTION: u32 = 88;
pub const SQUARE_FRACTION: u32 = 96;
/// Sums of radiance and of its squares that the film has of each pixel: of even runs, of odd ones, and the squared deviations.
pub const FILM_SUMS: usize = 3 * CHANNELS.len();
/// Sums of splats that a film with light paths has of each pixel: of even runs, of odd ones, and the squares.
pub const SPLAT_SUMS: usize = 3 * CHANNELS.len();
/// Bins that count the light that narrow lobes hide from light sampling.
pub const LIGHT_BINS: usize = 32;
/// Words before the first queue.
pub const QUEUE_HEADER: u32 = 8;

/// The colour channels of records, film and images, by the names that an EXR has for them.
pub const CHANNELS: [&str; 3] = ["R", "G", "B"];
/// A value for each of them.
pub type Rgb<T> = [T; CHANNELS.len()];

/// The variance of the samples of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleVariance {
    /// The variance of a sample, radiance squared; infinite if it is not known.
    pub variance: Rgb<f32>,
    /// The degrees of freedom of this estimate.
    pub degrees: u32,
    pub samples: u32,
}

/// A pixel that lamps cover in part, as the camera would see them if nothing hid them. Radiance is in device units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "LampPixelNumbers", into = "LampPixelNumbers")]
pub struct LampPixel {
    /// The pixel's index.
    pub pixel: u32,
    /// How many pixels it stands for.
    pub count: f32,
    /// The lamp that adds most.
    pub lamp: u32,
    /// The share of its samples that see a lamp.
    pub share: f32,
    /// The mean of the radiance that its samples see of lamps, and of the square.
    pub mean: Rgb<f32>,
    pub square: Rgb<f32>,
}

/// Its members in their order, without names: files may have a thousand of them.
type LampPixelNumbers = (u32, f32, u32, f32, Rgb<f32>, Rgb<f32>);

impl From<LampPixel> for LampPixelNumbers {
    fn from(LampPixel { pixel, count, lamp, share, mean, square }: LampPixel) -> LampPixelNumbers {
        (pixel, count, lamp, share, mean, square)
    }
}

impl From<LampPixelNumbers> for LampPixel {
    fn from((pixel, count, lamp, share, mean, square): LampPixelNumbers) -> LampPixel {
        LampPixel { pixel, count, lamp, share, mean, square }
    }
}

/// The code of the primitive at this index among its kind.
pub fn primitive_code(kind: u32, index: u32) -> u32 {
    PRIMITIVE_BIT | kind << PRIMITIVE_KIND_SHIFT | index
}

/// Luminance of a linear Rec. 709 colour (ITU-R BT.709-6, item 3.2).
pub fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

pub fn f32s(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

/// Clamped to 0..1; 0 of a NaN.
pub fn unit(value: f64) -> f64 {
    if value > 0.0 { value.min(1.0) } else { 0.0 }
}

/// The sRGB transfer function (IEC 61966-2-1:1999), linear 0..1 to encoded 0..1.
pub fn srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// How the samples of a pixel are chosen: a file of shaders/sampler.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sampler {
    /// Each by itself.
    #[default]
    Independent,
    /// Owen-scrambled Sobol points, in two halves: even and odd runs.
    Sobol,
}

impl Sampler {
    /// Whether a pixel's samples are independent: their deviations give the variance of their mean, which falls as 1/N. Otherwise the two
    /// halves of the runs give it, and it may fall faster.
    pub fn is_independent(self) -> bool {
        self == Sampler::Independent
    }
}

/// Declares a struct for the device, with its fields' names kept for the layout test.
macro_rules! device_struct {
    ($(#[$meta:meta])* $name:ident { $($field:ident: $ty:ty,)* }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
        pub struct $name { $(pub $field: $ty,)* }

        impl $name {
            /// Name, offset and bytes of each field.
            pub const FIELDS: &'static [(&'static str, usize, usize)] = &[
                $((stringify!($field), std::mem::offset_of!($name, $field), std::mem::size_of::<$ty>()),)*
            ];
        }
    };
}

device_struct!(
    /// The settings of a render. Kernels have the members that they need, each found by its name ([`crate::gpu::layout::pack`]).
    Settings {
        forward: [f32; 3],
        image_width: u32,
        pixel_x: [f32; 3],
        image_height: u32,
        pixel_y: [f32; 3],
        max_depth: u32,
        seed: u32,
        first_sample: u32,
        end_sample: u32,
        slots: u32,
        background_bottom: [f32; 3],
        root: u32,
        film_left: u32,
        film_top: u32,
        film_width: u32,
        film_height: u32,
        lens_x: [f32; 3],
        inverse_focus: f32,
        lens_y: [f32; 3],
        background_width: u32,
        background_height: u32,
        background_texel: u32,
        background_format: u32,
        background_top: [f32; 3],
        world_x: [f32; 3],
        world_y: [f32; 3],
        world_z: [f32; 3],
        indirect_limit: f32,
        brute_force: [u32; 4],
        background: u32,
        light_paths: u32,
        zero: u32,
    }
);

device_struct!(
    /// The runs that may be started now.
    Window { first_block: u32, end: u32, bounces: u32, first_pixel: u32, pixels: u32, begins: u32, receipt: u32, first_slot: u32,
        end_slot: u32, }
);

device_struct!(
    /// What the device counts for the host.
    Counters {
        next: u32,
        records: u32,
        idle: u32,
        nan: u32,
        infinite: u32,
        cut: u32,
        refused: u32,
        receipt: u32,
        counts: [[u32; 2]; 6],
        light: [[[u32; 2]; 2]; LIGHT_BINS],
    }
);

device_struct!(
    /// A finished run, on its way to the film.
    RunRecord {
        sum_r: f32,
        sum_g: f32,
        sum_b: f32,
        pixel: u32,
        counts: u32,
        rays: u32,
        squares_r: f32,
        squares_g: f32,
        squares_b: f32,
    }
);

device_struct!(
    /// What the film on the device holds of a pixel. The sums of further channels follow, where there are any.
    PixelTotals {
        samples: [u32; 2],
        runs: u32,
        rejected: u32,
        saturated: u32,
        sums: [[u32; 4]; FILM_SUMS],
    }
);

device_struct!(
    /// A node of the BVH: the boxes of up to four children on a grid of the node's own.
    Node {
        grid: [u32; 4],
        low: [u32; 3],
        padding0: u32,
        high: [u32; 3],
        padding1: u32,
        children: [u32; 4],
    }
);

device_struct!(
    /// Two faces of a mesh that share two corners, or one face.
    FacePair { a: [u32; 4], b: [u32; 4], c: [u32; 4], d: [u32; 4], }
);

device_struct!(
    /// A sphere, in render space.
    Sphere {
        center: [f32; 3],
        radius: f32,
        order: u32,
        material: u32,
        frame: u32,
        light: u32,
    }
);

device_struct!(
    /// A sphere by its point nearest to the camera, in render space.
    LargeSphere {
        nearest: [f32; 3],
        curvature: f32,
        inward: [f32; 3],
        order: u32,
        material: u32,
        frame: u32,
        light: u32,
        follows_nearest: u32,
    }
);

device_struct!(
    /// A parallelogram, in render space.
    Quad {
        corner: [f32; 3],
        order: u32,
        normal: [f32; 3],
        material: u32,
        a_axis: [f32; 3],
        frame: u32,
        b_axis: [f32; 3],
        error: f32,
        u: [f32; 3],
        light: u32,
        v: [f32; 3],
        error_across: f32,
    }
);

device_struct!(
    /// A rotated box, in render space.
    Cuboid {
        center: [f32; 3],
        order: u32,
        half_extent: [f32; 3],
        material: u32,
        x_axis: [f32; 3],
        frame: u32,
        y_axis: [f32; 3],
        light: u32,
    }
);

device_struct!(
    /// An instance of a mesh, in render space.
    Instance {
        x_axis: [f32; 3],
        order: u32,
        y_axis: [f32; 3],
        material: u32,
        translation: [f32; 3],
        frame: u32,
        scale: f32,
        to_light: u32,
        root: u32,
        to_uvs: u32,
    }
);

/// The elements of all shapes.
#[derive(Clone, Debug, Default)]
pub struct Tables {
    pub spheres: Vec<Sphere>,
    pub quads: Vec<Quad>,
    pub cuboids: Vec<Cuboid>,
    pub instances: Vec<Instance>,
    pub large_spheres: Vec<LargeSphere>,
    pub disks: Vec<Quad>,
}

device_struct!(
    /// A participating medium, in render space.
    Medium {
        center: [f32; 3],
        density: f32,
        colour: [f32; 3],
        texture: u32,
        boundary: u32,
        frame: u32,
        anisotropy: f32,
        one_minus_anisotropy: f32,
    }
);

device_struct!(
    /// Something that is sampled as a light.
    Light {
        code: u32,
        instance: u32,
        trail: u32,
        part: u32,
    }
);

device_struct!(
    /// A light without size, in render space.
    DeltaLight {
        position: [f32; 3],
        has_position: f32,
        colour: [f32; 3],
        height: f32,
        axis: [f32; 3],
        slope: f32,
    }
);

device_struct!(
    /// A node of the tree over the lights.
    LightNode {
        center: [f32; 3],
        radius: f32,
        intensity: f32,
        axis: u32,
        cos_half_angle: f32,
        child: u32,
    }
);

device_struct!(
    /// An entry of a table for the alias method: a light as the start of light paths.
    AliasEntry {
        threshold: f32,
        alias_index: u32,
        density: f32,
        alias_density: f32,
    }
);

device_struct!(
    /// A material.
    Material {
        colour: [f32; 3],
        kind: u32,
        numbers: [f32; 3],
        texture: u32,
    }
);

device_struct!(
    /// A texture.
    Texture {
        first: [f32; 3],
        kind: u32,
        second: [f32; 3],
        parameter: f32,
        texel: u32,
        width: u32,
        height: u32,
        format: u32,
    }
);

device_struct!(
    /// The map from a primitive's own coordinates to a texture's.
    Frame {
        x: [f32; 3],
        phase: f32,
        y: [f32; 3],
        padding0: u32,
        z: [f32; 3],
        padding1: u32,
        origin: [f32; 3],
        padding2: u32,
    }
);

device_struct!(
    /// One line of the numerics probe's questions.
    Trial {
        x: f32,
        y: f32,
        product: f32,
        angle: f32,
        far_angle: f32,
        log_of: f32,
        word: u32,
        special: u32,
        least: u32,
        subnormal: u32,
        zero: u32,
        loops: u32,
        p_x: f32,
        p_y: f32,
        q_x: f32,
        q_y: f32,
    }
);

device_struct!(
    /// What the driver makes of one.
    Answer {
        sum_error: u32,
        sum_error_barrier: u32,
        product_error_barrier: u32,
        fma_error: u32,
        contracted: u32,
        sine: u32,
        far_sine: u32,
        logarithm: u32,
        converted: u32,
        uniform_of_32: u32,
        uniform_of_24: u32,
        classes_of_special: u32,
        made_subnormal: u32,
        from_subnormal: u32,
        edge_sign: i32,
        loop_state: u32,
    }
);
