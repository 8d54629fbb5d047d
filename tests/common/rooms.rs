//! Small rooms with much light.

use gpu_rt::scene::Scene;

use super::render::scene;

/// A room of coloured walls, its ceiling a lamp, with `things` in it: much light, so that means are known well.
pub fn room(things: &str) -> Scene {
    scene(&room_text(things))
}

pub fn room_text(things: &str) -> String {
    format!(
        "Scene(
    image: (width: 16, height: 16),
    camera: (look_from: (0, 0, 3.4), look_at: (0, 0, 0), vertical_fov: 40, aperture: 0.1, focus_distance: 3),
    background: Solid((0.1, 0.1, 0.2)),
    materials: {{
        \"red\": Lambertian(albedo: Rgb(0.6, 0.1, 0.1)),
        \"green\": Lambertian(albedo: Rgb(0.1, 0.6, 0.1)),
        \"white\": Lambertian(albedo: Rgb(0.7, 0.7, 0.7)),
        \"metal\": Metal(albedo: Rgb(0.8, 0.8, 0.9), fuzz: 0.3),
        \"glass\": Dielectric(ior: 1.5),
        \"lamp\": DiffuseLight(emit: Rgb(2, 2, 2)),
    }},
    objects: [
        Quad(corner: (-1, -1, -1), u: (0, 0, 2), v: (0, 2, 0), material: \"red\"),
        Quad(corner: (1, -1, 1), u: (0, 0, -2), v: (0, 2, 0), material: \"green\"),
        Quad(corner: (-1, -1, -1), u: (2, 0, 0), v: (0, 2, 0), material: \"white\"),
        Quad(corner: (-1, -1, 1), u: (2, 0, 0), v: (0, 0, -2), material: \"white\"),
        Quad(corner: (-1, 1, -1), u: (2, 0, 0), v: (0, 0, 2), material: \"lamp\"),
        {things}
    ],
    render: (samples: 16, max_depth: 10),
)"
    )
}

/// What is seen through the open sides of an [`open_room`].
pub const AROUND: &str = "background: Solid((0.1, 0.1, 0.1))";

/// A room that is open to the front, with a lamp of this half of a side under its ceiling, if that is not 0. Its floor, its back, its left wall and its
/// right one are of these materials, if they are there.
pub fn open_room(walls: &[&str], lamp: f64, materials: &str, objects: &str, max_depth: u32) -> String {
    let quads = [
        "(-1, 0, -1), u: (0, 0, 2), v: (2, 0, 0)",
        "(-1, 0, -1), u: (2, 0, 0), v: (0, 2, 0)",
        "(-1, 0, 1), u: (0, 0, -2), v: (0, 2, 0)",
        "(1, 0, -1), u: (0, 0, 2), v: (0, 2, 0)",
    ];
    let side = 2.0 * lamp;
    let above = format!("(-{lamp}, 1.99, -{lamp}), u: ({side}, 0, 0), v: (0, 0, {side})");
    let lamp = if lamp > 0.0 { "lamp" } else { "" };
    let all = quads.into_iter().zip(walls.iter().copied()).chain([(above.as_str(), lamp)]);
    let quads = all.filter(|(_, material)| !material.is_empty());
    let quads = quads.map(|(quad, material)| format!("Quad(corner: {quad}, material: {material:?}),"));
    format!(
        "Scene(
    image: (width: 16, height: 16),
    camera: (look_from: (0, 1, 3.6), look_at: (0, 0.95, 0), vertical_fov: 38),
    {AROUND},
    materials: {{
        \"wall\": Lambertian(albedo: Rgb(0.7, 0.6, 0.5)), \"lamp\": DiffuseLight(emit: Rgb(4, 3, 2), two_sided: false), {materials}
    }},
    objects: [{} {objects}],
    render: (samples: 512, max_depth: {max_depth}),
)",
        quads.collect::<String>()
    )
}

/// What stands in them.
pub const THINGS: [(&str, &str); 3] = [
    ("a room", "Box(min: (-0.6, -1, -0.6), max: (0, 0.2, 0), material: \"white\"),"),
    (
        "glass",
        "Sphere(center: (-0.4, -0.5, 0), radius: 0.5, material: \"glass\"), Sphere(center: (0.5, -0.6, 0.2), radius: 0.4, material: \"metal\"),",
    ),
    (
        "smoke",
        "Medium(boundary: Box(min: (-0.8, -1, -0.8), max: (0.8, 0.4, 0.6)), density: 1.5, albedo: Rgb(0.9, 0.8, 0.6), anisotropy: 0.3),
         Medium(boundary: Sphere(center: (0, 0, 0), radius: 0.6), density: 2, albedo: Rgb(0.5, 0.8, 0.9)),",
    ),
];
