//! The image is a function of scene, settings and sample range alone: not of the sizes that the work is cut into, nor of the place
//! and scale of the scene (docs/promises.md).
//!
//! What is compared is the film: the exact totals of every pixel, their squares, and the counts of samples and rays. What the user
//! gets is developed from it by a pure function. Equality has no noise, and so no false alarms; that it can fail at all is shown by
//! renders that must differ.

use std::path::Path;
use std::time::Duration;

use crate::common::everything::{Everything, World, same};
use crate::common::render::{Request, render, render_each};
use gpu_rt::bvh::Quality;
use gpu_rt::film::Film;
use gpu_rt::flatten::{DeviceScene, flatten};
use gpu_rt::options::{RenderOptions, Scatter, Walk};
use gpu_rt::scene::Scene;

fn everything() -> (Everything, Scene) {
    let files = Everything::new();
    let scene = files.scene(World::default());
    (files, scene)
}

/// Seeds, depth and samples change the image: else its sameness elsewhere would mean nothing.
#[test]
fn seeds_and_sizes_change_the_image() {
    let (_files, scene) = everything();
    let request = Request::spp(16);
    let usual = render(&scene, &request);
    assert!(!same(&usual, &render(&scene, &request.clone().seed(1))), "seed");
    assert!(!same(&usual, &render(&scene, &request.clone().depth(5))), "depth");
    assert!(!same(&usual, &render(&scene, &Request::spp(24))), "samples");
    let later = Request { samples: Some(16..32), ..request };
    assert!(!same(&usual, &render(&scene, &later)), "sample range");
}

#[test]
fn two_renders_in_a_row_are_the_same() {
    let (_files, scene) = everything();
    let usual = render(&scene, &Request::spp(16));
    assert!(same(&usual, &render(&scene, &Request::spp(16))), "made anew");
    // What a render leaves in the buffers must not reach the next.
    let again = render_each(&scene, &Request::default(), &[0..16, 40..48, 0..16]);
    assert!(same(&usual, &again[0]) && same(&usual, &again[2]), "by one renderer");
}

/// How the work is cut: the way of linking, slots, the size of a workgroup, and bounces of a dispatch. Where these are 0, a bounce of all slots takes
/// too long, so that a submission has some of the slots: 5000 of them take five submissions.
type Cut = (Scatter, u32, u32, u32);

/// Each cut has the bytes of the usual one, which is linked and has workgroups of 64.
fn cuts_do_not_show(scene: &Scene, usual: &Request, cuts: &[Cut]) {
    let expected = render(scene, &usual.clone().scatter(Scatter::Linked));
    for &(scatter, slots, workgroup, bounces) in cuts {
        let mut request = usual.clone().scatter(scatter).with(|options| {
            (options.slots, options.workgroup) = (Some(slots), Some(workgroup));
            options.bounces = (bounces > 0).then_some(bounces);
        });
        request.submission = (bounces == 0).then_some(Duration::ZERO);
        assert!(same(&expected, &render(scene, &request)), "{request:?}");
    }
}

fn by_rays() -> Request {
    Request { samples: Some(0..16), ..Request::default() }
}

fn by_defaults() -> Request {
    Request { samples: Some(3..21), ..Request::default().mis().sobol().roulette().light_paths(1) }
}

/// Whole runs by scattered rays alone, and runs cut at both ends by the defaults and light paths. One path at a time, fewer than a row of pixels has, more than the
/// image has runs. Each size of a workgroup is another kernel to compile, which is what this costs: all ways of linking with all cuts are
/// `no_mix_of_slots_workgroups_and_submissions_shows`, and tests/unchanged.rs cuts all scenes.
#[test]
fn slots_workgroups_and_submissions_do_not_show() {
    use Scatter::{Fused, Linked, Queues};
    let (_files, scene) = everything();
    cuts_do_not_show(
        &scene,
        &by_rays(),
        &[(Linked, 1, 64, 50), (Queues, 97, 1, 1), (Linked, 5000, 64, 0), (Queues, 5000, 1, 0)],
    );
    cuts_do_not_show(&scene, &by_defaults(), &[(Linked, 100_000, 256, 7), (Fused, 97, 64, 1), (Fused, 5000, 64, 0)]);
}

#[test]
#[ignore = "a minute: make test-long"]
fn no_mix_of_slots_workgroups_and_submissions_shows() {
    let (_files, scene) = everything();
    let ways = [Scatter::Linked, Scatter::Queues, Scatter::Fused];
    for usual in [by_rays(), by_defaults()] {
        for (slots, workgroup, bounces) in [(1, 32, 50), (97, 1, 7), (4096, 64, 1), (100_000, 256, 7)] {
            cuts_do_not_show(&scene, &usual, &ways.map(|scatter| (scatter, slots, workgroup, bounces)));
        }
    }
}

#[test]
fn parts_do_not_show_with_sobol_points() {
    let (_files, scene) = everything();
    let request = Request::spp(24).sobol();
    let usual = render(&scene, &request);
    assert!(!same(&usual, &render(&scene, &Request::spp(24))), "the sampler changes the image");
    // Parity is that of the absolute number of a run; the first samples do not depend on how many there will be.
    let parts = render_each(&scene, &request, &[8..24, 0..8]);
    assert!(joined([&parts[0].film, &parts[1].film]) == usual.film);
}

