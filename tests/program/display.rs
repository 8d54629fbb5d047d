//! `render --display-server`: what a viewer gets, by the protocol of tev, and that no viewer stops a render.

use std::fs;
use std::io::Read;
use std::net::{SocketAddr, TcpListener};
use std::os::fd::AsRawFd;
use std::process::Child;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crate::common::program::{Ran, finish, meanwhile, send};
use crate::sandbox::{ENDLESS, Sandbox};

/// The numbers in a packet, at the most: 1 MiB.
const MOST_NUMBERS: usize = 1 << 18;

/// The bytes of an update of `sphere.exr` before its numbers.
const HEAD: usize = 6 + "sphere.exr\0".len() + 4 + "R\0G\0B\0".len() + 4 * 4 + 3 * 8 + 3 * 8;

/// A port of this machine.
fn listen() -> (TcpListener, SocketAddr) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port is free");
    let address = listener.local_addr().expect("it has an address");
    (listener, address)
}

/// A viewer that takes all that one program sends it.
pub fn viewer() -> (String, Arc<Mutex<Vec<u8>>>, std::thread::JoinHandle<()>) {
    let ((listener, address), bytes) = (listen(), Arc::<Mutex<Vec<u8>>>::default());
    let (theirs, mut some) = (bytes.clone(), [0; 4096]);
    let read = move || {
        let (mut socket, _) = listener.accept().expect("the program comes");
        while let count @ 1.. = socket.read(&mut some).expect("it can be read") {
            theirs.lock().unwrap().extend_from_slice(&some[..count]);
        }
    };
    (address.to_string(), bytes, std::thread::spawn(read))
}

/// The complete packets so far.
fn packets(mut bytes: &[u8]) -> Vec<&[u8]> {
    let mut packets = Vec::new();
    while let Some(length) = bytes.first_chunk().map(|length| u32::from_le_bytes(*length) as usize) {
        let Some((packet, rest)) = bytes.split_at_checked(length) else { break };
        packets.push(packet);
        bytes = rest;
    }
    packets
}

/// A packet: its length, its kind, whether the viewer shall show the image, the image's name, and more.
fn packet(kind: u8, focus: u8, name: &str, more: &[&[u8]]) -> Vec<u8> {
    let body = [&[kind, focus], name.as_bytes(), &[0], &more.concat()].concat();
    [&(body.len() as u32 + 4).to_le_bytes(), body.as_slice()].concat()
}

/// That which creates the image: its size and three channels.
fn creation(name: &str, (width, height): (u32, u32)) -> Vec<u8> {
    packet(4, 1, name, &[&width.to_le_bytes(), &height.to_le_bytes(), &3u32.to_le_bytes(), b"R\0G\0B\0"])
}

/// The messages of an image: bands of rows from the top, the channels of a pixel together.
fn update(name: &str, (width, height): (u32, u32), rgb: &[[f32; 3]]) -> Vec<Vec<u8>> {
    let rows = MOST_NUMBERS / (3 * width as usize);
    let band = |(number, pixels): (usize, &[[f32; 3]])| {
        let (top, rows) = ((number * rows) as u32, (pixels.len() / width as usize) as u32);
        let rectangle = [0, top, width, rows].map(u32::to_le_bytes).concat();
        let (offsets, strides) =
            ([0u64, 1, 2].map(u64::to_le_bytes).concat(), [3u64; 3].map(u64::to_le_bytes).concat());
        let data: Vec<u8> = pixels.as_flattened().iter().flat_map(|number| number.to_le_bytes()).collect();
        packet(6, 0, name, &[&3u32.to_le_bytes(), b"R\0G\0B\0", &rectangle, &offsets, &strides, &data])
    };
    assert_eq!(rgb.len(), (width * height) as usize);
    rgb.chunks(rows * width as usize).enumerate().map(band).collect()
}

/// One creation, then images, of which the last is that of the file. The number of images.
#[track_caller]
pub fn assert_shown(sandbox: &Sandbox, bytes: &[u8], size: (u32, u32)) -> usize {
    let image = sandbox.exr("sphere.exr");
    let last = update("sphere.exr", size, &image.rgb);
    let packets = packets(bytes);
    assert_eq!(packets.concat().len(), bytes.len(), "the last packet is whole");
    let (first, images) = packets.split_first().expect("there are packets");
    assert!(*first == creation("sphere.exr", size), "{first:?}");
    assert_eq!(images.len() % last.len(), 0, "images are whole");
    let each: Vec<_> = images.chunks(last.len()).collect();
    for (packet, expected) in each.iter().flat_map(|image| image.iter().zip(&last)) {
        assert!(packet.len() == expected.len() && packet[..HEAD] == expected[..HEAD], "{:?}", &packet[..HEAD]);
    }
    assert!(each.last().expect("there is an image") == &last, "the last image is that of the file");
    each.len()
}

