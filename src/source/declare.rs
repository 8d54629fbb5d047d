//! Declares an enum of the scene file: its variants, and of each its form and its fields, once.

/// Declares an enum that serde reads and writes, and for each variant a module with its `FORM` and its `FIELDS`.
///
/// ```ignore
/// declare! {
///     pub enum Material {
///         /// What the variant is, for docs/scene.md.
///         Metal: metal, "Metal(albedo: Rgb(0.8, 0.6, 0.2))" {
///             /// What the field means, for docs/scene.md.
///             albedo: Texture = Takes::Texture(Range::SHARE), "";
///             /// The text behind what it takes is its default; it is empty if the file must give it.
///             #[serde(default)]
///             fuzz: f64 = Takes::Number(Range::SHARE, NO_UNIT), "0";
///             /// A field of an earlier variant has its form.
///             glossy: bool => plastic::FIELDS.glossy;
///         }
///     }
/// }
/// ```
macro_rules! declare {
    ($(#[$attribute:meta])* pub enum $enum:ident { $(
        $(#[doc = $about:literal])*
        $variant:ident: $module:ident, $example:literal $({ $(
            $(#[doc = $meaning:literal])*
            $(#[serde $serde:tt])?
            $field:ident: $type:ty $(= $takes:expr, $default:literal)? $(=> $earlier:expr)?;
        )* })? $(( $(
            $(#[doc = $unnamed_meaning:literal])*
            $unnamed:ident: $unnamed_type:ty = $unnamed_takes:expr;
        )* ))?
    )* }) => {
        $(#[$attribute])*
        pub enum $enum { $(
            $(#[doc = $about])*
            $variant $({ $($(#[doc = $meaning])* $(#[serde $serde])? $field: $type),* })? $(($($unnamed_type),*))?
        ),* }

        $(
            pub mod $module {
                use super::*;

                pub struct Fields {
                    $($(pub $field: Field,)*)?
                    $($(pub $unnamed: Field,)*)?
                }

                pub const FIELDS: Fields = Fields {
                    $($($field: declare!(@field $field [$($meaning)*] $($takes, $default)? $($earlier)?),)*)?
                    $($($unnamed: declare!(@field $unnamed [$($unnamed_meaning)*] $unnamed_takes, ""),)*)?
                };

                pub const FORM: Form = Form {
                    name: stringify!($variant),
                    about: declare!(@text $($about)*),
                    fields: &[$($(FIELDS.$field,)*)? $($(FIELDS.$unnamed,)*)?],
                    in_order: <[&str]>::len(&[$($(stringify!($unnamed),)*)?]) > 0,
                    example: $example,
                };
            }
        )*
    };
    (@field $name:ident [$($meaning:literal)*] $takes:expr, $default:literal) => {
        Field { name: stringify!($name), takes: $takes, default: $default, about: declare!(@text $($meaning)*) }
    };
    (@field $name:ident [] $earlier:expr) => {
        $earlier
    };
    // Each line of a doc comment begins with a space.
    (@text $($line:literal)*) => {
        concat!($($line),*).split_at(1).1
    };
}

pub(crate) use declare;
