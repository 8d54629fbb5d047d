//! Images that are truncated or damaged: an error that names the file, and never a part of a picture.

use crate::common::corpus;
use crate::common::mutate::end_of_header;
use std::fs;
use std::path::Path;

use gpu_rt::error::Error;
use gpu_rt::output::exr::read_exr;
use gpu_rt::scene::{Bitmap, Scene};

/// The image that a scene's background names.
fn image(folder: &Path, file: &str, bytes: &[u8]) -> Result<Bitmap, Error> {
    fs::write(folder.join(file), bytes).expect("the image is written");
    let text = format!(
        "(image: (width: 4, height: 3), camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40), \
         background: Image(path: {file:?}), objects: [])"
    );
    let scene = Scene::parse(&text, &folder.join("scene.ron"))?;
    Ok(scene.bitmaps.colours(file).expect("it is loaded").clone())
}

/// The second half of the content is zeros, as of a download that broke off; and a part in the middle is overwritten.
fn damaged(file: &str, bytes: &[u8]) -> [Vec<u8>; 2] {
    let start = end_of_header(file, bytes);
    let (middle, eighth) = (start.midpoint(bytes.len()), (bytes.len() - start) / 8);
    let [mut zeros, mut overwritten] = [bytes.to_vec(), bytes.to_vec()];
    zeros[middle..].fill(0);
    overwritten[middle..bytes.len() - 2 - eighth].fill(0x55);
    [zeros, overwritten]
}

/// The lengths at which a truncated file is accepted with another picture than that of the full file.
fn accepted_in_part(file: &str, bytes: &[u8]) -> Vec<usize> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let full = image(folder.path(), file, bytes).unwrap_or_else(|error| panic!("{error}"));
    let is_wrong = |&length: &usize| match image(folder.path(), file, &bytes[..length]) {
        Ok(part) => part != full,
        Err(error) => {
            assert!(error.to_string().contains(file), "{error}");
            false
        }
    };
    (0..bytes.len()).filter(is_wrong).collect()
}

#[test]
fn no_truncated_image_is_accepted_in_part() {
    let images = corpus::images();
    let of_format = |ending: &str| images.iter().filter(|(file, _)| file.ends_with(ending)).count();
    for (ending, least) in [("png", 3), ("jpg", 2), ("webp", 3), ("tiff", 5), ("tga", 2), ("bmp", 2), ("hdr", 1)] {
        assert!(of_format(ending) >= least, "{ending}");
    }
    let wrong: Vec<String> = images
        .iter()
        .map(|(file, bytes)| (file, accepted_in_part(file, bytes), bytes.len()))
        .filter(|(_, lengths, _)| !lengths.is_empty())
        .map(|(file, lengths, full)| format!("{file}: of {full} bytes the first {lengths:?}"))
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn damage_that_a_format_can_tell_is_refused() {
    // Without compression or a checksum, zeros are a picture like any other. So is what stands for them in a format of few rules.
    const ZEROS: [&str; 7] =
        ["alpha.webp", "lossy.webp", "noise.webp", "palette.bmp", "plain.bmp", "plain.tga", "plain.tiff"];
    const OVERWRITTEN: [&str; 5] = ["baseline.jpg", "lossless.webp", "noise.jpg", "packbits.tiff", "rle.tga"];
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (file, bytes) in corpus::images() {
        let accepted = damaged(&file, &bytes).map(|bytes| image(folder.path(), &file, &bytes).is_ok());
        let unknowable = [ZEROS.contains(&file.as_str()), ZEROS.iter().chain(&OVERWRITTEN).any(|of| *of == file)];
        assert_eq!(accepted, unknowable, "{file}");
    }
}

/// An EXR of one colour, with primaries.
fn of_primaries(path: &Path, rgb: [f32; 3], primaries: [[f32; 2]; 4]) -> Vec<u8> {
    use exr::image::write::WritableImage;
    use exr::math::Vec2;
    let pixel = move |_| (rgb[0], rgb[1], rgb[2]);
    let mut image = exr::image::Image::from_channels((4, 3), exr::image::SpecificChannels::rgb(pixel));
    let [red, green, blue, white] = primaries.map(|[x, y]| Vec2(x, y));
    image.attributes.chromaticities = Some(exr::meta::attribute::Chromaticities { red, green, blue, white });
    image.write().to_file(path).expect("it is written");
    fs::read(path).expect("it is read")
}

const ACES_CG: [[f32; 2]; 4] = [[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], [0.32168, 0.33767]];
const REC_709: [[f32; 2]; 4] = [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]];

/// A picture and a sky of other primaries are those of Rec. 709 that look the same. A colour that Rec. 709 does not have is none of a sky.
#[test]
fn colours_of_other_primaries_are_converted_to_rec_709() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("sky.exr");
    // (0.5, 0.4, 0.3) of Rec. 709 in ACEScg, by the matrix of OpenColorIO's ACES config.
    let in_aces = [0.456_57, 0.405_68, 0.315_08];
    for (rgb, primaries, error, note) in [
        (in_aces, ACES_CG, 2e-4, Some("converted to Rec. 709, from red (0.713, 0.293)")),
        ([0.5, 0.4, 0.3], REC_709, 0.0, None),
    ] {
        let bytes = of_primaries(&file, rgb, primaries);
        let is_close = |found: [f32; 3]| found.iter().zip([0.5, 0.4, 0.3]).all(|(a, b)| (a - b).abs() <= error);
        let read = read_exr(&file).unwrap_or_else(|error| panic!("{error}"));
        assert!(read.rgb.iter().all(|rgb| is_close(*rgb)), "{:?}", read.rgb[0]);
        let words = read.colours.as_deref().unwrap_or_default();
        assert!(note.map_or(words.is_empty(), |note| words.contains(note)), "{words}");
        let sky = image(folder.path(), "sky.exr", &bytes).unwrap_or_else(|error| panic!("{error}"));
        assert!(sky.texels().all(is_close), "{:?}", sky.texel(0));
    }
    let green = of_primaries(&file, [0.1, 0.9, 0.1], ACES_CG);
    let Err(error) = image(folder.path(), "sky.exr", &green) else { panic!("it is outside of Rec. 709") };
    assert!(error.to_string().contains("texel (0, 0) is outside of Rec. 709"), "{error}");
    assert!(read_exr(&file).is_ok_and(|picture| picture.rgb[0][0] < 0.0), "a picture may have such colours");
    // No primaries: named, and taken for Rec. 709; of a sky they are refused.
    let broken = of_primaries(&file, [0.5, 0.4, 0.3], [[0.3, 0.3]; 4]);
    let read = read_exr(&file).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(read.rgb[5], [0.5, 0.4, 0.3]);
    assert!(read.colours.is_some_and(|words| words.contains("no primaries") && words.ends_with("taken for Rec. 709")));
    assert!(image(folder.path(), "sky.exr", &broken).is_err_and(|error| error.to_string().contains("no primaries")));
}

/// The fuzzer found it: the library indexes past the end of a block.
#[test]
fn an_exr_that_makes_the_library_panic_is_refused() {
    let file = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/damaged/short_block.exr"));
    let error = read_exr(file).expect_err("it is refused").to_string();
    assert!(error.contains("short_block.exr: cannot read: the parser gave up"), "{error}");
}
