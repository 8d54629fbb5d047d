//@ implements surface_light when sends_shadow_ray
//@ use bind/settings
//@ use choice/normal_map
//@ use choice/probe
//@ use choice/shading
//@ use choice/both_sides
//@ use choice/tint
//@ use scene/at_run_time
//@ use scene/responses
//@ use step/light
// Light sampling at a surface. It sets the density of the BSDF sample for MIS.
fn sample_light_at_surface(
    path: ptr<function, Path>,
    hit: Hit,
    surface: Surface,
    frame: ShadingFrame,
    interaction: Interaction,
    evaluated: EvaluatedMaterial,
    bsdf: Scatter,
    u: f32,
) {
    // Non-specular materials sample lights, on the side from which the ray comes.
    let samples_lights = (*path).depth < settings.max_depth && is_non_specular(evaluated);
    let probes = bsdf.event == SCATTERED && sends_probe(path, bsdf.lobe);
    var sampled = LightResponse(Response(), 0.0, 1.0);
    // One call serves both, because compilers inline the functions of all kinds of lights at each call.
    if samples_lights || probes {
        let side = choose_side(samples_lights, evaluated, frame.point, hit, surface, frame.facing, u);
        let light_sample = sample_light(path, side.point);
        var leaving = bsdf.direction;
        if samples_lights {
            leaving = light_sample.direction;
            // First the direction of the BSDF sample, whose density is kept, then that of the light.
            for (var i = 0u; i < turns_of_loop(2u); i++) {
                sampled.drawn_pdf = sampled.response.pdf;
                let direction = select(bsdf.direction, leaving, i == 1u);
                sampled.response = response_of_material(evaluated.material, interaction, direction);
            }
            sampled.response.value = response_on_side(sampled.response.value, leaving, interaction.normal, frame.shading);
        }
        sampled = respond_on_side(sampled, side, light_sample.direction, frame.shading);
        let response = tint_through(sampled.response.value, evaluated, leaving, frame.shading);
        aim_probe(path, probes, bsdf, light_sample.direction, frame.shading, sampled.probed);
        let origin = spawn_ray(hit, surface, frame.facing, frame.shading, side.point, leaving).origin;
        send_shadow_ray(path, light_sample, origin, response, sampled.response.pdf);
    }
    // A specular lobe has no density.
    (*path).pdf = select(sampled.drawn_pdf, 0.0, bsdf.lobe == LOBE_SPECULAR);
    record_event(path, bsdf.lobe, sampled.response.narrow);
}

//@ without
// No light is sampled.
fn sample_light_at_surface(
    path: ptr<function, Path>,
    hit: Hit,
    surface: Surface,
    frame: ShadingFrame,
    interaction: Interaction,
    evaluated: EvaluatedMaterial,
    bsdf: Scatter,
    u: f32,
) {
}
