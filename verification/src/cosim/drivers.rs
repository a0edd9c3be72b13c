//! Nets that another circuit would come of: of several drivers, of a driver that lets go (z), or of
//! values that no circuit has; and what synthesis reads differently.
//!
//! Verilator takes the first driver of a net and a z for 0, mostly without a word; other
//! simulators show x, and synthesis refuses the net. Its own warning is of continuous
//! assignments alone, so the elaborated design is read here, from what `--xml-only` writes. Time
//! stands still in co-simulation, and random numbers are the same in each.
//! Only what is certain is a fault: of bits that an expression selects nothing is said.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use roxmltree::{Document, Node};

/// Part of a build's identity: changes with what is refused here, so that no model is kept that
/// would not be built now.
pub(super) const VERSION: &str = "drivers 2";

/// What is wrong with the nets of a design, each with its place: `FILE:LINE:COLUMN: ...`. A text
/// that is not understood, as of another version of Verilator, says nothing.
pub(super) fn faults(xml: &str) -> Vec<String> {
    let of = |module: Node, files: &Files| {
        let mut found = of_several_drivers(module, files);
        found.extend(of_high_impedance(module, files));
        found.extend(of_the_simulation(module, files));
        found.extend(of_races(module, files));
        found
    };
    of_modules(xml, of).unwrap_or_default()
}

/// What synthesis may make another circuit of, each with its place: a block that does not wait for
/// just what it reads, which synthesis takes for one that does; what a clocked block assigns at once
/// and others read, so that the order of blocks decides.
pub(super) fn other_circuits(xml: &str) -> Vec<String> {
    let of = |module: Node, files: &Files| {
        let mut found = of_lists(module, files);
        found.extend(of_order(module, files));
        found
    };
    of_modules(xml, of).unwrap_or_else(|| vec!["Verilator's design cannot be read".to_owned()])
}

/// An x as a value, each with its place.
pub(super) fn undefined_values(xml: &str) -> Vec<String> {
    let of = |module: Node, files: &Files| {
        values_with('x', module).map(|x| format!("{}: an x", place(x, files))).collect()
    };
    of_modules(xml, of).unwrap_or_default()
}

/// What is found in any module, without repetitions; none of what is not a design.
fn of_modules(xml: &str, of: impl Fn(Node, &Files) -> Vec<String>) -> Option<Vec<String>> {
    let document = Document::parse(xml).ok()?;
    let files = document.descendants().filter(|node| node.has_tag_name("file"));
    let files: Files = files
        .filter_map(|file| Some((file.attribute("id")?, file.attribute("filename")?)))
        .collect();
    let modules = document.descendants().filter(|node| node.has_tag_name("module"));
    let found: BTreeSet<String> = modules.flat_map(|module| of(module, &files)).collect();
    Some(found.into_iter().collect())
}

fn is_clocked(block: Node) -> bool {
    let mut items = block.descendants().filter(|node| node.has_tag_name("senitem"));
    items.any(|item| matches!(item.attribute("edgeType"), Some("POS" | "NEG")))
}

fn of_lists(module: Node, files: &Files) -> Vec<String> {
    let blocks = module.descendants().filter(|node| node.has_tag_name("always"));
    let told = blocks.filter_map(|block| {
        let mut items = block.descendants().filter(|node| node.has_tag_name("senitem"));
        let item = items.find(|item| !matches!(item.attribute("edgeType"), Some("POS" | "NEG")))?;
        let place = place(item, files);
        (!waits_for_all(block)).then(|| format!("{place}: a list that is not what its block reads"))
    });
    told.collect()
}

/// Whether a block waits for each net that it reads and for nothing else, and keeps nothing from one
/// time to the next. What a function reads is not looked at.
fn waits_for_all(block: Node) -> bool {
    let elements = || block.descendants().filter(Node::is_element);
    let assignments =
        elements().filter(|node| node.has_tag_name("assign") || node.has_tag_name("assigndly"));
    let targets: Vec<Node> =
        assignments.filter_map(|node| node.last_element_child()).flat_map(bases).collect();
    let mut awaited = BTreeSet::new();
    let mut read = BTreeSet::new();
    for node in elements() {
        match node.tag_name().name() {
            "senitem" => {
                let net = node.first_element_child().filter(|net| net.has_tag_name("varref"));
                match (node.attribute("edgeType"), net) {
                    (Some("CHANGED"), Some(net)) => awaited.insert(net.attribute("name")),
                    _ => return false,
                };
            }
            "funcref" | "taskref" => return false,
            "varref" if !targets.contains(&node) && !is_awaited(node) => {
                read.insert(node.attribute("name"));
            }
            _ => {}
        }
    }
    read == awaited && targets.iter().all(|net| !read.contains(&net.attribute("name")))
}

