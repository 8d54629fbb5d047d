//@ use data/light
// Lights without size rest.
fn moved_delta_light(light: DeltaLight, index: u32) -> DeltaLight {
    return light;
}
