// As the coordinates of geometry/cuboid.
fn cuboid_tangents(surface: Surface, cuboid: Cuboid, frame: Frame) -> Tangents {
    let at = surface.local;
    let z_axis = cross(cuboid.x_axis, cuboid.y_axis);
    if at.z == 0.0 || at.z == 1.0 {
        return Tangents(select(cuboid.x_axis, -cuboid.x_axis, at.z == 0.0), cuboid.y_axis);
    }
    if at.x == 0.0 || at.x == 1.0 {
        return Tangents(select(z_axis, -z_axis, at.x == 1.0), cuboid.y_axis);
    }
    return Tangents(cuboid.x_axis, select(z_axis, -z_axis, at.y == 1.0));
}
