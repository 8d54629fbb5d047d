//@ use scene/at_run_time
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

// The four texels around a point.
struct FourTexels {
    left_above: vec3<f32>,
    right_above: vec3<f32>,
    left_below: vec3<f32>,
    right_below: vec3<f32>,
}

// One turn for each.
fn four_texels(image: ImageLayout, b: Bilinear) -> FourTexels {
    var four: FourTexels;
    for (var i = 0u; i < turns_of_loop(4u); i++) {
        let column = select(b.columns.x, b.columns.y, (i & 1u) == 1u);
        let row = select(b.rows.x, b.rows.y, i > 1u);
        four = FourTexels(four.right_above, four.left_below, four.right_below, texel(image, column, row));
    }
    return four;
}

// The image at (u, down), both in [0, 1], bilinear.
fn image_at(image: ImageLayout, u: f32, down: f32, wraps: vec2<bool>) -> vec3<f32> {
    let b = bilinear(u, down, image.width, image.height, wraps);
    let four = four_texels(image, b);
    let above = mix(four.left_above, four.right_above, b.share.x);
    let below = mix(four.left_below, four.right_below, b.share.x);
    return mix(above, below, b.share.y);
}
