//@ implements surface_radiance when !scene.emission
//@ use bind/materials
//@ use choice/light_colour
//@ use scene/lights
// The radiance that a surface emits to a shadow ray, if no material emits and scatters.
fn surface_radiance(hit: Hit, surface: Surface, ray: Ray) -> vec3<f32> {
    let material = materials[surface.material];
    if material.${diffuse_light.two_sided} == 0.0 && !arrives_at_front(hit, ray, surface) {
        return vec3<f32>(0.0);
    }
    return colour_of_light(material, hit, surface);
}
