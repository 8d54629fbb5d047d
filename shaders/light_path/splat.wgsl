//@ use bind/counters
//@ use bind/settings
//@ use bind/window
//@ use choice/clamp
//@ use choice/seam
//@ use choice/splat_filter
//@ use choice/splat_lights
//@ use step/film
//@ use step/pixel_order
//@ relies on bits
// Adds the light of light paths to the film. Its sums are integers, so the order of splats does not matter.

const FIRST_SPLAT: u32 = ${splat_sums}u;

// Adds a contribution at a point of the film, per pixel of the image, to one of the pixels whose filter covers the point. `half`: whether the
// run of the light path is even or odd. `u` chooses the pixel. Returns what was added.
fn splat(path: ptr<function, Path>, at: vec2<f32>, contribution: vec3<f32>, half: u32, u: vec2<f32>) -> vec3<f32> {
    let target_pixel = across_seam(choose_pixel(at, u));
    let column = target_pixel.column - i32(settings.film_left);
    let row = target_pixel.row - i32(settings.film_top);
    if target_pixel.weight == 0.0 || column < 0 || row < 0 || column >= i32(settings.film_width) || row >= i32(settings.film_height) {
        return vec3<f32>(0.0);
    }
    let pixel = rank_of_pixel(u32(target_pixel.row) * settings.image_width + u32(target_pixel.column)) - window.first_pixel;
    if pixel >= window.pixels {
        return vec3<f32>(0.0);
    }
    // `--clamp` limits what a light path adds to a sample of the pixel.
    let light_paths = f32(settings.light_paths) / f32(RUN_LENGTH);
    let limited = light_paths * limited_indirect(contribution / light_paths, INDIRECT_FROM);
    let value = target_pixel.weight * limited;
    if is_nan(value.x) || is_nan(value.y) || is_nan(value.z) {
        atomicAdd(&counters.nan, 1u);
        return vec3<f32>(0.0);
    }
    if is_infinite(value.x) || is_infinite(value.y) || is_infinite(value.z) {
        atomicAdd(&counters.infinite, 1u);
        return vec3<f32>(0.0);
    }
    for (var i = 0u; i < 3u; i++) {
        add_to_film(pixel, FIRST_SPLAT + 3u * half + i, value[i], SUM_FRACTION);
        add_to_film(pixel, FIRST_SPLAT + 6u + i, value[i] * value[i], SQUARE_FRACTION);
    }
    splat_light(path, pixel, value, half);
    return value;
}
