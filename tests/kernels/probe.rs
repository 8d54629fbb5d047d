//! The numerics probe: what it finds of the software drivers, that it finds what is planted, and that kernels are refused
//! where a driver lacks what they rely on.

use std::path::Path;
use std::sync::Arc;

use crate::common::device;

use gpu_rt::data::{Answer, Trial};
use gpu_rt::gpu::device::{Adapters, Device};
use gpu_rt::gpu::link::{Embedded, Library};
use gpu_rt::gpu::numerics::{LOOPS, Numerics, PROPERTIES, Rounding};
use gpu_rt::gpu::probe::{judge, numerics, run, trials};
use gpu_rt::job::{Frame, Goal, Job};
use gpu_rt::options::{RenderOptions, Scatter};
use gpu_rt::scene::Scene;
use gpu_rt::session::Session;

/// What a device that does everything right answers.
fn right(trial: &Trial) -> Answer {
    let (x, y) = (f64::from(trial.x), f64::from(trial.y));
    let rest = |exact: f64| ((exact - f64::from(exact as f32)) as f32).to_bits();
    let special = f32::from_bits(trial.special);
    let said = [
        special.is_nan(),
        special < 1.0,
        special >= 1.0,
        special.is_nan() || special < 1.0,
        special.is_nan(),
        special.is_infinite(),
    ];
    let edge = |a: f32, b: f32| f64::from(a) * f64::from(b);
    let difference = edge(trial.p_x, trial.q_y) - edge(trial.p_y, trial.q_x);
    Answer {
        sum_error: rest(x + y),
        sum_error_barrier: rest(x + y),
        product_error_barrier: rest(x * y),
        fma_error: rest(x * y),
        contracted: 0,
        sine: trial.angle.sin().to_bits(),
        far_sine: trial.far_angle.sin().to_bits(),
        logarithm: trial.log_of.ln().to_bits(),
        converted: (trial.word as f32).to_bits(),
        uniform_of_32: ((f64::from(trial.word) / 2f64.powi(32)) as f32).to_bits(),
        uniform_of_24: ((f64::from(trial.word >> 8) / 2f64.powi(24)) as f32).to_bits(),
        classes_of_special: said.iter().rev().fold(0, |all, &bit| all << 1 | u32::from(bit)),
        made_subnormal: (f32::from_bits(trial.least) / 16.0).to_bits(),
        from_subnormal: (f32::from_bits(trial.subnormal) * 16_777_216.0).to_bits(),
        edge_sign: if difference > 0.0 { 1 } else { -1 },
        loop_state: (0..trial.loops).fold(1, |state: u32, _| state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223)),
    }
}

fn ideal() -> (Vec<Trial>, Vec<Answer>) {
    let trials = trials();
    let answers = trials.iter().map(right).collect();
    (trials, answers)
}

#[test]
fn a_device_that_does_everything_right_is_found_to() {
    let (trials, answers) = ideal();
    let found = judge(&trials, &answers);
    let expected = Numerics {
        two_sum: true,
        two_sum_barrier: true,
        two_product_barrier: true,
        fma_fused: true,
        contraction: false,
        nan_compares: true,
        nan_fails_comparisons: true,
        nan_by_bits: true,
        loop_iterations: LOOPS,
        subnormals: true,
        conversion: Rounding::Nearest,
        words_reach_one: true,
        uniforms_exact: true,
        edge_signs: true,
        ..found
    };
    assert_eq!(found, expected);
    assert!(found.log_error < 6e-8 && found.log_relative_error < 6e-8, "{found:?}");
    assert!(found.sin_error < 6e-8 && found.sin_error_far < 6e-8, "{found:?}");
    assert_eq!(found.lacking().count(), 0);
}

