//@ implements body when diffuse_transmission
// KHR_materials_diffuse_transmission: the matt body of glTF's material lets a share t of the light that it scatters pass to its far side, in
// all directions and in a colour of its own. The rest is scattered back in the base colour.

fn body_albedo(hit: Interaction) -> vec3<f32> {
    return (1.0 - hit.lobes.through) * hit.colour + hit.lobes.through * hit.lobes.colour_through;
}

// The probability of the far side: its share of that light.
fn share_of_far_side(hit: Interaction) -> f32 {
    let far = hit.lobes.through * dot(hit.lobes.colour_through, vec3<f32>(1.0));
    let near = (1.0 - hit.lobes.through) * dot(hit.colour, vec3<f32>(1.0));
    return select(hit.lobes.through, far / (far + near), far + near > 0.0);
}

fn draw_body(hit: Interaction, u: vec2<f32>, side: f32) -> vec3<f32> {
    let near = sample_cosine_hemisphere(u);
    let height = select(near.z, -near.z, side < share_of_far_side(hit));
    return from_basis(basis_around(hit.normal), vec3<f32>(near.xy, height));
}

// Whether the base scatters light to this direction.
fn leaves_base(hit: Interaction, direction: vec3<f32>, is_of_facet: bool) -> bool {
    let height = dot(direction, hit.normal);
    return height > 0.0 || (height < 0.0 && !is_of_facet && hit.lobes.through > 0.0);
}

fn is_on_near_side(hit: Interaction, direction: vec3<f32>) -> bool {
    return dot(direction, hit.normal) > 0.0;
}

// The direction, or its mirror image before the surface: the layer lets as much light in as if it did not pass.
fn mirrored_to_near_side(hit: Interaction, direction: vec3<f32>) -> vec3<f32> {
    let height = dot(direction, hit.normal);
    return direction - 2.0 * select(0.0, min(height, 0.0), hit.lobes.through > 0.0) * hit.normal;
}

fn body_colour(hit: Interaction, direction: vec3<f32>) -> vec3<f32> {
    if is_on_near_side(hit, direction) {
        return (1.0 - hit.lobes.through) * hit.colour;
    }
    return hit.lobes.through * hit.lobes.colour_through;
}

fn body_pdf(hit: Interaction, direction: vec3<f32>, cos_light: f32) -> f32 {
    let far = share_of_far_side(hit);
    return select(far, 1.0 - far, is_on_near_side(hit, direction)) * (cos_light / PI);
}
