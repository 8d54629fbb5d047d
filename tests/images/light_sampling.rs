//! Light sampling changes no expectation, whatever a room is made of: scattered rays alone, and light sampling by either sampler, compared in tiles and
//! as a whole. Each room has errors of its own, which the comparison must find.

use gpu_rt::options::Scatter;
use gpu_rt::scene::Scene;

use crate::common::faults::{Fault, agree, are_found, differ};
use crate::common::instances::smooth_ball_file;
use crate::common::render::{Request, render, scene_in};
use crate::common::rooms::open_room;
use crate::{normal_maps, numbers};

/// What rounding may do to the mean of a tile.
const ROUNDING: f64 = 1e-5;

/// A room, open to the front and the right, with a lamp under its ceiling.
pub struct Room<'a> {
    /// The materials of the floor, the back and the left wall, if there is one.
    walls: [&'a str; 3],
    /// Half of its lamp's side.
    lamp: f64,
    /// The factor of all light that is found.
    brighter: f32,
    materials: &'a str,
    objects: &'a str,
    max_depth: u32,
    /// `FAULT` in the text of one says when it is there. Those of the module "scene" change the materials.
    faults: &'a [Fault<'a>],
}

/// All lobes of glTF's materials, brushed metal, and a lamp with a coat.
pub const LOBES: Room = Room {
    walls: ["varnish", "velvet", ""],
    lamp: 0.5,
    brighter: 1.02,
    materials: r#"
        "varnish": Pbr(base_color: Rgb(0.7, 0.6, 0.5), metallic: 0, roughness: 0.7, coat: 1, coat_roughness: 0.4, coat_ior: 3),
        "velvet": Pbr(base_color: Rgb(0.3, 0.2, 0.6), metallic: 0.2, roughness: 0.6, sheen: Rgb(0.9, 0.6, 0.9), sheen_roughness: 1),
        "brushed": Conductor(albedo: Rgb(0.9, 0.6, 0.3), roughness: 0.4, anisotropy: 0.8, anisotropy_rotation: 30),
        "half": Pbr(base_color: Rgb(0.5, 0.8, 0.9), metallic: 0, roughness: 0.5, transmission: 0.6, solid: true, absorption: (0.1, 0.2, 0.3)),
        "pane": Pbr(base_color: Rgb(0.9, 0.8, 0.5), metallic: 0, roughness: 0.6, transmission: 0.5, anisotropy: 0.5),
        "glow": Pbr(base_color: Rgb(0.2, 0.2, 0.2), metallic: 0, roughness: 0.5, coat: 1, coat_roughness: 0.3, coat_ior: 9, emission: Rgb(9, 6, 3)),
        "frosted": RoughDielectric(ior: 1.5, roughness: 0.4, anisotropy: 0.7, dispersion: 4),
        "leaf": Pbr(base_color: Rgb(0.3, 0.6, 0.2), metallic: 0, roughness: 0.5, diffuse_transmission: 0.7, diffuse_transmission_color: Rgb(0.6, 0.9, 0.3)),
        "oil": Pbr(base_color: Rgb(0.4, 0.4, 0.5), metallic: 0.5, roughness: 0.5, iridescence: 0.9, iridescence_ior: 1.6),"#,
    objects: r#"
        Quad(corner: (0.9, 0.5, -0.5), u: (0, 0, 0.5), v: (0, 0.5, 0), material: "glow"),
        Quad(corner: (-0.9, 0.1, 0.5), u: (0.8, 0, 0.2), v: (0, 0.7, 0), material: "pane"),
        Box(min: (0.2, 0, -0.4), max: (0.7, 0.5, 0.1), material: "brushed"),
        Sphere(center: (-0.4, 0.45, 0), radius: 0.4, material: "half"),
        Sphere(center: (0.45, 0.8, 0.1), radius: 0.25, material: "frosted"),
        Quad(corner: (-0.9, 1.1, 0.4), u: (1.1, 0.1, 0), v: (0, 0.7, -0.4), material: "leaf"),
        Sphere(center: (-0.6, 1.3, -0.4), radius: 0.25, material: "oil"),"#,
    max_depth: 6,
    faults: &[
        ("lobe/coat", "let value = vec3<f32>(pdf", "let value = vec3<f32>(select(1.0, 0.0, FAULT) * pdf"),
        (
            "scene/light_coat",
            "return emission_under_coat(radiance, seen);",
            "return select(emission_under_coat(radiance, seen), radiance, FAULT);",
        ),
        ("lobe/sheen", "let of_sheen = share *", "let of_sheen = select(1.0, 0.0, FAULT) * share *"),
        (
            "lobe/transmission",
            "tint_of_glass(hit, direction);",
            "select(tint_of_glass(hit, direction), vec3<f32>(1.0), FAULT);",
        ),
        (
            "lobe/diffuse_transmission",
            "return hit.lobes.through *",
            "return select(1.0, 0.0, FAULT) * hit.lobes.through *",
        ),
    ],
};

