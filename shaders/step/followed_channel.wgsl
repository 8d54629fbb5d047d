//@ implements followed_channel when dispersion
//@ use bind/settings
//@ use choice/sampler
// Dispersion: red, green and blue take different ways through a surface. From its first refraction there on, a path follows one of them, with
// its light over the channel's probability. A path that has light in one channel alone follows that one.
// Where light is smooth, nearly all noise is that of the channel. So one of eight intervals of a number draws it, which is stratified together
// with the point in the pixel: each eight samples of a half have each interval once. And at surfaces that disperse, the samples of a
// channel are stratified among themselves, so that each channel has its share of what is reflected.

// Eighths 0 to 2 are red, 3 to 5 green, and 6 and 7 blue, whose noise eyes see least.
const CHANNEL_EIGHTHS: u32 = 3u;
const CHANNEL_WEIGHTS: vec3<f32> = vec3<f32>(8.0 / 3.0, 8.0 / 3.0, 4.0);

fn eighth_of_path(path: ptr<function, Path>) -> u32 {
    return random_eighth((*path).pixel, (*path).sample, DIMENSION_CAMERA, settings.seed);
}

// The random numbers that scatter a path at a surface.
fn scatter_random(path: ptr<function, Path>, evaluated: EvaluatedMaterial) -> vec4<f32> {
    var sample = (*path).sample;
    var dimension = bounce_dimension((*path).depth, DIMENSION_SCATTER);
    if evaluated.lobes.dispersion != 0.0 {
        let eighth = eighth_of_path(path);
        let channel = eighth / CHANNEL_EIGHTHS;
        let first = channel * CHANNEL_EIGHTHS;
        sample = sample_of_part(sample, eighth, first, min(CHANNEL_EIGHTHS, 8u - first));
        dimension ^= (channel + 1u) << DIMENSION_CHANNEL_BIT;
    }
    return random4((*path).pixel, sample, dimension, settings.seed);
}

// Sets the channel whose index the material has, and what is kept of light that crosses the surface.
fn follow_channel(path: ptr<function, Path>, evaluated: EvaluatedMaterial) -> EvaluatedMaterial {
    var followed = evaluated;
    followed.kept = vec3<f32>(1.0);
    if evaluated.lobes.dispersion == 0.0 {
        return followed;
    }
    let has_light = (*path).throughput != vec3<f32>(0.0);
    var channel = eighth_of_path(path) / CHANNEL_EIGHTHS;
    let count = select(0u, 1u, has_light.x) + select(0u, 1u, has_light.y) + select(0u, 1u, has_light.z);
    if count == 1u {
        channel = select(select(2u, 1u, has_light.y), 0u, has_light.x);
    } else {
        followed.kept = select(vec3<f32>(0.0), CHANNEL_WEIGHTS, vec3<u32>(0u, 1u, 2u) == vec3<u32>(channel));
    }
    followed.followed = f32(channel) - 1.0;
    return followed;
}

//@ without
//@ use bind/settings
//@ use choice/sampler
// No surface has dispersion.
fn scatter_random(path: ptr<function, Path>, evaluated: EvaluatedMaterial) -> vec4<f32> {
    let dimension = bounce_dimension((*path).depth, DIMENSION_SCATTER);
    return random4((*path).pixel, (*path).sample, dimension, settings.seed);
}

fn follow_channel(path: ptr<function, Path>, evaluated: EvaluatedMaterial) -> EvaluatedMaterial {
    return evaluated;
}
