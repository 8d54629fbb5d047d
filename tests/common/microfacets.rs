//! Materials of microfacets: their formulas in f64 as the papers have them, and the rows of tests/shaders/rough.wgsl.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use glam::DVec3;
use gpu_rt::data::{self, NO_TEXTURE};
use gpu_rt::gpu::link::{Choices, Embedded, Entry, Library, Reason, When};
use gpu_rt::lobe::{LOBES, Lobe};
use gpu_rt::material::microfacets::directional_albedos;
use gpu_rt::material::{Distribution, Material, Plastic};

use super::kernel::{Kernel, Plant, Setup, array};
use super::rows::{glass, rows};
use super::stats::Random;
use super::vectors::{U, exact, rounded, unit};

pub const SCATTERED: u32 = data::SCATTERED;
pub const ABSORBED: u32 = data::ABSORBED;
/// The lobe of one direction.
pub const SPECULAR: u32 = data::LOBE_SPECULAR;

rows! {
    /// What tests/shaders/rough.wgsl takes. `followed` is the channel of dispersion.
    pub struct In {
        incoming: [f32; 3], front: u32,
        normal: [f32; 3], followed: f32,
        colour: [f32; 3], padding1: u32,
        light: [f32; 3], compensation: f32,
        u: [f32; 4],
        material: data::Material,
        second: data::Material,
        f0: [f32; 3], f90: f32,
        lobes: Lobes,
        coat_normal: [f32; 3], padding2: u32,
        tangent: [f32; 3], beckmann: f32,
    }

    /// As `generated/lobes` has it. `anisotropy` is the square of the strength.
    #[derive(PartialEq)]
    pub struct Lobes {
        coat: f32, coat_roughness: f32, coat_f0: f32, padding1: f32,
        sheen: [f32; 3], sheen_roughness: f32,
        transmission: f32, padding2: f32, contrasts: [f32; 2],
        ior: f32, anisotropy: f32, film: f32, film_ior: f32,
        film_thickness: f32, padding3: [f32; 3],
        colour_through: [f32; 3], through: f32,
        dispersion: f32, padding4: [f32; 3],
    }

    /// What it gives: the lobe of the direction that it drew (shaders/data/material), and the share of the pdf that narrow lobes have.
    pub struct Out {
        direction: [f32; 3], event: u32,
        weight: [f32; 3], pdf: f32,
        value: [f32; 3], non_specular: u32,
        lobe: u32, narrow: f32, padding: [u32; 2],
    }
}

/// The density as papers write it, by 1 - cos^2, and shadowing without the heights' correlation.
pub const BY_PAPERS: [Plant; 2] = [
    ("lib/microfacet", "dot(across, across)", "dot(along, along) - height * height"),
    (
        "lib/microfacet",
        "cos_light * (cos_view + root_view) / (cos_light * root_view + cos_view * smith_root(cos_light, alpha))",
        "2.0 * cos_light / (cos_light + smith_root(cos_light, alpha))",
    ),
];

/// The F90 of a row of glTF's material whose layer is that of its index.
pub const NO_LAYER: f32 = -1.0;

/// The kernel of a material with some of the modules that a scene may choose. It answers a row for its own uniforms; or many times, for
/// independent ones.
pub fn kernel(material: &str, with: &[&str]) -> Kernel {
    kernel_with(material, with, &Setup::default())
}

/// The same with what is planted.
pub fn kernel_with(material: &str, with: &[&str], setup: &Setup<'_>) -> Kernel {
    let heads = Embedded.heads().choices().values().flat_map(|choice| &choice.heads);
    let those =
        heads.filter(|head| with.contains(&&*head.module)).flat_map(|head| head.when.iter().flat_map(When::facts));
    let layers = LOBES.iter().filter(|lobe| lobe.is_layer && with.contains(&&*format!("lobe/{}", lobe.name())));
    let entry =
        |lobe: &&Lobe| Entry { name: lobe.name().to_string(), number: 0, closes: false, why: Reason::EveryRender };
    let layers: Vec<_> = layers.map(entry).collect();
    let facts: Vec<_> = those.map(|fact| (fact, true)).collect();
    let inner = layers.iter().rev().cloned().collect();
    let plan = Choices { lists: BTreeMap::from([("layer", layers), ("inner_layer", inner)]), ..Choices::default() };
    let Setup { replaced, plants, .. } = *setup;
    let values = [("material", material)];
    Kernel::with("test/rough", &Setup { replaced, plants, values: &values, facts: &facts, plan })
}