/// Metals that make up for light that microfacets scatter more than once, and one that does not.
pub const MULTISCATTER: Room = Room {
    walls: ["metal", "rough", ""],
    lamp: 0.5,
    brighter: 1.02,
    materials: r#"
        "rough": Pbr(base_color: Rgb(0.7, 0.6, 0.5), metallic: 0.5, roughness: 0.7, multiscatter: true),
        "metal": Conductor(albedo: Rgb(0.9, 0.6, 0.3), roughness: 0.8, multiscatter: true),
        "lossy": Conductor(albedo: Rgb(0.9, 0.6, 0.3), roughness: 0.8),
        "gold": Conductor(eta: (0.14, 0.37, 1.44), k: (3.98, 2.38, 1.6), roughness: 0.5, multiscatter: true),"#,
    objects: r#"
        Box(min: (0.2, 0, -0.4), max: (0.7, 0.5, 0.1), material: "lossy"),
        Sphere(center: (-0.4, 0.45, 0), radius: 0.4, material: "gold"),"#,
    max_depth: 6,
    faults: &[(
        "material/conductor_eval",
        "compensated(single, f0, hit)",
        "select(compensated(single, f0, hit), single, FAULT)",
    )],
};

/// Layers with a share and a colour of their own (KHR_materials_specular).
pub const LAYERS: Room = Room {
    walls: ["layer", "layer", ""],
    lamp: 0.5,
    brighter: 1.02,
    materials: r#"
        "layer": Pbr(base_color: Rgb(0.2, 0.15, 0.1), metallic: 0, roughness: 0.5, ior: 2.5, specular: 0.7),
        "coat": Pbr(base_color: Rgb(0.6, 0.2, 0.1), metallic: 0, roughness: 0.4, ior: 2, specular: 0.8, specular_color: Rgb(0.2, 1, 0.5)),"#,
    objects: r#"Sphere(center: (0, 0.6, 0), radius: 0.5, material: "coat"),"#,
    max_depth: 6,
    faults: &[("scene", "specular: 0.7", "specular: 0.9")],
};

/// Plastics, smooth and rough, and microfacets of Beckmann.
pub const PLASTICS: Room = Room {
    walls: ["gloss", "satin", ""],
    lamp: 0.5,
    brighter: 1.02,
    materials: r#"
        "gloss": Plastic(diffuse: Rgb(0.7, 0.5, 0.3), ior: 1.8),
        "satin": Plastic(diffuse: Rgb(0.3, 0.6, 0.7), roughness: 0.6, distribution: Beckmann, nonlinear: true),
        "worn": Conductor(albedo: Rgb(0.9, 0.6, 0.3), roughness: 0.6, anisotropy: 0.5, distribution: Beckmann),
        "hazy": RoughDielectric(ior: 1.5, roughness: 0.6, distribution: Beckmann),"#,
    objects: r#"
        Box(min: (0.2, 0, -0.4), max: (0.7, 0.5, 0.1), material: "hazy"),
        Sphere(center: (-0.4, 0.45, 0), radius: 0.4, material: "worn"),"#,
    max_depth: 6,
    faults: &[
        ("material/plastic_eval", "let matt = both_ways *", "let matt = select(1.0, 1.2, FAULT) * both_ways *"),
        ("lobe/anisotropy", "return 2.0 *", "return select(2.0, 3.0, FAULT) *"),
    ],
};

