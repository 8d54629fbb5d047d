//! Declares what a scene file has: each field once, with its meaning, its type, what it takes and its default.

/// Declares an enum or a struct that serde reads. Each variant, and the struct, gets a module with its `FORM` and its `FIELDS`.
/// The variants of an enum `of structs` hold structs of their names. RON writes such a variant as one with fields, so that serde reads another enum.
///
/// ```ignore
/// declare! {
///     #[derive(Deserialize)]
///     pub enum Material {
///         /// What the variant is, for docs/scene.md.
///         Metal: metal, "Metal(albedo: Rgb(0.8, 0.6, 0.2))" {
///             /// What the field means, for docs/scene.md.
///             albedo: Texture = texture(Range::SHARE);
///             /// A field with a default may be left out. This one has its type's, and is not written then.
///             @default fuzz: f64 = number(Range::SHARE, NO_UNIT).or("0");
///             // A field of an earlier variant has the same meaning here.
///             shine: f64 = plastic::FIELDS.shine;
///             // One that files do not have.
///             .. #[serde(skip)] parts: Vec<Part>
///         }
///         /// Fields that are written in order, without their names, stand in round brackets.
///         Solid: solid, "Solid((0, 0, 0))" (
///             /// The radiance.
///             radiance: Colour = colour(Range::ANY);
///         )
///     }
/// }
/// ```
macro_rules! declare {
    ($(#[$attribute:meta])* pub enum $enum:ident { $(
        $(#[doc = $about:literal])*
        $variant:ident: $module:ident, $example:literal $({ $(
            $(#[doc = $meaning:literal])*
            $(#[serde $serde:tt])?
            $(@$default:ident)?
            $field:ident: $type:ty = $form:expr;
        )* $(.. $(#[$not_read:meta])* $other:ident: $other_type:ty)? })? $(( $(
            $(#[doc = $unnamed_meaning:literal])*
            $unnamed:ident: $unnamed_type:ty = $unnamed_form:expr;
        )* ))?
    )* }) => {
        $(#[$attribute])*
        pub enum $enum { $(
            $(#[doc = $about])*
            $variant $({
                $(
                    $(#[doc = $meaning])*
                    $(#[serde $serde])?
                    $(#[serde($default, skip_serializing_if = "crate::source::declare::is_default")])?
                    $field: $type,
                )*
                $($(#[$not_read])* $other: $other_type)?
            })? $(($($unnamed_type),*))?
        ),* }

        impl $enum {
            /// The forms of the variants.
            pub const FORMS: &[Form] = &[$($module::FORM),*];

            /// The variant's name, as the scene file writes it.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$variant { .. } => stringify!($variant)),* }
            }

            /// The errors of the numbers that have names; `at` is the path of the variant.
            pub fn check_fields(&self, at: &ValuePath) -> Vec<Error> {
                let checks = match self { $(
                    Self::$variant { $($($field,)*)? .. } => vec![$($($field.check_as(&$module::FIELDS.$field, at)),*)?]
                ),* };
                checks.into_iter().filter_map(Result::err).collect()
            }
        }

        $(
            declare! {
                @module $module, stringify!($variant), concat!($($about),*), $example,
                !<[&str]>::is_empty(&[$($(stringify!($unnamed)),*)?]),
                {
                    $($($field = $form, concat!($($meaning),*);)*)?
                    $($($unnamed = $unnamed_form, concat!($($unnamed_meaning),*);)*)?
                }
            }
        )*
    };
    ($(#[$attribute:meta])* pub enum $enum:ident of structs, $(#[$written_attribute:meta])* enum $written:ident { $(
        $(#[doc = $about:literal])*
        $variant:ident: $module:ident, $example:literal { $(
            $(#[doc = $meaning:literal])*
            $(#[serde $serde:tt])?
            $(@$default:ident)?
            $field:ident: $type:ty = $form:expr;
        )* }
    )* }) => {
        $(#[$attribute])*
        pub enum $enum { $($(#[doc = $about])* $variant($variant)),* }

        $(#[$written_attribute])*
        enum $written { $($variant { $(
            $(#[serde $serde])?
            $(#[serde($default, skip_serializing_if = "crate::source::declare::is_default")])?
            $field: $type
        ),* }),* }

        impl From<$written> for $enum {
            fn from(written: $written) -> $enum {
                match written { $($written::$variant { $($field),* } => $enum::$variant($variant { $($field),* })),* }
            }
        }

        impl From<$enum> for $written {
            fn from(own: $enum) -> $written {
                match own { $($enum::$variant($variant { $($field),* }) => $written::$variant { $($field),* }),* }
            }
        }

        impl $enum {
            /// The forms of the variants.
            pub const FORMS: &[Form] = &[$($module::FORM),*];

            /// The variant's name, as the scene file writes it.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$variant(_) => stringify!($variant)),* }
            }

            /// The errors of the numbers that have names; `at` is the path of the variant.
            pub fn check_fields(&self, at: &ValuePath) -> Vec<Error> {
                let checks = match self {
                    $(Self::$variant(own) => vec![$(own.$field.check_as(&$module::FIELDS.$field, at)),*]),*
                };
                checks.into_iter().filter_map(Result::err).collect()
            }
        }

        $(
            $(#[doc = $about])*
            #[derive(Clone, Debug, PartialEq)]
            pub struct $variant { $($(#[doc = $meaning])* pub $field: $type),* }

            declare! { @module $module, stringify!($variant), concat!($($about),*), $example, false, {
                $($field = $form, concat!($($meaning),*);)*
            } }
        )*
    };
    ($(#[doc = $about:literal])* #[derive $derive:tt] #[serde $read:tt]
    pub struct $struct:ident: $module:ident, $example:literal { $(
        $(#[doc = $meaning:literal])*
        $(#[serde $serde:tt])?
        $(@$default:ident)?
        $field:ident: $type:ty = $form:expr;
    )* $(.. $(#[$not_read:meta])* $other:ident: $other_type:ty)? }) => {
        $(#[doc = $about])*
        #[derive $derive]
        #[serde $read]
        pub struct $struct { $(
            $(#[doc = $meaning])*
            $(#[serde $serde])?
            $(#[serde($default, skip_serializing_if = "crate::source::declare::is_default")])?
            pub $field: $type,
        )* $($(#[$not_read])* pub $other: $other_type)? }

        impl $struct {
            /// The errors of its numbers; `at` is its path.
            pub fn check_fields(&self, at: &ValuePath) -> Vec<Error> {
                let checks = [$(self.$field.check_as(&$module::FIELDS.$field, at)),*];
                checks.into_iter().filter_map(Result::err).collect()
            }
        }

        declare! { @module $module, stringify!($module), concat!($($about),*), $example, false, {
            $($field = $form, concat!($($meaning),*);)*
        } }
    };
    (@module $module:ident, $name:expr, $about:expr, $example:literal, $in_order:expr, {
        $($field:ident = $form:expr, $meaning:expr;)*
    }) => {
        pub mod $module {
            use super::*;

            pub struct Fields { $(pub $field: Field),* }

            pub const FIELDS: Fields = Fields { $($field: $form.named(stringify!($field), $meaning)),* };

            pub const FORM: Form = Form {
                name: $name,
                about: $about.trim_ascii_start(),
                fields: &[$(FIELDS.$field),*],
                in_order: $in_order,
                example: $example,
            };
        }
    };
}

pub(crate) use declare;

/// Whether a value is its type's default, which is not written.
pub fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
