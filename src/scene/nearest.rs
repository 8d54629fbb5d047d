//! "Did you mean ...?"

const LONGEST: usize = 100;

/// Names that other programs have for what scenes have, in lower case, and what is to be written. The first that fits is meant.
const OTHER_NAMES: &[(&[&str], &str)] = &[
    (&["fov", "field_of_view", "yfov", "vfov"], "vertical_fov"),
    (&["position", "pos", "eye", "origin", "from", "location"], "look_from"),
    (&["position", "pos", "origin", "location"], "center"),
    (&["position", "pos", "origin", "location"], "at"),
    (&["target", "lookat", "to"], "look_at"),
    (&["color", "colour", "diffuse", "reflectance"], "albedo"),
    (&["color", "colour", "albedo"], "base_color"),
    (&["color", "colour", "radiance", "intensity", "emission"], "emit"),
    (&["roughness"], "fuzz"),
    (&["eta", "refractive_index", "index"], "ior"),
    (&["spp", "samples_per_pixel"], "samples"),
    (&["cube", "cuboid", "aabb"], "Box(min: .., max: ..)"),
    (
        &["plane", "rectangle", "rect", "ground", "floor"],
        "Quad(corner: .., u: .., v: ..), or for a ground a Sphere of radius 1000",
    ),
    (
        &["triangle", "model", "obj", "trianglemesh", "cylinder", "cone", "torus", "ellipsoid"],
        "Mesh(path: \"..\"), a .ply, .obj, .stl or .glb file",
    ),
    (&["light", "arealight", "lamp"], "PointLight, or a shape of a DiffuseLight"),
    (&["sunlight", "sun"], "DirectionalLight(..)"),
    (&["diffuse", "matte", "matt", "lambert"], "Lambertian(albedo: Rgb(..))"),
    (&["glass", "water", "transparent", "refractive"], "Dielectric(ior: 1.5)"),
    (&["emissive", "emission", "emitter", "light", "arealight"], "DiffuseLight(emit: Rgb(..))"),
    (&["mirror", "chrome", "specular"], "Metal(albedo: Rgb(..))"),
    (&["principled", "disney", "standard", "openpbr"], "Pbr(base_color: Rgb(..), metallic: 0, roughness: ..)"),
    (&["roughplastic", "varnish"], "Plastic(diffuse: Rgb(..), roughness: ..)"),
    (&["color", "colour", "constant", "solid"], "Rgb(r, g, b)"),
    (&["texture", "file", "bitmap", "imagetexture"], "Image(path: \"..\")"),
    (&["sky", "hdri", "envmap", "environment"], "Image(path: \"..\")"),
    (&["color", "colour", "constant", "rgb"], "Solid((r, g, b))"),
    (&["move", "position"], "Translate((x, y, z))"),
];

/// What is to be written for a name of other programs, if one of these names begins it.
pub fn other_name(word: &str, names: &[&str]) -> Option<&'static str> {
    let word = word.to_lowercase();
    let meant = OTHER_NAMES.iter().filter(|(others, _)| others.contains(&word.as_str())).map(|(_, meant)| *meant);
    let begins = |meant: &&str| {
        names.contains(&meant.split(|c: char| c != '_' && !c.is_alphanumeric()).next().unwrap_or_default())
    };
    meant.into_iter().find(begins)
}

/// The candidate whose spelling is nearest to `word`, if it is near enough to be a misspelling.
///
/// Letter case does not count. Up to a third of the letters may differ, and at least one. A word longer than any name
/// has no candidate.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    let length = word.chars().count();
    if length > LONGEST {
        return None;
    }
    // The edit distance: insertions, deletions, replacements, and swaps of neighbouring letters.
    let edits = |candidate: &'a str| (strsim::osa_distance(&word, &candidate.to_lowercase()), candidate);
    let near = candidates.into_iter().map(edits).filter(|(edits, _)| *edits <= (length / 3).max(1));
    near.min_by_key(|(edits, _)| *edits).map(|(_, candidate)| candidate)
}

/// "; did you mean \"..\"?", if one of the names is near.
pub fn meant<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, names).map_or(String::new(), |meant| format!("; did you mean {meant:?}?"))
}

/// "expected one of ...", with the names up to a limit, or what is said where there is none.
pub fn one_of<'a>(names: impl Iterator<Item = &'a str>, none: &str) -> String {
    const MOST: usize = 10;
    let mut names: Vec<String> = names.map(|name| format!("{name:?}")).collect();
    let more = names.len().saturating_sub(MOST);
    names.truncate(MOST);
    names.extend((more > 0).then(|| format!("{more} more")));
    if names.is_empty() { none.to_owned() } else { format!("expected one of {}", names.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_word_that_was_meant_is_found() {
        let known = ["center", "radius", "material"];
        assert_eq!(nearest("radus", known), Some("radius"));
        assert_eq!(nearest("Centre", known), Some("center"));
        assert_eq!(nearest("materail", known), Some("material"));
        assert_eq!(nearest("colour", known), None);
        assert_eq!(nearest("", known), None);
        assert_eq!(nearest("Rbg", ["Image", "Rgb"]), Some("Rgb"));
    }

    #[test]
    fn names_of_other_programs_are_known_where_what_they_mean_is_expected() {
        assert_eq!(other_name("fov", &["look_from", "vertical_fov"]), Some("vertical_fov"));
        assert_eq!(other_name("position", &["center", "radius"]), Some("center"));
        assert_eq!(other_name("Glass", &["Lambertian", "Dielectric"]), Some("Dielectric(ior: 1.5)"));
        assert_eq!(other_name("Glass", &["Sphere", "Quad"]), None);
    }
}
