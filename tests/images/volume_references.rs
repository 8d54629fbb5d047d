//! A cloud of an OpenVDB file against two other renderers, Mitsuba's volpathmis and Cycles without bias: tests/references/volumes has the scene,
//! the images, and make.py, which made them and says where the renderers' conventions differ.
//!
//! Of each image, and of ours, the variance of each pixel is known, and pixels are independent. The mean of the image is within 3 standard errors
//! in each channel. Those of blocks may differ by as much as 3 standard errors allow a single number, but for their count (Šidák).

use std::path::{Path, PathBuf};

use glam::DVec3;
use gpu_rt::output::exr::{ExrImage, read_exr};
use gpu_rt::scene::{Density, Object, Scene, Transform, Varying};

use crate::common::render::{Mean, Request, Shot, mean_over, render};
use crate::common::stats::{normal_two_sided, sidak};

/// Blocks along a row and along a column.
const BLOCKS: (u32, u32) = (8, 6);

/// Of a mean of a thousand equal numbers in 32 bits: the sky.
const ROUNDING: f64 = 2e-5;

/// Seeds of each pixel of a reference: a variance has a degree of freedom less.
const SEEDS: f64 = 16.0;

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/references/volumes").join(name)
}

/// The differences of an image from a reference.
#[derive(Debug)]
#[expect(dead_code, reason = "shown where a test fails")]
struct Difference {
    /// Of the means, in standard errors, and in shares of the reference's, by channel.
    z: [f64; 3],
    share: [f64; 3],
    /// Of the worst block.
    block: f64,
    p: f64,
    corner: (u32, u32),
    agree: bool,
}

fn difference(shot: &Shot, reference: &ExrImage) -> Difference {
    let (width, height) = (reference.width, reference.height);
    assert_eq!((width, height), (shot.picture.width, shot.picture.height));
    let variance = reference.known_variance().expect("the file has it");
    let means = |(x, y): (u32, u32), (columns, rows): (u32, u32)| {
        let pixels = (y..y + rows).flat_map(|y| (x..x + columns).map(move |x| (y * width + x) as usize));
        let expected = mean_over(&reference.rgb, variance, pixels, SEEDS - 1.0);
        (shot.mean(x..x + columns, y..y + rows), expected)
    };
    let (found, expected) = means((0, 0), (width, height));
    let standard = |found: &Mean, expected: &Mean, c: usize| {
        (found.value[c] - expected.value[c]) / (found.variance[c] + expected.variance[c]).sqrt()
    };
    let z = [0, 1, 2].map(|c| standard(&found, &expected, c));
    let share = [0, 1, 2].map(|c| found.value[c] / expected.value[c] - 1.0);
    let size = (width / BLOCKS.0, height / BLOCKS.1);
    let corners = (0..BLOCKS.0 * BLOCKS.1).map(|at| (at % BLOCKS.0 * size.0, at / BLOCKS.0 * size.1));
    let blocks = corners.flat_map(|corner| {
        let (found, expected) = means(corner, size);
        [0, 1, 2].map(|c| (found.difference(&expected, c, ROUNDING), corner))
    });
    let ((p, block), corner) = blocks.min_by(|a, b| a.0.0.total_cmp(&b.0.0)).expect("there are blocks");
    let bound = sidak(normal_two_sided(3.0), 3 * (BLOCKS.0 * BLOCKS.1) as usize);
    let agree = z.iter().all(|z| z.abs() <= 3.0) && p >= bound;
    Difference { z, share, block, p, corner, agree }
}

/// A change of the scene's only medium.
type Planted = fn(&mut Object);

const THINNER: Planted = |object| {
    if let Object::Medium { density: Density::Varying(Varying::Grid { scale, .. }), .. } = object {
        *scale *= 0.97;
    }
};

const LESS_FORWARD: Planted = |object| {
    if let Object::Medium { anisotropy, .. } = object {
        *anisotropy = 0.36;
    }
};

/// By half a voxel, as if values were those of cells.
const MOVED: Planted = |object| {
    let medium = Box::new(object.clone());
    *object = Object::Transformed { by: vec![Transform::Translate(DVec3::splat(0.05))], object: medium };
};

#[test]
fn a_cloud_is_as_mitsuba_and_cycles_render_it() {
    let scene = Scene::load(&file("blob.ron")).unwrap_or_else(|error| panic!("{error}"));
    let references = ["mitsuba", "cycles"]
        .map(|name| (name, read_exr(&file(&format!("{name}.exr"))).unwrap_or_else(|error| panic!("{error}"))));
    let request = Request::spp(512).seed(11).mis().sobol().roulette();
    let shot = render(&scene, &request);
    for (name, reference) in &references {
        let found = difference(&shot, reference);
        println!("{name}: {found:?}");
        assert!(found.agree, "{name}: {found:?}");
    }
    for (what, plant) in [("thinner", THINNER), ("less forward", LESS_FORWARD), ("moved", MOVED)] {
        let mut planted = scene.clone();
        plant(planted.objects.last_mut().expect("the medium is the last object"));
        assert!(planted.objects != scene.objects, "{what}: nothing is changed");
        let shot = render(&planted, &Request { samples: Some(0..256), ..request.clone() });
        for (name, reference) in &references {
            let found = difference(&shot, reference);
            println!("{what}, {name}: {found:?}");
            assert!(!found.agree, "{what} is not found by {name}");
        }
    }
}
