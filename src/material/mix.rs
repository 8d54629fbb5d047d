//! A mix of two materials, of which each scattering event has one. It has no BSDF of its own.

use super::Material;
use super::declared::Mix;
use super::declared::mix::FIELDS;
use super::model::{MaterialKind, Model};
use super::row::{ALPHA, MIX, Row, Slot};
use crate::texture::{Colour, Use};

pub const KIND: MaterialKind = MaterialKind { rows: &[ALPHA, MIX], ..MaterialKind::new("mix", &[]) };

impl Mix {
    /// The numbers of its row are those of its parts, which it does not know.
    pub fn model(&self) -> Model<'_> {
        let share = Slot { field: &FIELDS.share, usage: Use::Share, texture: &self.share };
        let model = Model::default().cut_out(&self.alpha, None, false);
        // The frames of the parts are behind that of the last row.
        model.with_rows(vec![Row::new(MIX, share, &[])])
    }
}

impl Material {
    /// The names of the parts of a mix, with the fields that hold them.
    pub fn parts(&self) -> impl Iterator<Item = (&'static str, &str)> {
        let mix = if let Material::Mix(own) = self { Some(own) } else { None };
        mix.into_iter().flat_map(|own| [(FIELDS.a.name, own.a.as_str()), (FIELDS.b.name, own.b.as_str())])
    }

    /// The reason why it cannot be a part of a mix, if there is one.
    pub fn not_mixed(&self) -> Option<&'static str> {
        let model = self.model();
        let all = [
            (self.parts().next().is_some(), "is a Mix"),
            (self.kind().is_pane, "is a ThinDielectric"),
            (model.emission().is_some(), "emits light"),
            (model.has_alpha(), "has an alpha, which only the Mix can have"),
            (model.absorption.is_some_and(|absorption| absorption != Colour::ZERO), "absorbs light inside"),
        ];
        all.into_iter().find_map(|(is_so, what)| is_so.then_some(what))
    }
}