fn is_awaited(net: Node) -> bool {
    net.parent().is_some_and(|node| node.has_tag_name("senitem"))
}

/// The references to the nets of a target, without those of its indices.
fn bases<'a, 'd>(target: Node<'a, 'd>) -> Vec<Node<'a, 'd>> {
    let mut children = target.children().filter(Node::is_element);
    match target.tag_name().name() {
        "varref" => vec![target],
        "concat" => children.flat_map(bases).collect(),
        _ => children.next().map_or_else(Vec::new, bases),
    }
}

fn of_order(module: Node, files: &Files) -> Vec<String> {
    let references = || module.descendants().filter(|node| node.has_tag_name("varref"));
    let blocks = module.descendants().filter(|node| node.has_tag_name("always"));
    let at_once = blocks.filter(|&block| is_clocked(block)).flat_map(|block| {
        let assigned = block.descendants().filter(|node| node.has_tag_name("assign"));
        assigned.map(move |assignment| (block, assignment))
    });
    let told = at_once.filter_map(|(block, assignment)| {
        let target = assignment.last_element_child()?;
        let mut names = target.descendants().filter_map(|node| node.attribute("name"));
        let is_read = names.any(|name| {
            references().any(|reference| {
                reference.attribute("name") == Some(name)
                    && !reference.ancestors().any(|node| node == block)
            })
        });
        let place = place(assignment, files);
        is_read.then(|| {
            format!("{place}: what is assigned at once at a clock's edge is read elsewhere")
        })
    });
    told.collect()
}

/// What one block assigns at once at a clock's edge and another one reads at the same edge.
fn of_races(module: Node, files: &Files) -> Vec<String> {
    let edge = |block: Node| {
        let item = block.descendants().find(|node| node.has_tag_name("senitem"))?;
        let net = item.first_element_child()?.attribute("name")?;
        Some((item.attribute("edgeType")?.to_owned(), net.to_owned()))
    };
    let blocks: Vec<Node> = module
        .descendants()
        .filter(|node| node.has_tag_name("always") && is_clocked(*node))
        .collect();
    let assigned: Vec<BTreeSet<&str>> = blocks
        .iter()
        .map(|block| {
            let assignments = block.descendants().filter(|node| node.has_tag_name("assign"));
            let targets = assignments.filter_map(|node| node.last_element_child());
            targets.flat_map(bases).filter_map(|net| net.attribute("name")).collect()
        })
        .collect();
    let mut found = Vec::new();
    for (writer, names) in blocks.iter().zip(&assigned) {
        for (reader, own) in blocks.iter().zip(&assigned) {
            if writer == reader || edge(*writer) != edge(*reader) {
                continue;
            }
            // A variable that both assign, as one that counts loops, is each block's own.
            let raced = reader.descendants().find(|net| {
                let name = net.attribute("name").unwrap_or_default();
                net.has_tag_name("varref") && names.contains(name) && !own.contains(name)
            });
            found.extend(raced.map(|net| {
                format!(
                    "{}: {} is read here at the edge at which the block at {} assigns it at once (=): \
                     simulators differ in which comes first",
                    place(net, files),
                    net.attribute("name").unwrap_or_default(),
                    place(*writer, files)
                )
            }));
        }
    }
    found
}

/// Names of the files by their short ones.
type Files<'d> = BTreeMap<&'d str, &'d str>;

/// What drives some bits of a net.
struct Driver<'a, 'd> {
    /// The assignment, the block or the port of an instance: what counts as one.
    by: Node<'a, 'd>,
    /// Bits, all of them without a selection.
    bits: Range<u64>,
}