fn start(sandbox: &Sandbox, address: &str, more: &[&str]) -> Child {
    let arguments = [&sandbox.render_sphere(), ["--display-server", address].as_slice(), more].concat();
    sandbox.command(&arguments).spawn().expect("the program starts")
}

fn warnings(text: &str) -> usize {
    text.matches("warning: --display-server").count()
}

/// 512 x 300 pixels take two packets.
#[test]
fn a_viewer_gets_the_image_of_the_file() {
    let sandbox = Sandbox::new();
    let (address, bytes, viewer) = viewer();
    let ran = finish(start(&sandbox, &address, &["--size", "512x300", "--spp", "1"])).exits(0);
    viewer.join().expect("the viewer has all");
    assert!(assert_shown(&sandbox, &bytes.lock().unwrap(), (512, 300)) >= 1);
    assert_eq!(warnings(&ran.stderr), 0, "{}", ran.stderr);
}

/// Also if stderr is not a terminal.
#[test]
fn a_viewer_gets_the_image_so_far() {
    let sandbox = Sandbox::new();
    let (address, bytes, viewer) = viewer();
    let mut child = start(&sandbox, &address, &["--spp", ENDLESS, "--quiet"]);
    meanwhile(&mut child, || packets(&bytes.lock().unwrap()).len() > 2);
    send(&child, libc::SIGINT);
    finish(child).exits(130);
    viewer.join().expect("the viewer has all");
    let bytes = bytes.lock().unwrap();
    assert!(assert_shown(&sandbox, &bytes, (20, 12)) > 2);
    let packets = packets(&bytes);
    assert!(packets[1] != packets[2], "a later image has more samples");
}

#[test]
fn a_viewer_that_goes_away_is_reported_once() {
    let sandbox = Sandbox::new();
    let (listener, address) = listen();
    let log = sandbox.at("log");
    let arguments = [&sandbox.render_sphere(), ["--spp", ENDLESS, "--display-server"].as_slice()].concat();
    let mut command = sandbox.command(&arguments);
    command.arg(address.to_string()).stderr(fs::File::create(&log).expect("a file is made"));
    let mut child = command.spawn().expect("the program starts");
    let (mut socket, _) = listener.accept().expect("the program comes");
    socket.read_exact(&mut [0; 300]).expect("a first image comes");
    drop((socket, listener));
    let logged = || fs::read_to_string(&log).expect("it can be read");
    meanwhile(&mut child, || warnings(&logged()) > 0);
    send(&child, libc::SIGINT);
    finish(child).exits(130);
    assert_eq!(warnings(&logged()), 1, "{}", logged());
}

/// A viewer for which systems hold little.
fn small_viewer() -> (TcpListener, SocketAddr) {
    let (listener, address) = listen();
    let bytes: libc::c_int = 1 << 16;
    // SAFETY: the number is read during the call.
    let set = unsafe {
        let number = (&raw const bytes).cast();
        libc::setsockopt(listener.as_raw_fd(), libc::SOL_SOCKET, libc::SO_RCVBUF, number, size_of_val(&bytes) as u32)
    };
    assert_eq!(set, 0, "its buffer is small");
    (listener, address)
}

/// Nobody listens; the viewer ends the connection at once; it never reads, and systems do not hold 6 MB for it.
#[test]
fn no_viewer_stops_a_render() {
    let sandbox = Sandbox::new();
    let shown = |address: SocketAddr, more: &[&str]| -> Ran {
        let begun = Instant::now();
        let ran = finish(start(&sandbox, &address.to_string(), more)).exits(0);
        assert!(begun.elapsed() < Duration::from_secs(60), "it waited for the viewer");
        assert_eq!(warnings(&ran.stderr), 1, "{}", ran.stderr);
        ran
    };
    sandbox.render(&[]).exits(0);
    let usual = sandbox.exr("sphere.exr").rgb;
    let nobody = listen().1;
    shown(nobody, &[]);
    assert!(sandbox.exr("sphere.exr").rgb == usual, "another image");

    let large = ["--size", "1200x400", "--spp", "1", "--no-state"];
    let (listener, address) = small_viewer();
    let closing = std::thread::spawn(move || drop(listener.accept()));
    shown(address, &large);
    closing.join().expect("the program came");

    let (_listener, address) = small_viewer();
    let ran = shown(address, &large);
    assert!(ran.stderr.contains("it does not read"), "{}", ran.stderr);
}

#[test]
fn a_display_server_without_an_address_is_refused() {
    let sandbox = Sandbox::new();
    for address in ["14158", "localhost", ":14158", "localhost:0", "localhost:70000", "localhost:tev"] {
        sandbox.render(&["--display-server", address]).exits(2).on_stderr(&["expected HOST:PORT"]);
    }
    assert!(sandbox.files().is_empty());
}
