//@ use data/hit
// Each shape that is a light is one.
fn part_at_hit(index: u32, hit: Hit, local: vec3<f32>) -> u32 {
    return index;
}

fn part_of_light(index: u32) -> u32 {
    return 0u;
}
