//@ implements surface_radiance when scene.emission
//@ use bind/extensions
//@ use bind/materials
//@ use choice/light_colour
//@ use choice/vertex_emission
//@ use choice/light_coat
//@ use scene/lights
// The radiance that a surface emits to a shadow ray, where materials emit and scatter.
fn surface_radiance(hit: Hit, surface: Surface, ray: Ray) -> vec3<f32> {
    let emission = extensions[surface.material].emission;
    if emission == NO_EXTENSION || (materials[emission].${emission.two_sided} == 0.0 && !arrives_at_front(hit, ray, surface)) {
        return vec3<f32>(0.0);
    }
    let row = materials[emission];
    var framed = surface;
    framed.frame += row.kind;
    let emitted = times_vertex_emission(colour_of_light(row, hit, framed), hit, surface);
    return radiance_through_coat(emitted, hit, surface, ray);
}