/// A net: the number of the module, or the block of a generate, that declares it, and its name.
type Net<'d> = (u32, &'d str);

/// What a module declares.
struct Declared<'d> {
    /// All names, and whether they are nets of bits.
    names: BTreeMap<Net<'d>, bool>,
    /// Names that count loops, which blocks may share.
    counters: BTreeSet<&'d str>,
}

impl<'d> Declared<'d> {
    fn of(module: Node<'d, '_>) -> Declared<'d> {
        let declarations = module.descendants().filter(|node| node.has_tag_name("var"));
        let names = declarations.filter_map(|node| {
            let net = (node.parent()?.id().get(), node.attribute("name")?);
            Some((net, node.attribute("vartype") == Some("logic")))
        });
        let loops = module.descendants().filter(|node| node.has_tag_name("while"));
        let assigned = loops.flat_map(|node| node.descendants()).filter_map(|node| {
            let target = node.last_element_child().filter(|_| node.has_tag_name("assign"))?;
            target.attribute("name").filter(|_| target.has_tag_name("varref"))
        });
        Declared { names: names.collect(), counters: assigned.collect() }
    }

    /// The net that a reference names, if it is one of bits. Assignments of a generate stand
    /// beside its blocks: a name that is not declared round its reference is nobody's.
    fn net(&self, reference: Node<'d, '_>) -> Option<Net<'d>> {
        let name = reference.attribute("name").filter(|name| !self.counters.contains(name))?;
        let mut scopes = reference.ancestors().map(|scope| (scope.id().get(), name));
        let (net, is_of_bits) = scopes.find_map(|net| Some((net, *self.names.get(&net)?)))?;
        is_of_bits.then_some(net)
    }

    /// The nets and bits of a target. None of a memory, of a variable that counts loops, and of
    /// bits that depend on others.
    fn driven(&self, target: Node<'d, '_>) -> Vec<(Net<'d>, Range<u64>)> {
        let mut children = target.children().filter(Node::is_element);
        match target.tag_name().name() {
            "concat" => children.flat_map(|child| self.driven(child)).collect(),
            "varref" => self.net(target).map(|net| (net, 0..u64::MAX)).into_iter().collect(),
            "sel" => {
                let of = children.next().filter(|of| of.has_tag_name("varref"));
                let net = of.and_then(|of| self.net(of));
                let mut next = || children.next().and_then(number);
                match (net, next(), next()) {
                    (Some(net), Some(from), Some(width)) => {
                        vec![(net, from..from.saturating_add(width))]
                    }
                    _ => Vec::new(),
                }
            }
            _ => Vec::new(),
        }
    }
}

fn of_several_drivers(module: Node, files: &Files) -> Vec<String> {
    let declared = Declared::of(module);
    let mut nets: BTreeMap<Net, Vec<Driver>> = BTreeMap::new();
    for by in module.descendants() {
        for target in targets(by) {
            for (net, bits) in declared.driven(target) {
                nets.entry(net).or_default().push(Driver { by, bits });
            }
        }
    }
    let mut faults = Vec::new();
    for ((_, name), drivers) in nets {
        let overlap = |a: &Driver, b: &Driver| {
            let is_start = |driver: &Driver| driver.by.has_tag_name("initial");
            let is_register =
                |driver: &Driver| is_start(driver) || driver.by.has_tag_name("always");
            // A register may have a value at power-up. Of a net that is a constant Verilator
            // writes the same.
            let starts = is_start(a) && is_register(b) || is_start(b) && is_register(a);
            let share_bits = a.bits.start < b.bits.end && b.bits.start < a.bits.end;
            a.by != b.by && !starts && share_bits
        };
        let pair = drivers.iter().enumerate().find_map(|(at, driver)| {
            Some((driver, drivers[..at].iter().find(|other| overlap(driver, other))?))
        });
        if let Some((driver, other)) = pair {
            faults.push(format!(
                "{}: {name} has another driver at {}; a net has one",
                place(driver.by, files),
                place(other.by, files)
            ));
        }
    }
    faults
}

