//! `--aov` in files: joined, resumed and cropped like the radiance, named in two ways, and compared.

use std::collections::BTreeMap;

use exr::prelude::{MetaData, read_first_flat_layer_from_file};

use crate::place::{Place, SPHERE, attribute};

const ALL: &str = "albedo,normal,depth,position,object,material,direct,indirect";

/// The bits of all channels of a file's picture, by their names.
fn channels(place: &Place, name: &str) -> BTreeMap<String, Vec<u32>> {
    let image = read_first_flat_layer_from_file(place.work().join(name)).expect("an EXR");
    let bits = |channel: &exr::image::AnyChannel<exr::image::FlatSamples>| match &channel.sample_data {
        exr::image::FlatSamples::F32(values) => values.iter().map(|value| value.to_bits()).collect(),
        exr::image::FlatSamples::U32(values) => values.clone(),
        exr::image::FlatSamples::F16(_) => Vec::new(),
    };
    image.layer_data.channel_data.list.iter().map(|channel| (channel.name.to_string(), bits(channel))).collect()
}

#[test]
fn channels_are_joined_and_resumed_to_the_bit() {
    let place = Place::new();
    let render = |more: &str| place.render(&more.split_whitespace().collect::<Vec<_>>());
    render(&format!("--spp 24 --aov {ALL} -o whole.exr")).exits(0);
    render(&format!("--samples 0..8 --aov {ALL} -o a.exr")).exits(0);
    render(&format!("--samples 8..24 --aov {ALL} -o b.exr")).exits(0);
    place.says("merge b.exr a.exr -o joined.exr").exits(0);
    render(&format!("--spp 24 --aov {ALL} --resume -o a.exr")).exits(0);
    let whole = channels(&place, "whole.exr");
    assert_eq!(whole.len(), 8 + 3 + 3 + 1 + 3 + 2 + 6);
    assert!(channels(&place, "joined.exr") == whole && channels(&place, "a.exr") == whole);
    assert!(channels(&place, "b.exr") != whole);
    // Without them, the picture is the same.
    render("--spp 24 -o plain.exr").exits(0);
    let plain = channels(&place, "plain.exr");
    assert!(plain.len() == 8 && plain.iter().all(|(name, values)| whole[name] == *values));
    assert_eq!(attribute(&place.exr("whole.exr"), "gpu-rt:materials"), "grey");

    // Files that have others are not joined, nor resumed.
    for other in ["", "--aov albedo", &format!("--aov {ALL} --aov-surface first")] {
        let ran = render(&format!("--spp 32 {other} --resume -o a.exr")).exits(2);
        assert!(ran.stderr.contains("--aov"), "{}", ran.stderr);
    }
    render("--samples 24..32 -o c.exr").exits(0);
    let ran = place.says("merge a.exr c.exr -o d.exr").exits(2);
    assert!(ran.stderr.contains("--aov is"), "{}", ran.stderr);
}

#[test]
fn a_part_has_the_channels_of_the_whole() {
    let place = Place::new();
    let render = |more: &str| place.render(&more.split_whitespace().collect::<Vec<_>>()).exits(0);
    render(&format!("--spp 8 --aov {ALL} -o whole.exr"));
    render(&format!("--spp 8 --aov {ALL} --crop 4,3,9,8 -o part.exr"));
    let (whole, part) = (channels(&place, "whole.exr"), channels(&place, "part.exr"));
    for (name, values) in part {
        let rows = values.chunks(9).zip(whole[&name].chunks(20).skip(3));
        assert!(rows.into_iter().all(|(part, whole)| *part == whole[4..13]), "{name}");
    }
}

#[test]
fn blender_has_its_names() {
    let place = Place::new();
    for (more, prefix) in [("", ""), ("--no-state", "ViewLayer.")] {
        let line = format!("--spp 8 --aov {ALL} --aov-names blender {more} --force -o a.exr");
        place.render(&line.split_whitespace().collect::<Vec<_>>()).exits(0);
        let names = channels(&place, "a.exr");
        for name in ["Combined.R", "Depth.Z", "Denoising Albedo.G", "Denoising Normal.Y", "Position.X", "IndexOB.X"] {
            assert!(names.contains_key(&format!("{prefix}{name}")), "{name}: {:?}", names.keys());
        }
        let headers = MetaData::read_from_file(place.work().join("a.exr"), true).expect("an EXR").headers;
        let part = headers[0].own_attributes.layer_name.as_ref().map(ToString::to_string);
        assert_eq!(part.as_deref(), more.is_empty().then_some("ViewLayer"));
        // The picture is found, and so are layers by their own names.
        place.says("develop a.exr -o a.png").exits(0);
        place.says("compare a.exr a.exr --layer Depth --fail-above mse=0").exits(0);
        place.says("compare a.exr a.exr --fail-above mse=0").exits(0);
    }
    // With a state it goes on.
    let line = format!("--samples 0..8 --aov {ALL} --aov-names blender --force -o a.exr");
    place.render(&line.split_whitespace().collect::<Vec<_>>()).exits(0);
    let line = format!("--spp 16 --aov {ALL} --aov-names blender --resume -o a.exr");
    place.render(&line.split_whitespace().collect::<Vec<_>>()).exits(0);
    assert!(channels(&place, "a.exr").contains_key("Depth.Z"));
}

#[test]
fn layers_are_compared() {
    let place = Place::new();
    place.scene("dark.ron", &SPHERE.replace("0.5, 0.4, 0.3", "0.25, 0.4, 0.3"));
    place.render(&["--spp", "8", "--aov", "albedo,depth,normal", "-o", "a.exr"]).exits(0);
    let line = "render ../scenes/dark.ron --spp 8 --aov albedo,depth,normal --quiet -o b.exr --device";
    place.says(&format!("{line} {}", crate::common::device::index())).exits(0);
    let mse = |layer: &str| {
        place.says(&format!("compare a.exr b.exr --json --layer {layer}")).exits(0).json()["mse"].as_f64().unwrap()
    };
    assert_eq!((mse("Z"), mse("N")), (0.0, 0.0));
    // The sphere covers a share s of each pixel, and red differs there by 1/4: the mean over the image is below 1/16/3.
    let albedo = mse("albedo");
    assert!(albedo > 0.002 && albedo < 1.0 / 48.0, "{albedo}");
    let ran = place.says("compare a.exr b.exr --layer depth").exits(2);
    assert!(ran.stderr.contains("it has no layer depth; it has") && ran.stderr.contains("albedo"), "{}", ran.stderr);
}

#[test]
fn channels_without_a_place_are_refused() {
    let place = Place::new();
    let ran = place.render(&["--spp", "8", "--aov", "albedo", "-o", "a.png"]).exits(2);
    assert!(ran.stderr.contains("a PNG has no room for the channels of --aov"), "{}", ran.stderr);
    let ran = place.render(&["--spp", "8", "--aov", "albedo,colour", "-o", "a.exr"]).exits(2);
    assert!(ran.stderr.contains("expected some of albedo, normal"), "{}", ran.stderr);
    assert_eq!(place.files(), Vec::<String>::new());
}
