//! The elements of a glTF file's accessors.

use gltf::accessor::{DataType, Dimensions, Item, Iter};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index, buffer};

use super::File;

/// The elements of an accessor, one by one: a list of all of them would be larger than the file.
pub type Elements<'a, T> = Box<dyn Iterator<Item = T> + 'a>;

/// Which of an accessor's elements are read.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// The first one.
    pub from: usize,
    /// How many elements an accessor without a view may have, which are zero but for the sparse ones: the file could claim any number.
    pub zeros: u64,
}

pub const ALL: Extent = Extent { from: 0, zeros: 0 };

/// The elements of an accessor as f64, by the type of its numbers.
macro_rules! numbers {
    ($kind:ident, $file:ident, $index:ident, $extent:ident; $($name:ident $type:ty),*) => {
        match $kind { $(DataType::$name => $file.numbers::<$type, _>($index, $extent)),* }
    };
}

impl File {
    pub fn accessor(&self, index: Index<Accessor>) -> Option<&Accessor> {
        self.root().get(index)
    }

    /// Some elements of an accessor, each of N numbers.
    pub fn elements<const N: usize>(
        &self,
        index: Index<Accessor>,
        extent: Extent,
    ) -> Result<Elements<'_, [f64; N]>, String>
    where
        [i8; N]: Item,
        [u8; N]: Item,
        [i16; N]: Item,
        [u16; N]: Item,
        [u32; N]: Item,
        [f32; N]: Item,
    {
        let shape = match N {
            2 => Dimensions::Vec2,
            3 => Dimensions::Vec3,
            _ => Dimensions::Vec4,
        };
        let kind = self.kind(index, shape)?;
        numbers! { kind, self, index, extent; I8 [i8; N], U8 [u8; N], I16 [i16; N], U16 [u16; N], U32 [u32; N], F32 [f32; N] }
    }

