//! Packs decoded images into the texels that are kept.

use image::{DynamicImage, ImageBuffer, Pixel};

use crate::bitmap::{Bitmap, Channel, Decoding, Format, from_srgb};

/// An image in one of the ways in which it can be decoded. Integers of 8 bits stay as they are; all others become floats.
pub fn bitmap(image: &DynamicImage, decoding: Decoding) -> Bitmap {
    let code = |c: u16| f64::from(c) / f64::from(u16::MAX);
    let light = |c: u16| from_srgb(code(c));
    let plain = |c: u16| code(c) as f32;
    let float = |c: f32| c;
    match image {
        DynamicImage::ImageLuma8(image) => of_bytes(image, decoding),
        DynamicImage::ImageLumaA8(image) => of_bytes(image, decoding),
        DynamicImage::ImageRgb8(image) => of_bytes(image, decoding),
        DynamicImage::ImageRgba8(image) => of_bytes(image, decoding),
        DynamicImage::ImageLuma16(image) => floats(image, decoding, light, plain),
        DynamicImage::ImageLumaA16(image) => floats(image, decoding, light, plain),
        DynamicImage::ImageRgb16(image) => floats(image, decoding, light, plain),
        DynamicImage::ImageRgba16(image) => floats(image, decoding, light, plain),
        DynamicImage::ImageRgb32F(image) => floats(image, decoding, float, float),
        DynamicImage::ImageRgba32F(image) => floats(image, decoding, float, float),
        // The crate may add kinds.
        other => floats(&other.to_rgba32f(), decoding, float, float),
    }
}

/// The number of one channel of a pixel.
pub fn of_channel<T: Copy>([r, g, b, a]: [T; 4], channel: Channel) -> T {
    match channel {
        Channel::R | Channel::Rgb => r,
        Channel::G => g,
        Channel::B => b,
        Channel::A => a,
    }
}

fn of_bytes<P: Pixel<Subpixel = u8>>(image: &ImageBuffer<P, Vec<u8>>, decoding: Decoding) -> Bitmap {
    let (width, height) = image.dimensions();
    let pixels = image.pixels().map(|pixel| pixel.to_rgba().0);
    let codes = |format| Bitmap::of_codes(width, height, format, pixels.clone().map(|[r, g, b, _]| [r, g, b]));
    match decoding {
        Decoding::Colour => codes(Format::Srgb),
        Decoding::Numbers => codes(Format::Linear),
        Decoding::Number(channel) => Bitmap::of_numbers(width, height, pixels.map(|pixel| of_channel(pixel, channel))),
    }
}

/// `light` is the linear value of a colour, and `plain` that of a number.
fn floats<P: Pixel>(
    image: &ImageBuffer<P, Vec<P::Subpixel>>,
    decoding: Decoding,
    light: impl Fn(P::Subpixel) -> f32,
    plain: impl Fn(P::Subpixel) -> f32,
) -> Bitmap {
    let texel = |pixel: &P| {
        let [r, g, b, a] = pixel.to_rgba().0;
        match decoding {
            Decoding::Colour => [r, g, b].map(&light),
            Decoding::Numbers => [r, g, b].map(&plain),
            Decoding::Number(channel) => [plain(of_channel([r, g, b, a], channel)); 3],
        }
    };
    Bitmap::of_floats(image.width(), image.height(), image.pixels().map(texel))
}
