//! Textures of pbrt-v4 that no file has as they are: the values of their texels, and what they are once they are written.

use std::fs;
use std::path::Path;

use gpu_rt::bitmap::{Bitmap, Channel, Format, from_srgb};
use gpu_rt::scene::{
    Assets, Background, Colour, GltfOptions, Lambertian, Material, Scene, Texture, write_exr, write_ply,
};
use tempfile::TempDir;

use crate::common::stats::Random;
use crate::mitsuba::mutate;
use crate::pbrt::{VIEW, folder, load};

const CODES: [[u8; 4]; 6] = [
    [0, 0, 0, 255],
    [51, 102, 153, 255],
    [255, 255, 255, 255],
    [204, 10, 90, 255],
    [128, 128, 128, 255],
    [7, 8, 9, 255],
];

/// A PNG of 3 by 2 texels.
fn png(texel: impl Fn(usize) -> [u8; 4]) -> Vec<u8> {
    let image = image::RgbaImage::from_fn(3, 2, |x, y| image::Rgba(texel((3 * y + x) as usize)));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn grey(code: u8) -> [u8; 4] {
    [code, code, code, 255]
}

/// A scene with a body of the texture "t", and one whose alpha is the float "a" if there is one.
fn files(directives: &str) -> TempDir {
    let body = |material: &str, more: &str| {
        format!("{material} Shape \"trianglemesh\" \"point3 P\" [0 0 5 1 0 5 0 1 5] {more}\n")
    };
    let alpha = if directives.contains("\"a\" \"float\"") { "\"texture alpha\" \"a\"" } else { "" };
    let first = body("Material \"diffuse\" \"texture reflectance\" \"t\"", alpha);
    let text = format!("{VIEW}{directives} {first} LightSource \"infinite\"");
    let wide = Bitmap::of_floats(6, 2, (0..12).map(|index| [index as f32 / 8.0; 3]));
    let folder = folder(&[
        ("a.pbrt", text.as_bytes()),
        ("colours.png", &png(|index| CODES[index])),
        ("greys.png", &png(|index| grey(40 * index as u8))),
        ("leaf.png", &png(|index| [9, 9, 9, 50 * index as u8])),
    ]);
    write_exr(&wide, &mut fs::File::create(folder.path().join("wide.exr")).unwrap()).unwrap();
    folder
}

/// The albedo and the alpha of the first body.
fn textures(scene: &Scene) -> (&Texture, &Texture) {
    let Material::Lambertian(Lambertian { albedo, alpha, .. }) = &scene.materials[0].1 else {
        panic!("{:?}", scene.materials)
    };
    (albedo, alpha)
}

/// The values of all texels of a texture.
fn values(texture: &Texture, scene: &Scene) -> Vec<Colour> {
    let Texture::Image { tint, .. } = texture else { panic!("{texture:?}") };
    let bitmap = texture.bitmap(&scene.bitmaps).expect("it is loaded");
    bitmap.texels().map(|texel| *tint * Colour::from_array(texel.map(f64::from))).collect()
}

fn srgb(index: usize) -> Colour {
    let [r, g, b, _] = CODES[index].map(|code| f64::from(from_srgb(f64::from(code) / 255.0)));
    Colour::new(r, g, b)
}

fn code(index: usize) -> Colour {
    let [r, g, b, _] = CODES[index].map(|code| f64::from(code) / 255.0);
    Colour::new(r, g, b)
}

/// The sRGB codes of greys.png, as light.
fn share(index: usize) -> f64 {
    f64::from(from_srgb(f64::from(40 * index as u8) / 255.0))
}

const T: &str = r#"Texture "t" "spectrum" "imagemap" "string filename" "colours.png""#;
const GREYS: &str = r#"Texture "g" "float" "imagemap" "string filename" "greys.png""#;

/// Directives, the values of a texel, and what is told.
type Case = (String, fn(usize) -> Colour, &'static [&'static str]);

