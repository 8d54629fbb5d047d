//@ implements followed_channel when dispersion
//@ use bind/settings
//@ use choice/sampler
// Dispersion: red, green and blue take different ways through a surface. From its first refraction there on, a path follows one of them, with
// three times its light. A path that has light in one channel alone follows that one.

// Sets the channel whose index the material has, and what is kept of light that crosses the surface.
fn follow_channel(path: ptr<function, Path>, evaluated: EvaluatedMaterial) -> EvaluatedMaterial {
    var followed = evaluated;
    followed.kept = vec3<f32>(1.0);
    if evaluated.lobes.dispersion == 0.0 {
        return followed;
    }
    let has_light = (*path).throughput != vec3<f32>(0.0);
    let u = random4((*path).pixel, (*path).sample, DIMENSION_TIME, settings.seed).y;
    var channel = min(u32(3.0 * u), 2u);
    let count = select(0u, 1u, has_light.x) + select(0u, 1u, has_light.y) + select(0u, 1u, has_light.z);
    if count == 1u {
        channel = select(select(2u, 1u, has_light.y), 0u, has_light.x);
    } else {
        followed.kept = select(vec3<f32>(0.0), vec3<f32>(3.0), vec3<u32>(0u, 1u, 2u) == vec3<u32>(channel));
    }
    followed.followed = f32(channel) - 1.0;
    return followed;
}

//@ without
// No surface has dispersion.
fn follow_channel(path: ptr<function, Path>, evaluated: EvaluatedMaterial) -> EvaluatedMaterial {
    return evaluated;
}
