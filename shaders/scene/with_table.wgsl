//@ use geometry/triangle
// Returns a face that reads the texture coordinates of the table of this number.
fn with_table(triangle: Triangle, number: f32) -> Triangle {
    var result = triangle;
    result.instance.to_uvs *= u32(number) + 1u;
    return result;
}