#[test]
fn values_are_those_of_pbrt() {
    let inverted = |scale: f64| format!("{T} \"bool invert\" true \"float scale\" {scale}");
    let cases: &[Case] = &[
        (inverted(0.5), |index| 1.0 - 0.5 * srgb(index), &[]),
        (inverted(2.0), |index| (1.0 - 2.0 * srgb(index)).max(Colour::ZERO), &[]),
        (
            format!("{T} \"string encoding\" \"gamma 2.2\" \"float scale\" 0.5"),
            |index| 0.5 * code(index).powf(2.2),
            &[],
        ),
        (format!("{T} \"string encoding\" \"linear\" \"bool invert\" true"), |index| 1.0 - code(index), &[]),
        (format!("{T} \"float scale\" 3"), |index| (3.0 * srgb(index)).min(Colour::ONE), &[]),
        // Scaled again before it is cut.
        (
            format!(
                "{} \"float scale\" 3 Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"s\" \"float scale\" 0.25",
                T.replace("\"t\"", "\"s\"")
            ),
            |index| 0.75 * srgb(index),
            &[],
        ),
        (
            format!(
                "{} {GREYS} Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"s\" \"texture scale\" \"g\"",
                T.replace("\"t\"", "\"s\"")
            ),
            |index| share(index) * srgb(index),
            &["Texture scale: its images are multiplied at texels"],
        ),
        (
            format!(
                "{GREYS} Texture \"t\" \"spectrum\" \"mix\" \"rgb tex1\" [1 0 0.5] \"rgb tex2\" [0 1 0.5] \"texture amount\" \"g\""
            ),
            |index| Colour::new(1.0 - share(index), share(index), 0.5),
            &[],
        ),
        (
            format!(
                "{} Texture \"t\" \"spectrum\" \"mix\" \"texture tex1\" \"s\" \"rgb tex2\" [1 1 1] \"float amount\" 0.25",
                T.replace("\"t\"", "\"s\"")
            ),
            |index| 0.75 * srgb(index) + 0.25,
            &[],
        ),
        (
            format!(
                "{} {GREYS} Texture \"t\" \"spectrum\" \"mix\" \"texture tex1\" \"s\" \"rgb tex2\" [1 1 1] \"texture amount\" \"g\"",
                T.replace("\"t\"", "\"s\"")
            ),
            |index| srgb(index).lerp(Colour::ONE, share(index)),
            &["Texture mix: its images are multiplied at texels"],
        ),
    ];
    for (directives, expected, told) in cases {
        let files = files(directives);
        let path = files.path().join("a.pbrt");
        let scene = load(&path, false).unwrap_or_else(|error| panic!("{error}"));
        let found = values(textures(&scene).0, &scene);
        let off = |index: usize| (found[index] - expected(index)).abs().max_element();
        assert!(found.len() == 6 && (0..6).all(|index| off(index) < 1e-6), "{directives}: {found:?}");
        // Each has a texel that another texel's place would not fit.
        assert!((0..6).any(|index| (found[index] - expected(5 - index)).abs().max_element() > 0.05));
        let warnings = scene.warnings();
        let is_told = |own: &String| told.iter().any(|told| own.contains(told));
        assert!(warnings.len() == told.len() && warnings.iter().all(is_told), "{warnings:?}");
        assert_eq!(load(&path, true).is_err(), !told.is_empty());
        // The files of what is made are those of the scene.
        assert!(scene.inputs().iter().any(|input| input.ends_with("colours.png") || input.ends_with("greys.png")));
        assert!(scene.inputs().iter().all(|input| input.exists()), "{:?}", scene.inputs());
    }
}

/// What a leaf reflects and lets pass, at each texel: the parts of a matt body that passes a share of its light.
#[test]
fn leaves_have_textures() {
    let passed = Colour::new(0.25, 0.5, 0.125);
    let leaf = |more: &str| {
        let files = files(&format!(
            "{T} Material \"diffusetransmission\" \"texture reflectance\" \"t\" {more} Shape \"sphere\""
        ));
        (load(&files.path().join("a.pbrt"), false).unwrap_or_else(|error| panic!("{error}")), files)
    };
    let rgb = "\"rgb transmittance\" [.25 .5 .125]";
    let tells = |told: &[&str], scene: &Scene| {
        let warnings = scene.warnings();
        assert!(
            warnings.len() == told.len() && warnings.iter().zip(told).all(|(own, told)| own.contains(told)),
            "{warnings:?}"
        );
    };
    let parts = |scene: &Scene| {
        let found = scene.materials.iter().find_map(|(_, material)| match material {
            Material::Pbr(pbr) => Some(pbr),
            _ => None,
        });
        let own = found.expect("a leaf");
        [&own.base_color, &own.diffuse_transmission, &own.diffuse_transmission_color].map(|part| values(part, scene))
    };
    let divided = "divided at texels";
    for (scale, told) in [(0.5, &[divided] as &[&str]), (1.0, &["more light than it gets", divided])] {
        let (scene, _files) = leaf(&format!("{rgb} \"float scale\" {scale}"));
        tells(told, &scene);
        let [base, through, far] = parts(&scene);
        assert_eq!(through.len(), 6);
        for index in 0..6 {
            let (reflected, passed) = (scale * srgb(index), scale * passed);
            // Where the sum is above 1, both are divided by it.
            let sum = (reflected.max_element() + passed.max_element()).max(1.0);
            let found = [(1.0 - through[index].x) * base[index], through[index].x * far[index]];
            for (found, expected) in found.into_iter().zip([reflected, passed]) {
                assert!((found - expected / sum).abs().max_element() < 1e-6, "{index}: {found} {expected} {sum}");
            }
        }
    }
    let (scene, _files) = leaf("\"texture transmittance\" \"t\" \"float scale\" 0.5");
    tells(&["multiplied at texels"], &scene);
    let [base, through, far] = parts(&scene);
    assert!((1..6).all(|index| through[index].x == 0.5 && base[index] == far[index]), "{through:?}");
}

