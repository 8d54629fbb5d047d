//@ use choice/boundary
//@ use choice/coat
//@ each transmissive
//@ use material/${name}
//@ end
// A scattering event in both orders: that of camera paths, which come from the side of the camera, and that of light paths.

// The index of refraction on a side of a surface, relative to what is outside.
fn index_of_side(material: Material, hit: Interaction, is_front: bool) -> f32 {
    switch material.kind {
        //@ each transmissive
        case ${number}u: {
            return select(${name}_index(material, hit), 1.0, is_front);
        }
        //@ end
        default: {
            // The glass of glTF's material; no other has an index here.
            return select(1.0, followed_index(hit.lobes.ior, hit), hit.lobes.ior > 0.0 && !is_front);
        }
    }
}

// Whether a specular event has the same normal, and crosses the surface or not, in both orders. A normal that is bent towards the ray
// (lib/bent_back) may have another direction in the other order, and then no path of that order has this event.
fn is_reversible(hit: Interaction, direction: vec3<f32>, reverse: Interaction) -> bool {
    let crosses = dot(direction, hit.normal) < 0.0;
    let normal = select(reverse.normal, -reverse.normal, crosses);
    return coat_is_reversible(hit, reverse) && all(normal == hit.normal) && reverse.front == (hit.front != crosses);
}

// At a specular event: the density of directions to the light, of camera paths, over that of directions to the camera, of light paths,
// both over the cosine with the surface: (n_c^2 cos_c / n_l^2 cos_l) with the shading normal, times |cos_l / cos_c| with the surface's own.
// `to_camera` and `to_light` leave the surface.
fn specular_ratio(
    material: Material,
    hit: Interaction,
    surface_normal: vec3<f32>,
    to_camera: vec3<f32>,
    to_light: vec3<f32>,
) -> f32 {
    let camera = index_of_side(material, hit, hit.front == (dot(to_camera, hit.normal) > 0.0));
    let light = index_of_side(material, hit, hit.front == (dot(to_light, hit.normal) > 0.0));
    let shading = abs(dot(to_camera, hit.normal) / dot(to_light, hit.normal));
    let surface = abs(dot(to_light, surface_normal) / dot(to_camera, surface_normal));
    let index = camera / light;
    return index * index * (shading * surface);
}