/// Mixes of matt, rough, specular and clear materials, also by images.
pub const MIXES: Room = Room {
    walls: ["spotted", "dusty", ""],
    lamp: 0.5,
    brighter: 1.02,
    materials: r#"
        "matt": Lambertian(albedo: Rgb(0.7, 0.5, 0.3), normal: Image(path: "bumps.exr")),
        "steel": Conductor(albedo: Rgb(0.9, 0.8, 0.7), roughness: Checker(scale: 0.3, even: (0.3, 0, 0), odd: (0.7, 0, 0))),
        "gloss": Plastic(diffuse: Rgb(0.3, 0.6, 0.7), ior: 1.8),
        "glass": Dielectric(ior: 1.5),
        "spotted": Mix(a: "matt", b: "steel", share: Image(path: "marks.png", channel: G)),
        "dusty": Mix(a: "gloss", b: "matt", share: 0.4),
        "milky": Mix(a: "glass", b: "gloss", share: 0.3),"#,
    objects: r#"
        Box(min: (0.2, 0, -0.4), max: (0.7, 0.5, 0.1), material: "spotted"),
        Sphere(center: (-0.4, 0.45, 0), radius: 0.4, material: "milky"),"#,
    max_depth: 6,
    faults: &[
        ("scene", "share: 0.4", "share: 0.3"),
        ("scene/mix", "< extension_colour(", "< select(1.0, 0.0, FAULT) * extension_colour("),
    ],
};

/// Numbers that vary over a surface: a floor that is a mirror in places, and frosted glass that is clear in places.
pub const NUMBERS: Room = Room {
    walls: ["floor", "back", "wall"],
    lamp: 0.8,
    brighter: 1.02,
    materials: r#"
        "floor": Conductor(albedo: Rgb(0.9, 0.7, 0.5), roughness: Image(path: "marks.png", channel: G)),
        "back": Pbr(base_color: Rgb(0.8, 0.5, 0.3), metallic: Image(path: "marks.png", channel: B), roughness: Image(path: "marks.png", channel: R)),
        "glass": RoughDielectric(ior: 1.5, roughness: Checker(scale: 0.2, even: (0, 0, 0), odd: (0.4, 0, 0))),"#,
    objects: r#"Sphere(center: (-0.2, 0.5, 0.1), radius: 0.4, material: "glass"),"#,
    max_depth: 5,
    // The plain numbers in the response to lights.
    faults: &[(
        "step/surface_light",
        "response_of_material(evaluated.material, interaction, direction);",
        "response_of_material(evaluated.material, interaction, direction);
         if FAULT { sampled.response = response_of_material(materials[surface.material], interaction, direction); }",
    )],
};

/// Normal maps on walls, on smooth glass, on metal and on glazed clay.
pub const NORMAL_MAPS: Room = Room {
    walls: ["bumpy", "metal", "clay"],
    lamp: 0.5,
    brighter: 1.04,
    materials: r#"
        "bumpy": Lambertian(albedo: Rgb(0.7, 0.6, 0.5), normal: Image(path: "bumps.exr")),
        "glass": RoughDielectric(ior: 1.5, roughness: 0.6, normal: Image(path: "bumps.exr"), normal_scale: 0.5),
        "metal": Conductor(albedo: Rgb(0.8, 0.7, 0.6), roughness: 0.5, normal: Image(path: "bumps.exr")),
        "clay": Pbr(base_color: Rgb(0.9, 0.3, 0.2), metallic: 0, roughness: 0.4, normal: Image(path: "bumps.exr"), normal_scale: -2),"#,
    objects: r#"
        Quad(corner: (-0.9, 1.2, -0.1), u: (1.5, 0.2, 0), v: (0, 0.6, 0.9), material: "clay"),
        Box(min: (0.3, 0, -0.4), max: (0.8, 0.5, 0.2), material: "clay"),
        Transformed(by: [Scale(0.4), Translate((-0.3, 0.45, 0))], object: Mesh(path: "ball.obj", material: "glass")),"#,
    max_depth: 5,
    // Light from behind the surface.
    faults: &[("scene/normal_map", "value, keeps_its_side(direction", "value, FAULT || keeps_its_side(direction")],
};

