// The texture's frame turns render space to the object's own, in which u grows around the y axis and v along it.
fn large_sphere_tangents(surface: Surface, large_sphere: LargeSphere, frame: Frame) -> Tangents {
    let own = along_frame(frame, surface.normal);
    let around = vec3<f32>(own.z, 0.0, -own.x);
    let u = vec3<f32>(dot(frame.x, around), dot(frame.y, around), dot(frame.z, around));
    return Tangents(u, vec3<f32>(frame.x.y, frame.y.y, frame.z.y));
}