/// A number is the mean of colours, or an alpha that is not 1 everywhere, by the encoding of the directive. What has the right codes keeps them.
#[test]
fn numbers_are_decoded_as_pbrt_does() {
    let of = |file: &str, more: &str| {
        let files = files(&format!("{T} Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"{file}\" {more}"));
        let scene = load(&files.path().join("a.pbrt"), false).unwrap_or_else(|error| panic!("{error}"));
        let alpha = textures(&scene).1;
        let Texture::Image { path, channel, .. } = alpha else { panic!("{alpha:?}") };
        let format = alpha.bitmap(&scene.bitmaps).expect("it is loaded").format;
        (values(alpha, &scene).iter().map(|value| value.x).collect::<Vec<f64>>(), path.clone(), *channel, format)
    };
    let linear = "\"string encoding\" \"linear\"";
    let code = |index: usize, step: u8| f64::from(step * index as u8) / 255.0;
    let is = |found: &[f64], expected: &dyn Fn(usize) -> f64| {
        found.len() == 6 && (0..6).all(|index| (found[index] - expected(index)).abs() < 1e-6)
    };
    for (file, more, expected, kept) in [
        (
            "greys.png",
            "",
            (&|index| share(index)) as &dyn Fn(usize) -> f64,
            ("a.pbrt#images/0", Channel::R, Format::Srgb),
        ),
        ("greys.png", linear, &|index| code(index, 40), ("greys.png", Channel::R, Format::Number)),
        (
            "greys.png",
            "\"string encoding\" \"gamma 2\"",
            &|index| code(index, 40).powi(2),
            ("a.pbrt#images/0", Channel::R, Format::Float),
        ),
        ("colours.png", "", &|index| srgb(index).element_sum() / 3.0, ("a.pbrt#images/0", Channel::R, Format::Float)),
        ("leaf.png", linear, &|index| code(index, 50), ("leaf.png", Channel::A, Format::Number)),
        (
            "leaf.png",
            "\"bool invert\" true",
            &|index| 1.0 - f64::from(from_srgb(code(index, 50))),
            ("a.pbrt#images/0", Channel::R, Format::Float),
        ),
    ] {
        let (found, path, channel, format) = of(file, more);
        assert!(is(&found, expected), "{file} {more}: {found:?}");
        assert_eq!((path.as_str(), channel, format), (kept.0, Some(kept.1), kept.2), "{file} {more}");
    }
    assert!(!is(&of("greys.png", linear).0, &|index| share(index)));
}

