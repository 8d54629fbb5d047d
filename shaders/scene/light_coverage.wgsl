//@ use data/hit
//@ use data/light
//@ use data/primitive
//@ use data/ray
//@ use scene/coverage
//@ use scene/lights
// The light of a surface that covers a part of what is behind it. The walk does not draw whether a shadow ray passes its own end, so the
// coverage there is a factor.
fn cover_light_at_hit(radiance: vec3<f32>, ray: Ray, hit: Hit) -> vec3<f32> {
    // The sky and lights without size have no surface.
    if primitive_kind(hit.code) >= KIND_DELTA_LIGHT {
        return radiance;
    }
    return radiance * coverage_at(hit, light_surface_at(hit, ray));
}
