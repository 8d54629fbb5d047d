//! Pictures: what `gpu-rt develop` makes of any EXR, and the PNG beside an EXR that is rendered.

use crate::common::device::index as software;
use crate::common::program::{finish, meanwhile, send};
use crate::sandbox::{Sandbox, attribute, endless};
use std::fs;

use exr::image::write::WritableImage;
use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, f16};
use gpu_rt::output::exr::{read_exr, read_layer};

/// Writes an EXR of 2 x 2 pixels with these channels.
fn write(sandbox: &Sandbox, name: &str, channels: &[(&str, FlatSamples)], corner: (i32, i32)) {
    let list = channels.iter().map(|(name, samples)| AnyChannel::new(*name, samples.clone())).collect();
    let mut own = LayerAttributes::named("picture");
    own.layer_position = corner.into();
    let layer = Layer::new((2, 2), own, Encoding::SMALL_LOSSLESS, AnyChannels::sort(list));
    Image::from_layer(layer).write().to_file(sandbox.at(name)).expect("it is written");
}

fn pixels(sandbox: &Sandbox, name: &str) -> Vec<[u8; 3]> {
    let png = image::open(sandbox.at(name)).expect("a PNG").into_rgb8();
    png.pixels().map(|pixel| pixel.0).collect()
}

#[test]
fn develop_makes_the_picture_that_render_makes() {
    let sandbox = Sandbox::new();
    let mut pictures = Vec::new();
    for view in ["", "--exposure 2", "--tonemap srgb", "--tonemap neutral --exposure -1", "--tonemap filmic"] {
        let words: Vec<&str> = view.split_whitespace().collect();
        sandbox.render(&[&["--png", "full.png"], &words[..]].concat()).exits(0);
        let ran = sandbox.says(&format!("develop sphere.exr -o again.png {view}")).exits(0);
        assert_eq!((ran.stdout.as_str(), ran.stderr.as_str()), ("", ""));
        let bytes = |name: &str| fs::read(sandbox.at(name)).expect("it is read");
        assert!(bytes("full.png") == bytes("again.png"), "{view}");
        assert!(!pictures.contains(&bytes("again.png")), "{view}");
        pictures.push(bytes("again.png"));
    }
    assert!(sandbox.says("develop sphere.exr -o again.png --tonemap soft").exits(0).stderr.is_empty());
    assert!(fs::read(sandbox.at("again.png")).expect("it is read") == pictures[0], "soft is the default");
}

#[test]
fn develop_takes_any_exr_and_refuses_the_rest() {
    let sandbox = Sandbox::new();
    let float = |values: [f32; 4]| FlatSamples::F32(values.to_vec());
    let half = |values: [f32; 4]| FlatSamples::F16(values.map(f16::from_f32).to_vec());
    let (black, white) = ([0; 3], [255; 3]);
    // 188 is half of the radiance of white.
    let grey = |pixel: [u8; 3]| pixel.iter().all(|v| (187..=188).contains(v));

    write(&sandbox, "luminance.exr", &[("Y", half([0.0, 0.5, 1.0, 70.0]))], (0, 0));
    sandbox.says("develop luminance.exr -o a.png --tonemap srgb").exits(0);
    let found = pixels(&sandbox, "a.png");
    assert!(found[0] == black && grey(found[1]) && found[2..] == [white, white], "{found:?}");

    // A data window elsewhere, and a layer of another program beside depth.
    let red = float([1.0, 0.0, 0.0, 0.5]);
    let layer =
        [("beauty.R", red), ("beauty.G", half([0.0, 1.0, 0.0, 0.5])), ("beauty.B", float([0.0, 0.0, 1.0, 0.5]))];
    write(&sandbox, "layer.exr", &[&layer[..], &[("Z", float([9.0; 4]))]].concat(), (-3, 40));
    sandbox.says("develop layer.exr -o a.png --tonemap srgb").exits(0);
    let found = pixels(&sandbox, "a.png");
    assert!(found[..3] == [[255, 0, 0], [0, 255, 0], [0, 0, 255]] && grey(found[3]), "{found:?}");

    // What has no value to show is said.
    let strange = [f32::NAN, f32::INFINITY, -2.0, f32::NEG_INFINITY];
    write(&sandbox, "strange.exr", &["R", "G", "B"].map(|name| (name, float(strange))), (0, 0));
    let words = ["1 of 4 pixels are NaN", "1 of 4 pixels are infinite", "2 of 4 pixels are negative"];
    sandbox.says("develop strange.exr -o a.png").exits(0).on_stderr(&words);
    assert_eq!(pixels(&sandbox, "a.png"), [black, white, black, black]);

    fs::write(sandbox.at("text.exr"), "no EXR").expect("it is written");
    let files = sandbox.files();
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
        sandbox.says(line).exits(2).on_stderr(&[words]);
    }
    assert_eq!(sandbox.files(), files);
    read_exr(&sandbox.at("layer.exr")).expect("it is as it was");
}

/// The picture is there while the render goes on, and an interrupt leaves an EXR and a picture of the same samples.
#[cfg(unix)]
#[test]
fn checkpoints_write_the_picture() {
    let sandbox = Sandbox::new();
    let mut child = endless(&sandbox, &["--png", "now.png"]);
    let picture = sandbox.at("now.png");
    meanwhile(&mut child, || picture.exists());
    assert_eq!(pixels(&sandbox, "now.png").len(), 20 * 12);
    let written = || fs::metadata(&picture).and_then(|found| found.modified()).expect("it is there");
    let before = written();
    meanwhile(&mut child, || written() != before);
    send(&child, libc::SIGTERM);
    finish(child).exits(143);
    sandbox.says("develop sphere.exr -o then.png").exits(0);
    assert_eq!(pixels(&sandbox, "now.png"), pixels(&sandbox, "then.png"));
}

