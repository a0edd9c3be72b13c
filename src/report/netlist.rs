//! The modules of an emission and how they are connected, read from its Verilog.
//!
//! Only what our own printer writes is understood: one port, connection or statement
//! after another, each instance headed by its module's and its own name.

use std::collections::{BTreeMap, BTreeSet};

use crate::deliver::EmittedFile;

/// A module of the emission.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Module {
    /// Its name.
    pub name: String,
    /// Names of its inputs, without clock and reset.
    pub inputs: Vec<String>,
    /// Names of its outputs.
    pub outputs: Vec<String>,
    /// What stands in it, in the order of the Verilog.
    pub instances: Vec<Instance>,
    /// What its own statements make of what: name, names it follows from, and whether
    /// a register keeps it.
    statements: Vec<Statement>,
}

/// A module in a module.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Instance {
    /// Its own name.
    pub name: String,
    /// Its module's.
    pub module: String,
    /// Ports, and the names in what they are connected to.
    pub connections: Vec<(String, Vec<String>)>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Statement {
    target: String,
    from: Vec<String>,
    is_register: bool,
}

/// One end of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum End {
    /// Input of the module, by its number.
    Input(usize),
    /// Instance, by its number.
    Instance(usize),
    /// Registers and gates of the module itself.
    Own,
    /// Output of the module, by its number.
    Output(usize),
}

/// From one end to another, with the names of the nets.
pub type Connections = BTreeMap<(End, End), BTreeSet<String>>;

/// Every module of an emission, the top module's last. What is not of the emission, an FPGA's
/// own blocks behind a macro, is no part of them.
pub fn modules(files: &[EmittedFile]) -> Vec<Module> {
    let verilog = files.iter().filter(|file| file.name.ends_with(".v"));
    let mut modules: Vec<Module> = verilog.filter_map(|file| read(&file.text)).collect();
    let names: BTreeSet<String> = modules.iter().map(|module| module.name.clone()).collect();
    for module in &mut modules {
        let instances = &mut module.instances;
        instances.retain(|instance| names.contains(&instance.module));
    }
    modules
}

fn read(text: &str) -> Option<Module> {
    let code = hardware_of(text);
    let body = code.split_once("module ")?.1;
    let (name, body) = body.split_once('(')?;
    let (name, body) = match name.trim().strip_suffix('#') {
        // Behind the parameters, which have a line of their own each.
        Some(name) => (name, body.split_once("\n) (")?.1),
        None => (name, body),
    };
    let (ports, body) = body.split_once(");")?;
    let mut module = Module {
        name: name.trim().to_owned(),
        inputs: Vec::new(),
        outputs: Vec::new(),
        instances: Vec::new(),
        statements: Vec::new(),
    };
    for port in ports.split(',') {
        let words: Vec<&str> = port.split_whitespace().collect();
        match (words.first(), words.last()) {
            (Some(&"input"), Some(&port)) if !is_clock(port) => module.inputs.push(port.to_owned()),
            (Some(&"output"), Some(&port)) => module.outputs.push(port.to_owned()),
            _ => {}
        }
    }
    for statement in body.split("endmodule").next()?.split(';') {
        module.take(statement.trim());
    }
    Some(module)
}

fn is_clock(port: &str) -> bool {
    matches!(port, "i_clk" | "i_rst")
}

/// Without comments, and without what only simulators read.
fn hardware_of(text: &str) -> String {
    let mut is_hardware = true;
    let mut kept = Vec::new();
    for line in text.lines() {
        match line.trim() {
            "`ifndef SYNTHESIS" => is_hardware = false,
            "`endif" => is_hardware = true,
            _ if is_hardware => kept.push(line.split("//").next().unwrap_or_default()),
            _ => {}
        }
    }
    kept.join("\n")
}

