//! Damages files at random, by a seed.

use super::stats::Random;

/// Pieces of the formats, and numbers at the ends of their ranges as text, with a tab between them.
const PIECES: &[u8] =
    b"(\t)\t[\t]\t{\t}\t,\t:\t\"\t\\\t/*\t*/\t//\t\n\t \t/\t-\t0\t-1\t0.5\t1e100\t1e-100\t1e999\t-1e308\t5e-324\t\
    NaN\tinf\t65536\t16384\t2147483648\t4294967295\t18446744073709551615\tSome(\tNone\tr#\"\tb'\tSphere\t\
    Group([\tTransformed(by: [\tScale(0)\t\xc3\xa9\t\xff\xff\xff\xff\t\0\t\xff\xd9\t\xff\xda\tIDAT\tiCCP\tlist\t\
    element\tend_header\tf 1 2 3\n\tf -1 -2 -3\n\t\"byteStride\": 1,\t\"sparse\": {\t\"count\": 4294967295\t\
    ALPH\tVP8 ";

/// Numbers of 16 and 32 bits that lengths, offsets and counts may be off by.
#[rustfmt::skip]
const NUMBERS: &[u32] = &[
    0, 1, 2, 7, 0x7f, 0x80, 0xff, 0x100, 0x3fff, 0x4000, 0x7fff, 0x8000, 0xffff, 0x1_0000, 0x10_0000, 0x7fff_ffff,
    0x8000_0000, 0xffff_fff0, 0xffff_ffff,
];

/// The file with one to six edits, and half of the time with one or two, at or behind `start`. Splices take the end of `other`.
pub fn mutated(good: &[u8], other: &[u8], start: usize, random: &mut Random) -> Vec<u8> {
    let mut bytes = good.to_vec();
    let most = if random.below(2) == 0 { 2 } else { 6 };
    for _ in 0..random.below(most) + 1 {
        let start = start.min(bytes.len());
        let at = start + random.below(bytes.len() - start + 1);
        let end = (at + 1 + random.below(16)).min(bytes.len());
        match random.below(12) {
            // Flips a bit.
            0..=2 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            3 if random.below(3) == 0 => bytes.truncate(at),
            4 => drop(bytes.drain(at..end)),
            5 => {
                let many = if random.below(8) == 0 { 4096 } else { 8 };
                let byte = [0, 0xff, random.below(256) as u8][random.below(3)];
                drop(bytes.splice(at..at, vec![byte; 1 + random.below(many)]));
            }
            // Copies a part.
            6 => {
                let copy = bytes[at..end].to_vec();
                let to = start + random.below(bytes.len() - start + 1);
                drop(bytes.splice(to..to, copy));
            }
            7 if random.below(4) == 0 => {
                bytes.truncate(at);
                bytes.extend(&other[random.below(other.len() + 1)..]);
            }
            // Replaces a length, in either byte order.
            8 | 9 => {
                let number = NUMBERS[random.below(NUMBERS.len())];
                let word = if random.below(2) == 0 { number.to_le_bytes() } else { number.to_be_bytes() };
                let word = if random.below(2) == 0 { &word[..] } else { &word[..2] };
                let end = (at + word.len()).min(bytes.len());
                bytes[at..end].copy_from_slice(&word[..end - at]);
            }
            10 => replace_number(&mut bytes, at, random),
            _ => {
                let pieces: Vec<&[u8]> = PIECES.split(|byte| *byte == b'\t').collect();
                drop(bytes.splice(at..at, pieces[random.below(pieces.len())].iter().copied()));
            }
        }
    }
    bytes
}