/// Both walks take the same steps with the same stack: through small meshes, one of them around a medium, in trees of `best`; and through a large one.
#[test]
fn walks_do_not_show() {
    let (_files, everything) = everything();
    let knot = Scene::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/mesh.ron")).expect("the scene is valid");
    let siblings = |options: &mut RenderOptions| options.walk = Walk::Siblings;
    for (scene, quality) in [(everything, Quality::Best), (knot, Quality::Medium)] {
        let request = by_defaults().size(48, 27).with(|options| options.build = quality);
        let other = request.clone().with(siblings);
        assert!(same(&render(&scene, &request), &render(&scene, &other)), "{quality:?}");
        // The trees are others.
        let flat = |request: &Request| flatten(&scene, (48, 27), &request.options).expect("the scene flattens");
        let (coded, beside) = (flat(&request), flat(&other));
        assert!(!coded.face_pairs.is_empty() && beside.face_pairs.is_empty());
        assert!(beside.nodes.len() >= coded.nodes.len() + coded.face_pairs.len());
        let stacks =
            |flat: &DeviceScene| (flat.features.quantities.stack_size, flat.features.quantities.boundary_stack_size);
        assert_eq!(stacks(&coded), stacks(&beside));
    }
}

#[test]
fn bindings_do_not_show() {
    let (_files, scene) = everything();
    let usual = render(&scene, &Request::spp(16));
    let request = Request { storage_tables: true, ..Request::spp(16) };
    assert!(same(&usual, &render(&scene, &request)), "all tables in storage bindings");
}

#[test]
fn parts_join_to_the_full_render_in_any_order() {
    let (_files, scene) = everything();
    let parts = [0..8, 8..24, 24..32];
    let mut shots =
        render_each(&scene, &Request::default(), &[0..32, parts[0].clone(), parts[1].clone(), parts[2].clone()]);
    let full = shots.remove(0);
    for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        assert!(joined(order.map(|i| &shots[i].film)) == full.film, "{order:?}");
    }
    // A part twice, or one of another seed, is another image.
    assert!(joined([0, 1, 1].map(|i| &shots[i].film)) != full.film);
    let other = render(&scene, &Request { samples: Some(24..32), ..Request::default().seed(1) });
    assert!(joined([&shots[0].film, &shots[1].film, &other.film]) != full.film);
}

fn joined<const N: usize>(films: [&Film; N]) -> Film {
    let mut all = films[0].clone();
    films[1..].iter().for_each(|film| all.merge(film).expect("parts of one image"));
    all
}

/// Cut within a run, the same samples are added in other groups: a sum of up to 8 positive values has 7 roundings of at most 2^-24
/// of itself on either side, and the picture one more each; 16 in all is 9.6e-7.
#[test]
fn parts_cut_within_a_run_join_to_the_full_render_but_for_rounding() {
    let (_files, scene) = everything();
    let shots = render_each(&scene, &Request::default(), &[0..32, 0..5, 5..19, 19..32]);
    let all = joined([&shots[1].film, &shots[2].film, &shots[3].film]);
    assert_eq!(all.totals, shots[0].film.totals);
    let picture = all.develop();
    assert_eq!(picture.samples, shots[0].picture.samples);
    let differ = |bound: f32| {
        let pairs = picture.rgb.as_flattened().iter().zip(shots[0].picture.rgb.as_flattened());
        pairs.filter(|(a, b)| (*a - *b).abs() > bound * b.abs()).count()
    };
    assert_eq!(differ(9.6e-7), 0);
    assert!(differ(0.0) > 0, "all parts happen to have the same sums: this test has compared nothing");
}

#[test]
fn powers_of_two_of_the_radiance_scale_the_image_exactly() {
    let (files, scene) = everything();
    let usual = render(&scene, &Request::spp(16));
    for exponent in [-60, 60] {
        let brightness = 2f64.powi(exponent);
        let world = World { brightness, ..World::default() };
        let scaled = |world: World| {
            let shot = render(&files.scene(world), &Request::spp(16));
            assert_eq!(shot.film.totals, usual.film.totals, "paths and rays");
            shot.picture
        };
        let times = |v: f32, factor: f64| (f64::from(v) * factor) as f32;
        let picture = scaled(world);
        let expected: Vec<_> = usual.picture.rgb.iter().map(|rgb| rgb.map(|v| times(v, brightness))).collect();
        assert!(picture.rgb == expected, "2^{exponent}");
        // Variances scale with the square, as far as f32 holds them (the film overstates what it cannot hold).
        let pairs = picture.variance.as_flattened().iter().zip(usual.picture.variance.as_flattened());
        for (&found, &usual) in pairs {
            assert_eq!(found, times(usual, brightness * brightness).max(f32::MIN_POSITIVE.min(usual)), "2^{exponent}");
        }
        let one_lamp = World { lamp: 1.01, ..world };
        assert!(scaled(one_lamp).rgb != expected, "one lamp of three brighter by 1 % does not show");
    }
}
