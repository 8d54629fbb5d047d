//! Images that are truncated or damaged: an error that names the file, and never a part of a picture.

use crate::common::corpus;
use std::fs;
use std::path::Path;

use gpu_rt::error::Error;
use gpu_rt::scene::{Bitmap, Scene};

/// The image that a scene's background names.
fn image(folder: &Path, file: &str, bytes: &[u8]) -> Result<Bitmap, Error> {
    fs::write(folder.join(file), bytes).expect("the image is written");
    let text = format!(
        "(image: (width: 4, height: 3), camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40), \
         background: Image(path: {file:?}), objects: [])"
    );
    let mut scene = Scene::parse(&text, &folder.join("scene.ron"))?;
    Ok(scene.bitmaps.remove(file).expect("it is loaded"))
}

/// Damages that a format can tell: what is missing at the end is zeros, as of a download that broke off, or the second half is
/// left out and the end is there.
fn damaged(bytes: &[u8]) -> [Vec<u8>; 2] {
    let half = bytes.len() / 2;
    let mut zeros = bytes[..half].to_vec();
    zeros.resize(bytes.len(), 0);
    [zeros, [&bytes[..half], &bytes[bytes.len() - 8..]].concat()]
}

/// The lengths at which a truncated file is accepted with another picture than the whole file has.
fn accepted_in_part(file: &str, bytes: &[u8]) -> Vec<usize> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let whole = image(folder.path(), file, bytes).unwrap_or_else(|error| panic!("{error}"));
    let is_wrong = |&length: &usize| match image(folder.path(), file, &bytes[..length]) {
        Ok(part) => part != whole,
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
        .map(|(file, lengths, whole)| format!("{file}: of {whole} bytes the first {lengths:?}"))
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn images_whose_second_half_is_missing_are_refused() {
    // Without compression or a checksum, zeros are a picture like any other.
    const UNKNOWABLE: [&str; 6] = ["alpha.webp", "lossy.webp", "palette.bmp", "plain.bmp", "plain.tga", "plain.tiff"];
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (file, bytes) in corpus::images() {
        let [zeros, left_out] = damaged(&bytes).map(|bytes| image(folder.path(), &file, &bytes).is_ok());
        assert_eq!((zeros, left_out), (UNKNOWABLE.contains(&file.as_str()), false), "{file}");
    }
}
