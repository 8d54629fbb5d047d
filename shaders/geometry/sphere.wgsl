//@ use choice/sphere_chord

// Distance to the nearest crossing of the sphere in front of the ray's origin, or NO_HIT.
fn sphere_distance(ray: Ray, sphere: Sphere) -> f32 {
    let t = sphere_crossings(ray, sphere);
    return select(select(NO_HIT, t.y, t.y > 0.0), t.x, t.x > 0.0);
}

// The point is computed from the normal, as centre + r n. Its only error is the rounding of that sum.
fn sphere_surface(ray: Ray, t: f32, sphere: Sphere) -> Surface {
    let normal = sphere_normal(ray, t, sphere);
    var surface: Surface;
    surface.point = sphere.center + sphere.radius * normal;
    surface.normal = normal;
    let c = abs(sphere.center);
    surface.error = 4.0 * UNIT_ROUNDOFF * (max(max(c.x, c.y), c.z) + sphere.radius);
    surface.material = sphere.material;
    surface.frame = sphere.frame;
    surface.local = normal;
    return surface;
}

// `point` is the unit normal in the object's space.
fn sphere_uv(sphere: Sphere, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    return SurfaceUv(sphere_uv_at(point), vec2<bool>(true, false));
}
