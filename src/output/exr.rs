//! OpenEXR files: the linear picture with its error estimate, the state that a render goes on from, and pictures of other programs.

mod attribute;
mod denoised;
mod read;
mod state;
mod write;

pub use attribute::{Attribute, DENOISER, attribute, attribute_text};
pub use denoised::{of_image_alone, read_noisy, write_denoised};
pub use read::{ExrImage, light_layers, read_attributes, read_exr, read_layer};
pub use state::{State, StateFile, add_film, read_state};
pub use write::{write_exr, write_render};

#[cfg(test)]
mod tests {
    use std::path::Path;

    use ::exr::image::write::WritableImage;
    use ::exr::image::{AnyChannels, Encoding, FlatSamples, Image, Layer, Layers};
    use ::exr::math::Vec2;
    use ::exr::meta::MetaData;
    use ::exr::meta::attribute::LineOrder;
    use ::exr::meta::header::LayerAttributes;

    use super::*;
    use crate::film::{Picture, UNKNOWN_VARIANCE};

    /// A folder, and the path of a file in it.
    fn folder_and_path() -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        (folder, path)
    }

    /// All kinds of values that a film can produce, over the full range of f32.
    fn picture() -> Picture {
        let count = 7 * 5;
        let value = |i: usize| f32::from_bits((i as u32).wrapping_mul(0x0123_4567) & 0x7f7f_ffff);
        Picture {
            width: 7,
            height: 5,
            rgb: (0..count).map(|i| [value(i), value(i + 100), value(i + 200)]).collect(),
            variance: (0..count).map(|i| [value(i + 300), 0.0, UNKNOWN_VARIANCE]).collect(),
            samples: (0..count as u32).map(|i| u32::MAX - i).collect(),
            rejected: (0..count as u32).collect(),
        }
    }

    fn attributes() -> Vec<(String, Attribute)> {
        vec![
            ("scene".into(), Attribute::Text("Küche 場景.ron".into())),
            ("empty".into(), Attribute::Text(String::new())),
            ("max_depth".into(), Attribute::Int(50)),
            ("seed".into(), Attribute::Int(i64::MIN)),
            ("seconds".into(), Attribute::Float(0.1 + 0.2)),
            ("a name that is longer than 31 bytes".into(), Attribute::Float(1e-300)),
        ]
    }

    #[test]
    fn an_image_is_read_back_bit_for_bit() {
        let (_folder, path) = folder_and_path();
        let picture = picture();
        write_exr(&path, &picture, &attributes()).unwrap();
        let read = read_exr(&path).unwrap();
        assert_eq!((read.width, read.height), (7, 5));
        assert_eq!(read.rgb, picture.rgb);
        assert_eq!(read.variance, Some(picture.variance));
        assert_eq!(read.samples, Some(picture.samples));
        assert_eq!(read.rejected, Some(picture.rejected));
        let expected = [
            ("a name that is longer than 31 bytes", "1e-300"),
            ("empty", ""),
            ("max_depth", "50"),
            ("scene", "Küche 場景.ron"),
            ("seconds", "0.30000000000000004"),
            ("seed", "-9223372036854775808"),
        ];
        assert_eq!(read.attributes, expected.map(|(name, value)| (name.to_owned(), value.to_owned())));
    }

    #[test]
    fn the_same_picture_gives_the_same_bytes() {
        let (_folder, path) = folder_and_path();
        let mut tall = Picture { width: 64, height: 300, ..Picture::default() };
        tall.rgb = (0..64 * 300).map(|i| [i as f32, 1.0 / i as f32, 0.5].map(|v| v.min(1e9))).collect();
        tall.variance = tall.rgb.clone();
        tall.samples = vec![8; 64 * 300];
        tall.rejected = vec![0; 64 * 300];
        let bytes = || {
            write_exr(&path, &tall, &attributes()).unwrap();
            std::fs::read(&path).unwrap()
        };
        let first = bytes();
        for _ in 0..5 {
            assert!(bytes() == first);
        }
    }

    #[test]
    fn rows_run_from_top_to_bottom() {
        // Row 0 is also first in the file, with y growing downwards: other readers show it at the top.
        let (_folder, path) = folder_and_path();
        write_exr(&path, &picture(), &[]).unwrap();
        let header = &MetaData::read_from_file(&path, true).unwrap().headers[0];
        assert_eq!(header.line_order, LineOrder::Increasing);
        assert_eq!(header.data_window(), header.shared_attributes.display_window);
        assert_eq!(header.own_attributes.layer_position, Vec2(0, 0));
    }

    fn write_channels(path: &Path, layers: Vec<Vec<(&str, FlatSamples)>>) {
        use ::exr::image::AnyChannel;
        let layer = |(i, channels): (usize, Vec<(&str, FlatSamples)>)| {
            let list = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect();
            let name = LayerAttributes::named(format!("part {i}").as_str());
            Layer::new((2, 1), name, Encoding::UNCOMPRESSED, AnyChannels::sort(list))
        };
        let layer_data: Layers<_> = layers.into_iter().enumerate().map(layer).collect();
        let attributes = ::exr::meta::header::ImageAttributes::with_size((2, 1));
        Image { attributes, layer_data }.write().to_file(path).unwrap();
    }

    #[test]
    fn files_of_others_are_read() {
        use ::exr::prelude::f16;
        let (_folder, path) = folder_and_path();
        let half = |a: f32, b: f32| FlatSamples::F16(vec![f16::from_f32(a), f16::from_f32(b)]);
        let float = |a: f32, b: f32| FlatSamples::F32(vec![a, b]);
        let expected = [[1.0, 3.0, 5.0], [2.0, 4.0, f32::INFINITY]];

        let (red, green, blue) = (half(1.0, 2.0), float(3.0, 4.0), half(5.0, f32::INFINITY));
        write_channels(&path, vec![vec![("R", red), ("G", green), ("B", blue), ("A", half(1.0, 1.0))]]);
        let read = read_exr(&path).unwrap();
        assert_eq!(read.rgb, expected);
        assert_eq!((read.variance, read.samples, read.rejected), (None, None, None));
        let read = |layers| {
            write_channels(&path, layers);
            read_exr(&path).map(|image| image.rgb).map_err(|error| error.to_string())
        };

        // The picture is in the second part, after one of depth; then in a named layer.
        let rgb = |prefix: &'static [&'static str; 3]| {
            vec![(prefix[0], float(1.0, 2.0)), (prefix[1], float(3.0, 4.0)), (prefix[2], float(5.0, f32::INFINITY))]
        };
        assert_eq!(read(vec![vec![("Z", float(0.0, 0.0))], rgb(&["R", "G", "B"])]).unwrap(), expected);
        for names in [&["a.b.R", "a.b.G", "a.b.B"], &["r", "g", "b"], &["Main.red", "Main.green", "Main.blue"]] {
            assert_eq!(read(vec![rgb(names)]).unwrap(), expected, "{names:?}");
        }

        // Other layers are present, in any order of names; then the picture is ambiguous.
        let other = |names: &'static [&'static str; 3]| names.map(|name| (name, float(7.0, 7.0))).to_vec();
        for (picture, names) in [
            (rgb(&["R", "G", "B"]), &["A.R", "A.G", "A.B"]),
            (rgb(&["beauty.R", "beauty.G", "beauty.B"]), &["albedo.R", "albedo.G", "albedo.B"]),
            (rgb(&["C.R", "C.G", "C.B"]), &["A.R", "A.G", "A.B"]),
            (rgb(&["View.Combined.R", "View.Combined.G", "View.Combined.B"]), &["View.AO.R", "View.AO.G", "View.AO.B"]),
        ] {
            assert_eq!(read(vec![[picture, other(names)].concat()]).unwrap(), expected, "{names:?}");
        }
        let message = read(vec![[other(&["N.R", "N.G", "N.B"]), other(&["A.R", "A.G", "A.B"])].concat()]).unwrap_err();
        assert!(
            message.contains("which of its layers is the picture? It has part 0.A, part 0.N; expected"),
            "{message}"
        );
        let message = read(vec![other(&["R", "G", "B"]), other(&["R", "G", "B"])]).unwrap_err();
        assert!(message.contains("It has part 0, part 1; expected"), "{message}");

        // A luminance is grey, but not beside chroma, and not before colours.
        let y = |name: &'static str| vec![(name, half(0.5, -2.0))];
        let grey = [[0.5; 3], [-2.0; 3]];
        for name in ["Y", "beauty.Y"] {
            assert_eq!(read(vec![y(name)]).unwrap(), grey, "{name}");
        }
        assert!(read(vec![[y("Y"), y("RY"), y("BY")].concat()]).unwrap_err().contains("it has BY, RY, Y"));
        assert_eq!(read(vec![y("Y"), rgb(&["R", "G", "B"])]).unwrap(), expected);

        let message = read(vec![vec![("Z", half(1.0, 2.0)), ("R", FlatSamples::U32(vec![1, 2]))]]).unwrap_err();
        assert!(
            message.contains("a.exr: cannot read: expected channels R, G and B, or Y")
                && message.contains("it has R, Z"),
            "{message}"
        );
    }

    #[test]
    fn damaged_files_are_errors() {
        let (folder, path) = folder_and_path();
        assert!(read_exr(&path).unwrap_err().to_string().contains("a.exr: cannot read: "));
        assert!(read_exr(folder.path()).is_err());
        write_exr(&path, &picture(), &attributes()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let broken = folder.path().join("broken.exr");
        for length in (0..bytes.len()).step_by(7) {
            std::fs::write(&broken, &bytes[..length]).unwrap();
            assert!(read_exr(&broken).is_err(), "{length} of {} bytes", bytes.len());
        }
        // A header that asks for 2^62 bytes.
        let window = bytes.windows(11).position(|w| w == b"dataWindow\0").unwrap() + "dataWindow\0box2i\0".len() + 4;
        let mut huge = bytes.clone();
        huge[window..window + 16]
            .copy_from_slice(&[0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 0xff, 0x3f, 0xff, 0xff, 0xff, 0x3f]);
        std::fs::write(&broken, &huge).unwrap();
        assert!(read_exr(&broken).is_err());
    }

    #[test]
    fn attributes_that_cannot_be_written_are_errors_and_leave_no_file() {
        let (folder, path) = folder_and_path();
        for name in ["", "channels", "compression", &"x".repeat(256)] {
            assert!(write_exr(&path, &picture(), &[(name.into(), Attribute::Int(1))]).is_err(), "{name}");
        }
        assert!(!path.exists());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
