// A mirror direction, blurred by adding a random point of the unit ball times the fuzz (`parameter`). A direction below the surface is
// absorbed (Shirley, Black, Hollasch, "Ray Tracing in One Weekend", section 10.6). There is no Fresnel factor: the weight is the albedo.
fn metal_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    let mirrored = normalize(hit.incoming - 2.0 * dot(hit.incoming, hit.normal) * hit.normal);
    let blurred = mirrored + material.${metal.fuzz} * sample_ball(u.xyz);
    // At fuzz 1 the sum can vanish. Below this length its direction means nothing.
    if !(dot(blurred, blurred) > 1e-12) || !(dot(blurred, hit.normal) > 0.0) {
        return absorbed();
    }
    return scatter_towards(normalize(blurred), hit.colour, select(lobe_of(material.${metal.fuzz}), LOBE_SPECULAR, material.${metal.fuzz} == 0.0));
}
