//! docs/tutorial.md: its scenes are valid, what it quotes is said, and its pictures are of its scenes.

use crate::common::device::index as software;
use crate::common::renew;
use crate::sandbox::Sandbox;
use std::fs;
use std::path::{Path, PathBuf};

/// The most bytes that the pictures take together.
const MOST_BYTES: u64 = 300_000;

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs")
}

/// The code blocks of a language.
fn blocks(language: &str) -> Vec<String> {
    let text = fs::read_to_string(docs().join("tutorial.md")).expect("the tutorial is there");
    let fence = format!("```{language}\n");
    let starts = text.split(&fence).skip(1);
    starts.filter_map(|rest| Some(rest.split_once("```")?.0.to_owned())).collect()
}

#[test]
fn every_step_of_the_tutorial_is_a_scene() {
    let sandbox = Sandbox::new();
    let file = sandbox.at("tutorial.ron");
    let check = |text: &str| {
        fs::write(&file, text).expect("the scene is written");
        sandbox.says("check tutorial.ron")
    };
    assert_eq!(blocks("text"), [check("").exits(2).stderr]);
    let steps = blocks("ron");
    assert_eq!(steps.len(), 6);
    for step in &steps {
        assert_eq!(check(step).exits(0).stderr, "", "{step}");
    }
    // A scene that lacks its end is not taken for one.
    check(&steps[0][..steps[0].len() / 2]).exits(2);
    check(&steps[5]).exits(0);
    let render = ["render", "tutorial.ron", "--device", software(), "--png", "tutorial.png"];
    sandbox
        .run(&[&render[..], &["--size", "32x18", "--spp", "2", "--strict"]].concat())
        .exits(0)
        .says_last("tutorial.exr: 2 samples");
    assert_eq!(image::open(sandbox.at("tutorial.png")).expect("a PNG").into_rgb8().dimensions(), (32, 18));
}

/// The numbers of the steps that have a picture, and where it is.
fn pictures() -> Vec<(usize, PathBuf)> {
    let text = fs::read_to_string(docs().join("tutorial.md")).expect("the tutorial is there");
    let names = text.split("](images/tutorial-").skip(1).filter_map(|rest| Some(rest.split_once(".png)")?.0));
    names.map(|name| (name.parse().expect("a step"), docs().join(format!("images/tutorial-{name}.png")))).collect()
}

#[test]
fn the_pictures_of_the_tutorial_are_small() {
    let (steps, sandbox) = (blocks("ron"), Sandbox::new());
    let pictures = pictures();
    assert!(pictures.len() >= 3, "{pictures:?}");
    for (number, path) in &pictures {
        if renew() {
            let scene = sandbox.scene("tutorial.ron", &steps[number - 1]);
            let to = path.to_str().expect("a path in UTF-8");
            sandbox.run(&["render", &scene, "--device", software(), "--spp", "1024", "--png", to]).exits(0);
        }
        let picture = image::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert_eq!((picture.width(), picture.height()), (320, 180), "{}", path.display());
    }
    let bytes: u64 = pictures.iter().map(|(_, path)| fs::metadata(path).map_or(0, |about| about.len())).sum();
    assert!(bytes <= MOST_BYTES, "the pictures take {bytes} bytes");
}
