//@ use choice/shading
//@ use choice/normal_map
//@ use choice/second_parts
//@ use choice/multiscatter
//@ use choice/coat
//@ use choice/facet_tangent
//@ use choice/coat_normal
// The interaction of a ray with a surface, which materials take.

fn shading_frame(hit: Hit, surface: Surface, incoming: vec3<f32>) -> ShadingFrame {
    let front = dot(incoming, surface.normal) < 0.0;
    let facing = select(-surface.normal, surface.normal, front);
    let shading = shading_normal(hit, surface, incoming, facing);
    return ShadingFrame(front, facing, shading, event_point(hit, surface, facing));
}

fn interaction_at(
    hit: Hit,
    surface: Surface,
    frame: ShadingFrame,
    evaluated: EvaluatedMaterial,
    incoming: vec3<f32>,
) -> Interaction {
    var interaction: Interaction;
    interaction.incoming = incoming;
    interaction.normal = mapped_normal(hit, surface, incoming, frame.shading, frame.front, evaluated.normal);
    interaction.front = frame.front;
    interaction.colour = evaluated.colour;
    interaction.second = second_part_of(evaluated.material, surface.material);
    interaction.f0 = evaluated.f0;
    interaction.f90 = evaluated.f90;
    interaction.lobes = evaluated.lobes;
    interaction.followed = evaluated.followed;
    interaction.beckmann = evaluated.beckmann;
    interaction.tangent = facet_tangent(hit, surface, interaction.normal, frame.front, evaluated.turn);
    interaction.coat_normal = coat_normal_at(hit, surface, incoming, frame.shading, frame.front, evaluated.coat_normal);
    interaction.emission = emission_under_coat(evaluated.emission, interaction);
    interaction.compensation = energy_compensation(evaluated.material, surface, interaction);
    return interaction;
}
