// Wrong on purpose: the normal from the point at t, which is off by the rounding of a distance of many radii.
fn sphere_surface_by_t(ray: Ray, t: f32, sphere: Sphere) -> Surface {
    let normal = normalize(ray.origin + t * ray.direction - sphere.center);
    var surface: Surface;
    surface.point = sphere.center + sphere.radius * normal;
    surface.normal = normal;
    let c = abs(sphere.center);
    surface.error = 4.0 * UNIT_ROUNDOFF * (max(max(c.x, c.y), c.z) + sphere.radius);
    return surface;
}
