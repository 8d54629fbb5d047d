// All that a path keeps between two bounces.

fn load_path(slot: u32, path: ptr<function, Path>) {
    load_ray(slot, path);
    load_throughput(slot, path);
    load_sample_of_path(slot, path);
    load_run(slot, path);
    load_radiance(slot, path);
    load_direct(slot, path);
    load_aov_hit(slot, path);
    load_aov_surface(slot, path);
    load_aov_direct(slot, path);
    (*path).light = NO_LIGHT;
}

fn store_path(slot: u32, path: ptr<function, Path>) {
    store_ray(slot, path);
    store_throughput(slot, path);
    store_sample_of_path(slot, path);
    store_run(slot, path);
    store_radiance(slot, path);
    store_direct(slot, path);
    store_aov_hit(slot, path);
    store_aov_surface(slot, path);
    store_aov_direct(slot, path);
}
