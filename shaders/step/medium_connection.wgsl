//@ implements medium_light when light & kernel.light_path
//@ use choice/light_absorption
//@ use choice/medium_albedo
//@ use medium/phase_pdf
//@ use light_path/lens_connection
// An event of a light path in a medium sends a ray to the lens, too.
fn sample_light_in_medium(path: ptr<function, Path>, medium: Medium, point: vec3<f32>, direction: vec3<f32>) {
    if (*path).depth == FIRST_LIGHT_EVENT {
        return;
    }
    absorb_nothing_ahead(path);
    let view = view_of_event(path, point);
    let share = phase_pdf((*path).ray.direction, view.direction, medium.anisotropy, medium.one_minus_anisotropy);
    send_to_lens(path, view, point, medium_albedo(medium, point) * share, 1.0, share);
}
