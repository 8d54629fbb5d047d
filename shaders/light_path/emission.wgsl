//@ use bind/emitters
//@ use bind/lights
//@ use geometry/offset
//@ use light/alias
//@ use light/sample
//@ use light_path/aims
//@ use scene/at_run_time
//@ use scene/lights
//@ use choice/light_coverage
//@ use choice/delta_emission
//@ use choice/delta_lights
//@ use choice/light_surfaces
// The emission of light paths: a light by its power that the boxes of light_path/aims receive, a point uniform in its area, and a direction to one
// of the boxes.

const LIGHTS: u32 = ${lights}u;
// The hit record at a point of a light is that of a ray from this distance. (Render space has an extent near 1.)
const BEFORE_LIGHT: f32 = 0.125;

fn point_of_light(light: Light, u: vec2<f32>) -> LightPoint {
    let index = primitive_index(light.code);
    let pose = pose_at(light.code, light.instance);
    switch primitive_kind(light.code) {
        //@ each whole_emitter
        case ${number}u: {
            return ${name}_light_point(moved_${name}(${name}_at(index, light.instance), pose), u);
        }
        //@ end
        //@ each parted_emitter
        case ${number}u: {
            return ${name}_part_point(moved_${name}(${name}_at(index, light.instance), pose), light.part, u);
        }
        //@ end
        default: {
            return LightPoint(vec3<f32>(0.0), vec3<f32>(0.0));
        }
    }
}

// Whether light paths leave a light in this direction.
fn leaves_light(code: u32, normal: vec3<f32>, direction: vec3<f32>) -> bool {
    switch primitive_kind(code) {
        //@ each emitter
        case ${number}u: {
            return ${name}_light_leaves(normal, direction);
        }
        //@ end
        default: {
            return true;
        }
    }
}

// The light that a uniform number draws, with its probability over its area.
fn draw_emitter(u: f32) -> AliasChoice {
    let pick = alias_pick(u, LIGHTS);
    return alias_choice(pick, emitters[pick.index]);
}

// The ray of a drawn light. `u` chooses the box and the point; `v` the direction.
fn emit_light(choice: AliasChoice, u: vec3<f32>, v: vec2<f32>) -> EmittedRay {
    let light = lights[choice.index];
    if is_delta_light(light.code) {
        return emit_from_delta_light(light.code, choice.density, u.x, v);
    }
    let start = point_of_light(light, u.yz);
    let aim = aim_from(start.point, light.code, u.x, v);
    if !(aim.pdf > 0.0) || dot(start.outward, aim.direction) < 0.0 {
        return no_emission();
    }
    let back = Ray(start.point + BEFORE_LIGHT * aim.direction, -aim.direction);
    var hit = hit_at(light.code, BEFORE_LIGHT);
    hit.instance = light.instance;
    let surface = light_surface_at(hit, back);
    let radiance = emitted_by_surface(back, hit);
    let cosine = abs(dot(surface.normal, aim.direction));
    if !(cosine > 0.0) || !leaves_light(light.code, surface.normal, aim.direction) {
        return no_emission();
    }
    let density = choice.density * aim.pdf / cosine;
    let origin = leave_surface(surface.point, surface.error, surface.normal, aim.direction);
    let weight = cover_light_at_hit(radiance, back, hit) / density;
    return EmittedRay(Ray(origin, aim.direction), weight, density, radiance, false);
}

// The density over the cosine with which emit_light draws the reverse of a ray that hit a light; 0 if it never does.
fn density_of_emission(hit: Hit, surface: Surface, incoming: vec3<f32>) -> f32 {
    let index = light_at(hit, surface.local);
    let direction = -incoming;
    let cosine = abs(dot(surface.normal, direction));
    if index >= LIGHTS || !(cosine > 0.0) || !leaves_light(hit.code, surface.normal, direction) {
        return 0.0;
    }
    return emitters[at_run_time(index)].density * density_of_aim(Ray(surface.point, direction), hit.code) / cosine;
}
