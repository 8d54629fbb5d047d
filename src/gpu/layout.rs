//! The bindings of a linked shader and the layouts of its structs, from naga's reflection. WGSL is the only source of bindings
//! and sizes.

use std::collections::BTreeMap;

use naga::proc::Layouter;

use crate::error::{Error, Result};

/// One binding that a kernel uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    pub number: u32,
    pub kind: BindingKind,
    /// The bytes of one element if the binding is an array, else of all of it.
    pub element_bytes: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BindingKind {
    Uniform,
    Read,
    ReadWrite,
}

/// A member of a struct: its name, offset and size in bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    pub name: String,
    pub offset: u32,
    pub bytes: u32,
}

/// The bindings, by the names of their variables.
pub fn bindings(module: &naga::Module) -> Result<BTreeMap<String, Binding>> {
    let layouter = layouts(module)?;
    let mut found = BTreeMap::new();
    for (_, variable) in module.global_variables.iter() {
        let Some(binding) = variable.binding else { continue };
        let kind = match variable.space {
            naga::AddressSpace::Uniform => BindingKind::Uniform,
            naga::AddressSpace::Storage { access } if access.contains(naga::StorageAccess::STORE) => {
                BindingKind::ReadWrite
            }
            _ => BindingKind::Read,
        };
        let element = match module.types[variable.ty].inner {
            naga::TypeInner::Array { base, .. } => base,
            _ => variable.ty,
        };
        let name = variable.name.clone().unwrap_or_default();
        let element_bytes = layouter[element].to_stride();
        found.insert(name, Binding { number: binding.binding, kind, element_bytes });
    }
    Ok(found)
}

/// The members of a struct and its size in bytes; none if the shader has no such struct.
pub fn members(module: &naga::Module, name: &str) -> Result<Option<(Vec<Member>, u32)>> {
    let layouter = layouts(module)?;
    let found = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name));
    let Some((_, naga::Type { inner: naga::TypeInner::Struct { members, span }, .. })) = found else {
        return Ok(None);
    };
    let members = members
        .iter()
        .map(|member| Member {
            name: member.name.clone().unwrap_or_default(),
            offset: member.offset,
            bytes: layouter[member.ty].size,
        })
        .collect();
    Ok(Some((members, *span)))
}

/// Whether the shader has an override constant of this name.
pub fn has_override(module: &naga::Module, name: &str) -> bool {
    module.overrides.iter().any(|(_, known)| known.name.as_deref() == Some(name))
}

/// The override constants by name, with their default values if these are integers.
pub fn overrides(module: &naga::Module) -> BTreeMap<String, Option<u64>> {
    let named = |(_, known): (_, &naga::Override)| {
        let value = known.init.and_then(|init| integer_value(module, init));
        Some((known.name.clone()?, value))
    };
    module.overrides.iter().filter_map(named).collect()
}

fn integer_value(module: &naga::Module, value: naga::Handle<naga::Expression>) -> Option<u64> {
    match module.global_expressions[value] {
        naga::Expression::Literal(naga::Literal::U32(value)) => Some(u64::from(value)),
        naga::Expression::Literal(naga::Literal::I32(value)) => u64::try_from(value).ok(),
        naga::Expression::Constant(constant) => integer_value(module, module.constants[constant].init),
        _ => None,
    }
}

/// Converts a host's struct to the layout of a shader's struct, member by member, by name. `fields` has the name,
/// offset and size of each member of the host's struct. Members that the host lacks are zero.
pub fn pack(members: &[Member], fields: &[(&str, usize, usize)], host: &[u8]) -> Vec<u8> {
    let mut packed = vec![0; packed_bytes(members) as usize];
    for member in members {
        let field = fields.iter().find(|(name, _, bytes)| *name == member.name && *bytes == member.bytes as usize);
        let bytes = field.and_then(|(_, offset, bytes)| host.get(*offset..offset + bytes));
        let member_bytes = packed.get_mut(member.offset as usize..(member.offset + member.bytes) as usize);
        if let (Some(bytes), Some(target)) = (bytes, member_bytes) {
            target.copy_from_slice(bytes);
        }
    }
    packed
}

/// The number of bytes that [`pack`] returns: up to the end of the last member, in rows of 16 bytes as in uniforms.
pub fn packed_bytes(members: &[Member]) -> u32 {
    let end = members.iter().map(|member| member.offset + member.bytes).max().unwrap_or(0);
    end.next_multiple_of(16)
}

fn layouts(module: &naga::Module) -> Result<Layouter> {
    let mut layouter = Layouter::default();
    layouter
        .update(module.to_ctx())
        .map_err(|error| Error::Shader(format!("a linked shader has a type without a layout: {error}")))?;
    Ok(layouter)
}
