//@ implements panes when !pane
//@ use bind/settings
//@ use choice/walk
// No surface is a smooth pane.
fn hit_of_path(path: ptr<function, Path>) -> Hit {
    return nearest_hit((*path).ray, settings.root);
}

fn hit_of_shadow(path: ptr<function, Path>, limit: Hit) -> Hit {
    return first_hit((*path).shadow, settings.root, limit, true);
}

fn pass_panes(path: ptr<function, Path>, light: vec3<f32>) -> vec3<f32> {
    return light;
}
