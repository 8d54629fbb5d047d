//@ implements medium_light when light & !kernel.light_path
//@ use choice/medium_albedo
//@ use choice/probe
//@ use medium/phase_pdf
//@ use step/light
// Light sampling at a scattering event in a medium. It sets the density of the event's sampled direction for MIS.
fn sample_light_in_medium(path: ptr<function, Path>, medium: Medium, point: vec3<f32>, direction: vec3<f32>) {
    let incoming = (*path).ray.direction;
    let light_sample = sample_light(path, point);
    let g = medium.anisotropy;
    let share = phase_pdf(incoming, light_sample.direction, g, medium.one_minus_anisotropy);
    let albedo = medium_albedo(medium, point);
    let lobe = lobe_of(width_of_phase(medium.one_minus_anisotropy));
    // A medium has no sides: with the sampled direction as the normal, the cone lies on one side.
    aim_probe(path, sends_probe(path, lobe), scatter_towards(direction, albedo, lobe), light_sample.direction, direction, 1.0);
    send_shadow_ray(path, light_sample, point, albedo * share, share);
    record_event(path, lobe, select(1.0, 0.0, lobe == LOBE_WIDE));
    (*path).pdf = phase_pdf(incoming, direction, g, medium.one_minus_anisotropy);
}

//@ without
// No light is sampled.
fn sample_light_in_medium(path: ptr<function, Path>, medium: Medium, point: vec3<f32>, direction: vec3<f32>) {
}