/// A smaller image is interpolated at the texels of a larger one, where its edges wrap or end.
#[test]
fn images_of_different_sizes_are_told() {
    // The first column of the lower row is interpolated with the other edge, or with itself.
    for (wrap, edge) in [("repeat", 5), ("clamp", 3)] {
        let wrap = format!("\"string wrap\" \"{wrap}\"");
        let directives = format!(
            "{GREYS} {wrap} Texture \"s\" \"spectrum\" \"imagemap\" \"string filename\" \"wide.exr\" {wrap} \
             Texture \"t\" \"spectrum\" \"mix\" \"texture tex1\" \"s\" \"rgb tex2\" [0 0 0] \"texture amount\" \"g\""
        );
        let files = files(&directives);
        let scene = load(&files.path().join("a.pbrt"), false).unwrap_or_else(|error| panic!("{error}"));
        assert!(scene.warnings().iter().any(|own| own.contains("its images have different sizes")));
        let found = values(textures(&scene).0, &scene);
        let between = |a: usize, b: usize, share_of_b: f64| share(a) + share_of_b * (share(b) - share(a));
        for (index, amount) in [(1, between(0, 1, 0.25)), (2, between(0, 1, 0.75)), (6, between(3, edge, 0.25))] {
            let expected = index as f64 / 8.0 * (1.0 - amount);
            assert!((found[index].x - expected).abs() < 1e-6, "{wrap} {index}: {found:?}, expected {expected}");
        }
    }
    let wraps = format!(
        "{GREYS} \"string wrap\" \"clamp\" {} Texture \"u\" \"spectrum\" \"scale\" \"texture tex\" \"t\" \"texture scale\" \"g\"",
        T
    );
    let refused = load(&files(&wraps).path().join("a.pbrt"), false).expect_err("their wraps differ").to_string();
    assert!(refused.contains("Texture scale: expected one wrap of all its images"), "{refused}");
}