/// The expressions that an assignment, a block or an instance drives, if that is what a node is.
fn targets<'a, 'd>(node: Node<'a, 'd>) -> Vec<Node<'a, 'd>> {
    let assigned = |assignment: Node<'a, 'd>| assignment.last_element_child();
    match node.tag_name().name() {
        "contassign" => assigned(node).into_iter().collect(),
        "port" if node.attribute("direction") == Some("out") => {
            node.last_element_child().into_iter().collect()
        }
        "initial" => {
            node.descendants().filter(|n| n.has_tag_name("assign")).filter_map(assigned).collect()
        }
        "always" => {
            let is_clocked = is_clocked(node);
            // What a clocked block assigns at once may be a variable of its own, shared by name.
            let is_driver =
                |n: &Node| n.has_tag_name("assigndly") || n.has_tag_name("assign") && !is_clocked;
            node.descendants().filter(is_driver).filter_map(assigned).collect()
        }
        _ => Vec::new(),
    }
}

/// A number of digits alone: `32'h1f`.
fn number(node: Node) -> Option<u64> {
    let (_, digits) = node.attribute("name")?.split_once('\'')?;
    let digits = digits.strip_prefix('s').unwrap_or(digits).strip_prefix('h')?;
    u64::from_str_radix(digits, 16).ok()
}

fn of_high_impedance(module: Node, files: &Files) -> Vec<String> {
    let what = "z is not a value of a sensor's net: it has one driver, and that says 0 or 1";
    values_with('z', module).map(|value| format!("{}: {what}", place(value, files))).collect()
}

/// What a simulator has and no circuit: the time, random numbers, words of its command line. What is
/// only printed is left alone.
const OF_SIMULATION: [(&str, &str); 8] = [
    ("time", "the time"),
    ("timed", "the time"),
    ("rand", "a random number"),
    ("randrng", "a random number"),
    ("urandom", "a random number"),
    ("urandomrange", "a random number"),
    ("testplusargs", "a word of the command line"),
    ("valueplusargs", "a word of the command line"),
];

fn of_the_simulation(module: Node, files: &Files) -> Vec<String> {
    let told = |node: Node| {
        let (_, what) = OF_SIMULATION.iter().find(|(name, _)| node.has_tag_name(*name))?;
        let is_assignment =
            |n: &Node| ["assign", "assigndly", "contassign"].iter().any(|&tag| n.has_tag_name(tag));
        let decides = node.ancestors().find_map(|n| match n.tag_name().name() {
            "display" | "sformatf" => Some(false),
            "if" | "case" | "while" => n.descendants().any(|n| is_assignment(&n)).then_some(true),
            _ => is_assignment(&n).then_some(true),
        });
        let place = place(node, files);
        (decides == Some(true))
            .then(|| format!("{place}: {what} is not a value of a circuit's net"))
    };
    module.descendants().filter_map(told).collect()
}

/// Values with such a digit, not those of a case's or a comparison's pattern.
fn values_with<'a, 'd>(digit: char, module: Node<'a, 'd>) -> impl Iterator<Item = Node<'a, 'd>> {
    let has_digit = move |node: &Node| {
        let digits = node.attribute("name").and_then(|name| name.split_once('\''));
        node.has_tag_name("const") && digits.is_some_and(|(_, digits)| digits.contains(digit))
    };
    let is_value = |node: &Node| {
        let around = node.ancestors().find_map(|n| match n.tag_name().name() {
            "assign" | "assigndly" | "contassign" | "port" | "if" => Some(true),
            "caseitem" | "eqwild" | "neqwild" | "eqcase" | "neqcase" => Some(false),
            _ => None,
        });
        around == Some(true)
    };
    module.descendants().filter(has_digit).filter(is_value)
}

/// `FILE:LINE:COLUMN`.
fn place(node: Node, files: &Files) -> String {
    let mut parts = node.attribute("loc").unwrap_or_default().split(',');
    let file = parts.next().unwrap_or_default();
    let (line, column) = (parts.next().unwrap_or("1"), parts.next().unwrap_or("1"));
    format!("{}:{line}:{column}", files.get(file).unwrap_or(&file))
}

#[cfg(test)]
mod tests {
    use super::{faults, other_circuits, undefined_values};

