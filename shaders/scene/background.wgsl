//@ use bind/settings
//@ each background
//@ use background/${name}
//@ end
// The radiance where a ray leaves the scene. A scene has one background; more are linked where everything is (`--features all`).
fn background_radiance(direction: vec3<f32>) -> vec3<f32> {
    //@ each other_background
    if settings.background == ${number}u {
        return ${name}_background(direction);
    }
    //@ end
    //@ each own_background
    return ${name}_background(direction);
    //@ end
}