/// Squares may be of images: each texel of an image stands where its own texture coordinates are, in squares of one parity.
#[test]
fn squares_may_have_textures() {
    let pattern = |more: &str, lossless: bool| {
        let files = files(&format!("{} {more}", T.replace("\"t\"", "\"s\"")));
        (load(&files.path().join("a.pbrt"), lossless).unwrap_or_else(|error| panic!("{error}")), files)
    };
    let checkerboard = |more: &str| format!("Texture \"t\" \"spectrum\" \"checkerboard\" {more}");
    let inner = "\"texture tex1\" \"s\" \"rgb tex2\" [0.25 0.5 0.75]";
    for (scale, shift, times, size) in [
        (1.0, 0.0, 2, (42, 36)),
        (1.0, 0.25, 2, (42, 36)),
        (2.0, 0.0, 1, (33, 34)),
        (3.0, 0.25, 2, (102, 100)),
        (0.5, 0.0, 4, (36, 40)),
    ] {
        let text = format!("\"float uscale\" {scale} \"float vscale\" {scale} \"float udelta\" {shift}");
        let (scene, _files) = pattern(&checkerboard(&format!("{inner} {text}")), false);
        let texture = textures(&scene).0;
        let bitmap = texture.bitmap(&scene.bitmaps).expect("it is loaded");
        assert_eq!((bitmap.width, bitmap.height), size, "{scale}");
        // The image shows the inner one so many times, which the mesh shows once.
        let uvs = scene.meshes.values().next().expect("it is a mesh").uvs.clone();
        assert_eq!(uvs.iter().fold(0.0_f32, |most, uv| most.max(uv.x)), 1.0 / times as f32);
        let (found, mut seen) = (values(texture, &scene), [0, 0]);
        for (index, found) in found.into_iter().enumerate() {
            let (x, y) = (index % size.0 as usize, index / size.0 as usize);
            let at = |cell: usize, size: u32| f64::from(times) * (cell as f64 + 0.5) / f64::from(size);
            let (u, v) = (at(x, size.0), f64::from(times) - at(y, size.1));
            let [across, along] = [scale * u + shift, scale * v];
            let near_edge = |x: f64, size: u32| (x - x.round()).abs() < scale * f64::from(times) / f64::from(size);
            let own = [3.0 * u.fract() - 0.5, 2.0 * (1.0 - v.fract()) - 0.5];
            let is_own_texel = own.iter().all(|own| (own - own.round()).abs() < 1e-9);
            if near_edge(across, size.0) || near_edge(along, size.1) {
                continue;
            }
            let is_even = (across.floor() + along.floor()) % 2.0 == 0.0;
            let expected = match is_even {
                true if !is_own_texel => continue,
                true => srgb(own[0].round() as usize + 3 * own[1].round() as usize),
                false => Colour::new(0.25, 0.5, 0.75),
            };
            seen[usize::from(is_even)] += 1;
            assert!((found - expected).abs().max_element() < 1e-6, "{scale}: {x} {y}: {found} {expected}");
        }
        assert!(seen[0] > 100 && seen[1] >= 2, "{scale}: {seen:?}");
        let warnings = scene.warnings();
        assert!(
            matches!(&warnings[..], [told] if told.contains("Texture checkerboard: the edges of its squares are a texel wide here")),
            "{warnings:?}"
        );
    }
    // Squares of one size stay squares, as exact as they are.
    let squares = "Texture \"k\" \"spectrum\" \"checkerboard\" \"float uscale\" 4 \"float vscale\" 4";
    let both = format!(
        "{squares} {}",
        checkerboard("\"float uscale\" 4 \"float vscale\" 4 \"texture tex1\" \"k\" \"rgb tex2\" [.5 .5 .5]")
    );
    let (scene, _files) = pattern(&both, true);
    let half = Colour::splat(0.5);
    assert_eq!(*textures(&scene).0, Texture::Checker { scale: 0.5, even: Colour::ONE, odd: half, uv: true });
    let mixed = format!(
        "{squares} Texture \"t\" \"spectrum\" \"mix\" \"texture tex1\" \"k\" \"rgb tex2\" [0 0 0] \"float amount\" 0.5"
    );
    let (scene, _files) = pattern(&mixed, true);
    assert_eq!(*textures(&scene).0, Texture::Checker { scale: 0.5, even: half, odd: Colour::ZERO, uv: true });
    // Those of different sizes are an image: 4 by 4 small ones in each even large one.
    let nested = format!("{squares} {}", checkerboard("\"texture tex1\" \"k\" \"rgb tex2\" [.5 .5 .5]"));
    let (scene, _files) = pattern(&nested, false);
    let found = values(textures(&scene).0, &scene);
    let side = (found.len() as f64).sqrt() as usize;
    let at = |u: f64, v: f64| {
        let value = found[(u * side as f64) as usize + side * ((1.0 - v) * side as f64) as usize].x;
        // But for rounding errors.
        (1e6 * value).round() / 1e6
    };
    let rows = [0.06, 0.19, 0.31, 0.44, 0.75].map(|u| [at(u, 0.06), at(u, 0.19), at(u, 0.7)]);
    assert_eq!(rows, [[1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [0.5, 0.5, 0.0]]);
    // A mix of images of different mappings has the texels of the finer one, which it shows twice.
    let mixed = format!(
        "{} \"float uscale\" 2 {GREYS} Texture \"t\" \"spectrum\" \"mix\" \"texture tex1\" \"s\" \"rgb tex2\" [1 1 1] \"texture amount\" \"g\"",
        T.replace("\"t\"", "\"s\"")
    );
    let scene = load(&files(&mixed).path().join("a.pbrt"), false).unwrap_or_else(|error| panic!("{error}"));
    let found = values(textures(&scene).0, &scene);
    for (index, own, amount) in
        [(1, 1, share(0) + 0.25 * (share(1) - share(0))), (10, 4, share(5) - 0.25 * (share(5) - share(4)))]
    {
        let expected = srgb(own).lerp(Colour::ONE, amount);
        assert!(
            found.len() == 12 && (found[index] - expected).abs().max_element() < 1e-6,
            "{index}: {found:?} {expected}"
        );
    }
    let ends = mixed.replace("\"colours.png\"", "\"colours.png\" \"string wrap\" \"clamp\"");
    let ends = ends.replace("\"greys.png\"", "\"greys.png\" \"string wrap\" \"clamp\"");
    let refused = load(&files(&ends).path().join("a.pbrt"), false).expect_err("it ends").to_string();
    assert!(refused.contains("Texture mix: expected one wrap of all its images: repeat, if"), "{refused}");
    let clamped = format!("{} \"string wrap\" \"clamp\" {}", T.replace("\"t\"", "\"s\""), checkerboard(inner));
    let refused = load(&files(&clamped).path().join("a.pbrt"), false).expect_err("it ends").to_string();
    assert!(refused.contains("Texture checkerboard: expected one wrap of all its images: repeat, if"), "{refused}");
    let fine = format!("{} {}", T.replace("\"t\"", "\"s\""), checkerboard(&format!("{inner} \"float uscale\" 1e8")));
    let refused = load(&files(&fine).path().join("a.pbrt"), false).expect_err("it is too fine").to_string();
    assert!(refused.contains("which is more than a device can hold"), "{refused}");
}

/// Random edits of textures: each scene is read or refused, without a panic.
#[test]
fn mutants_of_textures_do_not_panic() {
    let directives = format!(
        "{GREYS} \"float scale\" 1.5 Texture \"s\" \"spectrum\" \"imagemap\" \"string filename\" \"wide.exr\" \"bool invert\" true \
         {T} \"string encoding\" \"gamma 2.2\" Texture \"m\" \"spectrum\" \"mix\" \"texture tex1\" \"s\" \"texture tex2\" \"t\" \
         \"texture amount\" \"g\" Texture \"k\" \"spectrum\" \"scale\" \"texture tex\" \"m\" \"texture scale\" \"g\" \
         Material \"diffuse\" \"texture reflectance\" \"k\" AreaLightSource \"diffuse\" \"spectrum L\" \"stdillum-F2\" \"float power\" 2"
    );
    let files = files(&directives);
    let path = files.path().join("a.pbrt");
    let whole = fs::read(&path).unwrap();
    let (mut random, mut good, mut bad) = (Random(70), 0, 0);
    for _ in 0..500 {
        let mut text = whole.clone();
        mutate(&mut text, b"[]\"\n-9. e#ab0", &mut random);
        fs::write(&path, &text).unwrap();
        match load(&path, false) {
            Ok(_) => good += 1,
            Err(_) => bad += 1,
        }
    }
    println!("{good} are read, {bad} refused");
    assert!(good > 5 && bad > 100, "{good} are read, {bad} refused");
}

/// A converted scene has the values of the one that was read.
#[test]
fn images_are_converted() {
    let directives =
        format!("{T} \"bool invert\" true Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"greys.png\"");
    let files = files(&directives);
    let (path, to) = (files.path().join("a.pbrt"), files.path().join("b.ron"));
    let scene = load(&path, false).unwrap_or_else(|error| panic!("{error}"));
    let made = Scene::of_model(&path, &to, &GltfOptions::default(), &mut Assets::default()).unwrap();
    let mut names = Vec::new();
    for (name, image) in made.made_images() {
        write_exr(image, &mut fs::File::create(files.path().join(name)).unwrap()).unwrap();
        names.push(name.to_owned());
    }
    names.sort();
    assert_eq!(names, ["b-0.exr", "b-1.exr"]);
    for (name, mesh) in made.made_meshes() {
        write_ply(mesh, &mut fs::File::create(files.path().join(name)).unwrap()).unwrap();
    }
    fs::write(&to, made.text()).unwrap();
    let again = Scene::load(&to).unwrap_or_else(|error| panic!("{error}"));
    let (albedo, alpha) = textures(&scene);
    let (written, of_alpha) = textures(&again);
    assert_eq!(values(written, &again), values(albedo, &scene));
    assert_eq!(values(of_alpha, &again), values(alpha, &scene));
    assert_ne!(values(written, &again), values(of_alpha, &again));
}

/// pbrt scales an image of a sky by the illuminance of its upper half as it counts that, which is half of what a plane gets.
#[test]
fn skies_have_the_illuminance_that_pbrt_counts() {
    let tint = |texel: fn(u32, u32) -> f32| {
        let text = format!(
            "{VIEW} LightSource \"infinite\" \"string filename\" \"sky.exr\" \"float illuminance\" 3 \"float scale\" 2"
        );
        let files = folder(&[("a.pbrt", text.as_bytes())]);
        let sky = Bitmap::of_floats(64, 64, (0..64 * 64).map(|index| [texel(index % 64, index / 64); 3]));
        write_exr(&sky, &mut fs::File::create(files.path().join("sky.exr")).unwrap()).unwrap();
        let scene = load(&files.path().join("a.pbrt"), false).unwrap_or_else(|error| panic!("{error}"));
        let Background::Image { tint, .. } = scene.background else { panic!("{:?}", scene.background) };
        tint.x
    };
    let even = 2.0 * 3.0 / std::f64::consts::FRAC_PI_2;
    assert!((tint(|_, _| 1.0) / even - 1.0).abs() < 1e-3);
    // The corners of the square are below.
    assert!((tint(|x, y| if x + y < 32 { 9.0 } else { 1.0 }) / even - 1.0).abs() < 1e-2);
    assert!((tint(|_, y| if y < 32 { 2.0 } else { 0.0 }) / even - 1.0).abs() < 1e-3);
    assert!((tint(|x, y| if x.abs_diff(32) + y.abs_diff(32) < 8 { 1.0 } else { 0.0 }) / even - 1.0).abs() > 1.0);
    let black = format!("{VIEW} LightSource \"infinite\" \"string filename\" \"colours.png\" \"float illuminance\" 3");
    let files = folder(&[("a.pbrt", black.as_bytes()), ("colours.png", &png(|_| [0, 0, 0, 255]))]);
    let refused = load(Path::new(&files.path().join("a.pbrt")), false).expect_err("it is black").to_string();
    assert!(refused.contains("LightSource infinite.illuminance: expected an image that is not black"), "{refused}");
}