/// What single scattering by microfacets keeps, and behind it what sheen reflects, as kernels have it.
pub fn albedo_table() -> &'static [[f32; 4]] {
    static TABLE: OnceLock<Vec<[f32; 4]>> = OnceLock::new();
    let tables = || LOBES.iter().filter_map(|lobe| lobe.table).flat_map(|table| table());
    let fours =
        |one: &OnePlastic| one.table.chunks(4).map(|four| [0, 1, 2, 3].map(|i| four[i] as f32)).collect::<Vec<_>>();
    let layers = || plastics().iter().flat_map(fours);
    TABLE.get_or_init(|| directional_albedos().iter().chain(tables()).copied().chain(layers()).collect())
}

/// A plastic, the share of its body's light that leaves its layer times the index squared, and the table of what its layer lets pass.
pub struct OnePlastic {
    pub own: Plastic,
    pub leaving: f64,
    pub table: Vec<f64>,
}

/// Plastics of some roughnesses, of both distributions.
pub fn plastics() -> &'static [OnePlastic] {
    static ALL: OnceLock<Vec<OnePlastic>> = OnceLock::new();
    let numbers = || [0.0, 0.1, 0.5, 1.0].into_iter().flat_map(|rough| [(rough, 1.5), (rough, 1.1), (rough, 2.4)]);
    let one = |(roughness, ior): (f64, f64)| {
        let distribution = if ior == 1.1 { "Beckmann" } else { "Ggx" };
        let text = format!("(diffuse: Rgb(0, 0, 0), ior: {ior}, roughness: {roughness}, distribution: {distribution})");
        let Ok(Material::Plastic(own)) = ron::from_str(&format!("Plastic{text}")) else { panic!("{text}") };
        let (leaving, table) = (*own.layer()).clone();
        OnePlastic { own, leaving, table }
    };
    ALL.get_or_init(|| numbers().map(one).collect())
}

/// The plastic of this number on the device.
pub fn plastic(row: In, number: usize, nonlinear: bool) -> In {
    let OnePlastic { own, leaving, .. } = &plastics()[number];
    let behind: usize = plastics()[number..].iter().map(|one| one.table.len()).sum();
    let numbers = [own.roughness as f32, ((own.ior - 1.0) * (own.ior + 1.0)) as f32, *leaving as f32];
    let second = [f32::from(u8::from(nonlinear)), (4 * albedo_table().len() - behind) as f32, 0.0];
    let beckmann = f32::from(u8::from(own.distribution == Distribution::Beckmann));
    let with = |numbers| data::Material { numbers, ..data::Material::default() };
    In { material: with(numbers), second: with(second), beckmann, ..row }
}

/// So many answers to rows, as many to each.
pub fn answers(kernel: &Kernel, rows: &[In], count: usize) -> Vec<Out> {
    let with_layer = |row: &In| match row.f90 == NO_LAYER {
        true => In { f0: [row.material.numbers[1]; 3], f90: 1.0, ..*row },
        false => *row,
    };
    let rows: Vec<In> = rows.iter().map(with_layer).collect();
    kernel.run_with(&rows, count, &[array("directional_albedos", albedo_table())])
}

/// The unit vectors to the view and along the normal, of the rounded ones of a row.
pub fn view_and_normal(row: &In) -> (DVec3, DVec3) {
    (-exact(row.incoming).normalize(), exact(row.normal).normalize())
}

/// A ray that meets a surface from its front, at an angle with its normal.
pub fn arriving(random: &mut Random, cos: f64) -> In {
    let normal = unit(random);
    let across = normal.cross(unit(random)).normalize();
    let incoming = ((1.0 - cos * cos).sqrt() * across - cos * normal).normalize();
    In { incoming: rounded(incoming), normal: rounded(normal), front: 1, colour: [1.0; 3], ..In::default() }
}

