//! Files that claim more than they hold: the program refuses them within a limit of memory, by the shell's `ulimit`. A failed
//! allocation would end it by a signal.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::common::corpus;
use crate::common::program::{Ran, finish};

/// The addresses that the program may use, in KiB. It takes a tenth of it to start.
const GIB: u32 = 1 << 20;

/// `gpu-rt check` on a scene in this folder, with a limit of memory.
fn check(folder: &Path, scene: &str, limit: u32) -> Ran {
    fs::write(folder.join("scene.ron"), scene).expect("the scene is written");
    let mut command = Command::new("sh");
    command.current_dir(folder).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.args(["-c", "ulimit -v $0 && exec \"$@\"", &limit.to_string(), env!("CARGO_BIN_EXE_gpu-rt")]);
    command.args(["check", "scene.ron"]);
    finish(command.spawn().expect("a shell starts"))
}

/// Asserts that the program refuses the scene with these words.
#[track_caller]
fn refuses(folder: &Path, scene: &str, limit: u32, words: &str) {
    let ran = check(folder, scene, limit).exits(2);
    assert!(ran.stderr.contains(words) && ran.stderr.lines().count() == 1, "expected {words}: {}", ran.stderr);
}

fn scene(background: &str, object: &str) -> String {
    format!(
        "(image: (width: 4, height: 3), camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40), \
         background: {background}, materials: {{\"m\": Metal(albedo: Rgb(1, 1, 1))}}, objects: [{object}])"
    )
}

fn of_image(file: &str) -> String {
    scene(&format!("Image(path: {file:?})"), "")
}

fn of_mesh(file: &str) -> String {
    scene("Solid((1, 1, 1))", &format!("Mesh(path: {file:?}, material: \"m\")"))
}

/// A file of zeros that takes no space on the disk.
fn sparse(path: &Path, bytes: u64) {
    File::create(path).and_then(|file| file.set_len(bytes)).expect("a sparse file is made");
}

#[test]
fn a_small_jpeg_that_claims_the_largest_size_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["baseline.jpg", "progressive.jpg"] {
        let (_, mut bytes) = corpus::images().into_iter().find(|(file, _)| file == name).expect("it is there");
        let frame = bytes.windows(2).position(|pair| [[0xff, 0xc0], [0xff, 0xc2]].contains(&[pair[0], pair[1]]));
        let frame = frame.expect("a start of frame");
        bytes[frame + 5..frame + 9].copy_from_slice(&[0x40, 0, 0x40, 0]);
        fs::write(folder.path().join(name), bytes).expect("the image is written");
        refuses(folder.path(), &of_image(name), GIB, "it takes 3328 MiB of memory to decode 16384 by 16384 texels");
    }
}

/// Bytes of DEFLATE with fixed codes (RFC 1951, 3.2.6) in a zlib stream: one zero, and 258 more for every 13 bits.
fn zeros_in_zlib(bytes: usize) -> Vec<u8> {
    let (mut stream, mut held, mut count) = (vec![0x78, 0x01], 0_u32, 0);
    let mut put = |bits: u32, length: u32| {
        held |= bits << count;
        count += length;
        while count >= 8 {
            stream.push(held as u8);
            held >>= 8;
            count -= 8;
        }
    };
    // The last block, with fixed codes; the literal 0; length 258 at distance 1; the end. Codes stand from their high bit on.
    put(0b011, 3);
    put(0b0000_1100, 8);
    for _ in 0..bytes / 258 {
        put(0b1010_0011, 8);
        put(0, 5);
    }
    put(0, 7);
    put(0, 7);
    stream
}

/// A chunk of a PNG file.
fn chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let named = [&name[..], data].concat();
    let crc = named.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| crc >> 1 ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 })
    });
    [&(data.len() as u32).to_be_bytes()[..], &named, &(!crc).to_be_bytes()].concat()
}

#[test]
fn a_profile_of_a_gibibyte_takes_no_memory() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (_, good) = corpus::images().into_iter().find(|(file, _)| file == "plain.png").expect("it is there");
    let profile = chunk(b"iCCP", &[b"name\0\0", &zeros_in_zlib(1 << 30)[..]].concat());
    // Behind the signature and the header.
    let png = [&good[..33], &profile, &good[33..]].concat();
    fs::write(folder.path().join("profile.png"), png).expect("the image is written");
    // Whether the profile is ignored or refused is up to the decoder.
    let ran = check(folder.path(), &of_image("profile.png"), GIB);
    assert!(ran.status.code().is_some_and(|code| [0, 2].contains(&code)), "{ran:?}");
}

#[test]
fn long_files_without_content_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["a.png", "a.exr", "a.ply", "a.obj", "a.glb", "a.gltf", "a.bin"] {
        sparse(&folder.path().join(name), 12 << 30);
    }
    for name in ["a.png", "a.exr"] {
        refuses(folder.path(), &of_image(name), GIB, "expected a file of at most 1073741824 bytes, found 12884901888");
    }
    for name in ["a.ply", "a.obj", "a.glb", "a.gltf"] {
        refuses(folder.path(), &of_mesh(name), GIB, "expected a file of at most 1073741824 bytes, found 12884901888");
    }
    sparse(&folder.path().join("scene.ron"), 12 << 30);
    let mut command = Command::new("sh");
    command.current_dir(folder.path()).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.args(["-c", &format!("ulimit -v {GIB} && exec \"$0\" check scene.ron"), env!("CARGO_BIN_EXE_gpu-rt")]);
    finish(command.spawn().expect("a shell starts")).exits(2).on_stderr(&["longer than 268435456 bytes"]);
}

