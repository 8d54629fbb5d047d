//@ implements light_coat when scene.emission & coat
//@ use bind/extensions
//@ use bind/materials
//@ use choice/coat
//@ use choice/coat_normal
//@ use scene/extensions
//@ use scene/interaction
// The emission of surfaces with a coat to shadow rays: as rays that hit the surface find it.
fn radiance_through_coat(radiance: vec3<f32>, hit: Hit, surface: Surface, ray: Ray) -> vec3<f32> {
    let rows = extensions[surface.material];
    if rows.coat == NO_EXTENSION {
        return radiance;
    }
    var code = vec3<f32>(0.0);
    if rows.coat_normal != NO_EXTENSION {
        code = extension_colour(rows.coat_normal, hit, surface);
    }
    let frame = shading_frame(hit, surface, ray.direction);
    var seen: Interaction;
    seen.incoming = ray.direction;
    seen.coat_normal = coat_normal_at(hit, surface, ray.direction, frame.shading, frame.front, code);
    seen.lobes.coat = min(extension_colour(rows.coat, hit, surface).x, 1.0);
    seen.lobes.coat_f0 = materials[rows.coat].${coat.f0};
    return emission_under_coat(radiance, seen);
}

//@ without
// No surface with a coat emits.
fn radiance_through_coat(radiance: vec3<f32>, hit: Hit, surface: Surface, ray: Ray) -> vec3<f32> {
    return radiance;
}
