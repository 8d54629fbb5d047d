//@ implements number_texels when number_images
//@ use scene/texel
// An image of colours or of numbers at (u, down), bilinear. Between equal texels of numbers it is their number to the bit, which mix may round.
fn colour_or_number_at(image: ImageLayout, u: f32, down: f32, wraps: vec2<bool>, is_number: bool) -> vec3<f32> {
    let b = bilinear(u, down, image.width, image.height, wraps);
    let four = four_texels(image, b);
    let above = mix(four.left_above, four.right_above, b.share.x);
    let below = mix(four.left_below, four.right_below, b.share.x);
    let left = vec2<f32>(four.left_above.x, four.left_below.x);
    let right = vec2<f32>(four.right_above.x, four.right_below.x);
    let across = left + b.share.x * (right - left);
    let number = across.x + b.share.y * (across.y - across.x);
    return select(mix(above, below, b.share.y), vec3<f32>(number), is_number);
}

//@ without
//@ use scene/texel
// All images have colours.
fn colour_or_number_at(image: ImageLayout, u: f32, down: f32, wraps: vec2<bool>, is_number: bool) -> vec3<f32> {
    return image_at(image, u, down, wraps);
}
