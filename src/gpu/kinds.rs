//! The functions that the modules of a kind of material, shape, texture, background or channel have. They are called by their names in lists
//! (`//@ each material`), so that a missing one is an unknown name elsewhere.

/// The beginning and the end of the function's name, with the kind's name between; the module; and what the function does.
const FUNCTIONS: &[(&str, &str, &str, &str)] = &[
    ("", "_scatter", "material", "it draws a direction and its weight"),
    ("", "_is_non_specular", "material/_eval", "it says whether a material has a lobe of more than one direction"),
    ("", "_eval", "material/_eval", "it returns BSDF times cosine and the density of a direction"),
    ("", "_index", "material", "it returns the index of refraction inside, for light paths through it"),
    ("", "_reflectance", "material/_eval", "it returns what a smooth pane reflects"),
    ("", "_spreads", "lobe", "it says whether a material with the layer has a lobe of more than one direction"),
    ("", "_albedo", "lobe", "it returns about what comes back to the view with the layer"),
    ("draw_", "", "lobe", "it draws from the layer or from what lies below"),
    ("below_", "", "lobe", "it returns a sample of what lies below the layer"),
    ("with_", "", "lobe", "it returns the response with the layer"),
    ("", "_at", "bind/s", "it returns the shape of a primitive"),
    ("", "_distance", "geometry", "it returns the distance of a ray's hit"),
    ("", "_surface", "geometry", "it returns the surface at a hit"),
    ("", "_uv", "geometry", "it returns the texture coordinates of a point"),
    ("", "_tangents", "tangent", "it returns the tangents along the texture coordinates"),
    ("", "_interval", "medium", "it returns the part of a ray inside"),
    ("", "_light_sample", "light", "it draws a direction to the light"),
    ("", "_light_pdf", "light", "it returns the density of a direction"),
    ("", "_light_front", "light", "it says whether a ray meets the front of the light"),
    ("", "_light_distance", "light", "it returns the distance of the light"),
    ("", "_light_point", "light", "it draws a point at which a light path starts"),
    ("", "_light_leaves", "light", "it says whether a light path leaves the light in a direction"),
    ("", "_part_sample", "light/_parts", "it draws a direction to a part of the light"),
    ("", "_part_pdf", "light/_parts", "it returns the density of a direction to a part"),
    ("", "_part_point", "light/_parts", "it draws a point of a part at which a light path starts"),
    ("", "_part_coordinates", "light/_parts", "it returns the coordinates of parts at a point"),
    ("moved_", "", "motion", "it returns the shape in a pose"),
    ("", "_at_rest", "motion", "it returns the surface with the local point of the shape at rest"),
    ("", "_unturned", "motion", "it returns the surface in the axes of the shape at rest"),
    ("", "_tangents_with", "motion", "it returns the tangents in a pose"),
    ("", "_colour", "texture", "it returns the colour at a point"),
    ("", "_background", "background", "it returns the radiance from a direction"),
    ("", "", "aov", "it returns a channel of the first hit"),
];

/// Where a function of this name is missing, and what it does. `has` says whether a module is there.
pub fn missing(name: &str, has: impl Fn(&str) -> bool) -> Option<String> {
    FUNCTIONS.iter().find_map(|(begins, ends, place, about)| {
        let kind = name.strip_prefix(begins)?.strip_suffix(ends)?;
        let (folder, ending) = place.split_once('/').unwrap_or((place, ""));
        let known = format!("{folder}/{kind}");
        let module = format!("{known}{ending}");
        (has(&known) || has(&module)).then(|| format!("shaders/{module}.wgsl must have the function {name}: {about}"))
    })
}
