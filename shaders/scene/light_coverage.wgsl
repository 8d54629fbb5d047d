//@ implements light_coverage when area_light & alpha & scene.emission
//@ use scene/coverage
//@ use scene/lights
// Returns the light of a surface times its coverage. A walk tests the coverage of the surfaces before the end of a shadow ray, but not
// that of the light at its end.
fn cover_light_at_hit(radiance: vec3<f32>, ray: Ray, hit: Hit) -> vec3<f32> {
    // The sky and lights without size have no surface.
    if primitive_kind(hit.code) >= KIND_DELTA_LIGHT {
        return radiance;
    }
    return radiance * coverage_at(hit, light_surface_at(hit, ray));
}

//@ without
// Lights cover all that is behind them.
fn cover_light_at_hit(radiance: vec3<f32>, ray: Ray, hit: Hit) -> vec3<f32> {
    return radiance;
}