#[test]
fn a_gltf_that_names_one_file_eight_times_reads_it_once() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    sparse(&folder.path().join("a.bin"), 256 << 20);
    let gltf = |byte_length: u64| {
        let buffer = format!("{{\"uri\": \"a.bin\", \"byteLength\": {byte_length}}}");
        let buffers = vec![buffer; 8].join(", ");
        let text = format!(
            "{{\"asset\": {{\"version\": \"2.0\"}}, \"scenes\": [{{\"nodes\": []}}], \"buffers\": [{buffers}]}}"
        );
        fs::write(folder.path().join("a.gltf"), text).expect("the mesh is written");
    };
    gltf(256 << 20);
    refuses(folder.path(), &of_mesh("a.gltf"), GIB, "it has no faces");
    // By other names it is another file, and all together have a limit.
    let buffers: Vec<String> =
        (0..8).map(|i| format!("{{\"uri\": \"{}a.bin\", \"byteLength\": 9}}", "./".repeat(i))).collect();
    let text = fs::read_to_string(folder.path().join("a.gltf")).expect("it is there");
    let (start, _) = text.split_once("\"buffers\"").expect("it has buffers");
    fs::write(folder.path().join("a.gltf"), format!("{start}\"buffers\": [{}]}}", buffers.join(", ")))
        .expect("written");
    refuses(
        folder.path(),
        &of_mesh("a.gltf"),
        2 * GIB,
        "buffers[3]: ./././a.bin: cannot read the buffer: expected a file of at most",
    );
}

#[test]
fn meshes_of_few_bytes_that_become_many_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let gltf = format!("{{\"asset\": {{\"version\": \"2.0\"}}, \"nodes\": [{}{{}}]}}", "{},".repeat(1 << 20));
    fs::write(folder.path().join("a.gltf"), gltf).expect("the mesh is written");
    refuses(folder.path(), &of_mesh("a.gltf"), GIB, "expected at most 1048576 objects in its JSON, found 1048579");
    // A material is the largest struct: as many as are read take a third of the limit.
    let gltf = |materials: usize| {
        let list = vec!["{}"; materials].join(",");
        let text = format!(
            "{{\"asset\": {{\"version\": \"2.0\"}}, \"scenes\": [{{\"nodes\": []}}], \"materials\": [{list}]}}"
        );
        fs::write(folder.path().join("a.gltf"), text).expect("the mesh is written");
    };
    gltf(1_000_000);
    let words = "expected at most 131072 materials in its JSON, found 1000000";
    refuses(folder.path(), &of_mesh("a.gltf"), GIB / 4, words);
    gltf(1 << 17);
    refuses(folder.path(), &of_mesh("a.gltf"), GIB / 3, "it has no faces");
    // Numbers of an extension become values of 72 bytes.
    let gltf = |numbers: usize| {
        let list = "1,".repeat(numbers);
        let text = format!("{{\"asset\": {{\"version\": \"2.0\"}}, \"extensions\": {{\"X\": [{list}1]}}}}");
        fs::write(folder.path().join("a.gltf"), text).expect("the mesh is written");
    };
    gltf(1 << 24);
    refuses(folder.path(), &of_mesh("a.gltf"), GIB / 4, "expected at most 16777216 values in its JSON, found 167772");
    let obj = format!("v 0 0 0\nf{}\n", " 1".repeat(28 << 20));
    fs::write(folder.path().join("a.obj"), obj).expect("the mesh is written");
    refuses(folder.path(), &of_mesh("a.obj"), GIB, "none of its 1 faces has an area");
}

#[test]
fn a_scene_of_brackets_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let text = scene("Solid((1, 1, 1))", &"[],".repeat(80 << 20));
    refuses(folder.path(), &text, 2 * GIB, "expected at most 16777216 values in a scene file");
}

/// Texels of an image take their memory once: here 412 MiB as floats, and 69 MiB while the file is decoded.
#[test]
fn a_large_image_is_not_copied() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    type Grey16 = image::ImageBuffer<image::Luma<u16>, Vec<u16>>;
    let image = Grey16::from_pixel(6000, 6000, image::Luma([32768]));
    image.save(folder.path().join("grey.png")).expect("the image is written");
    let sphere = "Sphere(center: (0, 0, 0), radius: 1, material: \"m\")";
    let text = scene("Solid((1, 1, 1))", sphere)
        .replace("Metal(albedo: Rgb(1, 1, 1))", "Lambertian(albedo: Image(path: \"grey.png\"))");
    check(folder.path(), &text, 785 << 10).exits(0);
    // A limit below what it needs is noticed.
    let refused = check(folder.path(), &text, 485 << 10);
    assert!(!refused.status.success(), "{refused:?}");
}
