// Transforms between render space and the space of a mesh.

fn rotated_to_mesh(instance: Instance, v: vec3<f32>) -> vec3<f32> {
    let z_axis = cross(instance.x_axis, instance.y_axis);
    return vec3<f32>(dot(instance.x_axis, v), dot(instance.y_axis, v), dot(z_axis, v));
}

fn rotated_from_mesh(instance: Instance, v: vec3<f32>) -> vec3<f32> {
    let z_axis = cross(instance.x_axis, instance.y_axis);
    return v.x * instance.x_axis + v.y * instance.y_axis + v.z * z_axis;
}

fn from_mesh(instance: Instance, point: vec3<f32>) -> vec3<f32> {
    return instance.translation + instance.scale * rotated_from_mesh(instance, point);
}

// The ray in the mesh's space. Its direction is not normalised again, so t means the same in both spaces.
fn to_mesh(instance: Instance, ray: Ray) -> Ray {
    let inverse_scale = 1.0 / instance.scale;
    return Ray(
        inverse_scale * rotated_to_mesh(instance, ray.origin - instance.translation),
        inverse_scale * rotated_to_mesh(instance, ray.direction),
    );
}

// Bound of the error of a mesh's point in render space, as a ray that starts there sees it: the error in the mesh's space, plus
// the rounding on the way to render space and back. This rounding is relative to the point's coordinates in the mesh, scaled:
// - To render space: 4 u for the rotation (three products and two sums, with axes that are rounded) and 1 u for the scale.
// - Back: 1 u for the difference, 4 u for the rotation, 2 u for the scale and its reciprocal.
// - The axes are off a right angle and off unit length by 2 u each, so rotating there and back adds 4 u.
// Adding `translation` rounds by half an ulp of the point's own coordinates. The step to the next float in geometry/offset is larger than that.
fn instance_error(instance: Instance, point: vec3<f32>, error: f32) -> f32 {
    let p = abs(point);
    return instance.scale * (error + 16.0 * UNIT_ROUNDOFF * (p.x + p.y + p.z));
}
