//@ use bind/sky
//@ relies on uniforms
// The sky's image as a light, drawn by inversion: a texel's row by one uniform number, and its column by another. So neighbours among the
// numbers are neighbours in the sky, and stratified numbers stay stratified. The rest of each number is the place around the texel,
// distributed as the tent with which the kernels interpolate (lib/bilinear). Tents that are weighted by texels add up to the interpolated
// image, so that the density follows the radiance within texels too. (With uniform places in texels, 96 samples of a sky with a sun have
// twenty times the noise.) Where the image has more texels than the table, the mean of a block stands for a texel.
//
// The table `sky` has running sums of parts of 2^24 (src/light_distribution.rs), so that a probability is a difference of integers.

// An entry of a list that a uniform number draws.
struct SkyDraw {
    index: u32,
    // Where the number falls between its sums, in [0, 1].
    rest: f32,
}

// The entry of the list from `first` on with sky[first + index] <= 2^24 u < sky[first + index + 1].
fn draw_sky(first: u32, count: u32, u: f32) -> SkyDraw {
    let k = u32(u * 0x1p24f);
    var index = 0u;
    var end = count;
    while end - index > 1u {
        let middle = (index + end) / 2u;
        let is_beyond = sky[first + middle] > k;
        index = select(middle, index, is_beyond);
        end = select(end, middle, is_beyond);
    }
    let start = sky[first + index];
    // The middle of a part: what has one part alone is drawn in its middle.
    return SkyDraw(index, (f32(k - start) + 0.5) / f32(sky[first + index + 1u] - start));
}

// The first of the sums of a row's texels.
fn sky_row(row: u32, columns: u32, rows: u32) -> u32 {
    return rows + 1u + row * (columns + 1u);
}

// A coordinate in texels, by a tent around the texel's centre, which reaches the centres beside it.
fn sky_coordinate(draw: SkyDraw) -> f32 {
    let to_end = 1.0 - sqrt(2.0 * max(min(draw.rest, 1.0 - draw.rest), 0.0));
    return f32(draw.index) + 0.5 + select(to_end, -to_end, draw.rest < 0.5);
}

// A point of the image, as shares from the left and from the top. The image goes on beyond its left and right edge, and is mirrored beyond
// the poles, where the kernels take the row next to them.
fn sky_point(u: vec2<f32>, columns: u32, rows: u32) -> vec2<f32> {
    let row = draw_sky(0u, rows, u.x);
    let column = draw_sky(sky_row(row.index, columns, rows), columns, u.y);
    let across = sky_coordinate(column) / f32(columns);
    let down = abs(sky_coordinate(row) / f32(rows));
    return vec2<f32>(across - floor(across), min(down, 2.0 - down));
}

fn sky_direction(point: vec2<f32>) -> vec3<f32> {
    let down = circle_point(0.5 * point.y);
    // Around the y axis, from -z towards +x.
    let around = down.y * circle_point(point.x - 0.5);
    return normalize(vec3<f32>(around.y, down.x, -around.x));
}

// 2^48 times the probability of a point's columns in a row.
fn sky_parts(row: u32, at: Bilinear, columns: u32, rows: u32) -> f32 {
    let first = sky_row(row, columns, rows);
    let left = first + at.columns.x;
    let right = first + at.columns.y;
    let parts = mix(f32(sky[left + 1u] - sky[left]), f32(sky[right + 1u] - sky[right]), at.share.x);
    return f32(sky[row + 1u] - sky[row]) * parts;
}

// The pdf of a direction, which is at this point of the image.
fn sky_pdf(direction: vec3<f32>, point: vec2<f32>, columns: u32, rows: u32) -> f32 {
    let at = bilinear(point.x, point.y, columns, rows, vec2<bool>(true, false));
    let parts = mix(sky_parts(at.rows.x, at, columns, rows), sky_parts(at.rows.y, at, columns, rows), at.share.y);
    // The image is 2 pi wide and pi high. At the poles, where it has no width, the bound keeps the pdf finite.
    let sine = max(length(direction.xz), 1e-6);
    return parts * 0x1p-48f * f32(columns * rows) / (2.0 * PI * PI * sine);
}
