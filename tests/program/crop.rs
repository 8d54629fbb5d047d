//! `--crop`: a part of an image has the bytes and the position that it has in the full image.

use std::fs;

use exr::prelude::{MetaData, Vec2};
use gpu_rt::output::exr::ExrImage;

use super::resume::Sandbox;

/// Whether an image holds just what a part of another one does: its pixels and all further channels.
fn is_part(part: &ExrImage, (left, top): (u32, u32), full: &ExrImage) -> bool {
    let bits = |image: &ExrImage, index: usize| {
        let [rgb, variance] =
            [Some(&image.rgb), image.variance.as_ref()].map(|layer| layer.map(|pixels| pixels[index]));
        let counts = [&image.samples, &image.rejected].map(|layer| layer.as_ref().map(|counts| counts[index]));
        ([rgb, variance].map(|layer| layer.map(|rgb| rgb.map(f32::to_bits))), counts)
    };
    let at = |image: &ExrImage, x: u32, y: u32| bits(image, (y * image.width + x) as usize);
    let pixels = || (0..part.height).flat_map(|y| (0..part.width).map(move |x| (x, y)));
    pixels().all(|(x, y)| at(part, x, y) == at(full, left + x, top + y))
}

#[test]
fn a_part_has_the_bytes_of_the_full_image() {
    let sandbox = Sandbox::new();
    sandbox.render("--spp 24 -o full.exr").exits(0);
    let full = sandbox.image("full.exr");
    // One pixel; strips of eight rows cut at both ends; corners; everything.
    for (left, top, width, height) in [(5, 9, 1, 1), (3, 2, 7, 13), (20, 0, 4, 16), (0, 15, 24, 1), (0, 0, 24, 16)] {
        for setting in ["", "--scatter linked --slots 7"] {
            let crop = format!("{left},{top},{width},{height}");
            let ran = sandbox.render(&format!("--spp 24 --crop {crop} --png part.png --json -o part.exr {setting}"));
            let json = ran.exits(0).json();
            assert_eq!((json["width"].as_u64(), json["height"].as_u64()), (Some(width.into()), Some(height.into())));
            assert_eq!(json["paths"].as_u64(), Some(u64::from(width * height) * 24));
            let part = sandbox.image("part.exr");
            assert_eq!((part.width, part.height), (width, height));
            assert!(is_part(&part, (left, top), &full), "{crop} {setting}");
            assert!(width == 24 || !is_part(&part, (left.max(1) - 1, top), &full), "{crop} passes as its neighbour");
            let picture = image::image_dimensions(sandbox.path("part.png")).expect("a PNG");
            assert_eq!(picture, (width, height));
            // Its position in the full image.
            let header = MetaData::read_from_file(sandbox.path("part.exr"), true).expect("it has a header").headers;
            for part in &header {
                assert_eq!(part.shared_attributes.display_window.size, Vec2(24, 16));
                assert_eq!(part.own_attributes.layer_position, Vec2(left as i32, top as i32));
            }
            fs::remove_file(sandbox.path("part.exr")).expect("it is there");
        }
    }
}

/// A film that the device does not hold at once.
#[test]
fn a_part_in_tiles_has_the_bytes_of_the_full_image() {
    let sandbox = Sandbox::new();
    sandbox.render("--spp 1 --no-state --size 1100x900 -o full.exr").exits(0);
    sandbox.render("--spp 1 --no-state --size 1100x900 --crop 37,13,1001,850 -o part.exr").exits(0);
    assert!(is_part(&sandbox.image("part.exr"), (37, 13), &sandbox.image("full.exr")));
}

#[test]
fn parts_go_on_and_join() {
    let sandbox = Sandbox::new();
    let crop = "--crop 3,2,7,13";
    sandbox.render(&format!("--spp 24 {crop} -o full.exr")).exits(0);
    sandbox.render(&format!("--samples 0..8 {crop} -o a.exr")).exits(0);
    sandbox.render(&format!("--samples 8..24 {crop} -o b.exr")).exits(0);
    sandbox.says("merge b.exr a.exr -o joined.exr").exits(0);
    sandbox.render(&format!("--spp 24 {crop} --resume -o a.exr")).exits(0);
    for name in ["joined.exr", "a.exr"] {
        assert!(is_part(&sandbox.image(name), (0, 0), &sandbox.image("full.exr")), "{name}");
        let header = MetaData::read_from_file(sandbox.path(name), true).expect("it has a header").headers;
        assert_eq!(header[0].own_attributes.layer_position, Vec2(3, 2), "{name}");
    }
    // Another part, and the full image, are other images.
    for other in ["--crop 4,2,7,13", ""] {
        sandbox.render(&format!("--spp 24 {other} --resume -o a.exr")).exits(2).on_stderr(&["--crop is"]);
    }
}

#[test]
fn a_crop_outside_the_image_is_refused() {
    let sandbox = Sandbox::new();
    for (crop, why) in [
        ("20,0,5,5", "24 x 16"),
        ("0,16,1,1", "24 x 16"),
        ("4294967295,0,2,1", "24 x 16"),
        ("0,0,0,4", "X,Y,WIDTH,HEIGHT"),
        ("0,0,4", "X,Y,WIDTH,HEIGHT"),
        ("-1,0,4,4", "X,Y,WIDTH,HEIGHT"),
    ] {
        sandbox.render(&format!("--spp 8 -o part.exr --crop={crop}")).exits(2).on_stderr(&[why]);
    }
}