/// Uniforms as the device makes them, of which some are at the ends of their range.
pub fn uniforms(random: &mut Random, number: usize) -> [f32; 4] {
    [0, 1, 2, 3].map(|at: usize| match number >> (2 * at) & 7 {
        0 => 0.0,
        1 => 1.0 - U as f32,
        _ => (random.bits() >> 40) as f32 * U as f32,
    })
}

/// A metal of this roughness on the device: of an albedo, or of an index with this k.
pub fn conductor(row: In, roughness: f64, k: Option<[f32; 3]>) -> In {
    let material = data::Material { numbers: [roughness as f32, 0.0, 0.0], ..data::Material::default() };
    let second = data::Material {
        colour: k.unwrap_or_default(),
        numbers: [f32::from(u8::from(k.is_some())), 0.0, 0.0],
        texture: NO_TEXTURE,
        ..data::Material::default()
    };
    In { material, second, ..row }
}

/// A thin pane of this index and roughness on the device.
pub fn pane(row: In, ior: f64, roughness: f64) -> In {
    let mut material = glass(ior);
    material.numbers[0] = roughness as f32;
    In { material, ..row }
}

/// A rough boundary of this index and roughness on the device.
pub fn frosted(row: In, ior: f64, roughness: f64) -> In {
    let second = data::Material { numbers: [ior as f32, 0.0, 0.0], texture: NO_TEXTURE, ..data::Material::default() };
    In { second, ..pane(row, ior, roughness) }
}

/// The density of microfacet normals at an angle with the surface's normal: equation 33 of Walter et al., EGSR 2007.
pub fn density(sin: f64, cos: f64, alpha: f64) -> f64 {
    let tan2 = (sin / cos).powi(2);
    (alpha * cos * cos * (1.0 + tan2 / (alpha * alpha))).powi(-2) / PI
}

/// Smith's Lambda: Heitz, JCGT 3(2), 2014, equation 72.
pub fn lambda(cos: f64, alpha: f64) -> f64 {
    let tan2 = (1.0 - cos * cos).max(0.0) / (cos * cos);
    0.5 * ((1.0 + alpha * alpha * tan2).sqrt() - 1.0)
}

/// The visible share of the microfacets.
pub fn masking(cos: f64, alpha: f64) -> f64 {
    1.0 / (1.0 + lambda(cos, alpha))
}

/// The share that is visible from both directions: correlated heights, equation 99 of the same.
pub fn shadowing(cos: f64, other: f64, alpha: f64) -> f64 {
    1.0 / (1.0 + lambda(cos, alpha) + lambda(other, alpha))
}

/// The density of microfacet normals `facet` as the view sees them, per solid angle.
pub fn visible(facet: DVec3, view: DVec3, normal: DVec3, alpha: f64) -> f64 {
    let cos = facet.dot(normal);
    if cos <= 0.0 {
        return 0.0;
    }
    let sin = facet.cross(normal).length();
    masking(view.dot(normal), alpha) * density(sin, cos, alpha) * view.dot(facet).max(0.0) / view.dot(normal)
}

/// What a metal reflects per channel for an index eta + i k: Fresnel's formulas in complex numbers.
pub fn metal_reflectance(cos: f64, eta: f64, k: f64) -> f64 {
    type Complex = (f64, f64);
    let times = |a: Complex, b: Complex| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
    let square = |a: Complex| a.0 * a.0 + a.1 * a.1;
    let index2 = times((eta, k), (eta, k));
    let under = (index2.0 - (1.0 - cos * cos), index2.1);
    let modulus = under.0.hypot(under.1);
    let root = ((0.5 * (modulus + under.0)).max(0.0).sqrt(), (0.5 * (modulus - under.0)).max(0.0).sqrt());
    let s = square((cos - root.0, -root.1)) / square((cos + root.0, root.1));
    let along = (index2.0 * cos, index2.1 * cos);
    let p = square((along.0 - root.0, along.1 - root.1)) / square((along.0 + root.0, along.1 + root.1));
    0.5 * (s + p)
}

