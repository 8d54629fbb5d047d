//! docs/files.md: its tables have all channels, attributes and keys that the program writes, and no others. That of
//! `tradeoff` is compared in tests/timed/tradeoff.rs, which gives a sweep the time that it needs.

use std::collections::BTreeSet;

use crate::common::device::index as software;
use crate::common::gltf::{glb, moving};
use crate::common::oidn;
use crate::common::tables::{compare, rows};
use crate::sandbox::{SPHERE, Sandbox};

/// A scene that is warned of.
fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.scene("sphere.ron", &SPHERE.replace("materials: {", "materials: { \"unused\": Dielectric(ior: 1.5),"));
    sandbox
}

#[test]
fn renders_and_their_parts_have_the_keys_and_attributes_that_are_documented() {
    let sandbox = sandbox();
    let json = |more: &str| {
        let more: Vec<&str> = more.split_whitespace().chain(["--json"]).collect();
        sandbox.render(&more).exits(0).json()
    };
    let (moving, binary) = moving();
    std::fs::write(sandbox.folder.path().join("scenes/moving.glb"), glb(&moving, &binary)).expect("it is written");
    let frame = format!(
        "render ../scenes/moving.glb --size 16x10 --spp 8 --frame 1 -o frame.exr --json --device {}",
        software()
    );
    let frame = sandbox.says(&frame);
    // Every render takes longer than a millisecond.
    let renders = [
        json("--spp 16 -o a.exr"),
        json("--spp 32 -o a.exr --resume"),
        json(
            "--noise 0.9 --spp 64 --profile --clamp 10 -o noise.exr \
             --aov albedo,normal,depth,position,object,material,direct,indirect,motion,depth0,distance0,position0,normal0,uv0,face0,offset0,lights,cryptomatte,cryptoasset",
        ),
        json("--samples 16..32 -o b.exr"),
        json("--samples 0..16 -o c.exr"),
        json("--time 1ms -o time.exr"),
        json("--noise 0.9 --spp 16 -o a.exr"),
        frame.exits(0).json(),
        json(&format!("--png d.png -o d.exr --denoise --oidn {}", oidn::folder().display())),
    ];
    compare("### `render --json`", &renders);
    let denoise = "denoise a.exr -o denoised.exr --png denoised.png --json --oidn";
    let folder = oidn::folder();
    let denoised = sandbox.run(&[denoise.split(' ').collect(), vec![folder.to_str().expect("UTF-8")]].concat());
    compare("### `denoise --json`", &[denoised.exits(0).json()]);
    let names = ["a.exr", "noise.exr", "denoised.exr", "frame.exr"].map(|name| sandbox.exr(name).attributes);
    let attributes: BTreeSet<_> = names.into_iter().flatten().map(|(name, _)| name).collect();
    let own: BTreeSet<_> = attributes.into_iter().filter(|name| name.starts_with("gpu-rt:")).collect();
    assert_eq!(own, rows("## Header"));
    let meta = exr::meta::MetaData::read_from_file(sandbox.at("noise.exr"), true).expect("an EXR");
    let channels = meta.headers[0].channels.list.iter().map(|channel| channel.name.to_string());
    // The layers of mattes differ in their numbers alone.
    let row = |name: String| match name.starts_with("Crypto") {
        true => format!("{}NN.C", name.trim_end_matches(['R', 'G', 'B', 'A', '.', '0', '1', '2'])),
        false => name,
    };
    assert_eq!(channels.map(row).collect::<BTreeSet<_>>(), rows("## Channels"));
    compare("### `merge --json`", &[sandbox.says("merge b.exr c.exr -o full.exr --json").exits(0).json()]);
    compare("### `compare --json`", &[sandbox.says("compare a.exr b.exr --json").exits(0).json()]);
    let spp = "converge ../scenes/sphere.ron --spp 16 --reference a.exr --json --device";
    compare("### `converge --json`", &[sandbox.says(&format!("{spp} {}", software())).exits(0).json()]);
}

#[test]
fn check_plan_and_devices_have_the_keys_that_are_documented() {
    let sandbox = sandbox();
    let good = sandbox.says("check ../scenes/sphere.ron --json").exits(0).json();
    compare("### `check --json`", &[good, sandbox.says("check ../scenes/none.ron --json").exits(2).json()]);
    let plan = sandbox.says(&format!("plan ../scenes/sphere.ron --json --device {}", software())).exits(0).json();
    compare("### `plan --json`", &[plan]);
    compare("### `devices --json`", &[sandbox.says("devices --json").exits(0).json()]);
}

#[test]
#[cfg(unix)]
fn status_has_the_keys_that_are_documented() {
    let sandbox = sandbox();
    let submit = "submit slurm ../scenes/sphere.ron --spp 16 --parts 2 -o job --dry-run --device";
    sandbox.says(&format!("{submit} {}", software())).exits(0);
    let before = sandbox.says("status job --json").exits(0).json();
    sandbox.render(&["--samples", "0..8", "-o", "job/parts/00-08.exr"]).exits(0);
    let after = sandbox.says("status job --json --error").exits(0).json();
    compare("### `status --json`", &[before, after]);
}
