//@ use lib/bilinear
//@ each texel_format
//@ use texel/${name}
//@ end
// The texels of images, in the formats that the scene's images have.

// Where an image lies in the buffer of texels: the index of its first word, its size, and the number of its format.
struct ImageLayout {
    first: u32,
    width: u32,
    height: u32,
    format: u32,
}

fn texel(image: ImageLayout, column: u32, row: u32) -> vec3<f32> {
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
fn image_at(image: ImageLayout, u: f32, down: f32, wraps: bool) -> vec3<f32> {
    let b = bilinear(u, down, image.width, image.height, wraps);
    let above = mix(texel(image, b.columns.x, b.rows.x), texel(image, b.columns.y, b.rows.x), b.share.x);
    let below = mix(texel(image, b.columns.x, b.rows.y), texel(image, b.columns.y, b.rows.y), b.share.x);
    return mix(above, below, b.share.y);
}

// An image of colours or of numbers at (u, down), bilinear. Between equal texels of numbers it is their number to the bit, which mix may round.
fn colour_or_number_at(image: ImageLayout, u: f32, down: f32, wraps: bool, is_number: bool) -> vec3<f32> {
    let b = bilinear(u, down, image.width, image.height, wraps);
    let left_above = texel(image, b.columns.x, b.rows.x);
    let right_above = texel(image, b.columns.y, b.rows.x);
    let left_below = texel(image, b.columns.x, b.rows.y);
    let right_below = texel(image, b.columns.y, b.rows.y);
    let above = mix(left_above, right_above, b.share.x);
    let below = mix(left_below, right_below, b.share.x);
    let left = vec2<f32>(left_above.x, left_below.x);
    let right = vec2<f32>(right_above.x, right_below.x);
    let across = left + b.share.x * (right - left);
    let number = across.x + b.share.y * (across.y - across.x);
    return select(mix(above, below, b.share.y), vec3<f32>(number), is_number);
}
