//! One module for all instances of a block that differ in constants only.
//!
//! A constant on which all instances agree is a `localparam`; any other is a
//! `parameter`, which the modules on the way down hand on.

use std::collections::HashSet;

use super::fault::Refusal;
use super::module::Module;
use super::prefix::Prefix;
use super::print::{LFSR_CHECK, module_body, module_text};
use super::scope::{AtomInfo, Content, Scope};
use rust_hdl::core::atom::AtomKind;

/// A printed module.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModuleText {
    /// Module name.
    pub name: String,
    /// The whole file.
    pub text: String,
}

/// A constant of a module, or of one below it.
#[derive(Debug, Clone)]
pub struct Parameter {
    /// Name in this module; after the instance's name if it is handed on.
    pub name: String,
    /// Bits.
    pub width: u32,
    /// Description.
    pub about: String,
    /// Heading over it.
    pub heading: Option<String>,
    /// Value in each instance of the module, in the order of the design.
    pub values: Vec<u128>,
    /// Whether it belongs to a module below.
    pub is_handed_on: bool,
}

impl Parameter {
    /// What stands beside it in the module's list of parameters.
    pub fn said(&self) -> String {
        let parts = [self.heading.as_deref().unwrap_or(""), &self.about];
        let parts = parts.into_iter().filter(|part| !part.is_empty());
        parts.collect::<Vec<_>>().join("; ")
    }

    /// Whether instances differ in it.
    pub fn varies(&self) -> bool {
        self.values.iter().any(|v| *v != self.values[0])
    }
}

/// A module and how it is used.
#[derive(Debug)]
pub struct ModuleType {
    /// The module.
    pub module: Module,
    /// Its name, made unique.
    pub name: String,
    /// Its own constants, then those of its instances.
    pub parameters: Vec<Parameter>,
    /// For each instance in it: the module, and where its parameters begin in
    /// `parameters`.
    pub children: Vec<(usize, usize)>,
    key: String,
}

/// Translates and prints a design, the top module last.
pub fn modules_of(top: &Scope, prefix: &Prefix, made_by: &str) -> Result<Vec<ModuleText>, Refusal> {
    let mut types = Vec::new();
    register(top, &mut types)?;
    make_names_unique(&mut types);
    for module in &mut types {
        module.name = prefix.of(&module.name);
    }
    let checks = types
        .iter()
        .any(|t| !t.module.description.checks.is_empty());
    let lfsr_check = checks.then(|| lfsr_check(prefix, made_by));
    let own = (0..types.len()).map(|index| ModuleText {
        name: types[index].name.clone(),
        text: module_text(&types, index, prefix, made_by),
    });
    Ok(lfsr_check.into_iter().chain(own).collect())
}

/// The module that the checks of LFSRs' states are instances of.
fn lfsr_check(prefix: &Prefix, made_by: &str) -> ModuleText {
    let name = prefix.of(LFSR_CHECK);
    let text = include_str!("lfsr_check.v").replace(LFSR_CHECK, &name);
    ModuleText {
        name,
        text: text.replacen("//\n\n", &format!("//\n// Made by  {made_by}\n\n"), 1),
    }
}

/// Adds `scope` as an instance of a module, old or new; returns the module
/// and the instance's constants.
fn register(
    scope: &Scope,
    types: &mut Vec<ModuleType>,
) -> Result<(usize, Vec<Parameter>), Refusal> {
    let module = Module::of(scope)?;
    let own = scope.atoms.iter().filter(|a| a.kind == AtomKind::Constant);
    let mut parameters: Vec<Parameter> = own
        .zip(&module.constants)
        .map(|(atom, id)| parameter(atom, &module.signals[*id].name))
        .collect();
    let mut children = Vec::new();
    for instance in &module.instances {
        let child = &scope.children[instance.child];
        if !matches!(child.content, Content::Kernel(_)) {
            continue;
        }
        let (index, below) = register(child, types)?;
        children.push((index, parameters.len()));
        parameters.extend(below.into_iter().map(|p| Parameter {
            name: format!("{}_{}", instance.name.to_uppercase(), p.name),
            is_handed_on: true,
            ..p
        }));
    }
    let key = format!(
        "{:?}\n{children:?}\n{:?}\n{}",
        module.description,
        parameters
            .iter()
            .map(|p| (&p.name, p.width, &p.about, &p.heading))
            .collect::<Vec<_>>(),
        module_body(&module),
    );
    match types.iter_mut().position(|t| t.key == key) {
        Some(index) => {
            for (known, new) in types[index].parameters.iter_mut().zip(&parameters) {
                known.values.push(new.values[0]);
            }
            Ok((index, parameters))
        }
        None => {
            types.push(ModuleType {
                name: module.description.module.clone(),
                module,
                parameters: parameters.clone(),
                children,
                key,
            });
            Ok((types.len() - 1, parameters))
        }
    }
}

fn parameter(atom: &AtomInfo, name: &str) -> Parameter {
    Parameter {
        name: name.to_owned(),
        width: atom.width,
        about: atom.about.clone(),
        heading: atom.heading.clone(),
        values: vec![atom.value],
        is_handed_on: false,
    }
}

fn make_names_unique(types: &mut [ModuleType]) {
    let mut taken = HashSet::new();
    for module in types {
        let base = module.name.clone();
        let mut number = 1;
        while !taken.insert(module.name.clone()) {
            number += 1;
            module.name = format!("{base}_{number}");
        }
    }
}
