//! `--aov` in files: joined, resumed and cropped like the radiance, named in two ways, and compared.

use std::collections::BTreeMap;

use crate::common::device::index as software;
use crate::common::program::words;
use crate::sandbox::{SPHERE, Sandbox, attribute};
use exr::prelude::{MetaData, read_first_flat_layer_from_file};

const ALL: &str = "albedo,normal,depth,position,object,material,direct,indirect,motion,depth0,distance0,position0,normal0,uv0,face0,offset0";

/// The bits of all channels of a file's picture, by their names.
pub fn channels(sandbox: &Sandbox, name: &str) -> BTreeMap<String, Vec<u32>> {
    let image = read_first_flat_layer_from_file(sandbox.at(name)).expect("an EXR");
    let bits = |channel: &exr::image::AnyChannel<exr::image::FlatSamples>| match &channel.sample_data {
        exr::image::FlatSamples::F32(values) => values.iter().map(|value| value.to_bits()).collect(),
        exr::image::FlatSamples::U32(values) => values.clone(),
        exr::image::FlatSamples::F16(_) => Vec::new(),
    };
    image.layer_data.channel_data.list.iter().map(|channel| (channel.name.to_string(), bits(channel))).collect()
}

#[test]
fn channels_are_joined_and_resumed_to_the_bit() {
    let sandbox = Sandbox::new();
    let render = |more: &str| sandbox.render(&words(more));
    render(&format!("--spp 24 --aov {ALL} -o full.exr")).exits(0);
    render(&format!("--samples 0..8 --aov {ALL} -o a.exr")).exits(0);
    render(&format!("--samples 8..24 --aov {ALL} -o b.exr")).exits(0);
    sandbox.says("merge b.exr a.exr -o joined.exr").exits(0);
    render(&format!("--spp 24 --aov {ALL} --resume -o a.exr")).exits(0);
    let full = channels(&sandbox, "full.exr");
    assert_eq!(full.len(), 8 + 3 + 3 + 1 + 3 + 2 + 6 + 15);
    assert!(channels(&sandbox, "joined.exr") == full && channels(&sandbox, "a.exr") == full);
    assert!(channels(&sandbox, "b.exr") != full);
    // Without them, the picture is the same.
    render("--spp 24 -o plain.exr").exits(0);
    let plain = channels(&sandbox, "plain.exr");
    assert!(plain.len() == 8 && plain.iter().all(|(name, values)| full[name] == *values));
    assert_eq!(attribute(&sandbox.exr("full.exr"), "gpu-rt:materials"), "grey");

    // Files that have others are not joined, nor resumed.
    for other in ["", "--aov albedo", &format!("--aov {ALL} --aov-surface first")] {
        render(&format!("--spp 32 {other} --resume -o a.exr")).exits(2).on_stderr(&["--aov"]);
    }
    render("--samples 24..32 -o c.exr").exits(0);
    sandbox.says("merge a.exr c.exr -o d.exr").exits(2).on_stderr(&["--aov is"]);
}

#[test]
fn a_part_has_the_channels_of_the_full_image() {
    let sandbox = Sandbox::new();
    let render = |more: &str| sandbox.render(&words(more)).exits(0);
    render(&format!("--spp 8 --aov {ALL} -o full.exr"));
    render(&format!("--spp 8 --aov {ALL} --crop 4,3,9,8 -o part.exr"));
    let (full, part) = (channels(&sandbox, "full.exr"), channels(&sandbox, "part.exr"));
    for (name, values) in part {
        let rows = values.chunks(9).zip(full[&name].chunks(20).skip(3));
        assert!(rows.into_iter().all(|(part, full)| *part == full[4..13]), "{name}");
    }
}