/// Schlick's approximation.
pub fn schlick(cos: f64, f0: f64) -> f64 {
    f0 + (1.0 - f0) * (1.0 - cos).powi(5)
}

/// Microfacets in cells. By area, `s = tan² / (alpha² + tan²)` is uniform. The rings are even in `1 - sqrt(1 - s)`, because the view
/// sees grazing microfacets by their tangent. The azimuth counts from the side of the view.
pub struct Facets {
    pub alpha: f64,
    pub cos_view: f64,
}

impl Facets {
    pub const RINGS: usize = 31;
    pub const SECTORS: usize = 17;
    pub const COUNT: usize = Facets::RINGS * Facets::SECTORS;
    /// Midpoints each way within a cell.
    const STEPS: usize = 24;

    /// The view, in the space whose z is the normal.
    pub fn view(&self) -> DVec3 {
        DVec3::new((1.0 - self.cos_view * self.cos_view).max(0.0).sqrt(), 0.0, self.cos_view)
    }

    /// The cell of a microfacet normal in that space.
    pub fn cell(&self, facet: DVec3) -> usize {
        let tan2 = (facet.x * facet.x + facet.y * facet.y) / (facet.z * facet.z * self.alpha * self.alpha);
        let azimuth = facet.y.atan2(facet.x);
        let bin = |x: f64, bins: usize| ((x * bins as f64) as usize).min(bins - 1);
        bin(1.0 - 1.0 / (1.0 + tan2).sqrt(), Facets::RINGS) * Facets::SECTORS
            + bin((azimuth + PI) / TAU, Facets::SECTORS)
    }

    /// Calls with each cell, microfacet normal, and the share of the visible ones that it stands for. `true_alpha` is the
    /// surface's: another one plants a wrong lobe.
    pub fn integrate(&self, true_alpha: f64, mut add: impl FnMut(usize, DVec3, f64)) {
        let (rings, sectors) = (Facets::RINGS * Facets::STEPS, Facets::SECTORS * Facets::STEPS);
        let view = self.view();
        for ring in 0..rings {
            let left = 1.0 - (ring as f64 + 0.5) / rings as f64;
            let tan = self.alpha * (1.0 - left * left).sqrt() / left;
            let cos = 1.0 / (1.0 + tan * tan).sqrt();
            let sin = tan * cos;
            // The solid angle of one midpoint is ds dphi / (2 pi D cos).
            let weight = 2.0 * left / (rings * sectors) as f64 / (density(sin, cos, self.alpha) * cos);
            for sector in 0..sectors {
                let azimuth = TAU * (sector as f64 + 0.5) / sectors as f64 - PI;
                let facet = DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos);
                let cell = ring / Facets::STEPS * Facets::SECTORS + sector / Facets::STEPS;
                add(cell, facet, weight * visible(facet, view, DVec3::Z, true_alpha));
            }
        }
    }
}

/// The share of light that comes back under one angle: what single scattering keeps.
pub fn directional_albedo(facets: &Facets) -> f64 {
    let view = facets.view();
    let mut sum = 0.0;
    facets.integrate(facets.alpha, |_, facet, share| {
        let cos_light = 2.0 * view.dot(facet) * facet.z - view.z;
        if cos_light > 0.0 {
            sum += share * shadowing(view.z, cos_light, facets.alpha) / masking(view.z, facets.alpha);
        }
    });
    sum
}

/// The axes of the space in which the normal is z and the view has no y: rows of (x, y, z).
pub fn axes(normal: DVec3, view: DVec3) -> [DVec3; 3] {
    let across = view - view.dot(normal) * normal;
    let across = if across.length() > 1e-9 { across.normalize() } else { normal.any_orthonormal_vector() };
    [across, normal.cross(across), normal]
}

/// A vector in such a space.
pub fn within(axes: &[DVec3; 3], v: DVec3) -> DVec3 {
    DVec3::from_array(axes.map(|axis| axis.dot(v)))
}
