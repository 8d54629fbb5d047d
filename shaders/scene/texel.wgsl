//@ use lib/bilinear
//@ each texel_format
//@ use texel/${name}
//@ end
// The texels of images, in the formats that the scene's images have.

// Where an image lies in the buffer of texels: the place of its first word, its size, and the number of its format.
struct ImagePlace {
    first: u32,
    width: u32,
    height: u32,
    format: u32,
}

fn texel(image: ImagePlace, column: u32, row: u32) -> vec3<f32> {
    let index = row * image.width + column;
    switch image.format {
        //@ each texel_format
        ${case}: {
            return ${name}_texel(image.first, index);
        }
        //@ end
    }
}

// The image at (u, down), both in [0, 1], bilinear.
fn image_at(image: ImagePlace, u: f32, down: f32, wraps: bool) -> vec3<f32> {
    let b = bilinear(u, down, image.width, image.height, wraps);
    let above = mix(texel(image, b.columns.x, b.rows.x), texel(image, b.columns.y, b.rows.x), b.share.x);
    let below = mix(texel(image, b.columns.x, b.rows.y), texel(image, b.columns.y, b.rows.y), b.share.x);
    return mix(above, below, b.share.y);
}

// The same of an image of numbers. Between equal texels it is their number to the bit, which mix may round.
fn number_in(image: ImagePlace, u: f32, down: f32, wraps: bool) -> f32 {
    let b = bilinear(u, down, image.width, image.height, wraps);
    let left = vec2<f32>(texel(image, b.columns.x, b.rows.x).x, texel(image, b.columns.x, b.rows.y).x);
    let right = vec2<f32>(texel(image, b.columns.y, b.rows.x).x, texel(image, b.columns.y, b.rows.y).x);
    let across = left + b.share.x * (right - left);
    return across.x + b.share.y * (across.y - across.x);
}
