fn lambertian_is_non_specular(material: Material) -> bool {
    return true;
}

// The Lambertian BSDF times cosine, and the pdf with which lambertian_scatter samples the direction.
fn lambertian_eval(material: Material, hit: Interaction, direction: vec3<f32>) -> Response {
    let cosine = max(dot(direction, hit.normal), 0.0);
    return Response(hit.colour * (cosine / PI), cosine / PI, 0.0);
}
