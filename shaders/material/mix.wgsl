// A mix of two materials, which has no BSDF of its own.

// The surface with a part of its mix: the first one, or the second. `row` is the row of the mix, behind whose frames are those of its parts.
fn part_of_mix(row: Material, surface: Surface, is_second: bool) -> Surface {
    var part = surface;
    part.material = u32(select(row.${mix.first}, row.${mix.second}, is_second));
    part.frame += row.kind + u32(row.texture != NO_TEXTURE) + u32(select(0.0, row.${mix.frames}, is_second));
    return part;
}