/// One wrong answer to one of the trials changes the finding that it is about, and no other; and so does a wrong question, which
/// stands for a wrong expectation.
#[test]
fn every_planted_error_is_found() {
    type Plant = (&'static str, fn(&mut Answer), fn(&mut Numerics));
    let plants: &[Plant] = &[
        ("two-sum", |a| a.sum_error ^= 1, |n| n.two_sum = false),
        ("two-sum deleted", |a| a.sum_error_barrier = 0, |n| n.two_sum_barrier = false),
        ("two-product", |a| a.product_error_barrier ^= 1, |n| n.two_product_barrier = false),
        ("fma in two steps", |a| a.fma_error = 0, |n| n.fma_fused = false),
        ("contraction", |a| a.contracted = a.fma_error, |n| n.contraction = true),
        ("x != x", |a| a.classes_of_special &= !1, |n| n.nan_compares = false),
        ("NaN >= 1", |a| a.classes_of_special ^= 0b1100, |n| n.nan_fails_comparisons = false),
        ("NaN by bits", |a| a.classes_of_special ^= 0b1_0000, |n| n.nan_by_bits = false),
        ("infinity by bits", |a| a.classes_of_special ^= 0b10_0000, |n| n.nan_by_bits = false),
        ("a loop cut short", |a| a.loop_state = 1, |n| n.loop_iterations = 0),
        ("a flushed result", |a| a.made_subnormal = 0, |n| n.subnormals = false),
        ("a flushed operand", |a| a.from_subnormal = 0, |n| n.subnormals = false),
        ("conversion", |a| a.converted -= 2, |n| n.conversion = Rounding::Neither),
        ("24 bits", |a| a.uniform_of_24 += 1, |n| n.uniforms_exact = false),
        ("signs", |a| a.edge_sign = 0, |n| n.edge_signs = false),
        ("sin", |a| a.sine = f32::NAN.to_bits(), |n| n.sin_error = f64::INFINITY),
        ("far sin", |a| a.far_sine = f32::NAN.to_bits(), |n| n.sin_error_far = f64::INFINITY),
    ];
    let (trials, answers) = ideal();
    for (name, plant, expect) in plants {
        let mut wrong = answers.clone();
        plant(&mut wrong[0]);
        let mut expected = judge(&trials, &answers);
        expect(&mut expected);
        assert_eq!(judge(&trials, &wrong), expected, "{name}");
    }
    let mut wrong = answers.clone();
    wrong.iter_mut().for_each(|answer| answer.uniform_of_32 = 0);
    assert!(!judge(&trials, &wrong).words_reach_one);
    let mut wrong = answers.clone();
    wrong[3].logarithm = 0;
    let found = judge(&trials, &wrong);
    assert!(found.log_error > 0.06 && found.log_relative_error == 1.0, "{found:?}");

    let mut changed = trials.clone();
    changed[0].y = changed[2].y;
    let found = judge(&changed, &answers);
    assert!(!found.two_sum && !found.two_sum_barrier && !found.fma_fused, "{found:?}");
    // Nothing is found where nothing came back.
    assert_eq!(judge(&trials, &[]).lacking().count(), PROPERTIES.len());
}

/// The device of the tests has all that kernels rely on; of Mesa's llvmpipe it is known what else it does.
#[test]
fn the_software_drivers_are_as_known() {
    let device = device::software();
    let start = std::time::Instant::now();
    let found = numerics(device).expect("the probe runs");
    println!("{}, in {:.1} ms: {found:#?}", device.name, start.elapsed().as_secs_f64() * 1e3);
    assert_eq!(found.lacking().map(|property| property.name).collect::<Vec<_>>(), [""; 0], "{found:?}");
    assert_eq!(judge(&trials(), &run(device, &trials()).expect("the probe runs")), *found, "the same when asked again");
    if device.name.name.contains("llvmpipe") {
        let limited = device.name.driver.contains("Mesa 22.3");
        let expected = Numerics {
            two_sum: device.forbids_contraction(),
            two_sum_barrier: true,
            two_product_barrier: true,
            fma_fused: false,
            contraction: false,
            nan_compares: false,
            nan_fails_comparisons: true,
            nan_by_bits: true,
            loop_iterations: if limited { 65_535 } else { LOOPS },
            subnormals: true,
            conversion: Rounding::Nearest,
            words_reach_one: true,
            uniforms_exact: true,
            edge_signs: true,
            ..found.clone()
        };
        assert_eq!(*found, expected);
        assert!((1e-8..4.8e-7).contains(&found.log_error) && found.log_relative_error > 1e-2, "{found:?}");
        assert!((1e-8..1e-6).contains(&found.sin_error) && found.sin_error_far < 1e-3, "{found:?}");
    }
}

/// A device that the probe is to have found this of.
fn pretend(change: impl Fn(&mut Numerics)) -> Arc<Device> {
    let name = device::software().name.to_string();
    let device = Device::open(Adapters::find().choose(Some(&name)).expect("it is there")).expect("it opens");
    let mut found = numerics(device::software()).expect("the probe runs").clone();
    change(&mut found);
    device.numerics.set(found).expect("nobody has asked it yet");
    Arc::new(device)
}

/// Why no renderer is made for a scene with these objects, fused and with a kernel a stage, or nothing where it is made.
fn refusals(device: &Arc<Device>, objects: &str) -> [Option<String>; 2] {
    let text = format!(
        "Scene(image: (width: 4, height: 4), camera: (look_from: (0, 0, 9), look_at: (0, 0, 0), vertical_fov: 40),
         background: Solid((1, 1, 1)), materials: {{\"m\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5))}}, objects: [{objects}])"
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/test.ron");
    let scene = Scene::parse(&text, &path).expect("the scene is valid");
    let job = Job { size: (4, 4), max_depth: 4, seed: 0, first_sample: 0, goal: Goal::Samples(8) };
    [Scatter::Fused, Scatter::Linked].map(|scatter| {
        let options = RenderOptions { scatter: Some(scatter), ..RenderOptions::default() };
        let mut session = Session::on(vec![Arc::clone(device)]);
        session.view(&scene, &Frame::full(job.size), &options).expect("it flattens");
        let mut film = session.film(job.size).expect("it is small");
        session.render(&job, &mut film, &mut ()).err().map(|error| error.to_string())
    })
}

#[test]
fn kernels_are_refused_where_a_driver_lacks_what_they_rely_on() {
    // Too many for a test of all of them by every ray: a walk through a tree is a loop that may be long.
    const SPHERES: &str = "Sphere(center: (-6, -6, 0), radius: 1, material: \"m\"),
        Sphere(center: (6, -6, 0), radius: 1, material: \"m\"), Sphere(center: (0, 0, 0), radius: 1, material: \"m\"),
        Sphere(center: (-6, 6, 0), radius: 1, material: \"m\"), Sphere(center: (6, 6, 0), radius: 1, material: \"m\"),";
    const MESH: &str = "Mesh(path: \"meshes/star.ply\", material: \"m\"),";
    const SMOKE: &str = "Medium(boundary: Sphere(center: (0, 0, 0), radius: 1), density: 1, albedo: Rgb(1, 1, 1)),";
    type Lack = (&'static str, fn(&mut Numerics), &'static [&'static str]);
    let lacks: [Lack; PROPERTIES.len()] = [
        ("loops", |n| n.loop_iterations = 60_000, &[SPHERES, MESH]),
        ("uniforms", |n| n.uniforms_exact = false, &[SPHERES, MESH, SMOKE]),
        ("bits", |n| n.nan_by_bits = false, &[SPHERES, MESH, SMOKE]),
        ("logarithm", |n| n.log_error = 1e-6, &[SMOKE]),
        ("signs", |n| n.edge_signs = false, &[MESH]),
    ];
    for (property, lack, relying) in lacks {
        let device = pretend(lack);
        for objects in [SPHERES, MESH, SMOKE] {
            let refused = refusals(&device, objects);
            let [fused, linked] = refused.each_ref().map(Option::is_some);
            assert_eq!(linked, relying.contains(&objects), "{property}, {objects}: {refused:?}");
            // Several bounces in one kernel are a loop that may be long, whatever there is to hit.
            assert_eq!(fused, linked || property == "loops", "{property}, {objects}: {refused:?}");
            for text in refused.into_iter().flatten() {
                let named =
                    [&format!("`{property}`"), &device.name.driver, "gpu-rt devices", "shaders/", "Update the driver"];
                assert!(named.iter().all(|word| text.contains(word)), "{text}");
            }
        }
    }
    // A property that no kernel relies on is no reason to refuse.
    let device = pretend(|found| {
        found.two_sum_barrier = false;
        found.two_product_barrier = false;
        found.subnormals = false;
        found.contraction = true;
        found.sin_error = 1e-2;
        found.nan_fails_comparisons = false;
        found.conversion = Rounding::TowardsZero;
    });
    assert_eq!(refusals(&device, &[SPHERES, MESH, SMOKE].concat()), [None, None]);
}

#[test]
fn every_property_has_shaders_that_rely_on_it_and_stands_in_the_table() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/dev/architecture.md");
    let document = std::fs::read_to_string(path).expect("the document can be read");
    for property in PROPERTIES {
        let relies = |name: &&String| {
            let text = Embedded.module(name).unwrap_or_default();
            text.lines().any(|line| line == format!("//@ relies on {}", property.name))
        };
        let names = Embedded::names();
        let relying: Vec<&String> = names.iter().filter(relies).collect();
        let begins = format!("| `{}` |", property.name);
        let row = document.lines().find(|line| line.starts_with(&begins));
        let row = row.unwrap_or_else(|| panic!("docs/dev/architecture.md has no row {begins}"));
        assert!(!relying.is_empty(), "nobody relies on {}", property.name);
        for name in relying {
            assert!(
                row.contains(&format!("`{name}`")),
                "{name} relies on {}, and the row does not say so",
                property.name
            );
        }
    }
}
