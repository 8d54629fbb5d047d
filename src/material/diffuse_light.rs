//! A diffuse light: it emits the same radiance in all directions, and reflects nothing.

use super::{MaterialKind, Model, Slot};
use crate::data;
use crate::source::form::{Field, Form, Takes};
use crate::texture::{Texture, Use};

const EMIT: Field = Field::new("emit", Takes::Texture(Use::Radiance.range()), "The emitted radiance.");
const TWO_SIDED: Field = Field::new(
    "two_sided",
    Takes::Other("true or false"),
    "Whether both sides emit. `false` emits on one side alone: u × v of a quad, the outside of a sphere, box or mesh. The other \
     side is black.",
)
.or("true");

pub const KIND: MaterialKind = MaterialKind {
    form: Form {
        name: "DiffuseLight",
        about: "A lamp: it emits the same radiance in all directions, and reflects nothing.",
        fields: &[EMIT, TWO_SIDED],
        in_order: false,
        example: "DiffuseLight(emit: Rgb(15, 15, 15), two_sided: false)",
    },
    shader: "diffuse_light",
    lobes: &[],
    is_transmissive: false,
    emits: true,
    extensions: &[],
    has_second_part: false,
};

pub fn model(emit: &Texture, two_sided: bool) -> Model<'_> {
    Model {
        slot: Some(Slot { field: &EMIT, usage: Use::Radiance, texture: emit }),
        lobes: Vec::new(),
        two_sided: Some(two_sided),
        numbers: Vec::new(),
        colours: Vec::new(),
        lacks: None,
        second_part: None,
        extensions: Vec::new(),
        absorption: None,
        on_device: data::Material { parameter: f32::from(u8::from(two_sided)), ..data::Material::default() },
    }
}