/// Replaces the first number in digits after an offset.
fn replace_number(bytes: &mut Vec<u8>, at: usize, random: &mut Random) {
    let is_part = |byte: &u8| byte.is_ascii_digit() || b"+-.e".contains(byte);
    let Some(begin) = bytes[at..].iter().position(u8::is_ascii_digit).map(|found| at + found) else { return };
    let end = bytes[begin..].iter().position(|byte| !is_part(byte)).map_or(bytes.len(), |length| begin + length);
    let number = match random.below(4) {
        0 => format!("{:e}", f64::from_bits(random.bits())),
        1 => format!("{}", random.below(100)),
        2 => format!("{:e}", 10f64.powi(random.below(220) as i32 - 110)),
        _ => format!("{:.3}", 4.0 * random.uniform() - 2.0),
    };
    drop(bytes.splice(begin..end, number.into_bytes()));
}

/// Claims a size, in formats whose sizes are at a known offset.
pub fn claim_size(name: &str, bytes: &mut [u8], random: &mut Random) {
    let behind = |mark: &[u8]| bytes.windows(mark.len()).position(|window| window == mark).map(|at| at + mark.len());
    let (offset, length, is_big_endian) = match name.rsplit_once('.').map_or("", |(_, ending)| ending) {
        "png" => (Some(16), 4, true),
        "jpg" => (behind(&[0xff, 0xc0, 0, 17, 8]).or(behind(&[0xff, 0xc2, 0, 17, 8])), 2, true),
        "bmp" => (Some(18), 4, false),
        "ktx2" => (Some(20), 4, false),
        "tga" => (Some(12), 2, false),
        "webp" => (behind(&[0x9d, 0x01, 0x2a]), 2, false),
        "exr" => (behind(b"dataWindow\0box2i\0\x10\0\0\0\0\0\0\0\0\0\0\0"), 4, false),
        _ => return,
    };
    for at in [0, 1].map(|number| offset.unwrap_or(bytes.len()) + number * length) {
        let number = NUMBERS[random.below(NUMBERS.len())];
        let word = if is_big_endian { (number << (32 - 8 * length)).to_be_bytes() } else { number.to_le_bytes() };
        if let Some(to) = bytes.get_mut(at..at + length) {
            to.copy_from_slice(&word[..length]);
        }
    }
}

/// The approximate offset where a file's header ends and its content begins.
pub fn end_of_header(name: &str, bytes: &[u8]) -> usize {
    let behind = |mark: &[u8], more: usize| {
        let found = bytes.windows(mark.len()).position(|window| window == mark);
        found.map_or(0, |at| (at + mark.len() + more).min(bytes.len()))
    };
    match name.rsplit_once('.').map_or("", |(_, ending)| ending) {
        "jpg" => behind(&[0xff, 0xda], 12),
        "png" => behind(b"IDAT", 0),
        "webp" => 30,
        "tiff" => 8,
        "tga" => 18,
        "bmp" => 54,
        "hdr" => behind(b"\n\n", 20),
        "exr" => behind(b"screenWindowWidth\0float\0", 9),
        "ktx2" => 80,
        "vdb" => behind(b"Tree_float_5_4_3", 0),
        "ply" => behind(b"end_header\n", 0),
        "glb" => behind(b"BIN\0", 0),
        "gltf" => behind(b";base64,", 0),
        "obj" => behind(b"\nf ", 0),
        "ron" => behind(b"objects: [", 0),
        _ => 0,
    }
}

/// Writes the checksums of a PNG's chunks anew, so that what they contain is read.
pub fn with_checksums(mut png: Vec<u8>) -> Vec<u8> {
    let mut at = 8;
    while let Some(&length) = png.get(at..).and_then(|rest| rest.first_chunk::<4>()) {
        let end = (u32::from_be_bytes(length) as usize).saturating_add(at + 8);
        let Some(named) = png.get(at + 4..end) else { break };
        let crc = !named.iter().fold(u32::MAX, |crc, byte| {
            (0..8).fold(crc ^ u32::from(*byte), |crc, _| crc >> 1 ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 })
        });
        let Some(to) = png.get_mut(end..end + 4) else { break };
        to.copy_from_slice(&crc.to_be_bytes());
        at = end + 4;
    }
    png
}
