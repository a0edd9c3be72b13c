//! From a rust-hdl block to plain data: its scopes, atoms and kernels.

use rust_hdl_core::ast::{Verilog, VerilogLiteral, VerilogStatement};
use rust_hdl_core::atom::{Atom, AtomKind};
use rust_hdl_core::block::Block;
use rust_hdl_core::probe::Probe;
use rust_hdl_core::type_descriptor::TypeKind;

use super::fault::{Fault, FaultyDescription};
use crate::rtl::front::{Description, Marker, Size, told_by};

/// A block with everything in it.
#[derive(Debug)]
pub struct Scope {
    /// Field name, `$n` after an element of a vector.
    pub name: String,
    /// What the parent's kernel calls it: after the names of the bundles that it is in.
    pub key: String,
    /// Ports, local signals and constants, in the order of declaration.
    pub atoms: Vec<AtomInfo>,
    /// What the block is.
    pub content: Content,
    /// Blocks in it, in the order of declaration.
    pub children: Vec<Scope>,
}

impl Scope {
    /// Bits of one of its ports; 0 if there is none of that name.
    pub fn width_of(&self, pin: &str) -> u32 {
        let atom = self.atoms.iter().find(|a| a.outer_key == pin);
        atom.map_or(0, |atom| atom.width)
    }

    fn about(&self) -> Option<(&Description, &[Size])> {
        self.children.iter().find_map(|child| match &child.content {
            Content::Marker(Marker::About(description, sizes)) => Some((description, &sizes[..])),
            _ => None,
        })
    }

    /// Its module's name; empty without a description.
    pub fn module_name(&self) -> &str {
        self.about().map_or("", |(description, _)| &description.module)
    }

    /// What its instances have as parameters, where they differ or the module is given.
    pub fn size_values(&self) -> Vec<(String, u32)> {
        match &self.content {
            Content::Marker(Marker::Given { sizes, .. }) => sizes.clone(),
            _ => self.sizes().iter().map(|size| (size.name.clone(), size.value)).collect(),
        }
    }

    /// What instances of it may differ in.
    pub fn sizes(&self) -> &[Size] {
        self.about().map_or(&[], |(_, sizes)| sizes)
    }

    /// Whether registers or memories are in it.
    fn is_clocked(&self) -> bool {
        let is_clock = |atom: &AtomInfo| atom.outer_key == CLOCK.0;
        self.children.iter().any(|child| match &child.content {
            Content::Marker(marker) => {
                matches!(marker, Marker::Register { .. } | Marker::Given { .. })
            }
            Content::Kernel(_) => child.atoms.first().is_some_and(is_clock),
        })
    }

    /// What the parent's kernel calls a port.
    pub fn pin(&self, pin: &str) -> String {
        format!("{}${pin}", self.key)
    }
}

/// What a scope is.
#[derive(Debug)]
pub enum Content {
    /// A kernel.
    Kernel(Vec<VerilogStatement>),
    /// A marker of our own.
    Marker(Marker),
}

/// A port, local signal or constant.
#[derive(Debug)]
pub struct AtomInfo {
    /// Name inside the block's kernel.
    pub inner_key: String,
    /// Name after the instance's in the parent's kernel.
    pub outer_key: String,
    /// rust-hdl's kind.
    pub kind: AtomKind,
    /// Bits.
    pub width: u32,
    /// Value, for constants.
    pub value: u128,
    /// Whether that is a number, and not a pattern of bits.
    pub is_number: bool,
    /// Description.
    pub about: String,
    /// Heading in the port list.
    pub heading: Option<String>,
}

/// Clock and reset of every module that has registers: name and description.
pub const CLOCK: (&str, &str) = ("i_clk", "one cycle per chip");
pub const RESET: (&str, &str) = ("i_rst", "synchronous, active high; pulse it after power-up");

/// A port of a single bit that comes from outside.
fn port(name: &str, about: &str) -> AtomInfo {
    AtomInfo {
        inner_key: name.to_owned(),
        outer_key: name.to_owned(),
        kind: AtomKind::InputParameter,
        width: 1,
        value: 0,
        is_number: false,
        about: about.to_owned(),
        heading: None,
    }
}

/// Collects the scopes of `top`.
pub fn scopes_of(top: &dyn Block) -> Result<Scope, FaultyDescription> {
    let mut collector = Collector::default();
    top.accept("top", &mut collector);
    match (collector.fault, collector.done) {
        (Some(refusal), _) => Err(refusal),
        (None, Some(scope)) => Ok(scope),
        (None, None) => Err(FaultyDescription {
            module: "top".to_owned(),
            fault: Fault::Unsupported { construct: "a design without a block".to_owned() },
        }),
    }
}