impl Module {
    fn take(&mut self, statement: &str) {
        if let Some(assigned) = statement.strip_prefix("assign ") {
            if let Some((target, value)) = assigned.split_once('=') {
                self.add_statement(target, value, false);
            }
        } else if let Some((before, value)) = statement.split_once("<=") {
            // What leads to it, `if` and `begin`, stands before it.
            let target = before.rsplit([' ', '\n']).find(|word| !word.is_empty());
            let conditions = &before[..before.len() - target.map_or(0, str::len).min(before.len())];
            // Where in a vector or memory is one more thing that it follows from.
            let (_, place) = target.and_then(|t| t.split_once('[')).unwrap_or_default();
            let from = format!("{value} {place} {conditions}");
            self.add_statement(target.unwrap_or_default(), &from, true);
        } else if statement.contains("(\n") {
            self.instances.extend(Instance::read(statement));
        }
    }

    fn add_statement(&mut self, target: &str, value: &str, is_register: bool) {
        let target = names(target).next();
        self.statements.extend(target.map(|target| Statement {
            target,
            from: names(value).filter(|name| !is_clock(name)).collect(),
            is_register,
        }));
    }

    /// What drives what: straight, or through gates that keep nothing.
    pub fn connections(&self, modules: &[Module]) -> Connections {
        let driven = self.driven_by_instances(modules);
        let mut connections = Connections::new();
        let mut connect = |to: End, net: &str| {
            for (from, name) in self.sources(net, &driven) {
                if from != to {
                    connections.entry((from, to)).or_default().insert(name);
                }
            }
        };
        for (index, instance) in self.instances.iter().enumerate() {
            for (port, nets) in &instance.connections {
                let is_input = port.starts_with("i_");
                for net in nets.iter().filter(|net| is_input && !is_clock(net)) {
                    connect(End::Instance(index), net);
                }
            }
        }
        for statement in self.statements.iter().filter(|statement| statement.is_register) {
            statement.from.iter().for_each(|net| connect(End::Own, net));
        }
        for (index, output) in self.outputs.iter().enumerate() {
            connect(End::Output(index), output);
        }
        connections
    }

    /// Nets that the outputs of instances drive.
    fn driven_by_instances(&self, modules: &[Module]) -> BTreeMap<&str, usize> {
        let mut driven = BTreeMap::new();
        for (index, instance) in self.instances.iter().enumerate() {
            let of = modules.iter().find(|module| module.name == instance.module);
            let is_output = |port: &String| of.is_some_and(|of| of.outputs.contains(port));
            for (port, nets) in &instance.connections {
                if is_output(port) {
                    driven.extend(nets.iter().map(|net| (net.as_str(), index)));
                }
            }
        }
        driven
    }

    /// Where a net's value comes from, and by which name.
    fn sources(&self, net: &str, driven: &BTreeMap<&str, usize>) -> BTreeSet<(End, String)> {
        let mut found = BTreeSet::new();
        let mut seen = BTreeSet::new();
        let mut waiting = vec![net.to_owned()];
        while let Some(net) = waiting.pop() {
            if !seen.insert(net.clone()) {
                continue;
            }
            if let Some(input) = self.inputs.iter().position(|input| *input == net) {
                found.insert((End::Input(input), net));
                continue;
            }
            if let Some(&instance) = driven.get(net.as_str()) {
                found.insert((End::Instance(instance), net));
                continue;
            }
            for statement in self.statements.iter().filter(|s| s.target == net) {
                match statement.is_register {
                    true => {
                        found.insert((End::Own, net.clone()));
                    }
                    false => waiting.extend(statement.from.iter().cloned()),
                }
            }
        }
        found
    }
}

impl Instance {
    fn read(statement: &str) -> Option<Instance> {
        let (head, ports) = statement.split_once("(\n")?;
        // Declarations may stand before it, and parameters between the module's name and its own.
        let (head, name, ports) = match head.trim_end().strip_suffix('#') {
            Some(head) => {
                let (parameters, ports) = ports.split_once("(\n")?;
                (head, parameters.split_whitespace().next_back()?, ports)
            }
            None => {
                let (head, name) = head.trim_end().rsplit_once(char::is_whitespace)?;
                (head, name, ports)
            }
        };
        let module = head.split_whitespace().next_back()?;
        let connections = ports.split('.').skip(1).filter_map(|connection| {
            let (port, net) = connection.split_once('(')?;
            let net = net.rsplit_once(')').map_or(net, |(net, _)| net);
            Some((port.trim().to_owned(), names(net).collect()))
        });
        Some(Instance {
            name: name.to_owned(),
            module: module.to_owned(),
            connections: connections.collect(),
        })
    }
}