/// Coloured glass: a frosted ball and box, a frosted pane before the lamp, and a clear one.
pub const COLOURED_GLASS: Room = Room {
    walls: ["wall", "wall", ""],
    lamp: 0.5,
    brighter: 1.02,
    materials: r#"
        "ball": RoughDielectric(ior: 1.5, roughness: 0.5, transmittance: Rgb(0.9, 0.6, 0.3), absorption: (0.1, 0.5, 2)),
        "box": RoughDielectric(ior: 1.3, roughness: 0.7, transmittance: Checker(scale: 0.2, even: (1, 0.5, 0.2), odd: (0.2, 1, 0.5))),
        "frosted": ThinDielectric(roughness: 0.6, transmittance: Rgb(0.4, 0.9, 0.5)),
        "clear": ThinDielectric(ior: 1.8, transmittance: Rgb(0.9, 0.3, 0.3)),"#,
    objects: r#"
        Quad(corner: (-0.7, 1.2, 0.4), u: (0.9, 0, 0), v: (0, 0.3, -0.8), material: "frosted"),
        Quad(corner: (0.3, 0.6, 0.6), u: (0.6, 0, 0.2), v: (0, 0.8, 0), material: "clear"),
        Box(min: (0.2, 0, -0.4), max: (0.7, 0.5, 0.1), material: "box"),
        Transformed(by: [Scale(0.4), Translate((-0.4, 0.45, 0))], object: Mesh(path: "smooth-ball.obj", material: "ball")),"#,
    max_depth: 6,
    faults: &[(
        "step/surface_light",
        "tint_through(sampled.response.value, evaluated, leaving, frame.shading)",
        "select(tint_through(sampled.response.value, evaluated, leaving, frame.shading), sampled.response.value, FAULT)",
    )],
};

/// Smooth panes of all shapes, which light sampling looks through: coloured, partly frosted, on a smooth mesh, around fog, and before a mirror.
pub const PANES: Room = Room {
    walls: ["wall", "mirror", ""],
    lamp: 0.5,
    brighter: 1.02,
    materials: r#"
        "mirror": Metal(albedo: Rgb(0.8, 0.8, 0.8)),
        "clear": ThinDielectric(ior: 1.8, transmittance: Rgb(0.9, 0.3, 0.3)),
        "frosted": ThinDielectric(roughness: Checker(scale: 0.2, even: (0, 0, 0), odd: (0.6, 0.6, 0.6)), transmittance: Rgb(0.4, 0.9, 0.5)),
        "checked": ThinDielectric(transmittance: Checker(scale: 0.1, even: (1, 0.5, 0.2), odd: (0.2, 1, 0.5))),"#,
    objects: r#"
        Quad(corner: (-0.9, 1.5, 0.7), u: (1.8, 0, 0), v: (0, 0, -1.4), material: "clear"),
        Disk(center: (-0.4, 1.1, 0.2), normal: (0.3, 1, 0.2), radius: 0.4, material: "frosted"),
        Sphere(center: (0.5, 0.5, 0), radius: 0.4, material: "checked"),
        Box(min: (-0.8, 0.05, -0.4), max: (-0.3, 0.5, 0.1), material: "clear"),
        Transformed(by: [Scale(0.3), Translate((0, 0.35, 0.4))], object: Mesh(path: "smooth-ball.obj", material: "checked")),
        Medium(boundary: Sphere(center: (0.5, 0.5, 0), radius: 0.4), density: 1, albedo: Rgb(0.8, 0.8, 0.8)),"#,
    max_depth: 6,
    // Shadows without colours.
    faults: &[(
        "step/panes",
        "(1.0 - pane.reflectance) * pane.colour",
        "(1.0 - pane.reflectance) * select(pane.colour, vec3<f32>(1.0), FAULT)",
    )],
};

