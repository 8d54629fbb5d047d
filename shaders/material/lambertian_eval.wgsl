//@ use data/material
//@ use lib/sampling
fn lambertian_is_non_specular(material: Material) -> bool {
    return true;
}

// The Lambertian BSDF times cosine, and the density by which lambertian_scatter draws the direction.
fn lambertian_eval(material: Material, hit: Interaction, direction: vec3<f32>) -> Response {
    let cosine = max(dot(direction, hit.normal), 0.0);
    return Response(hit.colour * (cosine / PI), cosine / PI);
}
