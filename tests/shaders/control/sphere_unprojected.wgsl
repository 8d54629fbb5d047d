//@ use geometry/sphere
// Wrong on purpose: the point stays where the distance put it, off the sphere by the error of the distance.
fn unprojected_surface(ray: Ray, t: f32, sphere: Sphere) -> Surface {
    var surface = sphere_surface(ray, t, sphere);
    surface.point = ray.origin + t * ray.direction;
    return surface;
}