    /// Numbers, from one of them on.
    pub fn scalars(&self, index: Index<Accessor>, from: usize) -> Result<Elements<'_, f64>, String> {
        let extent = Extent { from, ..ALL };
        let kind = self.kind(index, Dimensions::Scalar)?;
        numbers! { kind, self, index, extent; I8 i8, U8 u8, I16 i16, U16 u16, U32 u32, F32 f32 }
    }

    /// Matrices, by columns.
    pub fn matrices(&self, index: Index<Accessor>) -> Result<Elements<'_, [[f64; 4]; 4]>, String> {
        match self.kind(index, Dimensions::Mat4)? {
            DataType::F32 => self.numbers::<[[f32; 4]; 4], _>(index, ALL),
            _ => Err(format!("accessor {}: expected matrices of componentType 5126", index.value())),
        }
    }

    fn numbers<T: Number<V>, V>(&self, index: Index<Accessor>, extent: Extent) -> Result<Elements<'_, V>, String> {
        let is_normalized = self.accessor(index).is_some_and(|accessor| accessor.normalized);
        let elements = self.read::<T>(index, extent.zeros)?.skip(extent.from);
        Ok(Box::new(elements.map(move |element| element.value(is_normalized))))
    }

    /// The indices of vertices.
    pub fn indices(&self, index: Index<Accessor>) -> Result<Elements<'_, u64>, String> {
        Ok(match self.kind(index, Dimensions::Scalar)? {
            DataType::U8 => Box::new(self.read::<u8>(index, 0)?.map(u64::from)),
            DataType::U16 => Box::new(self.read::<u16>(index, 0)?.map(u64::from)),
            DataType::U32 => Box::new(self.read::<u32>(index, 0)?.map(u64::from)),
            _ => return Err("expected indices of componentType 5121, 5123 or 5125".to_owned()),
        })
    }

    /// The type of an accessor's numbers, if the accessor has this shape.
    fn kind(&self, index: Index<Accessor>, shape: Dimensions) -> Result<DataType, String> {
        let at = index.value();
        let accessor = self.accessor(index).ok_or_else(|| format!("there is no accessor {at}"))?;
        let name = |shape: Dimensions| format!("{shape:?}").to_ascii_uppercase();
        match (accessor.type_, accessor.component_type) {
            (Checked::Valid(found), Checked::Valid(kind)) if found == shape => Ok(kind.0),
            (Checked::Valid(found), _) if found == shape => {
                Err(format!("accessor {at}: expected a componentType from 5120 to 5126"))
            }
            (found, _) => {
                let found = match found {
                    Checked::Valid(found) => name(found),
                    Checked::Invalid => "none that glTF has".to_owned(),
                };
                Err(format!("accessor {at}: expected an accessor of type {}, found {found}", name(shape)))
            }
        }
    }

    /// The elements of an accessor, after a check that its buffer contains all of them. One without a view may have so many `zeros`.
    fn read<T: Item>(
        &self,
        index: Index<Accessor>,
        zeros: u64,
    ) -> Result<impl Iterator<Item = T> + use<'_, T>, String> {
        let accessor = self.accessor(index).ok_or("there is no such accessor")?;
        let size = size_of::<T>() as u64;
        match accessor.buffer_view {
            Some(view) => {
                self.check_span(view, accessor.byte_offset.unwrap_or_default().0, accessor.count.0, size)?;
            }
            None if accessor.sparse.is_some() && (1..=zeros).contains(&accessor.count.0) => {}
            None => return Err("an accessor has no bufferView".to_owned()),
        }
        if let Some(sparse) = &accessor.sparse {
            let (indices, values) = (&sparse.indices, &sparse.values);
            let Checked::Valid(kind) = indices.component_type else {
                return Err("expected sparse indices of componentType 5121, 5123 or 5125".to_owned());
            };
            self.check_span(indices.buffer_view, indices.byte_offset.0, sparse.count.0, kind.0.size() as u64)?;
            self.check_span(values.buffer_view, values.byte_offset.0, sparse.count.0, size)?;
        }
        let accessor = self.document.accessors().nth(index.value());
        let bytes = |buffer: gltf::Buffer| self.buffers.get(buffer.index()).map(|bytes| bytes.as_slice());
        accessor.and_then(|accessor| Iter::new(accessor, bytes)).ok_or_else(|| "an accessor cannot be read".to_owned())
    }

    /// Checks that a view contains `count` elements, and that its buffer contains the view. The format demands at least
    /// one element.
    fn check_span(&self, view: Index<buffer::View>, offset: u64, count: u64, size: u64) -> Result<(), String> {
        let view = self.root().get(view).ok_or("an accessor's bufferView is not there")?;
        let stride = match view.byte_stride {
            Some(stride) if stride.0 > 0 => stride.0 as u64,
            _ => size,
        };
        if stride < size {
            return Err(format!("a bufferView has a byteStride of {stride}: elements of {size} bytes overlap"));
        }
        let is_inside = || {
            let end = stride.checked_mul(count.checked_sub(1)?)?.checked_add(size)?.checked_add(offset)?;
            let view_end = view.byte_offset.unwrap_or_default().0.checked_add(view.byte_length.0)?;
            let buffer = self.buffers.get(view.buffer.value())?;
            (end <= view.byte_length.0 && view_end <= buffer.len() as u64).then_some(())
        };
        is_inside().ok_or_else(|| "an accessor has no elements or reaches past the end of its buffer".to_owned())
    }
}

/// An element, or a component of one. Normalised integers represent 0 to 1, or -1 to 1.
trait Number<V>: Item + Copy + 'static {
    fn value(self, is_normalized: bool) -> V;
}

impl<T: Number<V>, V, const N: usize> Number<[V; N]> for [T; N]
where
    [T; N]: Item,
{
    fn value(self, is_normalized: bool) -> [V; N] {
        self.map(|number| number.value(is_normalized))
    }
}

macro_rules! integers {
    ($($integer:ty)*) => {
        $(impl Number<f64> for $integer {
            fn value(self, is_normalized: bool) -> f64 {
                let value = f64::from(self);
                if is_normalized { (value / f64::from(<$integer>::MAX)).max(-1.0) } else { value }
            }
        })*
    };
}

integers! { i8 u8 i16 u16 u32 }

impl Number<f64> for f32 {
    fn value(self, _: bool) -> f64 {
        f64::from(self)
    }
}
