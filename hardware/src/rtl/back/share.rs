//! One module for all instances of a block that differ in constants only.
//!
//! A constant on which all instances agree is a `localparam`; any other is a
//! `parameter`, which the modules on the way down hand on.

use std::collections::HashSet;

use super::fault::FaultyDescription;
use super::module::VerilogModule;
use super::module_type::{ModuleType, Parameter};
use super::netlist::ModuleNetlist;
use super::prefix::Prefix;
use super::print::{LFSR_CHECK, given_text, module_text};
use super::scope::{AtomInfo, Content, Scope};
use super::sheet::{Sheet, families};
use super::variants::sheet_of_all;
use crate::rtl::front::Marker;
use rust_hdl_core::atom::AtomKind;

/// A printed module.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModuleText {
    /// Module name.
    pub name: String,
    /// The whole file.
    pub text: String,
    /// What is in it, and how that is connected; none of what only simulators read.
    pub netlist: Option<ModuleNetlist>,
}

/// Translates and prints a design, the top module last.
pub fn modules_of(
    top: &Scope,
    prefix: &Prefix,
    made_by: &str,
) -> Result<Vec<ModuleText>, FaultyDescription> {
    let mut types = Vec::new();
    register(top, &mut types)?;
    make_names_unique(&mut types);
    for module in &mut types {
        module.name = prefix.of(&module.name);
    }
    let checks = types.iter().any(|t| !t.module.description.checks.is_empty());
    let lfsr_check = checks.then(|| ModuleText {
        name: prefix.of(LFSR_CHECK),
        text: given_text(prefix, made_by, LFSR_CHECK, include_str!("lfsr_check.v")),
        netlist: None,
    });
    let (given, own): (Vec<usize>, _) = (0..types.len()).partition(|i| types[*i].given.is_some());
    let module = |index: usize| ModuleText {
        name: types[index].name.clone(),
        text: module_text(&types, index, prefix, made_by),
        netlist: Some(ModuleNetlist::of(&types, index)),
    };
    Ok(lfsr_check.into_iter().chain(given.into_iter().chain(own).map(module)).collect())
}

/// Adds `scope` as an instance of a module, old or new; returns the module
/// and the instance's constants.
fn register(
    scope: &Scope,
    types: &mut Vec<ModuleType>,
) -> Result<(usize, Vec<Parameter>), FaultyDescription> {
    if let Content::Marker(Marker::Given { module, text, contents, .. }) = &scope.content {
        return Ok((given(scope, module, (text, contents), types), Vec::new()));
    }
    let module = VerilogModule::of(scope)?;
    let own = scope.atoms.iter().filter(|a| a.kind == AtomKind::Constant);
    let mut parameters: Vec<Parameter> = own
        .zip(&module.constants)
        .map(|(atom, id)| parameter(atom, &module.signals[*id].name))
        .collect();
    let mut children = Vec::new();
    for instance in &module.instances {
        let child = &scope.children[instance.child];
        let (index, below) = register(child, types)?;
        children.push((index, parameters.len()));
        parameters.extend(below.into_iter().map(|p| Parameter {
            name: handed_on(&instance.name.to_uppercase(), &p.name),
            is_handed_on: true,
            ..p
        }));
    }
    let sizes_below = module.sizes_below(scope);
    let kinds: Vec<_> = children.iter().map(|(kind, _)| *kind).zip(&sizes_below).collect();
    let families = families(&module.instances, &kinds);
    let sheet = Sheet::of(&module, &families, &sizes_below);
    let key = format!(
        "{:?}\n{:?}\n{:?}\n{:?}\n{:?}",
        module.description,
        families.iter().map(|members| children[members[0]]).collect::<Vec<_>>(),
        parameters.iter().map(|p| (&p.name, p.width, &p.about, &p.heading)).collect::<Vec<_>>(),
        module.tables.iter().map(|table| &table.bits).collect::<Vec<_>>(),
        scope.sizes(),
    );
    let values: Vec<u32> = scope.sizes().iter().map(|size| size.value).collect();
    let variant = (values, sheet);
    for (index, known) in types.iter_mut().enumerate().filter(|(_, known)| known.key == key) {
        if !known.variants.contains(&variant) {
            let all: Vec<_> = known.variants.iter().chain([&variant]).cloned().collect();
            let Some(sheet) = sheet_of_all(&all, scope.sizes())? else {
                continue;
            };
            (known.sheet, known.variants) = (sheet, all);
        }
        for (known, new) in known.parameters.iter_mut().zip(&parameters) {
            known.values.push(new.values[0]);
        }
        return Ok((index, parameters));
    }
    types.push(ModuleType {
        name: module.description.module.clone(),
        module,
        given: None,
        contents: None,
        sheet: variant.1.clone(),
        parameters: parameters.clone(),
        children,
        families,
        sizes: scope.sizes().to_vec(),
        variants: vec![variant],
        key,
    });
    Ok((types.len() - 1, parameters))
}

/// The module `name` that is given, new or old.
fn given(
    scope: &Scope,
    name: &str,
    (text, contents): (&'static str, &Option<(String, String)>),
    types: &mut Vec<ModuleType>,
) -> usize {
    let is_known = |known: &ModuleType| known.given == Some(text) && known.contents == *contents;
    let known = types.iter().position(is_known);
    known.unwrap_or_else(|| {
        types.push(ModuleType {
            name: name.to_owned(),
            module: VerilogModule::given(scope, name),
            given: Some(text),
            contents: contents.clone(),
            sheet: Sheet::default(),
            parameters: Vec::new(),
            children: Vec::new(),
            families: Vec::new(),
            sizes: Vec::new(),
            variants: Vec::new(),
            key: String::new(),
        });
        types.len() - 1
    })
}

/// What an instance's parameter is called in the module that hands it on.
fn handed_on(instance: &str, parameter: &str) -> String {
    match parameter.strip_prefix(instance).is_some_and(|rest| rest.starts_with('_')) {
        true => parameter.to_owned(),
        false => format!("{instance}_{parameter}"),
    }
}

fn parameter(atom: &AtomInfo, name: &str) -> Parameter {
    Parameter {
        name: name.to_owned(),
        width: atom.width,
        about: atom.about.clone(),
        heading: atom.heading.clone(),
        is_number: atom.is_number,
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
