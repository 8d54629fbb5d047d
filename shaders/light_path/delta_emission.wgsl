//@ implements delta_emission when delta_light
//@ use bind/emitters
//@ use light_path/aims
//@ use scene/at_run_time
//@ use light_path/parallel_aims
//@ use scene/delta_lights
// Light paths of lights without size.

// The first light without size in the table of lights. All others follow it.
const FIRST_DELTA_LIGHT: u32 = ${first_delta_light}u;

fn emit_from_delta_light(code: u32, probability: f32, u: f32, v: vec2<f32>) -> EmittedRay {
    let light = delta_light_at(primitive_index(code));
    if light.has_position > 0.0 {
        let aim = aim_from(light.position, code, u, v);
        let intensity = intensity_of_delta_light(code, -aim.direction);
        let density = probability * aim.pdf;
        let weight = select(vec3<f32>(0.0), intensity / density, density > 0.0);
        return EmittedRay(Ray(light.position, aim.direction), weight, density, vec3<f32>(1.0), false);
    }
    let direction = -light.position;
    let aim = aim_parallel(direction, code, u, v);
    let irradiance = intensity_of_delta_light(code, light.position);
    let density = probability * aim.density;
    let weight = select(vec3<f32>(0.0), irradiance / density, density > 0.0);
    return EmittedRay(Ray(aim.origin, direction), weight, density, vec3<f32>(1.0), true);
}

// The density with which emit_from_delta_light draws the reverse of a ray to the light: in solid angle, or over the area across.
fn density_of_delta_emission(code: u32, to_light: Ray) -> f32 {
    let light = delta_light_at(primitive_index(code));
    let probability = emitters[at_run_time(FIRST_DELTA_LIGHT + primitive_index(code))].density;
    if light.has_position > 0.0 {
        return probability * density_of_aim(Ray(light.position, -to_light.direction), code);
    }
    return probability * density_of_parallel_aim(Ray(to_light.origin, -to_light.direction), code);
}

//@ without
// No light is without size.
fn emit_from_delta_light(code: u32, probability: f32, u: f32, v: vec2<f32>) -> EmittedRay {
    return no_emission();
}

fn density_of_delta_emission(code: u32, to_light: Ray) -> f32 {
    return 0.0;
}
