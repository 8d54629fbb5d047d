//! The library's own interface: a scene rendered in memory, and the films that a render takes.

use crate::common::device::{index, software};
use crate::common::render::{Request, render, scene};
use gpu_rt::film::Film;
use gpu_rt::flatten::flatten;
use gpu_rt::job::{Goal, Job};
use gpu_rt::options::RenderOptions;
use gpu_rt::plan::Plan;
use gpu_rt::render::{Next, Renderer};
use gpu_rt::{RenderSettings, Scene, render_scene};

const SIZE: (u32, u32) = (12, 9);
const SAMPLES: u32 = 16;

/// A lamp so bright that the scale of the film is not 1.
fn lit() -> Scene {
    scene(
        "Scene(image: (width: 40, height: 30), camera: (look_from: (0, 0, 4), look_at: (0, 0, 0), vertical_fov: 30),
        background: Gradient(bottom: (1, 1, 1), top: (9, 7, 5)),
        materials: { \"matt\": Lambertian(albedo: Rgb(0.5, 0.25, 0.75)) },
        objects: [Sphere(center: (0, 0, 0), radius: 1, material: \"matt\")])",
    )
}

#[test]
fn a_picture_in_memory_is_that_of_the_program() {
    let settings =
        RenderSettings { size: Some(SIZE), samples: Some(SAMPLES), seed: 3, device: Some(index().to_owned()) };
    let request = Request { options: RenderOptions::default(), ..Request::spp(SAMPLES).seed(3).size(SIZE.0, SIZE.1) };
    let picture = render_scene(&lit(), &settings).expect("it renders");
    assert_eq!(picture, render(&lit(), &request).picture);
    for settings in [
        RenderSettings { size: Some((0, 9)), ..settings.clone() },
        RenderSettings { size: Some((9, 1 << 17)), ..settings.clone() },
        RenderSettings { samples: Some(0), ..settings.clone() },
        RenderSettings { device: Some("no such device".to_owned()), ..settings },
    ] {
        assert!(render_scene(&lit(), &settings).is_err(), "{settings:?}");
    }
}

/// On a film of the scale 1 the image would be several times too dark.
#[test]
fn a_film_that_does_not_fit_is_refused() {
    let (scene, options) = (lit(), RenderOptions::default());
    let flat = flatten(&scene, SIZE, &options).expect("the scene flattens");
    let exponent = flat.radiance_exponent;
    assert_ne!(exponent, 0);
    let job = Job { size: SIZE, max_depth: 5, seed: 0, first_sample: 0, goal: Goal::Samples(SAMPLES) };
    let plan = Plan::new(&flat, &options, software().class(), &job).expect("the kernels link");
    let mut renderer = Renderer::new(software(), &plan, &job, false).expect("the kernels compile");
    let mut run = |width, height, exponent| {
        let mut film = Film::with_sampler(width, height, exponent, options.sampler).expect("it is small");
        renderer.run(&job, &mut film, &mut |_, _| Next::GoOn).map_err(|error| error.to_string())
    };
    let needed = format!("needs a film of 12 x 9 pixels of the scale 2^{exponent}");
    for (width, height, scale) in [(12, 9, 0), (12, 9, exponent + 1), (9, 12, exponent)] {
        let error = run(width, height, scale).err().unwrap_or_default();
        let found = format!("found {width} x {height} pixels of the scale 2^{scale}");
        assert!(error.contains(&needed) && error.ends_with(&found), "{error}");
    }
    assert!(run(12, 9, exponent).is_ok());
}
