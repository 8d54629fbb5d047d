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

/// A picture and a sky of other primaries are those of Rec. 709 that look the same. What Rec. 709 has no number for is 0 in a sky.
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
    let sky = image(folder.path(), "sky.exr", &green).unwrap_or_else(|error| panic!("{error}"));
    assert!(sky.texels().all(|texel| texel[0] == 0.0 && texel[1] > 0.9), "{:?}", sky.texel(0));
    assert!(sky.warning.is_some_and(|words| words.starts_with("12 of 12 texels have a number that is negative")));
    assert!(read_exr(&file).is_ok_and(|picture| picture.rgb[0][0] < 0.0), "a picture may have such colours");
    // No primaries: named, and taken for Rec. 709; of a sky they are refused.
    let broken = of_primaries(&file, [0.5, 0.4, 0.3], [[0.3, 0.3]; 4]);
    let read = read_exr(&file).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(read.rgb[5], [0.5, 0.4, 0.3]);
    assert!(read.colours.is_some_and(|words| words.contains("no primaries") && words.ends_with("taken for Rec. 709")));
    assert!(image(folder.path(), "sky.exr", &broken).is_err_and(|error| error.to_string().contains("no primaries")));
}

/// A picture in all ways in which EXRs hold one: of halves and floats, in each compression, in tiles, in the second of two parts, and with a
/// data window that is less or more than the display window, which is the picture.
#[test]
fn every_kind_of_exr_is_the_same_picture() {
    use exr::image::write::WritableImage;
    use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer, Layers};
    use exr::math::Vec2;
    use exr::meta::attribute::{Compression, IntegerBounds, LineOrder};
    use exr::meta::header::{ImageAttributes, LayerAttributes};
    use exr::prelude::f16;

    const SIZE: Vec2<usize> = Vec2(32, 16);
    let at = |x: i64, y: i64| [0.25 + x as f32 / 64.0, 0.5 + y as f32 / 64.0, 0.125 * ((x + y) % 5) as f32 + 0.5];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("sky.exr");
    let picture = IntegerBounds::new(Vec2(0, 0), SIZE);
    let layer = |name: &str, data: IntegerBounds, encoding: Encoding, halves: bool| {
        let values = |channel: usize| {
            let points = (0..data.size.area()).map(|i| (i % data.size.0, i / data.size.0));
            let value =
                |(x, y)| at(x as i64 + i64::from(data.position.0), y as i64 + i64::from(data.position.1))[channel];
            match halves {
                true => FlatSamples::F16(points.map(value).map(f16::from_f32).collect()),
                false => FlatSamples::F32(points.map(value).collect()),
            }
        };
        let channels = ["B", "G", "R"].into_iter().zip([2, 1, 0]).map(|(name, of)| AnyChannel::new(name, values(of)));
        let attributes = LayerAttributes { layer_position: data.position, ..LayerAttributes::named(name) };
        Layer::new(data.size, attributes, encoding, AnyChannels::sort(channels.collect()))
    };
    let read = |display: IntegerBounds, layers: Vec<Layer<AnyChannels<FlatSamples>>>| {
        let layer_data: Layers<_> = layers.into();
        let image = Image { attributes: ImageAttributes::new(display), layer_data };
        image.write().non_parallel().to_file(&file).expect("it is written");
        image_at(folder.path(), &file)
    };
    let lines = |compression| Encoding { compression, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let zip = lines(Compression::ZIP16);
    let is_near = |found: &Bitmap, holds: IntegerBounds, off: f32| {
        assert_eq!((found.width, found.height), (32, 16));
        let wrong = |(index, texel): (usize, [f32; 3])| {
            let (x, y) = (index as i64 % 32, index as i64 / 32);
            let is_in = |at: i64, start: i32, size: usize| (0..size as i64).contains(&(at - i64::from(start)));
            let is_there = is_in(x, holds.position.0, holds.size.0) && is_in(y, holds.position.1, holds.size.1);
            let wanted = if is_there { at(x, y) } else { [0.0; 3] };
            texel.iter().zip(wanted).any(|(a, b)| (a - b).abs() > off)
        };
        !found.texels().enumerate().any(wrong)
    };
    // The values are numbers of halves. B44 keeps 6 bits of the differences in a block of 4 by 4, and DWA loses what its level says.
    for (compression, off) in [
        (Compression::Uncompressed, 0.0),
        (Compression::RLE, 0.0),
        (Compression::ZIP1, 0.0),
        (Compression::ZIP16, 0.0),
        (Compression::PIZ, 0.0),
        (Compression::PXR24, 0.0),
        (Compression::B44, 0.02),
        (Compression::B44A, 0.02),
        (Compression::DWAA(None), 0.05),
        (Compression::DWAB(None), 0.05),
    ] {
        for halves in [true, false] {
            let found = read(picture, vec![layer("sky", picture, lines(compression), halves)]);
            assert!(is_near(&found, picture, off), "{compression} {halves}");
        }
    }
    let tiles = Encoding { blocks: Blocks::Tiles(Vec2(8, 4)), ..zip };
    assert!(is_near(&read(picture, vec![layer("sky", picture, tiles, true)]), picture, 0.0));
    let depth = || {
        let channels = vec![AnyChannel::new("Z", FlatSamples::F32(vec![1.0; SIZE.area()]))];
        Layer::new(SIZE, LayerAttributes::named("depth"), zip, AnyChannels::sort(channels.into()))
    };
    assert!(is_near(&read(picture, vec![depth(), layer("sky", picture, zip, true)]), picture, 0.0));
    for (position, size) in
        [((5, 3), (9, 11)), ((-4, -2), (40, 20)), ((20, -3), (30, 8)), ((40, 0), (3, 3)), ((0, 7), (32, 9))]
    {
        let data = IntegerBounds::new(Vec2(position.0, position.1), size);
        let found = read(picture, vec![layer("sky", data, zip, true)]);
        assert!(is_near(&found, data, 0.0), "{position:?} {size:?}");
        // Data that is taken for the picture is another one, where it does not cover all of it.
        let covers = position == (-4, -2);
        assert!(covers || !is_near(&found, IntegerBounds::new(Vec2(0, 0), data.size), 0.0), "{position:?} {size:?}");
    }
    // A picture that begins elsewhere.
    let away = IntegerBounds::new(Vec2(100, -50), SIZE);
    let data = IntegerBounds::new(Vec2(101, -50), Vec2(4, 4));
    let found = read(away, vec![layer("sky", data, zip, true)]);
    assert!((0..2).all(|x| (found.texel(x) == [0.0; 3]) == (x == 0)), "{:?}", found.texel(1));
    // Without red, green and blue it is refused, by what it has.
    let names = |names: &[&str]| {
        let channels = names.iter().map(|name| AnyChannel::new(*name, FlatSamples::F32(vec![0.5; SIZE.area()])));
        let layer = Layer::new(SIZE, LayerAttributes::named("sky"), zip, AnyChannels::sort(channels.collect()));
        Image::from_layer(layer).write().non_parallel().to_file(&file).expect("it is written");
        image(folder.path(), "sky.exr", &fs::read(&file).expect("it is read")).expect_err("it is refused").to_string()
    };
    for (channels, words) in [
        (&["Y", "RY", "BY"][..], "found BY, RY, Y: save it as RGB, without layers and without luminance and chroma"),
        (&["Y"], "found Y: save"),
        (
            &["V.C.R", "V.C.G", "V.C.B", "V.C.A", "V.D.Z", "V.N.X", "V.N.Y", "V.N.Z", "V.O"],
            "V.N.Y, V.N.Z and 1 more: save",
        ),
    ] {
        let error = names(channels);
        assert!(error.contains("expected the channels R, G and B") && error.contains(words), "{error}");
    }
}

fn image_at(folder: &Path, file: &Path) -> Bitmap {
    image(folder, "sky.exr", &fs::read(file).expect("it is read")).unwrap_or_else(|error| panic!("{error}"))
}

/// The fuzzer found it: the library indexes past the end of a block.
#[test]
fn an_exr_that_makes_the_library_panic_is_refused() {
    let file = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/damaged/short_block.exr"));
    let error = read_exr(file).expect_err("it is refused").to_string();
    assert!(error.contains("short_block.exr: cannot read: the parser gave up"), "{error}");
}