/// The names in an expression, without numbers and words of Verilog.
fn names(expression: &str) -> impl Iterator<Item = String> + '_ {
    let words = expression.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == '\''));
    let is_name = |word: &&str| {
        let first = word.chars().next();
        let begins = first.is_some_and(|c| c.is_ascii_lowercase() || c == '_');
        begins && !matches!(*word, "if" | "else" | "begin" | "end" | "always" | "posedge" | "case")
    };
    words.filter(is_name).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "// a comment (\nmodule top (\n    input  wire i_clk, // clock\n    input  \
        wire [1:0] i_a,\n    output wire o_b,\n    output reg o_c\n);\n    wire inner;\n    wire \
        glue;\n\n    assign glue = inner & ~i_a[1];\n    assign o_b = glue;\n\n    leaf first (\n        \
        .i_clk (i_clk),\n        .i_x   (i_a[0]),\n        .o_y   (inner)\n    );\n\n    always \
        @(posedge i_clk) begin\n        if (glue) begin\n            o_c <= 1'b0;\n        end else \
        begin\n            o_c <= inner;\n        end\n    end\n\n`ifndef SYNTHESIS\n    check \
        again (\n        .i_x (glue)\n    );\n`endif\n\nendmodule\n";

    #[test]
    fn a_module_is_read_with_its_instances_and_what_drives_what() {
        let leaf = read("module leaf (\n input wire i_x,\n output wire o_y\n);\nendmodule\n");
        let (leaf, top) = (leaf.expect("a module"), read(TEXT).expect("a module"));
        assert_eq!((top.name.as_str(), &top.inputs), ("top", &vec!["i_a".to_owned()]));
        assert_eq!(top.outputs, ["o_b", "o_c"]);
        assert_eq!(top.instances.len(), 1, "{top:?}");
        assert_eq!(top.instances[0].name, "first");
        let found: Vec<(End, End)> = top.connections(&[leaf]).into_keys().collect();
        let expected = [
            (End::Input(0), End::Instance(0)),
            (End::Input(0), End::Own),
            (End::Input(0), End::Output(0)),
            (End::Instance(0), End::Own),
            (End::Instance(0), End::Output(0)),
            (End::Own, End::Output(1)),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn parameters_of_modules_and_instances_are_no_names() {
        let file =
            |name: &str, text: &str| EmittedFile { name: name.to_owned(), text: text.to_owned() };
        let memory = "module memory #(\n    parameter WORDS = (2),\n    parameter BITS = 1 // of a \
            word\n) (\n    input wire i_write,\n    input wire [BITS-1:0] i_row,\n    output wire \
            o_word\n);\n    reg words [0:WORDS-1];\n\n    VENDOR #(\n        .WIDTH(18)\n    ) ram \
            (\n        .CLK (i_clk)\n    );\n\n    always @(posedge i_clk) begin\n        \
            words[i_row] <= i_write;\n    end\nendmodule\n";
        let top = "module top (\n    input wire i_a,\n    output wire o_b\n);\n    wire b;\n\n    \
            memory #(\n        .WORDS(4), .BITS(2)\n    ) memory_0 (\n        .i_write (i_a),\n        \
            .o_word  (b)\n    );\n\n    assign o_b = b;\nendmodule\n";
        let modules = modules(&[file("memory.v", memory), file("top.v", top)]);
        let [memory, top] = modules.as_slice() else {
            panic!("{modules:?}");
        };
        assert_eq!(memory.name, "memory");
        assert_eq!(memory.inputs, ["i_write", "i_row"]);
        assert!(memory.instances.is_empty(), "{memory:?}");
        let of_memory: Vec<(End, End)> = memory.connections(&modules).into_keys().collect();
        assert_eq!(of_memory, [0, 1].map(|input| (End::Input(input), End::Own)));
        assert_eq!((&*top.instances[0].name, &*top.instances[0].module), ("memory_0", "memory"));
        let of_top: Vec<(End, End)> = top.connections(&modules).into_keys().collect();
        let expected = [(End::Input(0), End::Instance(0)), (End::Instance(0), End::Output(0))];
        assert_eq!(of_top, expected);
    }
}
