//@ implements depth_limit when !kernel.light_path
//@ use bind/settings
// Whether a camera path may have the event of this number, from 0.
fn is_within_depth(event: u32) -> bool {
    return event < settings.max_depth;
}
