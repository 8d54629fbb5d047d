//! `--aov cryptomatte` in files: names and ids in the header, joined, resumed and cropped to the bit, and what is said where names are lost.

use crate::aov::channels;
use crate::common::device::index as software;
use crate::common::gltf::{glb, moving};
use crate::common::oidn;
use crate::sandbox::{SPHERE, Sandbox, attribute};
use serde_json::{Value, json};

/// Balls of these names and materials, side by side, eight in a row.
fn balls(names: &[(&str, &str)]) -> String {
    let ball = |(number, (name, material)): (usize, &(&str, &str))| {
        let at = |index: usize, count: usize| 0.9 * (index as f64 - (count - 1) as f64 / 2.0);
        let (x, y) = (at(number % 8, names.len().min(8)), at(number / 8, names.len().div_ceil(8)));
        format!("Named(name: \"{name}\", object: Sphere(center: ({x}, {y}, 0), radius: 0.5, material: \"{material}\"))")
    };
    let all: Vec<String> = names.iter().enumerate().map(ball).collect();
    SPHERE.replace("Sphere(center: (0, 0, 0), radius: 1, material: \"grey\")", &all.join(", ")).replace(
        "materials: {",
        "materials: { \"unused\": Dielectric(ior: 1.5), \"red\": Lambertian(albedo: Rgb(0.9, 0.1, 0.1)),",
    )
}

fn render(sandbox: &Sandbox, more: &str) -> crate::common::program::Ran {
    sandbox.says(&format!("render ../scenes/sphere.ron --device {} {more}", software()))
}

#[test]
fn mattes_are_joined_resumed_and_cropped_to_the_bit() {
    let sandbox = Sandbox::new();
    sandbox.scene("sphere.ron", &balls(&[("a", "grey"), ("b", "red"), ("a", "red")]));
    let render = |more: &str| render(&sandbox, &format!("--aov cryptomatte {more}"));
    render("--spp 24 -o full.exr").exits(0);
    render("--spp 24 --slots 7 -o slots.exr").exits(0);
    render("--samples 0..8 -o a.exr").exits(0);
    render("--samples 8..24 -o b.exr").exits(0);
    sandbox.says("merge b.exr a.exr -o joined.exr").exits(0);
    render("--spp 24 --resume -o a.exr").exits(0);
    render("--spp 24 --crop 4,3,9,8 -o part.exr").exits(0);
    let full = channels(&sandbox, "full.exr");
    assert_eq!(full.len(), 8 + 2 * 12 + 1);
    for file in ["slots.exr", "joined.exr", "a.exr"] {
        assert!(channels(&sandbox, file) == full, "{file}");
    }
    assert!(channels(&sandbox, "b.exr") != full);
    for (name, values) in channels(&sandbox, "part.exr") {
        let rows = values.chunks(9).zip(full[&name].chunks(20).skip(3));
        assert!(rows.into_iter().all(|(part, full)| *part == full[4..13]), "{name}");
    }
    // The manifest has all names, each once, with their ids; that of the joined image, too.
    for file in ["full.exr", "joined.exr", "a.exr"] {
        let (image, key) = (sandbox.exr(file), "cryptomatte/3ae39a5");
        let manifest: Value = serde_json::from_str(attribute(&image, &format!("{key}/manifest"))).expect("JSON");
        assert_eq!(manifest, json!({"a": "3c2569b2", "b": "95de7e03"}));
        assert_eq!(attribute(&image, &format!("{key}/name")), "CryptoObject");
        assert_eq!(attribute(&image, &format!("{key}/hash")), "MurmurHash3_32");
        assert_eq!(attribute(&image, &format!("{key}/conversion")), "uint32_to_float32");
        let materials = attribute(&image, "cryptomatte/be359d6/manifest");
        assert!(["grey", "red", "unused"].iter().all(|name| materials.contains(name)), "{materials}");
        assert_eq!(attribute(&image, "gpu-rt:crypto_lost_pixels"), "0");
        // Only files of glTF have assets.
        assert!(!image.attributes.iter().any(|(_, value)| value == "CryptoAsset"));
    }
    // The two balls of one name are one matte: in the middle row, the id is on both sides of the other.
    let first: Vec<u32> = full["CryptoObject00.R"][6 * 20..7 * 20].iter().copied().filter(|id| *id != 0).collect();
    let mut order = first.clone();
    order.dedup();
    assert_eq!(order, [0x3c25_69b2, 0x95de_7e03, 0x3c25_69b2], "{first:x?}");

    // Nothing of it is there where nothing asks.
    render("--spp 8 -o x.exr").exits(0);
    let plan =
        |more: &str| sandbox.says(&format!("plan ../scenes/sphere.ron --device {} {more}", software())).exits(0).stdout;
    assert!(plan("--aov cryptomatte").contains("matte_ids") && !plan("--aov object").contains("matte"));
    // A file without mattes is not resumed with them.
    sandbox.says(&format!("render ../scenes/sphere.ron --spp 8 -o plain.exr --device {}", software())).exits(0);
    render("--spp 16 --resume -o plain.exr").exits(2).on_stderr(&["--aov is cryptomatte"]);
}

#[test]
fn layers_of_mattes_are_compared() {
    let sandbox = Sandbox::new();
    sandbox.scene("sphere.ron", &balls(&[("a", "grey"), ("b", "red")]));
    render(&sandbox, "--spp 8 --aov cryptomatte -o a.exr").exits(0);
    sandbox.scene("sphere.ron", &balls(&[("a", "grey"), ("c", "red")]));
    render(&sandbox, "--spp 8 --aov cryptomatte -o b.exr").exits(0);
    let identical = |layer: &str| {
        sandbox.says(&format!("compare a.exr b.exr --json --layer {layer}")).exits(0).json()["identical"] == true
    };
    let layers = ["CryptoObject00", "CryptoObject01", "CryptoMaterial00", "CryptoMaterial02", "crypto_lost"];
    assert_eq!(layers.map(identical), [false, true, true, true, true]);
}

