//@ use bind/settings
//@ each background
//@ use background/${name}
//@ end
// The radiance of a ray that leaves the scene. A scene has one background; `--features all` links more.
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
