//! The library's own interface: a scene rendered in memory, sessions, and the films that they take.

use std::sync::Arc;

use crate::common::device::{index, open, software};
use crate::common::render::{Request, render, scene};
use gpu_rt::film::Accumulation;
use gpu_rt::film::Film;
use gpu_rt::flatten::flatten;
use gpu_rt::job::{Frame, Goal, Job};
use gpu_rt::options::RenderOptions;
use gpu_rt::session::Session;
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
    let mut session = Session::on(vec![Arc::clone(software())]);
    session.show(flat, &options);
    let mut run = |width, height, exponent| {
        let film = Film::with_sampler(width, height, exponent, options.sampler).expect("it is small");
        session.render(&job, &mut Accumulation::empty(film), &mut ()).map_err(|error| error.to_string())
    };
    let needed = format!("needs a film of 12 x 9 pixels of the scale 2^{exponent}");
    for (width, height, scale) in [(12, 9, 0), (12, 9, exponent + 1), (9, 12, exponent)] {
        let error = run(width, height, scale).err().unwrap_or_default();
        let found = format!("found {width} x {height} pixels of the scale 2^{scale}");
        assert!(error.contains(&needed) && error.ends_with(&found), "{error}");
    }
    assert!(run(12, 9, exponent).is_ok());
}

/// A session that goes on with another camera, object, size and seed has the images of sessions that begin with them, and compiles no kernel again.
/// Another material needs other kernels.
#[test]
fn a_session_keeps_its_kernels_from_view_to_view() {
    let view = |look_from: &str, radius: f64, material: &str| {
        scene(&format!(
            "Scene(image: (width: 12, height: 9), camera: (look_from: {look_from}, look_at: (0, 0, 0), vertical_fov: 30),
            background: Gradient(bottom: (1, 1, 1), top: (9, 7, 5)), materials: {{ \"m\": {material} }},
            objects: [Sphere(center: (0, 0, 0), radius: {radius}, material: \"m\")])"
        ))
    };
    let matt = "Lambertian(albedo: Rgb(0.5, 0.25, 0.75))";
    let views = [
        (view("(0, 0, 4)", 1.0, matt), SIZE, 3, false),
        (view("(3000, 2, 4)", 1.0, matt), SIZE, 3, false),
        (view("(0, 0, 4)", 0.5, matt), (20, 15), 4, false),
        (view("(0, 0, 4)", 1.0, "Dielectric(ior: 1.5)"), SIZE, 3, true),
    ];
    let render = |session: &mut Session, (scene, size, seed, _): &(Scene, (u32, u32), u32, bool)| {
        session.view(scene, &Frame::full(*size), &RenderOptions::default()).expect("it flattens");
        let mut film = session.film(*size).expect("it is small");
        let job = Job { size: *size, max_depth: 8, seed: *seed, first_sample: 0, goal: Goal::Samples(SAMPLES) };
        session.render(&job, &mut film, &mut ()).expect("the device renders");
        film.film
    };
    let compiled = |session: &Session| session.devices[0].kernels.compiled_names().len();
    let mut long = Session::on(vec![Arc::new(open())]);
    let mut films = Vec::new();
    for view in &views {
        let before = compiled(&long);
        let film = render(&mut long, view);
        assert!(film == render(&mut Session::on(vec![Arc::clone(software())]), view), "seed {}", view.2);
        assert_eq!(compiled(&long) > before, view.3 || films.is_empty());
        films.push(film);
    }
    assert!(films[0] != films[1] && films[0] != films[3]);
}