#[test]
fn blender_has_its_names_of_mattes() {
    let sandbox = Sandbox::new();
    sandbox.scene("sphere.ron", &balls(&[("Cube", "grey"), ("b", "red")]));
    for more in ["", "--no-state"] {
        let line = format!("--spp 8 --aov cryptomatte --aov-names blender {more} --force -o a.exr");
        render(&sandbox, &line).exits(0);
        let (names, image) = (channels(&sandbox, "a.exr"), sandbox.exr("a.exr"));
        let letters = ["r", "g", "b", "a"].map(|letter| format!("ViewLayer.CryptoObject01.{letter}"));
        assert!(letters.iter().all(|name| names.contains_key(name)), "{:?}", names.keys());
        assert_eq!(attribute(&image, "cryptomatte/542cafa/name"), "ViewLayer.CryptoObject");
        assert!(attribute(&image, "cryptomatte/542cafa/manifest").contains("\"Cube\":\"a8fce865\""));
        sandbox.says("compare a.exr a.exr --layer CryptoObject00 --fail-above mse=0").exits(0);
    }
}

/// Assets are the topmost nodes of a glTF file, by their names or places.
#[test]
fn assets_are_topmost_nodes() {
    let sandbox = Sandbox::new();
    let (mut json, binary) = moving();
    json["nodes"][1]["children"] = json!([2, 3]);
    json["nodes"][3]["name"] = json!("square");
    json["scenes"][0]["nodes"] = json!([0, 1, 4, 5, 6]);
    std::fs::write(sandbox.folder.path().join("scenes/moving.glb"), glb(&json, &binary)).expect("it is written");
    let line = format!("render ../scenes/moving.glb --size 16x10 --device {}", software());
    sandbox.says(&format!("{line} --spp 8 --aov cryptomatte -o a.exr")).exits(0);
    let image = sandbox.exr("a.exr");
    let assets: Value = serde_json::from_str(attribute(&image, "cryptomatte/f42029d/manifest")).expect("JSON");
    let names: Vec<&String> = assets.as_object().expect("an object").keys().collect();
    assert_eq!(names, ["lower", "nodes[0]", "nodes[4]"]);
    let objects = attribute(&image, "cryptomatte/3ae39a5/manifest");
    assert!(objects.contains("\"square\"") && !objects.contains("\"lower\""), "{objects}");
    assert!(channels(&sandbox, "a.exr")["CryptoAsset00.R"].iter().any(|id| *id != 0));
    sandbox.says(&format!("{line} --aov cryptomatte --spp 16 --resume -o a.exr")).exits(0);
}

#[test]
fn lost_names_are_said_and_a_filter_with_negative_weights_is_refused() {
    let sandbox = Sandbox::new();
    let names: Vec<String> = (0..40).map(|number| format!("ball {number}")).collect();
    let pairs: Vec<(&str, &str)> = names.iter().map(|name| (name.as_str(), "grey")).collect();
    sandbox.scene("sphere.ron", &balls(&pairs).replace("look_from: (0, 0, 3)", "look_from: (0, 0, 10)"));
    let view = "--size 1x1 --spp 256 --aov cryptomatte";
    let ran = render(&sandbox, &format!("{view} --json -o a.exr")).exits(0);
    let says = "warning: the camera sees more than 16 names in 1 pixel:";
    assert_eq!(
        (ran.json()["crypto_lost_pixels"].as_u64(), ran.stderr.contains(says)),
        (Some(1), true),
        "{}",
        ran.stderr
    );
    assert_eq!(attribute(&sandbox.exr("a.exr"), "gpu-rt:crypto_lost_pixels"), "1");
    assert!(f32::from_bits(channels(&sandbox, "a.exr")["crypto_lost.Y"][0]) > 0.0);
    render(&sandbox, &format!("{view} --samples 256..264 -o b.exr").replace("--spp 256", "")).exits(0);
    let merged = sandbox.says("merge a.exr b.exr -o c.exr --json").exits(0);
    assert!(merged.stderr.contains(says) && merged.json()["crypto_lost_pixels"] == 1, "{}", merged.stderr);
    let says = ["--filter mitchell: --aov cryptomatte counts samples", "use --filter gauss, tent or box"];
    render(&sandbox, &format!("{view} --filter mitchell -o d.exr")).exits(2).on_stderr(&says);
    assert!(!sandbox.at("d.exr").exists());
}

/// A denoised image is the picture alone, and names no mattes.
#[test]
fn a_denoised_image_names_no_mattes() {
    let sandbox = Sandbox::new();
    sandbox.scene("sphere.ron", &balls(&[("a", "grey"), ("b", "red")]));
    render(&sandbox, "--spp 8 --aov cryptomatte -o a.exr").exits(0);
    let folder = oidn::folder();
    let line = ["denoise", "a.exr", "-o", "b.exr", "--oidn", folder.to_str().expect("UTF-8")];
    sandbox.run(&line).exits(0);
    let named =
        |file: &str| sandbox.exr(file).attributes.iter().filter(|(name, _)| name.starts_with("cryptomatte/")).count();
    assert_eq!((named("a.exr"), named("b.exr")), (8, 0));
}
