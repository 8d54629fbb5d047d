//@ implements surface_light when !sends_shadow_ray & light
//@ use choice/probe
// For kernels whose materials sample no lights, in scenes where others do. Their lobes have no density for MIS.
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
    (*path).pdf = 0.0;
    record_event(path, bsdf.lobe, 0.0);
}
