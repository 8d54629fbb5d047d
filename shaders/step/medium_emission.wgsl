//@ implements medium_emission when medium_emission & !kernel.light_path
//@ use bind/fields
//@ use scene/at_run_time
//@ use choice/aov_direct
//@ use choice/clamp
//@ use choice/heat
// Adds the emission of a medium by its expectation at an event: what an event absorbs emits. No light sampling finds it, so that its weight is 1.
fn add_medium_emission(path: ptr<function, Path>, number: u32, medium: Medium, point: vec3<f32>, albedo: vec3<f32>) {
    let field = fields[at_run_time(number)];
    let radiance = field.emission * heat_at(medium, field, point);
    let contribution = (*path).throughput * (1.0 - albedo) * radiance;
    record_direct(path, contribution, (*path).depth);
    (*path).radiance += limited_indirect(contribution, (*path).depth);
}

//@ without
// No medium emits.
fn add_medium_emission(path: ptr<function, Path>, number: u32, medium: Medium, point: vec3<f32>, albedo: vec3<f32>) {
}
