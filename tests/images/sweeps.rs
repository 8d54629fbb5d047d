//! What a sweep over settings says of them: planted biases are found, noise is not called a bias, and what paths seldom meet is not known.

use crate::common::device;
use crate::common::render::{Request, render};
use crate::common::sweeps::{ROOM, SKY, judged, lamp, measure, plant, scene, unbiased};

use gpu_rt::metrics::error::floor_of;
use gpu_rt::options::{CLAMP, LIGHT_PATHS, LightPaths, RenderOptions, SIZE};
use gpu_rt::tradeoff::extent::FullSize;
use gpu_rt::tradeoff::judge::{judge, recommended};
use gpu_rt::tradeoff::replicates::{Pixels, Weights, squared_bias};
use gpu_rt::tradeoff::sweep::{Setting, Sweep};
use gpu_rt::tradeoff::truth::Truth;

/// A box with a glass sphere below a tiny lamp: most of the noise is in rare bright paths.
const CAUSTIC: &str = "Scene(
    image: (width: 24, height: 24),
    camera: (look_from: (0, 1.4, 4.5), look_at: (0, 0.4, 0), vertical_fov: 20),
    background: Solid((0.01, 0.01, 0.01)),
    materials: {
        \"wall\": Lambertian(albedo: Rgb(0.9, 0.8, 0.85)), \"glass\": Dielectric(ior: 1.5),
        \"lamp\": DiffuseLight(emit: Rgb(300000, 250000, 200000)),
    },
    objects: [
        Quad(corner: (-1, 0, -1), u: (0, 0, 2), v: (2, 0, 0), material: \"wall\"),
        Quad(corner: (-1, 0, -1), u: (2, 0, 0), v: (0, 2, 0), material: \"wall\"),
        Quad(corner: (-1, 0, 1), u: (0, 0, -2), v: (0, 2, 0), material: \"wall\"),
        Quad(corner: (1, 0, -1), u: (0, 0, 2), v: (0, 2, 0), material: \"wall\"),
        Sphere(center: (0, 0.5, 0), radius: 0.4, material: \"glass\"), Sphere(center: (0, 1.7, 0), radius: 0.01, material: \"lamp\"),
    ],
    render: (samples: 64, max_depth: 20),
)";

const SMOKE: &str = "Scene(
    image: (width: 48, height: 48),
    camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40),
    background: Solid((0.3, 0.4, 0.5)),
    materials: { \"lamp\": DiffuseLight(emit: Rgb(5, 5, 5)) },
    objects: [
        Medium(boundary: Sphere(center: (0, 0, 0), radius: 1.2), density: 1.5, albedo: Rgb(0.9, 0.8, 0.7)),
        Sphere(center: (2, 1.5, 0), radius: 0.4, material: \"lamp\"),
    ],
    render: (samples: 16, max_depth: 20),
)";

/// 0.5 % darker, then brighter, in a setting whose images are else those of the defaults, and in one that shares none of their random numbers.
/// Of that the mean of 16 rounds is known to 0.15 % or better on these scenes (asserted), so that 0.5 % is 3.3 standard errors or more; at 15
/// degrees of freedom and two settings it is found above 2.9 (Šidák): two times in three, and in all but 1 of 10^4 times where it is 6 and more.
/// The numbers of samples and rounds decide that, and the seeds are pinned.
#[test]
fn a_planted_bias_is_found_with_its_sign_and_size() {
    for (name, text) in [("room", ROOM), ("sky", SKY), ("smoke", SMOKE)] {
        let scene = scene(text);
        let mut sweep = Sweep::new(device::software(), &scene, (48, 48), 0);
        let [defaults, .., independent] = &unbiased(&scene)[..] else { panic!("there are several") };
        // A limit that does next to nothing here.
        let clamp = Setting {
            option: Some(&CLAMP),
            value: "1e6".into(),
            options: RenderOptions { clamp: Some(1e6), ..RenderOptions::default() },
            ..defaults.clone()
        };
        for setting in [defaults, &clamp, independent] {
            sweep.add(setting.clone()).expect("it compiles");
        }
        measure(&mut sweep, 1000, 16);
        // Without it there is none.
        let usual = judged(&mut sweep, None).measured;
        assert!(usual.len() == 3 && usual.iter().all(|measured| !measured.biased), "{name}: {usual:?}");
        for (subject, bias) in [(1, -0.005f32), (1, 0.005), (2, -0.005), (2, 0.005)] {
            let before = plant(&mut sweep, subject, 1.0 + bias);
            let found = judged(&mut sweep, None).measured;
            sweep.subjects[subject].blocks = before;
            let (found, usual) = (&found[subject], &usual[subject]);
            let (value, half) = (found.signed.value, found.signed.half_width());
            let why = format!("{name}, {bias}: {value} ± {half}, {} rounds", found.rounds);
            assert!(found.signed.error < 0.0015, "{why}");
            assert!(found.biased && value * f64::from(bias) > 0.0 && found.verdict().contains("biased"), "{why}");
            // What was planted is all that is new, in the mean and, at the least, in its interval: 0.5 % of what was there.
            assert!((value - usual.signed.value - f64::from(bias)).abs() < 1e-4, "{why}");
            assert!((value - f64::from(bias)).abs() <= half + 2e-5, "{why}");
        }
    }
}

/// A lamp that a scattered ray meets once in 24,000 times, in 4,000, and in 1,000: each of 120 sweeps may have a false alarm with a probability of
/// 5 %, and more than 20 have one once in 2e6 times. A rate of 25 % would be found in 98 of 100 times, one of 15 % in 26. What is stated is that
/// the noise is not known: of a setting like that a defect is hardly seen. Planted is eight times as much light of the largest lamp, which
/// more sweeps of 40 call biased than may have an alarm of 120.
#[test]
fn paths_that_seldom_meet_a_lamp_are_no_defect() {
    const SWEEPS: u32 = 40;
    const ALARMS: u32 = 20;
    let (mut alarms, mut planted) = (0, 0);
    for radius in [0.02, 0.05, 0.1] {
        let scene = scene(&lamp(radius, 24));
        let mut sweep = Sweep::new(device::software(), &scene, (24, 24), 0);
        unbiased(&scene).into_iter().take(2).for_each(|setting| sweep.add(setting).expect("it compiles"));
        let mut unreliable = 0;
        for number in 0..SWEEPS {
            measure(&mut sweep, 1 + 1000 * number, 8);
            let found = judged(&mut sweep, None).measured;
            let [defaults, bsdf] = &found[..] else { panic!("{found:?}") };
            assert!(defaults.reliable && bsdf.squared.upper() >= 0.0, "{found:?}");
            alarms += u32::from(bsdf.biased);
            if radius == 0.1 {
                plant(&mut sweep, 1, 8.0);
                planted += u32::from(judged(&mut sweep, None).measured[1].biased);
            }
            unreliable += u32::from(!bsdf.reliable);
        }
        println!("radius {radius}: {alarms} alarms so far, {planted} of what is planted; {unreliable} unreliable");
        assert!(unreliable >= 3 * SWEEPS / 4, "{radius}: {unreliable} unreliable");
    }
    assert!(alarms <= ALARMS, "{alarms} called biased");
    assert!(planted > ALARMS, "eight times as much light is found {planted} times");
}

/// Under a sky all noise is known, but what paths never meet is not noise: a setting that lacks the light of a tiny lamp is never advised, and is
/// no defect. The defaults sample the lamp.
#[test]
fn a_lamp_that_nobody_meets_under_a_sky_is_missed() {
    let text = "Scene(
        image: (width: 32, height: 24),
        camera: (look_from: (0, 2, 5), look_at: (0, 0, 0), vertical_fov: 40),
        background: Solid((0.2, 0.2, 0.2)),
        materials: { \"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)), \"lamp\": DiffuseLight(emit: Rgb(1e6, 1e6, 1e6)) },
        objects: [
            Quad(corner: (-4, 0, 4), u: (8, 0, 0), v: (0, 0, -8), material: \"grey\"),
            Sphere(center: (0, 3, 0), radius: 0.001, material: \"lamp\"),
        ],
        render: (samples: 64, max_depth: 8),
    )";
    let measured = |text: &str| {
        let scene = scene(text);
        let mut sweep = Sweep::new(device::software(), &scene, (32, 24), 0);
        unbiased(&scene).into_iter().take(2).for_each(|setting| sweep.add(setting).expect("it compiles"));
        measure(&mut sweep, 1, 8);
        judged(&mut sweep, None).measured
    };
    let found = measured(text);
    let [defaults, bsdf] = &found[..] else { panic!("{found:?}") };
    assert!(defaults.reliable && !defaults.lacks_paths, "{defaults:?}");
    assert!(bsdf.noise_error < 0.2 && bsdf.signed.value < -0.05 && !bsdf.biased, "{bsdf:?}");
    assert!(bsdf.lacks_paths && !bsdf.reliable && bsdf.verdict().contains("may have missed"), "{bsdf:?}");
    assert!(recommended(&found).iter().all(|best| best.is_some_and(|best| best.setting.option.is_none())));
    // Without the lamp both have the same image, and either may be advised.
    let found = measured(&text.replace("1e6", "1"));
    assert!(found.iter().all(|measured| measured.reliable && !measured.lacks_paths), "{found:?}");
}

/// What a limit takes is what paths bring that the defaults have seldom met: neither is known, and no limit is advised.
#[test]
fn a_bias_against_what_is_not_known_is_not_known() {
    let scene = scene(CAUSTIC);
    let mut defaults = unbiased(&scene).remove(0);
    // Light paths would find the caustic.
    defaults.options.light_paths = LightPaths::Off;
    let mut sweep = Sweep::new(device::software(), &scene, (24, 24), 0);
    sweep.add(defaults.clone()).expect("it compiles");
    for value in ["1", "10"] {
        let options = RenderOptions { clamp: value.parse().ok(), ..defaults.options.clone() };
        sweep
            .add(Setting { option: Some(&CLAMP), value: value.into(), options, ..defaults.clone() })
            .expect("it compiles");
    }
    measure(&mut sweep, 1, 8);
    let found = judged(&mut sweep, None).measured;
    assert!(found.len() == 3 && !found[0].reliable, "{found:?}");
    for clamp in &found[1..] {
        // Its own noise is small, and known.
        assert!(clamp.noise_error < 0.2 && !clamp.bias_known && !clamp.reliable, "{clamp:?}");
        assert!(clamp.verdict().contains("unreliable: the image that it is compared with is too noisy"));
    }
    assert!(recommended(&found).iter().all(Option::is_none));
    // A reference with little noise makes biases known, unless its header calls its error unreliable.
    let request = Request { options: RenderOptions::default(), ..Request::spp(1024).seed(9).size(24, 24) };
    let picture = render(&scene, &request).picture;
    for (reliable, known) in [(None, true), (Some(true), true), (Some(false), false)] {
        let (image, variance) = (picture.rgb.clone(), Some(picture.variance.clone()));
        let found = judged(&mut sweep, Some(&Truth { image, variance, reliable })).measured;
        assert!(found[1..].iter().all(|clamp| clamp.bias_known == known), "{reliable:?}: {found:?}");
    }
}

/// The number of light paths is in no shader, and has an effect all the same. That which `auto` decides has none of its own.
#[test]
fn each_number_of_light_paths_is_a_setting() {
    let point = "PointLight(at: (0, 1.7, 0), intensity: (9, 8, 7))";
    let small = "Sphere(center: (0, 1.7, 0), radius: 0.01, material: \"lamp\")";
    for (text, same_as_auto) in [(CAUSTIC.to_string(), "1"), (CAUSTIC.replace(small, point), "4")] {
        let scene = scene(&text);
        let defaults = unbiased(&scene).remove(0);
        let mut sweep = Sweep::new(device::software(), &scene, (24, 24), 0);
        sweep.add(defaults.clone()).expect("it compiles");
        for (value, count) in [("1", 1), ("4", 4), ("8", 8)] {
            let options = RenderOptions { light_paths: LightPaths::Count(count), ..RenderOptions::default() };
            let setting = Setting { option: Some(&LIGHT_PATHS), value: value.into(), options, ..defaults.clone() };
            sweep.add(setting).expect("it compiles");
        }
        let left: Vec<_> = sweep.unmeasured.iter().map(|left| left.setting.value.as_str()).collect();
        assert_eq!(left, [same_as_auto]);
        assert_eq!(sweep.subjects.len(), 3);
    }
}

/// The loss of detail that images of all pixels show is that of images of fewer pixels.
#[test]
fn lost_detail_is_computed_without_rendering_it() {
    let scene = scene(ROOM);
    let defaults = unbiased(&scene).remove(0);
    let mut sweep = Sweep::new(device::software(), &scene, (48, 48), 0);
    sweep.add(defaults.clone()).expect("it compiles");
    let half = Setting { option: Some(&SIZE), value: "50%".into(), scale: 0.5, ..defaults };
    sweep.add(half).expect("it compiles");
    measure(&mut sweep, 1, 8);
    let images = |subject: usize| -> Vec<Pixels> {
        sweep.subjects[subject].blocks[&16].iter().map(|block| block.image.clone()).collect()
    };
    let weights =
        Weights::of_rounds(images(0).iter().enumerate().map(|(i, image)| (i, 16, image)), floor_of).expect("images");
    let rendered = squared_bias(&images(1), &images(0), &weights, 1).expect("eight rounds");
    let (_, computed) = FullSize::assumed(&sweep, sweep.size).lost_detail(0.5).expect("eight images");
    let error = rendered.error.hypot(computed.error);
    // Five standard errors: once in 700 times with 7 degrees of freedom, and the seed is pinned.
    assert!(
        (computed.value - rendered.value).abs() < 5.0 * error && computed.value > 20.0 * error,
        "{computed:?} {rendered:?}"
    );
    // In the report it is what counts.
    let found = judged(&mut sweep, None).measured;
    assert!(found[1].squared == computed && found[1].verdict().contains("loses detail"), "{:?}", found[1]);
    // Without images of the full size nothing is said of it.
    let unknown = FullSize::assumed(&sweep, (96, 96));
    assert_eq!(judge(&mut sweep, None, &unknown, "").measured.len(), 1);
    assert!(sweep.unmeasured.iter().any(|left| left.why.contains("images of full size")));
}

/// Of 100 sweeps at most 18 may have a false alarm: with a probability of 5 % each, more do once in 2e6 times. A rate of 25 % would be found in
/// 94 of 100 times, one of 15 % in 16. So too against a reference that is as noisy as what it judges, of which no less than a tenth more light
/// is found here (0.5 % is in `a_planted_bias_is_found_with_its_sign_and_size`).
#[test]
fn settings_that_only_add_noise_are_not_called_biased() {
    const SWEEPS: u32 = 100;
    let scene = scene(ROOM);
    let all = unbiased(&scene);
    let mut sweep = Sweep::new(device::software(), &scene, (12, 12), 0);
    let mut other = Sweep::new(device::software(), &scene, (12, 12), 0);
    other.add(all[0].clone()).expect("it compiles");
    all.into_iter().for_each(|setting| sweep.add(setting).expect("it compiles"));
    let (mut alarms, mut with_reference, mut found_darker) = (0, 0, 0);
    for number in 0..SWEEPS {
        measure(&mut sweep, 1 + 1000 * number, 6);
        let found = judged(&mut sweep, None).measured;
        assert_eq!(found.len(), 4);
        alarms += u32::from(found.iter().any(|measured| measured.biased));

        measure(&mut other, 501 + 1000 * number, 2);
        let mut reference = Truth::pooled(&other, None).expect("there are images");
        let itself = Weights::of_image(reference.image.clone(), floor_of);
        let own = reference.error(&itself).expect("of two halves");
        let noise = found[0].model.error(16.0);
        assert!((0.05..2.0).contains(&(own / noise)), "the reference's noise is {own:e}, an image's {noise:e}");
        let found = judged(&mut sweep, Some(&reference));
        let (_, differs) = found.against_reference.expect("its noise is known");
        with_reference += u32::from(differs || found.measured.iter().any(|measured| measured.biased));
        // The control: one that shows another scene.
        reference.image.as_flattened_mut().iter_mut().for_each(|v| *v *= 1.1);
        let found = judged(&mut sweep, Some(&reference));
        let (distance, differs) = found.against_reference.expect("its noise is known");
        found_darker += u32::from(differs && distance.signed.value < 0.0);
    }
    println!("{alarms} alarms, and against references {with_reference}, of {SWEEPS}; found darker: {found_darker}");
    assert!(alarms <= 18 && with_reference <= 18, "{alarms}, and against references {with_reference}, of {SWEEPS}");
    assert!(found_darker >= 95, "{found_darker} of {SWEEPS}");
}
