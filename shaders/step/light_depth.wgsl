//@ implements depth_limit when kernel.light_path
//@ use bind/settings
// Whether a light path may have the event of this number, from FIRST_LIGHT_EVENT.
fn is_within_depth(event: u32) -> bool {
    return event - FIRST_LIGHT_EVENT < settings.max_depth;
}