#[derive(Default)]
struct Collector {
    /// Each with the bundles that are open in it.
    open: Vec<(Scope, Vec<String>)>,
    done: Option<Scope>,
    fault: Option<FaultyDescription>,
}

impl Collector {
    /// What the kernel of the innermost block calls what is in the bundles that are open.
    fn key(&self, name: &str) -> String {
        let bundles = self.open.last().into_iter().flat_map(|(_, open)| open);
        bundles.map(String::as_str).chain([name]).collect::<Vec<_>>().join("$")
    }
}

impl Probe for Collector {
    fn visit_start_scope(&mut self, name: &str, node: &dyn Block) {
        let content = match told_by(node) {
            (_, Some(marker)) => Ok(Content::Marker(marker)),
            (Verilog::Combinatorial(kernel), _) => Ok(Content::Kernel(kernel)),
            (Verilog::Empty, _) => Ok(Content::Kernel(Vec::new())),
            (Verilog::Custom(_), _) => Err("Verilog text".to_owned()),
            (Verilog::Blackbox(_) | Verilog::Wrapper(_), _) => Err("a black box".to_owned()),
        };
        let content = content.unwrap_or_else(|construct| {
            self.fault.get_or_insert(FaultyDescription {
                module: name.to_owned(),
                fault: Fault::Unsupported { construct },
            });
            Content::Kernel(Vec::new())
        });
        let scope = Scope {
            name: name.to_owned(),
            key: self.key(name),
            atoms: Vec::new(),
            content,
            children: Vec::new(),
        };
        self.open.push((scope, Vec::new()));
    }

    fn visit_start_namespace(&mut self, name: &str, _node: &dyn Block) {
        self.open.last_mut().into_iter().for_each(|(_, open)| open.push(name.to_owned()));
    }

    fn visit_atom(&mut self, name: &str, atom: &dyn Atom) {
        let inner_key = self.key(name);
        let Some((scope, _)) = self.open.last_mut() else {
            return;
        };
        let descriptor = atom.descriptor();
        let is_number = matches!(descriptor.kind, TypeKind::Signed(_));
        let described = descriptor.name;
        let (heading, about) = match described.split_once('\n') {
            Some((heading, about)) => (Some(heading.to_owned()), about.to_owned()),
            None => (None, described),
        };
        scope.atoms.push(AtomInfo {
            inner_key,
            outer_key: name.to_owned(),
            kind: atom.kind(),
            width: atom.bits() as u32,
            value: literal_value(&atom.verilog()).unwrap_or(0),
            is_number,
            about,
            heading,
        });
    }

    fn visit_end_namespace(&mut self, _name: &str, _node: &dyn Block) {
        self.open.last_mut().into_iter().for_each(|(_, open)| _ = open.pop());
    }

    fn visit_end_scope(&mut self, _name: &str, _node: &dyn Block) {
        let Some((mut scope, _)) = self.open.pop() else {
            return;
        };
        if let Content::Marker(Marker::Given { sees_reset, .. }) = scope.content {
            let ports = if sees_reset { &[CLOCK, RESET][..] } else { &[CLOCK] };
            scope.atoms.splice(0..0, ports.iter().map(|(name, about)| port(name, about)));
        }
        if scope.is_clocked() {
            scope.atoms.splice(0..0, [CLOCK, RESET].map(|(name, about)| port(name, about)));
        }
        match self.open.last_mut() {
            Some((parent, _)) => parent.children.push(scope),
            None => self.done = Some(scope),
        }
    }
}

/// The number in a literal, or `None` if negative or beyond 128 bits.
/// rust-hdl keeps it private; its hexadecimal form, `32'h1f`, has it.
pub fn literal_value(literal: &VerilogLiteral) -> Option<u128> {
    let text = format!("{literal:x}");
    let digits = text.split_once("'h")?.1;
    u128::from_str_radix(digits, 16).ok()
}

/// The declared width of a literal; rust-hdl gives 1 to `true` and `false`
/// and 32 or more to numbers.
pub fn literal_width(literal: &VerilogLiteral) -> u32 {
    let text = format!("{literal:x}");
    text.split_once('\'').and_then(|(width, _)| width.parse().ok()).unwrap_or(0)
}