    /// What Verilator 5.006 writes, shortened to what is read.
    fn design(items: &str) -> String {
        let vars: String = ["a", "b", "clk"]
            .map(|name| format!("<var loc=\"c,1,1,1,2\" name=\"{name}\" vartype=\"logic\"/>"))
            .concat();
        format!(
            "<verilator_xml><files><file id=\"c\" filename=\"rtl/x.v\"/></files><netlist>\
             <module loc=\"c,1,1,1,2\" name=\"x\">{vars}<var name=\"i\" vartype=\"integer\"/>{items}\
             </module></netlist></verilator_xml>"
        )
    }

    fn assign(line: u32, to: &str) -> String {
        let one = "<const name=\"1'h1\"/>";
        format!("<contassign loc=\"c,{line},5,{line},6\">{one}{to}</contassign>")
    }

    fn bits(name: &str, from: u32, width: u32) -> String {
        format!(
            "<sel><varref name=\"{name}\"/><const name=\"32'h{from:x}\"/>\
             <const name=\"32'sh{width:x}\"/></sel>"
        )
    }

    const WHOLE: &str = "<varref name=\"a\"/>";

    #[test]
    fn a_net_of_two_drivers_is_named_with_both() {
        let instance = "<instance name=\"s\"><port loc=\"c,9,7,9,8\" direction=\"out\">\
                        <varref name=\"a\"/></port></instance>";
        let clocked = "<always loc=\"c,9,7,9,8\"><sentree><senitem edgeType=\"POS\"/></sentree>\
                       <assigndly><const name=\"1'h1\"/><varref name=\"a\"/></assigndly></always>";
        let constant =
            format!("<initial loc=\"c,4,5,4,6\"><assign><const/>{WHOLE}</assign></initial>");
        assert_eq!(faults(&design(&(constant.clone() + instance))).len(), 1);
        assert_eq!(faults(&design(&(constant + clocked))), [""; 0], "a value at power-up");
        for other in [instance.to_owned(), clocked.to_owned(), assign(9, &bits("a", 3, 2))] {
            for one in [assign(4, WHOLE), assign(4, &bits("a", 4, 1))] {
                let found = faults(&design(&(one + &other)));
                assert_eq!(found.len(), 1, "{other}: {found:?}");
                let places = ["rtl/x.v:4:5", "rtl/x.v:9:"];
                assert!(places.iter().all(|place| found[0].contains(place)), "{found:?}");
            }
        }
    }

    #[test]
    fn other_bits_loops_and_local_names_are_no_second_driver() {
        let block = |name: &str| {
            format!(
                "<always><sentree><senitem edgeType=\"POS\"/></sentree><assign><const name=\"1'h1\"/>\
                 <varref name=\"{name}\"/></assign></always>"
            )
        };
        let scope = |line| {
            format!(
                "<begin name=\"g\"><var name=\"a\" vartype=\"logic\"/>{}</begin>",
                assign(line, WHOLE)
            )
        };
        for items in [
            assign(4, &bits("a", 0, 2)) + &assign(5, &bits("a", 2, 2)),
            block("i") + &block("i"),
            block("a") + &block("a"),
            assign(4, WHOLE) + &assign(5, "<varref name=\"b\"/>"),
            scope(4) + &scope(5),
        ] {
            assert_eq!(faults(&design(&items)), [""; 0], "{items}");
        }
        assert_eq!(faults("no such text"), [""; 0]);
    }

    #[test]
    fn z_is_refused_as_a_value_and_not_as_a_pattern() {
        let z = "<const loc=\"c,6,2,6,3\" name=\"1'bz\"/>";
        let value = format!("<contassign><cond>{z}</cond>{WHOLE}</contassign>");
        let found = faults(&design(&value));
        assert!(found.len() == 1 && found[0].starts_with("rtl/x.v:6:2: z"), "{found:?}");
        let pattern = format!("<always><case><caseitem>{z}</caseitem></case></always>");
        assert_eq!(faults(&design(&pattern)), [""; 0]);
    }

