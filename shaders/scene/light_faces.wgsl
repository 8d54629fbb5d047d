//@ implements light_faces when area_light.triangle
// The instance of a hit on a light: of a face, that of its mesh.
fn instance_of_light(code: u32, instance: u32) -> u32 {
    return select(NO_INSTANCE, instance, primitive_kind(code) == KIND_TRIANGLE);
}

//@ without
// No face is a light.
fn instance_of_light(code: u32, instance: u32) -> u32 {
    return NO_INSTANCE;
}
