//@ implements seam when projection.equirectangular & light_paths
//@ use bind/settings
// The left and the right edge of a full panorama are the same directions, and its poles are edges at which the film is mirrored: filters reach
// across. The film's own directions do so, too (camera/equirectangular).
fn across_seam(found: TargetPixel) -> TargetPixel {
    let width = i32(settings.image_width);
    let height = i32(settings.image_height);
    let top = settings.film.y - 0.5 * f32(height) * settings.film.w;
    let bottom = settings.film.y + 0.5 * f32(height) * settings.film.w;
    var result = found;
    if abs(abs(settings.film.z) * f32(width) - 1.0) < 1e-6 {
        result.column = (found.column + width) % width;
    }
    if found.row < 0 && abs(top) > 0.25 - 1e-6 {
        result.row = -1 - found.row;
    }
    if found.row >= height && abs(bottom) > 0.25 - 1e-6 {
        result.row = 2 * height - 1 - found.row;
    }
    return result;
}

//@ without
// The film has edges.
fn across_seam(found: TargetPixel) -> TargetPixel {
    return found;
}
