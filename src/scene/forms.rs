//! The forms of the scene file that belong to no material, texture or shape: how they are written, and what their fields take.

use super::types::Material;
use crate::delta_light;
use crate::shape::kinds_in_files;
use crate::source::form::{Field, Form, PATH, Takes};
use crate::source::{DEGREES, NO_UNIT, Range, SCENE_UNITS};
use crate::texture::{Texture, Use};

pub const SCENE: Form = Form {
    name: "Scene",
    about: "The whole file.",
    fields: &[
        Field::new("image", Takes::Other("(width: .., height: ..)"), "The size of the image."),
        Field::new(
            "camera",
            Takes::Other("(look_from: .., look_at: .., vertical_fov: ..)"),
            "Where the camera is, and its lens.",
        ),
        Field::new(
            "background",
            Takes::Other("a background: Solid((r, g, b)), Gradient(bottom: .., top: ..) or Image(path: ..)"),
            "The radiance of rays that hit nothing.",
        ),
        Field::new(
            "materials",
            Takes::Other("a map of materials: {\"name\": Lambertian(..), ..}"),
            "The materials, by the names that objects give.",
        )
        .or("{}"),
        Field::new("objects", Takes::Other("a list of objects: [..]"), "What is in the scene."),
        Field::new("render", Takes::Other("(samples: .., max_depth: ..)"), "Settings that the command line overrides.")
            .or("(samples: 100, max_depth: 50)"),
    ],
    in_order: false,
    example: "Scene(
    image: (width: 320, height: 180),
    camera: (look_from: (0, 2, 8), look_at: (0, 1, 0), vertical_fov: 30),
    background: Solid((0.5, 0.7, 1)),
    materials: { \"matt\": Lambertian(albedo: Rgb(0.7, 0.3, 0.2)) },
    objects: [ Sphere(center: (0, 1, 0), radius: 1, material: \"matt\") ],
)",
};

pub const WIDTH: Field = Field::new("width", Takes::Whole(1, LARGEST_SIDE), "In pixels.");
pub const HEIGHT: Field = Field::new("height", Takes::Whole(1, LARGEST_SIDE), "In pixels.");
const LARGEST_SIDE: u32 = 1 << 16;
/// The most pixels of an image.
pub const LARGEST_AREA: u64 = 1 << 30;

pub const IMAGE: Form = Form {
    name: "image",
    about: "The size of the image: 2^30 pixels at most. `--size` overrides it.",
    fields: &[WIDTH, HEIGHT],
    in_order: false,
    example: "(width: 1200, height: 675)",
};

pub const LOOK_FROM: Field = Field::new("look_from", Takes::Point, "Where the camera is.");
pub const LOOK_AT: Field = Field::new("look_at", Takes::Point, "What is in the middle of the image.");
pub const UP: Field =
    Field::new("up", Takes::Vector, "The direction that is up in the image; not parallel to the view.").or("(0, 1, 0)");
pub const VERTICAL_FOV: Field = Field::new(
    "vertical_fov",
    Takes::Number(Range::between(0.0, 180.0), DEGREES),
    "The angle between the upper and the lower edge of the image.",
);
pub const APERTURE: Field = Field::new(
    "aperture",
    Takes::Number(Range::NOT_NEGATIVE, SCENE_UNITS),
    "The diameter of the lens; 0 is a pinhole, which shows everything sharp.",
)
.or("0");
pub const FOCUS_DISTANCE: Field = Field::new(
    "focus_distance",
    Takes::Number(Range::POSITIVE, SCENE_UNITS),
    "The distance from the lens to the plane that is sharp.",
)
.or("the distance to `look_at`");

pub const CAMERA: Form = Form {
    name: "camera",
    about: "A camera with a thin lens.",
    fields: &[LOOK_FROM, LOOK_AT, UP, VERTICAL_FOV, APERTURE, FOCUS_DISTANCE],
    in_order: false,
    example: "(look_from: (13, 2, 3), look_at: (0, 0, 0), vertical_fov: 20, aperture: 0.1, focus_distance: 10)",
};

pub const SAMPLES: Field =
    Field::new("samples", Takes::Whole(1, 1 << 31), "Samples per pixel; `--spp` overrides it.").or("100");
pub const MAX_DEPTH: Field = Field::new(
    "max_depth",
    Takes::Whole(0, 1_000_000),
    "The most scattering events of a path, on surfaces and in media; `--max-depth` overrides it.",
)
.or("50");

pub const RENDER: Form = Form {
    name: "render",
    about: "Settings that the command line overrides.",
    fields: &[SAMPLES, MAX_DEPTH],
    in_order: false,
    example: "(samples: 500, max_depth: 50)",
};

const RADIANCE: Takes = Takes::Colour(Use::Radiance.range());

pub const BACKGROUNDS: &[Form] = &[
    Form {
        name: "Solid",
        about: "The same radiance from everywhere.",
        fields: &[Field::new("colour", RADIANCE, "The radiance.")],
        in_order: true,
        example: "Solid((0, 0, 0))",
    },
    Form {
        name: "Gradient",
        about: "A blend from straight down to straight up, by 0.5 (y + 1) of the ray's unit direction.",
        fields: &[
            Field::new("bottom", RADIANCE, "The radiance straight down."),
            Field::new("top", RADIANCE, "The radiance straight up."),
        ],
        in_order: false,
        example: "Gradient(bottom: (1, 1, 1), top: (0.5, 0.7, 1))",
    },
    Form {
        name: "Image",
        about: "A sky all around: a latitude-longitude image, with +y at the top and -z in the middle.",
        fields: &[Field::new("path", Takes::Other(PATH), "A file of the same formats as the texture `Image`.")],
        in_order: false,
        example: "Image(path: \"sky.exr\")",
    },
];

pub const TRANSLATE: Field = Field::new("by", Takes::Vector, "The shift, in scene units.");
pub const FACTOR: Field =
    Field::new("scale", Takes::Number(Range::POSITIVE, NO_UNIT), "The factor, the same along all axes.");
pub const ANGLE: Field = Field::new("degrees", Takes::Number(Range::ANY, DEGREES), "The angle.");
pub const AXIS: Field = Field::new("axis", Takes::Vector, "The axis, of any length but 0.");

pub const TRANSFORMS: &[Form] = &[
    Form {
        name: "Translate",
        about: "A shift.",
        fields: &[TRANSLATE],
        in_order: true,
        example: "Translate((265, 0, 295))",
    },
    Form {
        name: "Scale",
        about: "A change of size around the origin.",
        fields: &[FACTOR],
        in_order: true,
        example: "Scale(2)",
    },
    Form {
        name: "RotateX",
        about: "A turn around the x axis: 90 takes +y to +z.",
        fields: &[ANGLE],
        in_order: true,
        example: "RotateX(90)",
    },
    Form {
        name: "RotateY",
        about: "A turn around the y axis: 90 takes +z to +x.",
        fields: &[ANGLE],
        in_order: true,
        example: "RotateY(15)",
    },
    Form {
        name: "RotateZ",
        about: "A turn around the z axis: 90 takes +x to +y.",
        fields: &[ANGLE],
        in_order: true,
        example: "RotateZ(-18)",
    },
    Form {
        name: "Rotate",
        about: "A turn around any axis through the origin, right-handed.",
        fields: &[AXIS, ANGLE],
        in_order: false,
        example: "Rotate(axis: (1, 1, 0), degrees: 45)",
    },
];

pub const DENSITY: Field = Field::new(
    "density",
    Takes::Number(Range::NOT_NEGATIVE, "per scene unit"),
    "The extinction coefficient: light falls to 1/e over a distance of 1 / density.",
);
pub const MEDIUM_ALBEDO: Field = Field::new(
    "albedo",
    Takes::Texture(Use::Albedo.range()),
    "The scattered share of that light; the rest is absorbed. An `Image` is not allowed.",
);
pub const ANISOTROPY: Field = Field::new(
    "anisotropy",
    Takes::Number(Range::between(-1.0, 1.0), NO_UNIT),
    "Henyey and Greenstein's g: above 0 most light is scattered forwards, below 0 back.",
)
.or("0");

/// The objects that hold others.
pub const COMPOUNDS: &[Form] = &[
    Form {
        name: "Transformed",
        about: "An object that is moved, turned or scaled.",
        fields: &[
            Field::new("by", Takes::Other("a list of transforms: [..]"), "Applied in the order listed."),
            Field::new("object", Takes::Other("an object"), "Any object, also a group."),
        ],
        in_order: false,
        example: "Transformed(
    by: [Scale(2), RotateY(15), Translate((265, 0, 295))],
    object: Box(min: (0, 0, 0), max: (1, 1, 1), material: \"matt\"),
)",
    },
    Form {
        name: "Group",
        about: "Several objects as one.",
        fields: &[Field::new("[..]", Takes::Other("a list of objects: [..]"), "The objects.")],
        in_order: true,
        example: "Group([
    Sphere(center: (0, 1, 0), radius: 1, material: \"matt\"),
    Sphere(center: (0, 2.5, 0), radius: 0.5, material: \"matt\"),
])",
    },
    Form {
        name: "Gltf",
        about: "What the default scene of a glTF file has, with its materials and transforms, without its cameras. Its materials have the \
                names `PATH#NAME` for other objects. [gltf.md](gltf.md) says what is read.",
        fields: &[
            Field::new("path", Takes::Other(PATH), "A .gltf or .glb."),
            Field::new(
                "watts",
                Takes::Other("true or false"),
                "Whether its lights are in Blender's watts, which are divided by 683 lm/W.",
            )
            .or("true for files by Blender, else false"),
            Field::new(
                "thin",
                Takes::Other("Auto or Pane"),
                "Which glass is thin. Auto: of files by Blender open meshes, as it renders them. Pane: glass without a thickness in the file, \
                 as glTF says.",
            )
            .or("Auto"),
        ],
        in_order: false,
        example: "Gltf(path: \"meshes/stool.glb\")",
    },
    Form {
        name: "Medium",
        about: "Fog or smoke of constant density inside a boundary, which itself is invisible. Where media overlap, their densities \
                add. A medium whose boundary is also a glass surface fills the glass.",
        fields: &[
            Field::new(
                "boundary",
                Takes::Other("an object without a material"),
                "A Sphere, a Box or a closed Mesh, Transformed or not.",
            ),
            DENSITY,
            MEDIUM_ALBEDO,
            ANISOTROPY,
        ],
        in_order: false,
        example: "Medium(boundary: Sphere(center: (0, 1, 0), radius: 5), density: 0.01, albedo: Rgb(1, 1, 1), anisotropy: 0)",
    },
];

/// The forms of objects: shapes, lights without size, and what holds others.
fn objects() -> Vec<&'static Form> {
    kinds_in_files().map(|kind| &kind.form).chain(delta_light::FORMS).chain(COMPOUNDS).collect()
}

/// All forms by what they are, in the order of docs/scene.md. A name may stand for two of them, which are written alike.
pub fn groups() -> [(&'static str, Vec<&'static Form>); 6] {
    [
        ("Scene", vec![&SCENE, &IMAGE, &CAMERA, &RENDER]),
        ("Backgrounds", BACKGROUNDS.iter().collect()),
        ("Materials", Material::KINDS.iter().map(|kind| &kind.form).collect()),
        ("Textures", Texture::KINDS.iter().map(|kind| &kind.form).collect()),
        ("Objects", objects()),
        ("Transforms", TRANSFORMS.iter().collect()),
    ]
}
