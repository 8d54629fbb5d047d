//! Small good files of every format that the program reads. Tests damage them.

use std::fs;
use std::path::{Path, PathBuf};

use gpu_rt::data::Sampler;
use gpu_rt::film::{Accumulation, Film, Picture};
use gpu_rt::identity::Identity;
use gpu_rt::output::exr::{Attribute, State, write_exr, write_render};
use gpu_rt::samples::Samples;

/// The images of tests/corpus, which encoders other than ours have made, and a .hdr, a 16-bit .png and three .exr, one with the state of a
/// render: names and bytes.
pub fn images() -> Vec<(String, Vec<u8>)> {
    let mut images = files(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus")));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name);
    let value = |x: u32, y: u32| [x * 9, y * 9, x * y];
    let float = image::Rgb32FImage::from_fn(20, 12, |x, y| image::Rgb(value(x, y).map(|c| c as f32 / 256.0)));
    float.save(at("float.hdr")).expect("the image is written");
    let wide = image::ImageBuffer::from_fn(20, 12, |x, y| image::Rgb(value(x, y).map(|c| c as u16 * 250)));
    wide.save(at("wide.png")).expect("the image is written");
    exr::prelude::write_rgb_file(at("float.exr"), 20, 12, |x, y| (x as f32, y as f32 * 0.1, 0.5f32))
        .expect("the image is written");
    let picture = Picture {
        width: 3,
        height: 2,
        rgb: vec![[0.5, 0.25, 1.0]; 6],
        variance: vec![[0.1; 3]; 6],
        samples: vec![8; 6],
        rejected: vec![0; 6],
    };
    let attributes = [Attribute::Text("a scene".to_owned()), Attribute::Int(-7), Attribute::Float(0.5)];
    let attributes = ["text", "gpu-rt:seed", "float"].map(str::to_owned).into_iter().zip(attributes);
    write_exr(&at("own.exr"), &picture, &attributes.collect::<Vec<_>>()).expect("the image is written");
    let film = Film::with_sampler(5, 3, 2, Sampler::Sobol).expect("the film fits");
    let settings = [("size".to_owned(), "5x3".to_owned())].into_iter().collect();
    let [version, kernels, scene] = ["1", "kernels", "scene"].map(str::to_owned);
    let identity = Identity { version, kernels, scene, assets: vec![("a.png".to_owned(), "1".to_owned())], settings };
    let (samples, devices) = (Samples::from(0..16), vec![("device".to_owned(), "driver".to_owned())]);
    let film = Accumulation { samples, devices, ..Accumulation::empty(film) };
    let state = State::new(identity, &film);
    write_render(&at("render.state.exr"), &film.film, &[], Some(&state), || Ok(())).expect("the image is written");
    images.extend(files(folder.path()));
    images
}

/// The glTF files of tests/corpus/packed, which encoders other than ours have made of plain.glb: names and bytes.
pub fn packed() -> Vec<(String, Vec<u8>)> {
    files(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/packed")))
}

/// The scene files that ship, and those of the tests.
pub fn scenes() -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes"));
    let mut scenes = files(folder);
    scenes.extend(files(&folder.join("test")));
    scenes.retain(|(name, _)| name.ends_with(".ron"));
    scenes
}

/// The files in a folder, by their names.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let named = |path: PathBuf| {
        let bytes = fs::read(&path).expect("the file can be read");
        (path.file_name().expect("it has a name").to_string_lossy().into_owned(), bytes)
    };
    super::files::files(folder, "", false).into_iter().map(named).collect()
}