/// `develop --lights` mixes what `render --aov lights` has written apart, with its error; `merge` and `--resume` keep it.
#[test]
fn develop_mixes_lights() {
    let sandbox = Sandbox::new();
    let scene = sandbox.scene(
        "lamps.ron",
        "Scene(
            image: (width: 12, height: 8),
            camera: (look_from: (0, 1, 6), look_at: (0, 1, 0), vertical_fov: 40),
            background: Solid((0.2, 0.3, 0.4)),
            materials: {
                \"floor\": Lambertian(albedo: Rgb(0.7, 0.7, 0.7)),
                \"key\": DiffuseLight(emit: Rgb(4, 4, 4), light_group: \"key light\"),
                \"lamp\": DiffuseLight(emit: Rgb(2, 1, 1)),
            },
            objects: [
                Box(min: (-5, -1, -5), max: (5, 0, 5), material: \"floor\"),
                Sphere(center: (-1, 1, 0), radius: 0.6, material: \"key\"),
                Sphere(center: (1, 1, 0), radius: 0.6, material: \"lamp\"),
            ],
        )",
    );
    let render =
        |more: &str| sandbox.says(&format!("render {scene} --aov lights --device {} {more}", software())).exits(0);
    render("--spp 32 -o all.exr");
    render("--samples 0..16 -o a.exr");
    render("--samples 16..32 -o b.exr");
    sandbox.says("merge a.exr b.exr -o merged.exr").exits(0);
    render("--samples 0..32 -o a.exr --resume");
    let layer = |name: &str, layer: &str| read_layer(&sandbox.at(name), layer).expect("it has it").rgb;
    for name in ["merged.exr", "a.exr"] {
        for own in ["light_key light", "light_background", "light_rest"] {
            assert!(layer(name, own) == layer("all.exr", own), "{name} {own}");
        }
    }
    // Factors of 1 give the image and its error; others are those of the layers.
    let stated = |name: &str| attribute(&sandbox.exr(name), "gpu-rt:relative_error").parse::<f64>().expect("a number");
    let close = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        a.as_flattened().iter().zip(b.as_flattened()).all(|(a, b)| (a - b).abs() <= 2e-6 * b.abs())
    };
    sandbox.says("develop all.exr -o same.exr --lights rest=1").exits(0).on_stderr(&["same.exr: relative error"]);
    assert!(close(&sandbox.exr("same.exr").rgb, &sandbox.exr("all.exr").rgb));
    assert!((stated("same.exr") / stated("all.exr") - 1.0).abs() < 1e-5);
    sandbox.says("develop all.exr -o mix.exr --lights").exits(2);
    sandbox.run(&["develop", "all.exr", "-o", "mix.exr", "--lights", "key light=0,background=0.5:1:2,rest=3"]).exits(0);
    let mix = sandbox.exr("mix.exr");
    let (sky, rest) = (layer("all.exr", "light_background"), layer("all.exr", "light_rest"));
    let expected: Vec<[f32; 3]> = sky
        .iter()
        .zip(&rest)
        .map(|(s, r)| [0.5 * s[0] + 3.0 * r[0], s[1] + 3.0 * r[1], 2.0 * s[2] + 3.0 * r[2]])
        .collect();
    assert!(close(&mix.rgb, &expected) && !close(&mix.rgb, &sandbox.exr("all.exr").rgb));
    assert!(mix.attributes.iter().all(|(name, _)| name != "gpu-rt:relative_error_bound"), "{:?}", mix.attributes);
    assert_eq!(attribute(&mix, "gpu-rt:lights"), "key light=0:0:0,background=0.5:1:2,rest=3:3:3");
    // Groups of another program that do not add up to the image are no mix.
    let of_all = ["R", "G", "B", "Combined_key.R", "Combined_key.G", "Combined_key.B"];
    write(&sandbox, "others.exr", &of_all.map(|name| (name, FlatSamples::F32(vec![1.0; 4]))), (0, 0));
    sandbox.says("develop others.exr -o b.png --lights key=1").exits(2).on_stderr(&["no lights apart"]);
    sandbox.says("merge mix.exr all.exr -o no.exr").exits(2).on_stderr(&["mix.exr"]);
    // The names of Blender's passes; without a state there is no error.
    render("--spp 16 -o blender.exr --aov-names blender --no-state");
    let ran = sandbox.says("develop blender.exr -o mix.png --lights background=0").exits(0);
    assert_eq!(ran.stderr, "");
    for (line, words) in [
        ("develop all.exr -o b.png --lights sun=1", "it has background, key light, rest"),
        ("develop sphere.exr -o b.png --lights key=1", "--aov lights"),
        ("develop all.exr -o b.png --lights rest=-1", "expected NAME=FACTOR"),
        ("develop all.exr -o b.png --lights rest=1:2", "expected NAME=FACTOR"),
        ("develop all.exr -o b.png --lights rest=1,rest=2", "rest has two factors"),
        ("develop all.exr -o b.png --lights rest=nan", "expected NAME=FACTOR"),
    ] {
        sandbox.render(&[]).exits(0);
        sandbox.says(line).exits(2).on_stderr(&[words]);
    }
}
