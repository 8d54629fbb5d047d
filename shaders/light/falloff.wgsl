//@ implements falloff when falloff
// The light's intensity for a direction to it, with the falloff of its beam. An angle from the two differences of unit vectors keeps its
// digits in narrow beams as in wide ones.
fn delta_light_intensity(direction: vec3<f32>, light: DeltaLight) -> vec3<f32> {
    let apart = direction + light.axis;
    if light.height < 0.0 {
        let angle = 2.0 * angle_of(length(apart), length(direction - light.axis));
        return light.colour * clamp((-light.height - angle) * light.slope, 0.0, 1.0);
    }
    let share = clamp((light.height - 0.5 * dot(apart, apart)) * abs(light.slope), 0.0, 1.0);
    return light.colour * (share * share) * select(1.0, 3.0 - 2.0 * share, light.slope < 0.0);
}

//@ without
// The light's intensity for a direction to it: that of a spot falls with the angle from its axis as in glTF's extension
// KHR_lights_punctual. 1 - cos is half the square of the difference of two unit vectors, which keeps its digits in narrow beams.
fn delta_light_intensity(direction: vec3<f32>, light: DeltaLight) -> vec3<f32> {
    let apart = direction + light.axis;
    let share = clamp((light.height - 0.5 * dot(apart, apart)) * light.slope, 0.0, 1.0);
    return light.colour * (share * share);
}
