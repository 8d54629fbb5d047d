//! The lobes of materials: which of them a kernel draws from, and which the host expects of it.

use std::path::Path;

use gpu_rt::bitmap::Bitmaps;
use gpu_rt::data;
use gpu_rt::data::NARROW_LOBE;
use gpu_rt::material::LobeWidth;
use gpu_rt::scene::{Material, Scene};

use crate::common::microfacets::{
    ABSORBED, In, Lobes, Out, answers, arriving, conductor, frosted, kernel, pane, uniforms,
};
use crate::common::stats::Random;
use crate::common::vectors::{U, decades, exact, rounded};
use crate::pbr_lobes::ALL;

const LOBES: [LobeWidth; 3] = [LobeWidth::Wide, LobeWidth::Narrow, LobeWidth::Specular];

/// A material of a scene file.
fn material(text: &str) -> Material {
    let scene = format!(
        "Scene(image: (width: 1, height: 1), camera: (look_from: (0, 0, 1), look_at: (0, 0, 0), vertical_fov: 40),
        background: Solid((0, 0, 0)), materials: {{ \"it\": {text} }}, objects: [])"
    );
    let scene = Scene::parse(&scene, Path::new("test.ron")).unwrap_or_else(|error| panic!("{error}\n{text}"));
    scene.materials.into_iter().next().expect("it has one").1
}

/// A kind of material: its shader, what the scene file says of one with a roughness, and its row on the device.
type Kind = (&'static str, fn(f64) -> String, fn(In, f64) -> In);

const KINDS: [Kind; 11] = [
    (
        "conductor",
        |roughness| format!("Conductor(albedo: Rgb(0.9, 0.9, 0.9), roughness: {roughness})"),
        |row, roughness| conductor(row, roughness, None),
    ),
    (
        "rough_dielectric",
        |roughness| format!("RoughDielectric(ior: 1.5, roughness: {roughness})"),
        |row, roughness| frosted(row, 1.5, roughness),
    ),
    (
        "rough_dielectric",
        |roughness| format!("RoughDielectric(ior: 1.01, roughness: {roughness})"),
        |row, roughness| frosted(row, 1.01, roughness),
    ),
    (
        "thin_dielectric",
        |roughness| format!("ThinDielectric(roughness: {roughness})"),
        |row, roughness| pane(row, 1.5, roughness),
    ),
    ("pbr", |roughness| format!("Pbr(metallic: 0, roughness: {roughness})"), |row, roughness| pbr(row, 0.0, roughness)),
    ("pbr", |roughness| format!("Pbr(metallic: 1, roughness: {roughness})"), |row, roughness| pbr(row, 1.0, roughness)),
    // A coat of index 3 around a mirror, whose roughness is that of the coat.
    (
        "pbr",
        |roughness| format!("Pbr(metallic: 1, roughness: 0, coat: 1, coat_ior: 3, coat_roughness: {roughness})"),
        |row, roughness| {
            let lobes = Lobes { coat: 1.0, coat_roughness: roughness as f32, coat_f0: 0.25, ..Lobes::default() };
            In { lobes, coat_normal: row.normal, ..pbr(row, 1.0, 0.0) }
        },
    ),
    (
        "pbr",
        |roughness| format!("Pbr(metallic: 1, roughness: {roughness}, sheen: Rgb(1, 1, 1), sheen_roughness: 1)"),
        |row, roughness| {
            let lobes = Lobes { sheen: [1.0; 3], sheen_roughness: 1.0, ..Lobes::default() };
            In { lobes, ..pbr(row, 1.0, roughness) }
        },
    ),
    (
        "pbr",
        |roughness| format!("Pbr(metallic: 0, roughness: {roughness}, transmission: 1)"),
        |row, roughness| {
            let contrasts = [1.25, 1.0 / 2.25 - 1.0];
            In { lobes: Lobes { transmission: 1.0, contrasts, ..Lobes::default() }, ..pbr(row, 0.0, roughness) }
        },
    ),
    (
        "pbr",
        |roughness| format!("Pbr(metallic: 0, roughness: {roughness}, transmission: 0.5)"),
        |row, roughness| {
            let contrasts = [1.25, 1.0 / 2.25 - 1.0];
            In { lobes: Lobes { transmission: 0.5, contrasts, ..Lobes::default() }, ..pbr(row, 0.0, roughness) }
        },
    ),
    // Rougher along a direction by so little that lobes may still be narrow. The device makes none of them smooth.
    (
        "conductor",
        |roughness| format!("Conductor(albedo: Rgb(0.9, 0.9, 0.9), roughness: {roughness}, anisotropy: 0.1)"),
        |row, roughness| {
            let tangent = rounded(exact(row.normal).any_orthonormal_vector());
            let lobes = Lobes { anisotropy: 0.01, ..Lobes::default() };
            In { lobes, tangent, ..conductor(row, roughness.max(1.0 / 1024.0), None) }
        },
    ),
];

fn pbr(row: In, metallic: f32, roughness: f64) -> In {
    let layer = 0.2f32.powi(2);
    let material = data::Material { numbers: [roughness as f32, layer, metallic], ..data::Material::default() };
    In { material, ..row }
}

/// Kernels link the counting of hidden light only where the host knows of a lobe that hides light, and light sampling only where it knows of
/// one that does not. So each lobe that a kernel draws from is one that the host has, and each that the host has is drawn from.
#[test]
fn the_host_knows_the_lobes_that_kernels_draw_from() {
    const DRAWS: usize = 256;
    let mut random = Random(301);
    let roughnesses: Vec<f64> = (0..60).map(|i| if i == 0 { 0.0 } else { decades(&mut random, -3.5, 0.0) }).collect();
    let (mut seen, mut planted) = ([0; 3], 0);
    for (shader, text, row) in KINDS {
        let rows: Vec<In> = { roughnesses.iter() }
            .flat_map(|roughness| std::iter::repeat_n(*roughness, DRAWS))
            .enumerate()
            .map(|(i, roughness)| {
                let cos = 0.3 + 0.7 * random.uniform();
                let front = i as u32 % 2;
                In { front, u: uniforms(&mut random, usize::MAX), ..row(arriving(&mut random, cos), roughness) }
            })
            .collect();
        let found = answers(&kernel(shader, &ALL), &rows, rows.len());
        for (roughness, answers) in roughnesses.iter().zip(found.chunks(DRAWS)) {
            let material = material(&text(*roughness));
            let known = material.widths(&Bitmaps::default());
            let of = |out: &Out| LOBES[out.lobe as usize];
            let drawn: Vec<LobeWidth> = answers.iter().filter(|out| out.event != ABSORBED).map(of).collect();
            let what = format!("{}: {known:?}", text(*roughness));
            assert!(drawn.iter().all(|lobe| known.contains(lobe)), "{what}, drawn {drawn:?}");
            // Glass reflects so rarely that not all of its lobes are drawn.
            let is_glass = shader == "rough_dielectric";
            assert!(is_glass || known.iter().all(|lobe| drawn.contains(lobe)), "{what}, drawn {drawn:?}");
            let samples_lights = known.iter().any(|lobe| *lobe != LobeWidth::Specular);
            assert!(answers.iter().all(|out| (out.non_specular == 1) == samples_lights), "{what}");
            // Where there is one lobe, the response is all its own.
            for out in answers.iter().filter(|out| out.event != ABSORBED && samples_lights && out.pdf > 0.0) {
                // The share is a quotient, which WGSL allows to be 2.5 ULP off.
                let (narrow, off) = (f64::from(out.narrow), 5.0 * U);
                let is_own = (narrow - f64::from(u8::from(of(out) == LobeWidth::Narrow))).abs() <= off;
                assert!(if known.len() == 1 { is_own } else { (0.0..=1.0 + off).contains(&narrow) }, "{what}: {out:?}");
            }
            drawn.iter().for_each(|lobe| seen[*lobe as usize] += 1);
            // The planted error: what the host would say of another roughness.
            let other = self::material(&text((10.0 * roughness + 0.02).min(1.0))).widths(&Bitmaps::default());
            planted += usize::from(drawn.iter().any(|lobe| !other.contains(lobe)));
        }
    }
    assert!(seen.iter().all(|count| *count > 200) && planted > 20, "{seen:?}, {planted}");
}

/// A lobe of the limit's width: half of its directions are within about this angle of its axis, as the limit says.
#[test]
fn the_width_of_a_lobe_is_the_angle_that_half_of_its_directions_keep() {
    const DRAWS: usize = 1 << 14;
    let mut random = Random(303);
    // 2 alpha is the limit.
    let roughness = f64::from(NARROW_LOBE / 2.0).sqrt();
    let straight = arriving(&mut random, 1.0);
    for (shader, row, width) in [
        ("conductor", conductor(straight, roughness, None), f64::from(NARROW_LOBE)),
        ("thin_dielectric", pane(straight, 1.5, roughness), f64::from(NARROW_LOBE)),
        // Refraction turns a ray by 1 - 1/1.5 of its microfacet's angle, and the few reflected rays go back.
        ("rough_dielectric", frosted(straight, 1.5, roughness), f64::from(NARROW_LOBE) / 6.0),
    ] {
        let axis = exact(row.incoming).normalize();
        let found = kernel(shader, &[]).run_with::<_, Out>(&[row], DRAWS, &[]);
        let angle = |out: &Out| axis.cross(exact(out.direction)).length().asin();
        let within = |width: f64| found.iter().filter(|out| angle(out) < width).count() as f64 / DRAWS as f64;
        // 16,384 draws give a share to 0.4 %. The tangent for the angle, and reflected rays at glass, are 2 %.
        assert!((within(width) - 0.5).abs() < 0.04, "{shader}: {}", within(width));
        assert!((within(1.2 * width) - 0.5).abs() > 0.04, "{shader}: a lobe of another width is not told from it");
    }
}
