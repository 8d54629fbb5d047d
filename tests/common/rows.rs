//! Rows that test kernels take and give, where several tests run them.

use gpu_rt::data::Material;

use super::kernel::Expression;

/// Rows of a kernel's input or output, as WGSL lays them out: a line has 16 bytes. All fields are public.
macro_rules! rows {
    ($($(#[$doc:meta])* $vis:vis struct $name:ident { $($(#[$of_field:meta])* $field:ident: $kind:ty),* $(,)? })*) => { $(
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
        $vis struct $name {
            $($(#[$of_field])* pub $field: $kind),*
        }
    )* };
}
pub(crate) use rows;

rows! {
    /// The input of tests/shaders/scatter.wgsl: a ray that hits a surface.
    pub struct SurfaceHit {
        incoming: [f32; 3], front: u32,
        normal: [f32; 3], padding0: u32,
        colour: [f32; 3], padding1: u32,
        u: [f32; 4],
        material: Material,
    }

    /// Its output.
    pub struct Answer {
        direction: [f32; 3], event: u32,
        weight: [f32; 3], padding: u32,
    }
}

/// Glass with the host's constants, rounded from f64.
pub fn glass(ior: f64) -> Material {
    let inside = 1.0 / ior;
    Material {
        numbers: [ior as f32, ((ior - 1.0) * (ior + 1.0)) as f32, ((inside - 1.0) * (inside + 1.0)) as f32],
        ..Material::default()
    }
}

rows! {
    /// What tests/shaders/sampling.wgsl gives.
    pub struct Maps {
        disk: [f32; 2], circle: [f32; 2],
        hemisphere: [f32; 3], root: f32,
        sphere: [f32; 3], padding0: u32,
        ball: [f32; 3], padding1: u32,
    }

    /// Random bits of a key, the uniforms of the key (pixel, sample, dimension, seed), and the key itself taken for random bits.
    pub struct Words {
        bits: [u32; 4],
        u: [f32; 4],
        direct: [f32; 4],
    }

    /// What tests/shaders/colour.wgsl takes: a ray, and what it meets.
    pub struct Aimed {
        origin: [f32; 3], code: u32,
        direction: [f32; 3], padding: u32,
    }

    /// A pixel, and the points in it and on the lens.
    pub struct OnFilm {
        column: u32, row: u32, padding: [u32; 2],
        u: [f32; 4],
    }

    pub struct CameraRay {
        origin: [f32; 3], padding0: u32,
        direction: [f32; 3], padding1: u32,
    }

    /// The output of tests/shaders/projection.wgsl: a ray, the point of the film where it is seen, and its density.
    pub struct SeenRay {
        origin: [f32; 3], density: f32,
        direction: [f32; 3], padding: u32,
        point: [f32; 2], padding1: [u32; 2],
    }

    /// A point of a pixel, and its weight.
    pub struct FilterPoint { point: [f32; 2], weight: f32, padding: u32 }
}

/// What gives [`Words`].
pub const WORDS: Expression<'_> = [
    "sampler/independent",
    "vec4<u32>",
    "array<vec4<u32>, 3>",
    "array(pcg4d(given), bitcast<vec4<u32>>(random4(given.x, given.y, given.z, given.w)),
        bitcast<vec4<u32>>(unit_interval(given)))",
];