    #[test]
    fn what_synthesis_reads_differently_is_named() {
        let list = |names: &[&str], body: &str| {
            let items: String = names
                .iter()
                .map(|name| {
                    format!(
                        "<senitem loc=\"c,3,2,3,3\" edgeType=\"CHANGED\"><varref name=\"{name}\"/></senitem>"
                    )
                })
                .collect();
            format!("<always><sentree>{items}</sentree>{body}</always>")
        };
        let or = "<assign><or><varref name=\"a\"/><varref name=\"b\"/></or><varref name=\"i\"/></assign>";
        let at_once = |other: &str| {
            format!(
                "<always><sentree><senitem edgeType=\"POS\"/></sentree><assign loc=\"c,3,2,3,3\">\
                 <const name=\"1'h1\"/>{WHOLE}</assign></always>{other}"
            )
        };
        let read = format!("<contassign>{WHOLE}<varref name=\"b\"/></contassign>");
        for (items, told) in [
            (list(&["a"], or), "a list"),
            (list(&["a", "b", "clk"], or), "a list"),
            (list(&["a", "b"], "<assign><funcref/><varref name=\"i\"/></assign>"), "a list"),
            (list(&["a"], &format!("<assign><not>{WHOLE}</not>{WHOLE}</assign>")), "a list"),
            (at_once(&read), "read elsewhere"),
        ] {
            let found = other_circuits(&design(&items));
            assert!(found.len() == 1 && found[0].starts_with("rtl/x.v:3:2: "), "{found:?}");
            assert!(found[0].contains(told), "{found:?}");
        }
        for same in [at_once(""), list(&["a", "b"], or)] {
            assert_eq!(other_circuits(&design(&same)), [""; 0], "{same}");
        }
        assert_eq!(other_circuits("no such text").len(), 1);
        let x = "<contassign><const loc=\"c,3,2,3,3\" name=\"2'b1x\"/><varref name=\"b\"/></contassign>";
        assert_eq!(undefined_values(&design(x)), ["rtl/x.v:3:2: an x"]);
    }

    #[test]
    fn a_race_of_two_blocks_is_refused_with_both_places() {
        let block = |line: u32, edge: &str, body: String| {
            format!(
                "<always loc=\"c,{line},1,{line},7\"><sentree><senitem edgeType=\"{edge}\"><varref \
                 name=\"clk\"/></senitem></sentree>{body}</always>"
            )
        };
        let at_once =
            |value: &str, to: &str| format!("<assign>{value}<varref name=\"{to}\"/></assign>");
        let one = "<const name=\"1'h1\"/>";
        let a = "<varref loc=\"c,7,2,7,3\" name=\"a\"/>";
        let later = format!("<assigndly>{a}<varref name=\"b\"/></assigndly>");
        let writer = block(3, "POS", at_once(one, "a"));
        let found = faults(&design(&(writer.clone() + &block(7, "POS", later.clone()))));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].starts_with("rtl/x.v:7:2: a is read") && found[0].contains("rtl/x.v:3:1"));
        for other in [
            block(7, "NEG", later.clone()),
            block(7, "POS", at_once(one, "a") + &later),
            format!("<contassign>{a}<varref name=\"b\"/></contassign>"),
        ] {
            assert_eq!(faults(&design(&(writer.clone() + &other))), [""; 0], "{other}");
        }
        let alone = block(3, "POS", at_once(one, "a") + &later);
        assert_eq!(faults(&design(&alone)), [""; 0]);
    }

    #[test]
    fn what_only_a_simulation_has_is_refused_where_it_decides() {
        let time = "<time loc=\"c,6,2,6,3\"/>";
        let assigned = format!("<assigndly>{time}{WHOLE}</assigndly>");
        let clocked = |body: &str| {
            format!("<always><sentree><senitem edgeType=\"POS\"/></sentree>{body}</always>")
        };
        let set = format!("<assigndly><const name=\"1'h1\"/>{WHOLE}</assigndly>");
        let printed = format!("<display><sformatf>{time}</sformatf></display>");
        for decides in
            [clocked(&assigned), clocked(&format!("<if>{time}<begin>{set}</begin></if>"))]
        {
            let found = faults(&design(&decides));
            assert!(found.len() == 1 && found[0].starts_with("rtl/x.v:6:2: the time"), "{found:?}");
        }
        for harmless in
            [clocked(&printed), clocked(&format!("<if>{time}<begin>{printed}</begin></if>"))]
        {
            assert_eq!(faults(&design(&harmless)), [""; 0]);
        }
    }
}
