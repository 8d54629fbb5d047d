// Wrong on purpose: Snell's law as it stands in books, which cancels as the index nears 1.
fn refract_by(incoming: vec3<f32>, normal: vec3<f32>, cos_incident: f32, eta: f32, cos_transmitted: f32) -> vec3<f32> {
    let across = (incoming + cos_incident * normal) / eta;
    return across - sqrt(abs(1.0 - dot(across, across))) * normal;
}
