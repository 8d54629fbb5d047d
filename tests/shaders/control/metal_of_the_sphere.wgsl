// Wrong on purpose: a point of the unit sphere's surface instead of the ball.
fn metal_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    let mirrored = normalize(hit.incoming - 2.0 * dot(hit.incoming, hit.normal) * hit.normal);
    let blurred = mirrored + material.${metal.fuzz} * sample_sphere(u.xy);
    if !(dot(blurred, hit.normal) > 0.0) {
        return absorbed();
    }
    return scatter_towards(normalize(blurred), hit.colour, LOBE_WIDE);
}
