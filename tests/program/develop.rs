//! Pictures: what `gpu-rt develop` makes of any EXR, and the PNG beside an EXR that is rendered.

use crate::common::program::{finish, meanwhile, send};
use crate::place::{Place, endless};
use std::fs;

use exr::image::write::WritableImage;
use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, f16};
use gpu_rt::output::exr::read_exr;

/// Writes an EXR of 2 x 2 pixels with these channels.
fn write(place: &Place, name: &str, channels: &[(&str, FlatSamples)], corner: (i32, i32)) {
    let list = channels.iter().map(|(name, samples)| AnyChannel::new(*name, samples.clone())).collect();
    let mut own = LayerAttributes::named("picture");
    own.layer_position = corner.into();
    let layer = Layer::new((2, 2), own, Encoding::SMALL_LOSSLESS, AnyChannels::sort(list));
    Image::from_layer(layer).write().to_file(place.work().join(name)).expect("it is written");
}

fn pixels(place: &Place, name: &str) -> Vec<[u8; 3]> {
    let png = image::open(place.work().join(name)).expect("a PNG").into_rgb8();
    png.pixels().map(|pixel| pixel.0).collect()
}

#[test]
fn develop_makes_the_picture_that_render_makes() {
    let place = Place::new();
    let mut pictures = Vec::new();
    for view in ["", "--exposure 2", "--tonemap srgb", "--tonemap neutral --exposure -1", "--tonemap filmic"] {
        let words: Vec<&str> = view.split_whitespace().collect();
        place.render(&[&["--png", "whole.png"], &words[..]].concat()).exits(0);
        let ran = place.says(&format!("develop sphere.exr -o again.png {view}")).exits(0);
        assert_eq!((ran.stdout.as_str(), ran.stderr.as_str()), ("", ""));
        let bytes = |name: &str| fs::read(place.work().join(name)).expect("it is read");
        assert!(bytes("whole.png") == bytes("again.png"), "{view}");
        assert!(!pictures.contains(&bytes("again.png")), "{view}");
        pictures.push(bytes("again.png"));
    }
    assert!(place.says("develop sphere.exr -o again.png --tonemap soft").exits(0).stderr.is_empty());
    assert!(fs::read(place.work().join("again.png")).expect("it is read") == pictures[0], "soft is the default");
}

#[test]
fn develop_takes_any_exr_and_refuses_the_rest() {
    let place = Place::new();
    let float = |values: [f32; 4]| FlatSamples::F32(values.to_vec());
    let half = |values: [f32; 4]| FlatSamples::F16(values.map(f16::from_f32).to_vec());
    let (black, white) = ([0; 3], [255; 3]);
    // 188 is half of the radiance of white.
    let grey = |pixel: [u8; 3]| pixel.iter().all(|v| (187..=188).contains(v));

    write(&place, "luminance.exr", &[("Y", half([0.0, 0.5, 1.0, 70.0]))], (0, 0));
    place.says("develop luminance.exr -o a.png --tonemap srgb").exits(0);
    let found = pixels(&place, "a.png");
    assert!(found[0] == black && grey(found[1]) && found[2..] == [white, white], "{found:?}");

    // A data window elsewhere, and a layer of another program beside depth.
    let red = float([1.0, 0.0, 0.0, 0.5]);
    let layer =
        [("beauty.R", red), ("beauty.G", half([0.0, 1.0, 0.0, 0.5])), ("beauty.B", float([0.0, 0.0, 1.0, 0.5]))];
    write(&place, "layer.exr", &[&layer[..], &[("Z", float([9.0; 4]))]].concat(), (-3, 40));
    place.says("develop layer.exr -o a.png --tonemap srgb").exits(0);
    let found = pixels(&place, "a.png");
    assert!(found[..3] == [[255, 0, 0], [0, 255, 0], [0, 0, 255]] && grey(found[3]), "{found:?}");

    // What has no value to show is said.
    let strange = [f32::NAN, f32::INFINITY, -2.0, f32::NEG_INFINITY];
    write(&place, "strange.exr", &["R", "G", "B"].map(|name| (name, float(strange))), (0, 0));
    let said = place.says("develop strange.exr -o a.png").exits(0).stderr;
    assert_eq!(pixels(&place, "a.png"), [black, white, black, black]);
    for words in ["1 of 4 pixels are NaN", "1 of 4 pixels are infinite", "2 of 4 pixels are negative"] {
        assert!(said.contains(words), "{said}");
    }

    fs::write(place.work().join("text.exr"), "no EXR").expect("it is written");
    let files = place.files();
    for (line, words) in [
        ("develop missing.exr -o b.png", "missing.exr"),
        ("develop text.exr -o b.png", "text.exr: cannot read"),
        ("develop layer.exr -o ./layer.exr", "layer.exr"),
        ("develop layer.exr -o missing/b.png", "missing"),
        ("develop layer.exr -o b.jpg", "give b.png"),
        ("develop - -o b.png", "expected the name of an EXR"),
        ("develop layer.exr", "--output"),
        ("develop layer.exr -o b.png --tonemap reinhard", "soft, srgb, neutral, filmic"),
        ("develop layer.exr -o b.png --exposure nan", "--exposure"),
    ] {
        let ran = place.says(line).exits(2);
        assert!(ran.stderr.contains(words) && ran.stdout.is_empty(), "{line}: {ran:?}");
    }
    assert_eq!(place.files(), files);
    read_exr(&place.work().join("layer.exr")).expect("it is as it was");
}

/// The picture is there while the render goes on, and an interrupt leaves an EXR and a picture of the same samples.
#[cfg(unix)]
#[test]
fn checkpoints_write_the_picture() {
    let place = Place::new();
    let mut child = endless(&place, &["--png", "now.png"]);
    let picture = place.work().join("now.png");
    meanwhile(&mut child, || picture.exists());
    assert_eq!(pixels(&place, "now.png").len(), 20 * 12);
    let written = || fs::metadata(&picture).and_then(|found| found.modified()).expect("it is there");
    let before = written();
    meanwhile(&mut child, || written() != before);
    send(&child, libc::SIGTERM);
    finish(child).exits(143);
    place.says("develop sphere.exr -o then.png").exits(0);
    assert_eq!(pixels(&place, "now.png"), pixels(&place, "then.png"));
}
