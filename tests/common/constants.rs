//! Which tables of a kernel are read at an index that a compiler could know: what is constant by the text, followed through variables,
//! members of structs, calls and what they return, wherever any one way is constant.

use std::collections::{BTreeSet, HashSet};

use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{Arena, Expression, Function, Handle, LocalVariable, Module, Statement, Type, TypeInner};

/// A function by its handle in the module; entry points have none.
type Name = Option<Handle<Function>>;

/// What may hold a constant.
#[derive(Default, PartialEq, Eq, Clone)]
struct Constant {
    locals: HashSet<(Name, Handle<LocalVariable>)>,
    arguments: HashSet<(Handle<Function>, u32)>,
    members: HashSet<(Handle<Type>, u32)>,
    results: HashSet<Handle<Function>>,
}

struct Within<'a> {
    module: &'a Module,
    name: Name,
    function: &'a Function,
    info: &'a FunctionInfo,
    /// Of struct types: members that count as never constant.
    exempt: &'a [(&'a str, &'a str)],
}

impl Within<'_> {
    fn expressions(&self) -> &Arena<Expression> {
        &self.function.expressions
    }

    /// The struct that an expression is, or points to.
    fn struct_of(&self, expression: Handle<Expression>) -> Option<Handle<Type>> {
        let handle = match &self.info[expression].ty {
            naga::proc::TypeResolution::Handle(handle) => match self.module.types[*handle].inner {
                TypeInner::Pointer { base, .. } => base,
                _ => *handle,
            },
            naga::proc::TypeResolution::Value(TypeInner::Pointer { base, .. }) => *base,
            naga::proc::TypeResolution::Value(_) => return None,
        };
        matches!(self.module.types[handle].inner, TypeInner::Struct { .. }).then_some(handle)
    }

    fn is_exempt(&self, of: Handle<Type>, member: u32) -> bool {
        let of = &self.module.types[of];
        let TypeInner::Struct { members, .. } = &of.inner else { return false };
        let is = |name: &Option<String>, other: &str| name.as_deref() == Some(other);
        self.exempt.iter().any(|(name, field)| is(&of.name, name) && is(&members[member as usize].name, field))
    }

    fn is_constant(&self, known: &Constant, expression: Handle<Expression>) -> bool {
        let all = |parts: &[Handle<Expression>]| parts.iter().all(|part| self.is_constant(known, *part));
        match &self.expressions()[expression] {
            Expression::Literal(_) | Expression::Constant(_) | Expression::Override(_) | Expression::ZeroValue(_) => {
                true
            }
            Expression::FunctionArgument(index) => {
                self.name.is_some_and(|name| known.arguments.contains(&(name, *index)))
            }
            Expression::CallResult(function) => known.results.contains(function),
            Expression::Load { pointer } => match &self.expressions()[*pointer] {
                Expression::LocalVariable(local) => known.locals.contains(&(self.name, *local)),
                Expression::AccessIndex { base, index } => {
                    self.struct_of(*base).is_some_and(|of| known.members.contains(&(of, *index)))
                }
                _ => false,
            },
            Expression::AccessIndex { base, index } => match self.struct_of(*base) {
                Some(of) => known.members.contains(&(of, *index)),
                None => all(&[*base]),
            },
            Expression::Unary { expr, .. } | Expression::As { expr, .. } => all(&[*expr]),
            Expression::Binary { left, right, .. } => all(&[*left, *right]),
            // Either could be what is left when the condition is known.
            Expression::Select { accept, reject, .. } => all(&[*accept]) || all(&[*reject]),
            Expression::Compose { components, .. } => all(components),
            Expression::Splat { value, .. } => all(&[*value]),
            Expression::Math { arg, arg1, arg2, arg3, .. } => {
                [Some(*arg), *arg1, *arg2, *arg3].into_iter().flatten().all(|part| self.is_constant(known, part))
            }
            _ => false,
        }
    }

    /// Adds what this function makes constant.
    fn follow(&self, known: &mut Constant) {
        for (local, variable) in self.function.local_variables.iter() {
            if variable.init.is_some_and(|init| self.is_constant(known, init)) {
                known.locals.insert((self.name, local));
            }
        }
        for (expression, value) in self.expressions().iter() {
            if let (Expression::Compose { components, .. }, Some(of)) = (value, self.struct_of(expression)) {
                for (member, component) in (0..).zip(components) {
                    self.member(known, of, member, *component);
                }
            }
        }
        self.follow_block(known, &self.function.body);
    }

    fn member(&self, known: &mut Constant, of: Handle<Type>, member: u32, value: Handle<Expression>) {
        if !self.is_exempt(of, member) && self.is_constant(known, value) {
            known.members.insert((of, member));
        }
    }

    fn follow_block(&self, known: &mut Constant, block: &naga::Block) {
        for statement in block {
            match statement {
                Statement::Store { pointer, value } => match &self.expressions()[*pointer] {
                    Expression::LocalVariable(local) if self.is_constant(known, *value) => {
                        known.locals.insert((self.name, *local));
                    }
                    Expression::AccessIndex { base, index } => {
                        if let Some(of) = self.struct_of(*base) {
                            self.member(known, of, *index, *value);
                        }
                    }
                    _ => {}
                },
                Statement::Call { function, arguments, .. } => {
                    for (index, argument) in (0..).zip(arguments) {
                        if self.is_constant(known, *argument) {
                            known.arguments.insert((*function, index));
                        }
                    }
                }
                Statement::Return { value: Some(value) } => {
                    if let Some(name) = self.name.filter(|_| self.is_constant(known, *value)) {
                        known.results.insert(name);
                    }
                }
                Statement::Block(block) => self.follow_block(known, block),
                Statement::If { accept, reject, .. } => {
                    self.follow_block(known, accept);
                    self.follow_block(known, reject);
                }
                Statement::Switch { cases, .. } => {
                    for case in cases {
                        self.follow_block(known, &case.body);
                    }
                }
                Statement::Loop { body, continuing, .. } => {
                    self.follow_block(known, body);
                    self.follow_block(known, continuing);
                }
                _ => {}
            }
        }
    }

    fn read_at_constants(&self, known: &Constant, tables: &[&str], found: &mut BTreeSet<String>) {
        for (_, expression) in self.expressions().iter() {
            let (base, is_constant) = match expression {
                Expression::Access { base, index } => (base, self.is_constant(known, *index)),
                Expression::AccessIndex { base, .. } => (base, true),
                _ => continue,
            };
            let Expression::GlobalVariable(global) = self.expressions()[*base] else { continue };
            let name = self.module.global_variables[global].name.clone().unwrap_or_default();
            if is_constant && tables.contains(&name.as_str()) {
                let function = self.function.name.clone().unwrap_or_default();
                found.insert(format!("{name} in {function}"));
            }
        }
    }
}

/// Where the kernel reads one of the tables at an index that may be constant ("lights in sky_density"). The members of structs that `exempt`
/// names are taken to be none.
pub fn tables_read_at_constants(
    module: &Module,
    info: &ModuleInfo,
    tables: &[&str],
    exempt: &[(&str, &str)],
) -> BTreeSet<String> {
    let entries = module.entry_points.iter().enumerate().map(|(index, entry)| Within {
        module,
        name: None,
        function: &entry.function,
        info: info.get_entry_point(index),
        exempt,
    });
    let functions = module.functions.iter().map(|(name, function)| Within {
        module,
        name: Some(name),
        function,
        info: &info[name],
        exempt,
    });
    let functions: Vec<Within> = entries.chain(functions).collect();
    let mut known = Constant::default();
    loop {
        let before = known.clone();
        functions.iter().for_each(|function| function.follow(&mut known));
        if known == before {
            break;
        }
    }
    let mut found = BTreeSet::new();
    functions.iter().for_each(|function| function.read_at_constants(&known, tables, &mut found));
    found
}
