//@ implements saturation when aov.lights
//@ use bind/film
// Sums that leave their range. A word of its own has a bit for each group of lights.

const FIRST_LIGHT_SUM: u32 = 9u + ${plain_sums}u;

fn mark_saturated(pixel: u32, sum: u32) {
    let group = (sum - FIRST_LIGHT_SUM) / ${sums_of_group}u;
    if sum >= FIRST_LIGHT_SUM && group < ${light_groups}u {
        atomicOr(&film[pixel].saturated_groups[0], 1u << group);
    } else {
        atomicOr(&film[pixel].saturated, saturated_bit(sum));
    }
}

//@ without
//@ use bind/film
fn mark_saturated(pixel: u32, sum: u32) {
    atomicOr(&film[pixel].saturated, saturated_bit(sum));
}