/// Lamps, walls and meshes with an alpha, in fog, before a mirror.
pub const ALPHA_OF_LAMPS: Room = Room {
    walls: ["wall", "mirror", "gauze"],
    lamp: 0.5,
    brighter: 1.02,
    materials: r#"
        "mirror": Metal(albedo: Rgb(0.8, 0.8, 0.8)),
        "glow": Lambertian(albedo: Rgb(0.6, 0.4, 0.2), emission: Rgb(1, 2, 3), alpha: 0.4),
        "gauze": Pbr(base_color: Rgb(0.6, 0.7, 0.8), metallic: 0, roughness: 0.5, alpha: 0.6),"#,
    objects: r#"
        Quad(corner: (-0.7, 1.2, -0.5), u: (0.6, 0, 0.1), v: (0, 0.1, 0.7), material: "glow"),
        Quad(corner: (0.2, 1.3, -0.5), u: (0.6, 0, 0.1), v: (0, 0.1, 0.7), material: "gauze"),
        Transformed(by: [Scale(0.4), Translate((0.3, 0.5, 0))], object: Mesh(path: "octahedron.obj", material: "glow")),
        Transformed(by: [Scale(0.3), Translate((-0.4, 0.4, 0.3))], object: Mesh(path: "octahedron.obj", material: "gauze")),
        Medium(boundary: Box(min: (-0.9, 0.1, -0.9), max: (0.9, 0.7, 0.9)), density: 0.3, albedo: Rgb(0.8, 0.8, 0.8)),"#,
    max_depth: 5,
    // A lamp is found by the share of its coverage, by either technique.
    faults: &[
        (
            "scene/light_coverage",
            "coverage_at(hit, light_surface_at(hit, ray))",
            "select(coverage_at(hit, light_surface_at(hit, ray)), 1.0, FAULT)",
        ),
        ("step/trace", "begin_walk(path, DIMENSION_SCATTER);", "if !FAULT { begin_walk(path, DIMENSION_SCATTER); }"),
    ],
};

/// Surfaces that emit and scatter, beside a lamp, in fog, with a mirror.
pub const EMISSIVE: Room = Room {
    walls: ["wall", "mirror", "glow"],
    lamp: 0.5,
    brighter: 1.02,
    materials: r#"
        "mirror": Metal(albedo: Rgb(0.8, 0.8, 0.8)),
        "glow": Lambertian(albedo: Rgb(0.6, 0.4, 0.2), emission: Rgb(1, 2, 3)),
        "enamel": Pbr(base_color: Rgb(0.9, 0.3, 0.2), metallic: 0, roughness: 0.3, emission: Checker(scale: 0.3, even: (1, 2, 3), odd: (0.1, 0, 0))),"#,
    objects: r#"
        Box(min: (0.3, 0, -0.4), max: (0.8, 0.5, 0.2), material: "glow"),
        Sphere(center: (-0.3, 0.4, 0), radius: 0.4, material: "enamel"),
        Medium(boundary: Box(min: (-0.9, 0.1, -0.9), max: (0.9, 0.7, 0.9)), density: 0.3, albedo: Rgb(0.8, 0.8, 0.8)),"#,
    max_depth: 5,
    // Light that is counted twice.
    faults: &[(
        "step/found_light",
        "let weight = mis_weight(path, hit, surface.local);",
        "let weight = select(mis_weight(path, hit, surface.local), 1.0, FAULT);",
    )],
};

