// A metal without fuzz is a mirror.
fn metal_is_non_specular(material: Material) -> bool {
    return material.${metal.fuzz} > 0.0;
}

// The pdf with which metal_scatter samples the direction: the density of points in the ball of radius fuzz around the tip of
// the mirrored direction, integrated along a ray from the origin in this direction. With d- and d+ the distances at which that
// ray enters and leaves the ball, it is (d+^3 - d-^3) / (4 pi fuzz^3) (own derivation; docs/light-transport.md). The form here
// has no cancellation for small fuzz: d+^3 - d-^3 = 2 h (3 c^2 + h^2), with c the cosine to the mirrored direction, s the sine,
// and h = sqrt(fuzz^2 - s^2). If the origin lies in the ball, d- = 0. The BSDF times cosine is the albedo times the pdf.
// Directions below the surface are absorbed.
fn metal_eval(material: Material, hit: Interaction, direction: vec3<f32>) -> Response {
    let fuzz = material.${metal.fuzz};
    let mirrored = normalize(hit.incoming - 2.0 * dot(hit.incoming, hit.normal) * hit.normal);
    let c = dot(mirrored, direction);
    let across = direction - c * mirrored;
    let h2 = fuzz * fuzz - dot(across, across);
    if !(h2 > 0.0) || !(dot(direction, hit.normal) > 0.0) {
        return no_response();
    }
    let h = sqrt(h2);
    var cubes = 2.0 * h * (3.0 * c * c + h2);
    if fuzz >= 1.0 && h > c {
        let far = max(c + h, 0.0);
        cubes = far * far * far;
    } else if c < 0.0 {
        return no_response();
    }
    let pdf = cubes / (4.0 * PI * fuzz * fuzz * fuzz);
    return Response(hit.colour * pdf, pdf, select(0.0, 1.0, is_narrow(fuzz)));
}
