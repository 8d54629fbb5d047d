//@ implements body when !diffuse_transmission
// The matt body of glTF's material: Lambertian.

// The share of light that comes back of all that the body gets.
fn body_albedo(hit: Interaction) -> vec3<f32> {
    return hit.colour;
}

// A direction of the body. `side` is a uniform.
fn draw_body(hit: Interaction, u: vec2<f32>, side: f32) -> vec3<f32> {
    return from_basis(basis_around(hit.normal), sample_cosine_hemisphere(u));
}

// Whether the base scatters light to this direction. Other lobes may answer to light from below, but none of that is of this one.
fn leaves_base(hit: Interaction, direction: vec3<f32>, is_of_facet: bool) -> bool {
    return dot(direction, hit.normal) > 0.0;
}

fn is_on_near_side(hit: Interaction, direction: vec3<f32>) -> bool {
    return true;
}

fn mirrored_to_near_side(hit: Interaction, direction: vec3<f32>) -> vec3<f32> {
    return direction;
}

fn body_colour(hit: Interaction, direction: vec3<f32>) -> vec3<f32> {
    return hit.colour;
}

// The density with which the body scatters to a direction of this cosine.
fn body_pdf(hit: Interaction, direction: vec3<f32>, cos_light: f32) -> f32 {
    return cos_light / PI;
}
