//@ use bind/directional_albedos
// An element of the tables of directional albedos, mixed with the next one by `share`.
fn tabled_albedo(index: u32, share: f32) -> f32 {
    return mix(albedo_at(index), albedo_at(index + 1u), share);
}

fn albedo_at(index: u32) -> f32 {
    return directional_albedos[index / 4u][index % 4u];
}
