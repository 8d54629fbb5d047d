//! `--aov lights`: the light of each group of lights, against scenes in which only its lights are lit.

use std::ops::Range;

use gpu_rt::aov::Aov;
use gpu_rt::film::Film;
use gpu_rt::gpu::link::Library;
use gpu_rt::options::Scatter;

use crate::common::kernel::Overlay;
use crate::common::render::{Change, Request, Shot, render, render_each, render_with, scene};
use crate::common::stats::{mean_and_variance, sidak, welch_t};

/// The lights of the room, each with the strength of its group.
const GROUPS: [&str; 5] = ["background", "glow", "key", "spot", "rest"];
const SEEDS: u32 = 16;

/// Lamps of all kinds: one that light sampling and BSDF sampling find, a surface that emits and scatters, one without a group, a light without size that
/// only light paths bring through the glass, and the sky; with fog.
fn room(strengths: [f64; 5]) -> String {
    let [sky, glow, key, spot, rest] = strengths;
    format!(
        "Scene(
            image: (width: 24, height: 16),
            camera: (look_from: (0, 2, 7), look_at: (0, 1, 0), vertical_fov: 40),
            background: Gradient(bottom: ({sky}, {sky}, {sky}), top: (0, {sky}, {sky})),
            materials: {{
                \"white\": Lambertian(albedo: Rgb(0.7, 0.7, 0.7)),
                \"glass\": Dielectric(ior: 1.5),
                \"key\": DiffuseLight(emit: Rgb({key}, {key}, 0), light_group: \"key\"),
                \"glow\": Lambertian(albedo: Rgb(0.5, 0.2, 0.2), emission: Rgb({glow}, {glow}, {glow}), light_group: \"glow\"),
                \"plain\": DiffuseLight(emit: Rgb({rest}, {rest}, {rest})),
            }},
            objects: [
                Box(min: (-5, -1, -5), max: (5, 0, 5), material: \"white\"),
                Sphere(center: (0, 1, 0), radius: 1, material: \"glass\"),
                Sphere(center: (2, 0.7, 0), radius: 0.7, material: \"glow\"),
                Sphere(center: (-2, 0.7, 0), radius: 0.5, material: \"plain\"),
                Quad(corner: (-1, 3, -2), u: (2, 0, 0), v: (0, 0, 2), material: \"key\"),
                PointLight(at: (3, 3, 3), intensity: ({spot}, {spot}, {spot}), light_group: \"spot\"),
                Medium(boundary: Sphere(center: (0, 1, 2), radius: 1), density: 0.3, albedo: Rgb(1, 1, 1)),
            ],
            render: (samples: 16, max_depth: 6),
        )"
    )
}

const STRENGTHS: [f64; 5] = [0.3, 0.4, 6.0, 8.0, 3.0];

fn request(samples: u32) -> Request {
    Request::spp(samples).mis().light_paths(2)
}

fn grouped(request: Request) -> Request {
    request.with(|options| options.aov.set(vec![Aov::Lights]))
}

/// The light of a group, of each pixel by channel.
fn light(film: &Film, group: &str) -> Vec<f64> {
    let channels = film.aovs().channels();
    let own = channels.iter().filter(|channel| channel.name.starts_with(&format!("light_{group}.")));
    let own: Vec<_> = own.collect();
    assert_eq!(own.len(), 3, "{group}: {channels:?}");
    let pixels = 0..film.width() as usize * film.height() as usize;
    pixels.flat_map(|pixel| own.iter().map(move |channel| f64::from(film.channel(pixel, channel)))).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn values(shot: &Shot) -> Vec<f64> {
    shot.picture.rgb.as_flattened().iter().map(|v| f64::from(*v)).collect()
}

/// A mean for each seed, of each group.
type Means = [Vec<f64>; 5];

fn means_of_groups(library: Option<&dyn Library>) -> Means {
    let mut means = Means::default();
    each_seed(&room(STRENGTHS), &grouped(request(16)), 0..SEEDS, library, |shot| {
        GROUPS.iter().zip(&mut means).for_each(|(group, means)| means.push(mean(&light(&shot.film, group))));
    });
    means
}

/// Renders a scene by each of these seeds. Its kernels are compiled once: drivers keep the memory of each that they have compiled.
fn each_seed(text: &str, request: &Request, seeds: Range<u32>, library: Option<&dyn Library>, take: impl FnMut(Shot)) {
    let samples = request.samples.clone().expect("they are given");
    let change = Change { library, ..Change::default() };
    render_with(&scene(text), request, seeds.map(|seed| (seed, samples.clone())), &change, take);
}

/// Those of images in which only the lights of the group are lit.
fn means_alone() -> Means {
    [0, 1, 2, 3, 4].map(|lit| {
        let mut strengths = [0.0; 5];
        strengths[lit] = STRENGTHS[lit];
        let mut means = Vec::new();
        each_seed(&room(strengths), &request(16), SEEDS..2 * SEEDS, None, |shot| means.push(mean(&values(&shot))));
        means
    })
}

/// Why groups have not the light of their lights; a false alarm once in a million times.
fn check(groups: &Means, alone: &Means) -> Result<(), String> {
    let threshold = sidak(1e-6, GROUPS.len());
    for (group, (own, alone)) in GROUPS.iter().zip(groups.iter().zip(alone)) {
        let found = welch_t(own, alone);
        println!("{group}: {:.5} {found:?}", mean(own));
        // The test sees a tenth of the light.
        let error = (mean_and_variance(alone).1 / f64::from(SEEDS)).sqrt();
        assert!(error < 0.015 * mean(alone), "{group}: {error} of {}", mean(alone));
        if found.p < threshold {
            return Err(format!("{group}: {found:?}"));
        }
    }
    Ok(())
}

/// Each group has the light that its lights alone would give. A group whose light paths, whose emission, or whose shadow rays do not count is found.
#[test]
fn a_group_has_the_light_of_its_lights() {
    let alone = means_alone();
    check(&means_of_groups(None), &alone).unwrap();
    for (module, from, to) in [
        ("light_path/splat_lights", "value[i], SUM_FRACTION", "0.0, SUM_FRACTION"),
        ("step/surface_emission", "record_light(path, hit, limited);", ""),
        ("step/scatter", "record_light(path, hit, limited_indirect((*path).throughput, depth));", ""),
        ("step/light", "record_light(path, hit, limited_light(contribution));", ""),
        ("step/refill", "record_light(path, hit_at(HIT_NOTHING, VERY_FAR)", "record_light(path, hit_at(0u, VERY_FAR)"),
    ] {
        let planted = Overlay::new(&[]).rewritten(module, |text| {
            assert!(text.contains(from), "{module}");
            text.replace(from, to)
        });
        assert!(check(&means_of_groups(Some(&planted)), &alone).is_err(), "{module}");
    }
}

/// The groups and the rest add up to the radiance in each pixel, whose bits are those of a render without groups.
#[test]
fn groups_add_up_and_change_nothing() {
    for scatter in [Scatter::Fused, Scatter::Linked, Scatter::Queues] {
        for light_paths in [0, 2] {
            let request = request(16).light_paths(light_paths).scatter(scatter);
            let shot = render(&scene(&room(STRENGTHS)), &grouped(request.clone()));
            assert_eq!(shot.bits(), render(&scene(&room(STRENGTHS)), &request).bits());
            let groups = GROUPS.map(|group| light(&shot.film, group));
            for (index, value) in values(&shot).into_iter().enumerate() {
                let sum: f64 = groups.iter().map(|light| light[index]).sum();
                assert!((sum - value).abs() <= 1e-6 * value, "{index}: {sum} for {value}");
            }
            // Without a light of its own, there is no rest but rounding, which counts as 0.
            let [sky, glow, key, spot, _] = STRENGTHS;
            let all_grouped = render(&scene(&room([sky, glow, key, spot, 0.0])), &grouped(request));
            assert!(light(&all_grouped.film, "rest").iter().all(|rest| *rest == 0.0));
        }
    }
}

/// The sums of parts are those of the whole.
#[test]
fn groups_of_parts_are_joined() {
    let scene = scene(&room(STRENGTHS));
    let parts = render_each(&scene, &grouped(request(32)), &[0..8, 8..16, 16..32]);
    let whole = render(&scene, &grouped(request(32))).film;
    let mut joined = parts[2].film.clone();
    parts[..2].iter().for_each(|part| joined.merge(&part.film).expect("they are of one image"));
    assert!(joined == whole);
    // A film without groups is another one.
    assert!(joined.merge(&render(&scene, &request(8)).film).is_err());
}

/// Of a mix, the variance by its halves is that of images of many seeds; with all factors 1 it is the image's own.
#[test]
fn the_variance_of_a_mix_is_that_of_many_seeds() {
    const RENDERS: u32 = 48;
    let factors = [[0.5; 3], [0.0; 3], [2.0, 1.0, 1.0], [3.0; 3], [1.0; 3]];
    let (mut stated, mut mixes) = (0.0, Vec::new());
    each_seed(&room(STRENGTHS), &grouped(request(16).sobol()), 0..RENDERS, None, |shot| {
        let film = &shot.film;
        let groups = GROUPS.map(|group| light(film, group));
        let pixels = groups[0].len() / 3;
        let variance =
            |index, factors: &[[f64; 3]]| film.variance_of_mix(index, factors).expect("both halves are there");
        for index in 0..pixels {
            for (own, of_mix) in film.developed(index).variance.into_iter().zip(variance(index, &[[1.0; 3]; 5])) {
                assert!((f64::from(own) - of_mix).abs() <= 1e-6 * of_mix + 1e-20, "{own} {of_mix}");
            }
        }
        stated += (0..pixels).map(|index| variance(index, &factors).iter().sum::<f64>()).sum::<f64>();
        let mix = |value: usize| (0..5).map(|group| factors[group][value % 3] * groups[group][value]).sum::<f64>();
        mixes.push((0..3 * pixels).map(mix).collect::<Vec<f64>>());
    });
    let of_value = |value: usize| mean_and_variance(&mixes.iter().map(|mix| mix[value]).collect::<Vec<_>>()).1;
    let found: f64 = (0..mixes[0].len()).map(of_value).sum();
    let ratio = stated / f64::from(RENDERS) / found;
    // A sum over 384 pixels whose noise is alike and whose halves have one degree of freedom, of 48 renders: with tails as of rare paths, each side
    // is known to 4 %; four times that.
    println!("{ratio}");
    assert!((0.84..1.16).contains(&ratio), "{ratio}");
    // A mix of other factors has another variance.
    assert!(!(0.84..1.16).contains(&(ratio * 1.5)));
}