/// Surfaces whose back is black, some of them seen from there.
pub const ONE_SIDED: Room = Room {
    walls: ["front", "metal", ""],
    lamp: 0.5,
    brighter: 1.02,
    materials: r#"
        "front": Lambertian(albedo: Rgb(0.7, 0.6, 0.5), one_sided: true),
        "metal": Conductor(albedo: Rgb(0.9, 0.6, 0.3), roughness: 0.6, one_sided: true),
        "glow": Pbr(base_color: Rgb(0.9, 0.8, 0.7), metallic: 0, roughness: 0.5, emission: Rgb(3, 2, 1), one_sided: true),
        "half": Lambertian(albedo: Rgb(0.5, 0.6, 0.7), emission: Rgb(1, 2, 3), one_sided_emission: true),"#,
    objects: r#"
        Quad(corner: (-0.9, 0.3, 0.3), u: (0.8, 0, 0), v: (0, 0.9, 0.2), material: "glow"),
        Quad(corner: (0.1, 0.2, 0.2), u: (0, 0.8, 0.2), v: (0.8, 0, 0), material: "glow"),
        Quad(corner: (-0.4, -0.9, 0.5), u: (0.5, 0, 0), v: (0.1, 0.5, 0), material: "half"),
        Mesh(path: "octahedron.obj", material: "metal"),"#,
    max_depth: 6,
    // Light of their backs.
    faults: &[("scene", "emission: Rgb(3, 2, 1), one_sided: true", "emission: Rgb(3, 2, 1)")],
};

impl Room<'_> {
    pub fn scene(&self) -> Scene {
        let folder = normal_maps::folder();
        numbers::marks(folder.path());
        for (name, detail) in [("octahedron.obj", 0), ("smooth-ball.obj", 1)] {
            std::fs::write(folder.path().join(name), smooth_ball_file(detail)).expect("it is written");
        }
        scene_in(folder.path(), &open_room(&self.walls, self.lamp, self.materials, self.objects, self.max_depth))
    }

    /// The errors found are more light, and those of its own.
    fn has_one_expectation(&self) {
        let room = self.scene();
        let mis = Request::default().mis().scatter(Scatter::Linked);
        let by_rays = render(&room, &Request::default().seed(1));
        agree("light sampling", &by_rays, &render(&room, &mis.clone().seed(2)), ROUNDING);
        let sobol = render(&room, &mis.clone().seed(3).sobol());
        agree("by Sobol points", &by_rays, &sobol, ROUNDING);
        differ("more light", &by_rays, &sobol.changed(|_, _, rgb| rgb.map(|v| self.brighter * v)), ROUNDING);
        let (of_room, of_kernels): (Vec<_>, Vec<_>) = self.faults.iter().partition(|(module, ..)| *module == "scene");
        for (_, part, by) in of_room {
            let materials = self.materials.replace(part, by);
            differ(
                by,
                &by_rays,
                &render(&Room { materials: &materials, ..*self }.scene(), &mis.clone().seed(2)),
                ROUNDING,
            );
        }
        if !of_kernels.is_empty() {
            are_found("light sampling", &room, &by_rays, &mis, &of_kernels, ROUNDING);
        }
    }
}

/// A test for each room.
macro_rules! rooms {
    ($($name:ident $room:ident)*) => {
        mod changes_no_expectation {
            $(#[test] fn $name() { super::$room.has_one_expectation(); })*
        }
    };
}

rooms! {
    behind_black_backs ONE_SIDED
    beside_lobes LOBES
    beside_metals_that_lose_nothing MULTISCATTER
    beside_layers LAYERS
    beside_plastics PLASTICS
    beside_mixes MIXES
    where_numbers_vary NUMBERS
    under_normal_maps NORMAL_MAPS
    behind_coloured_glass COLOURED_GLASS
    behind_panes PANES
    where_lamps_have_an_alpha ALPHA_OF_LAMPS
    where_surfaces_emit_and_scatter EMISSIVE
}