/// The names of the objects by the numbers of `object.Y`, of each copy apart: those of a render, of one that is resumed, and of parts that are
/// joined. Each is where its number is.
#[test]
fn objects_have_names() {
    let sandbox = Sandbox::new();
    let ball = |x: i32| format!("Sphere(center: ({x}, 0, 0), radius: 0.4, material: \"grey\")");
    let cup =
        format!("Named(name: \"cup, blue\", object: Group([{}, Named(name: \"ear\", object: {})]))", ball(-1), ball(0));
    let moved = format!("Transformed(by: [Translate((2, 0, 0))], object: {cup})");
    let text = SPHERE
        .replace("Sphere(center: (0, 0, 0), radius: 1, material: \"grey\")", &format!("{moved}, {}, {cup}", ball(3)));
    let scene = sandbox.scene("cups.ron", &text.replace("(0, 0, 3)", "(0, 0, 9)").replace("fov: 50", "fov: 10"));
    let render = |more: &str| {
        let line = format!("render {scene} --device {} --size 90x9 --aov object {more}", software());
        sandbox.says(&line)
    };
    render("--spp 16 -o full.exr").exits(0);
    render("--samples 0..8 -o a.exr").exits(0);
    render("--samples 8..16 -o b.exr").exits(0);
    sandbox.says("merge b.exr a.exr -o joined.exr").exits(0);
    render("--spp 16 --resume -o a.exr").exits(0);
    let names = "cup, blue\near\nobjects[1]\ncup, blue\near";
    for file in ["full.exr", "a.exr", "joined.exr"] {
        assert_eq!(attribute(&sandbox.exr(file), "gpu-rt:objects"), names, "{file}");
    }
    // From left to right at x = -1, 0, 1, 2 and 3: the second cup, the first cup, and the ball.
    let row = &channels(&sandbox, "full.exr")["object.Y"][4 * 90..5 * 90];
    let mut numbers: Vec<f32> = row.iter().map(|bits| f32::from_bits(*bits)).filter(|number| *number > 0.0).collect();
    numbers.dedup();
    assert_eq!(numbers, [4.0, 5.0, 1.0, 2.0, 3.0]);

    // No names without the numbers, and none that no line holds.
    sandbox.says(&format!("render {scene} --device {} --size 9x9 --spp 1 -o no.exr", software())).exits(0);
    assert!(sandbox.exr("no.exr").attributes.iter().all(|(name, _)| name != "gpu-rt:objects"));
    for name in ["", "a\\nb"] {
        sandbox.scene("bad.ron", &text.replace("cup, blue", name));
        let says = ["expected a name of one line, found", "objects[0].Transformed.object.Named.name"];
        sandbox.says("check ../scenes/bad.ron").exits(2).on_stderr(&says);
    }
}

#[test]
fn blender_has_its_names() {
    let sandbox = Sandbox::new();
    for (more, prefix) in [("", ""), ("--no-state", "ViewLayer.")] {
        let line = format!("--spp 8 --aov {ALL} --aov-names blender {more} --force -o a.exr");
        sandbox.render(&words(&line)).exits(0);
        let names = channels(&sandbox, "a.exr");
        for name in ["Combined.R", "Depth.Z", "Denoising Albedo.G", "Denoising Normal.Y", "Position.X", "IndexOB.X"] {
            assert!(names.contains_key(&format!("{prefix}{name}")), "{name}: {:?}", names.keys());
        }
        let headers = MetaData::read_from_file(sandbox.at("a.exr"), true).expect("an EXR").headers;
        let part = headers[0].own_attributes.layer_name.as_ref().map(ToString::to_string);
        assert_eq!(part.as_deref(), more.is_empty().then_some("ViewLayer"));
        // The picture is found, and so are layers by their own names.
        sandbox.says("develop a.exr -o a.png").exits(0);
        sandbox.says("compare a.exr a.exr --layer Depth --fail-above mse=0").exits(0);
        sandbox.says("compare a.exr a.exr --fail-above mse=0").exits(0);
    }
    // With a state it goes on.
    for line in ["--samples 0..8 --force", "--spp 16 --resume"] {
        sandbox.render(&words(&format!("{line} --aov {ALL} --aov-names blender -o a.exr"))).exits(0);
    }
    assert!(channels(&sandbox, "a.exr").contains_key("Depth.Z"));
}

#[test]
fn layers_are_compared() {
    let sandbox = Sandbox::new();
    sandbox.scene("dark.ron", &SPHERE.replace("0.5, 0.4, 0.3", "0.25, 0.4, 0.3"));
    sandbox.render(&["--spp", "8", "--aov", "albedo,depth,normal", "-o", "a.exr"]).exits(0);
    let line = "render ../scenes/dark.ron --spp 8 --aov albedo,depth,normal --quiet -o b.exr --device";
    sandbox.says(&format!("{line} {}", crate::common::device::index())).exits(0);
    let mse = |layer: &str| {
        sandbox.says(&format!("compare a.exr b.exr --json --layer {layer}")).exits(0).json()["mse"].as_f64().unwrap()
    };
    assert_eq!((mse("Z"), mse("N")), (0.0, 0.0));
    // The sphere covers a share s of each pixel, and red differs there by 1/4: the mean over the image is below 1/16/3.
    let albedo = mse("albedo");
    assert!(albedo > 0.002 && albedo < 1.0 / 48.0, "{albedo}");
    sandbox.says("compare a.exr b.exr --layer depth").exits(2).on_stderr(&["it has no layer depth; it has", "albedo"]);
}

#[test]
fn channels_that_no_file_can_hold_are_refused() {
    let sandbox = Sandbox::new();
    let ran = sandbox.render(&["--spp", "8", "--aov", "albedo", "-o", "a.png"]).exits(2);
    assert!(ran.stderr.contains("a PNG has no room for the channels of --aov"), "{}", ran.stderr);
    let ran = sandbox.render(&["--spp", "8", "--aov", "albedo,colour", "-o", "a.exr"]).exits(2);
    assert!(ran.stderr.contains("expected some of albedo, normal"), "{}", ran.stderr);
    assert_eq!(sandbox.files(), Vec::<String>::new());
}
