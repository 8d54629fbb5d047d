//@ use data/emitted_ray
//@ use data/primitive
//@ use scene/aims
//@ use scene/parallel_aims
//@ use scene/delta_lights
// Light paths of lights without size. Their density is 0: no other technique finds them by this class of paths.
fn emit_from_delta_light(code: u32, probability: f32, u: f32, v: vec2<f32>) -> EmittedRay {
    let light = delta_light_at(primitive_index(code));
    if light.has_position > 0.0 {
        let aim = aim_from(light.position, code, u, v);
        let intensity = intensity_of_delta_light(code, -aim.direction);
        let weight = select(vec3<f32>(0.0), intensity / (probability * aim.pdf), aim.pdf > 0.0);
        return EmittedRay(Ray(light.position, aim.direction), weight, 0.0, false);
    }
    let direction = -light.position;
    let aim = aim_parallel(direction, code, u, v);
    let irradiance = intensity_of_delta_light(code, light.position);
    let weight = select(vec3<f32>(0.0), irradiance / (probability * aim.density), aim.density > 0.0);
    return EmittedRay(Ray(aim.origin, direction), weight, 0.0, true);
}
