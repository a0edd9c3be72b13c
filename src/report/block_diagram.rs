//! The emitted modules and their connections, drawn.

use super::figure::shortened;
use super::layers::{Layers, Slot, layers};
use super::prelude::*;
use crate::rtl::back::{Connections, End, ModuleNetlist};

const WIDTH: f64 = 480.0;
const MARGIN: f64 = 8.0;
const ROOM: f64 = WIDTH - 2.0 * MARGIN;
/// Height of a box, and from one layer to the next.
const BOX: f64 = 38.0;
const PITCH: f64 = 76.0;
/// Least space between two places.
const GAP: f64 = 10.0;
/// Width of edges that pass a layer.
const PASSING: f64 = 4.0;
/// Width of a character of a label, and of a name in bold.
const CHARACTER: f64 = 6.6;
const BOLD_CHARACTER: f64 = 8.0;
/// Longest label that is shown whole.
const LONGEST: usize = 22;
/// Fewest of a kind, numbered from one to the next, that are drawn as one.
const LEAST_FAMILY: usize = 3;

/// A node as it is drawn.
struct Node {
    end: Vec<End>,
    lines: Vec<String>,
    class: &'static str,
}

impl Node {
    fn height(&self) -> f64 {
        if self.class == "port" { 22.0 } else { BOX }
    }
}

/// A drawing of one module, and its connections in words.
pub(super) struct Diagram {
    pub figure: SvgFigure,
    /// From, to, nets.
    pub connections: Vec<[String; 3]>,
}

/// Draws each module that has others in it, the top module first.
pub(super) fn diagrams(modules: &[ModuleNetlist]) -> Vec<Diagram> {
    let with_others = modules.iter().rev().filter(|module| !module.instances.is_empty());
    with_others.map(diagram).collect()
}

fn diagram(module: &ModuleNetlist) -> Diagram {
    let connections = module.connections();
    let nodes = nodes(module, &connections);
    let number = |end: &End| nodes.iter().position(|node| node.end.contains(end));
    let mut edges: Vec<(usize, usize)> = connections
        .keys()
        .filter_map(|(from, to)| Some((number(from)?, number(to)?)))
        .filter(|(from, to)| from != to)
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let of_kind = |wanted: fn(&End) -> bool| -> Vec<usize> {
        (0..nodes.len()).filter(|&n| nodes[n].end.iter().any(wanted)).collect()
    };
    let inputs = of_kind(|end| matches!(end, End::Input(_)));
    let outputs = of_kind(|end| matches!(end, End::Output(_)));
    let fits = |row: &[Slot]| {
        let taken: f64 = row.iter().map(|slot| width(*slot, &nodes) + GAP).sum();
        taken - GAP <= ROOM
    };
    let placed = layers(nodes.len(), &edges, &inputs, &outputs, fits);
    let drawing = Drawing::of(&placed, &nodes);
    let instances: Vec<String> = module
        .instances
        .iter()
        .map(|instance| format!("{} ({})", instance.name, instance.module))
        .collect();
    let id = format!("module-{}", module.name.replace('_', "-"));
    Diagram {
        figure: SvgFigure {
            id: id.clone(),
            title: module.name.clone(),
            description: format!(
                "Block diagram of module {}: inputs above, outputs below, between them {}. Clock and \
                 reset go to every block and are not drawn.",
                module.name,
                instances.join(", ")
            ),
            size: (WIDTH, drawing.height),
            wide: false,
            content: drawn(&id, &placed, &drawing, &nodes, &edges),
        },
        connections: in_words(module, &connections),
    }
}

/// Ports of one interface together, instances, and the module's own registers. What is
/// numbered and of one kind is one node.
fn nodes(module: &ModuleNetlist, connections: &Connections) -> Vec<Node> {
    let mut nodes: Vec<Node> = Vec::new();
    let mut ports = |names: &[String], end: fn(usize) -> End| {
        let of_stream = |name: &str| name.starts_with("m_axis_");
        let stream: Vec<usize> = (0..names.len()).filter(|&i| of_stream(&names[i])).collect();
        let mut groups = families(names.iter().map(|name| (name.as_str(), "")));
        groups.retain(|family| !of_stream(&names[family.members[0]]));
        if let Some(&first) = stream.first() {
            let before = groups.iter().filter(|family| family.members[0] < first);
            let family = NumberedNames { name: "m_axis".to_owned(), members: stream };
            groups.insert(before.count(), family);
        }
        nodes.extend(groups.into_iter().map(|family| Node {
            lines: vec![shortened(&family.name, LONGEST)],
            end: family.members.into_iter().map(end).collect(),
            class: "port",
        }));
    };
    ports(&module.inputs, End::Input);
    ports(&module.outputs, End::Output);
    let instances = module.instances.iter();
    let instances = families(instances.map(|instance| (&*instance.name, &*instance.module)));
    nodes.extend(instances.into_iter().map(|family| {
        let of = shortened(&module.instances[family.members[0]].module, LONGEST);
        let of = match family.members.len() {
            1 => of,
            number => format!("{number} \u{d7} {of}"),
        };
        Node {
            end: family.members.into_iter().map(End::Instance).collect(),
            lines: vec![shortened(&family.name, LONGEST), of],
            class: "block",
        }
    }));
    let is_own = |(from, to): &(End, End)| *from == End::Own || *to == End::Own;
    if connections.keys().any(is_own) {
        nodes.push(Node {
            end: vec![End::Own],
            lines: vec!["own registers".to_owned()],
            class: "own",
        });
    }
    nodes
}

/// What is drawn as one, and its name.
struct NumberedNames {
    name: String,
    members: Vec<usize>,
}

/// Names that differ in a number alone, which grows by one from each to the next, and that are
/// of one kind: `bank_0 to 7`. Each of the others is alone.
fn families<'a>(names: impl Iterator<Item = (&'a str, &'a str)>) -> Vec<NumberedNames> {
    let names: Vec<(&str, &str)> = names.collect();
    let numbered = |index: usize| {
        let (name, kind) = *names.get(index)?;
        let (stem, number) = name.rsplit_once('_')?;
        Some((stem, kind, number.parse::<usize>().ok()?))
    };
    let mut families = Vec::new();
    let mut first = 0;
    while let Some((name, _)) = names.get(first) {
        let mut family = NumberedNames { name: (*name).to_owned(), members: vec![first] };
        if let Some((stem, kind, from)) = numbered(first) {
            let follows = |index: &usize| {
                numbered(*index) == Some((stem, kind, from.saturating_add(index - first)))
            };
            let end = (first..names.len()).find(|index| !follows(index));
            let end = end.unwrap_or(names.len());
            if end - first >= LEAST_FAMILY {
                family.name = format!("{name} to {}", from + (end - first - 1));
                family.members = (first..end).collect();
            }
        }
        first += family.members.len();
        families.push(family);
    }
    families
}

/// What stands where: centres in the rows.
struct Drawing {
    /// Row by row, along the row.
    along: Vec<BTreeMap<Slot, f64>>,
    height: f64,
}

impl Drawing {
    fn of(layers: &Layers, nodes: &[Node]) -> Drawing {
        let mut along = layers.places(ROOM, GAP, |slot| width(slot, nodes));
        // In the middle of the drawing.
        let ends = along.iter().flatten().map(|(slot, x)| (x, width(*slot, nodes) / 2.0));
        let (left, right) = ends.fold((ROOM, 0.0_f64), |(left, right), (x, half)| {
            (left.min(x - half), right.max(x + half))
        });
        let shift = (ROOM - left - right) / 2.0;
        along.iter_mut().flatten().for_each(|(_, x)| *x += shift);
        let height = 2.0 * MARGIN + BOX + PITCH * (along.len().max(1) - 1) as f64;
        Drawing { along, height }
    }

    fn centre(&self, layer: usize, slot: Slot) -> (f64, f64) {
        let along = self.along[layer].get(&slot).copied().unwrap_or(0.0);
        (MARGIN + along, MARGIN + BOX / 2.0 + layer as f64 * PITCH)
    }
}

fn width(slot: Slot, nodes: &[Node]) -> f64 {
    match slot {
        Slot::Passing(_) => PASSING,
        Slot::Node(node) => {
            let lines = &nodes[node].lines;
            let is_bold = |line: usize| line == 0 && lines.len() > 1;
            let widths = lines.iter().enumerate().map(|(number, line)| {
                let character = if is_bold(number) { BOLD_CHARACTER } else { CHARACTER };
                line.chars().count() as f64 * character
            });
            widths.fold(0.0, f64::max) + 14.0
        }
    }
}

fn drawn(
    id: &str,
    layers: &Layers,
    drawing: &Drawing,
    nodes: &[Node],
    edges: &[(usize, usize)],
) -> Markup {
    let arrow = format!("{id}-arrow");
    html! {
        defs {
            marker id=(arrow) viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7"
                orient="auto-start-reverse" {
                path class="arrow" d="M0,0 L8,4 L0,8 z" {}
            }
        }
        @for edge in edges {
            path class="wire" d=(wire(layers, drawing, nodes, *edge)) marker-end={ "url(#" (arrow) ")" } {}
        }
        @for (layer, row) in layers.rows.iter().enumerate() {
            @for slot in row {
                @if let Slot::Node(node) = slot {
                    (block(&nodes[*node], drawing.centre(layer, *slot), width(*slot, nodes)))
                }
            }
        }
    }
}

fn block(node: &Node, (x, y): (f64, f64), width: f64) -> Markup {
    let height = node.height();
    html! {
        rect class=(node.class) x=(coordinate(x - width / 2.0)) y=(coordinate(y - height / 2.0))
            width=(coordinate(width)) height=(coordinate(height)) rx="5" {}
        @if let [name, module] = node.lines.as_slice() {
            (label(x, y - 3.0, "middle strong", name))
            (label(x, y + 12.0, "middle small", module))
        } @else {
            (label(x, y + 4.0, "middle small", node.lines.first().map_or("", String::as_str)))
        }
    }
}

/// A line through the layers between: upright where it passes them, and smooth from one to the next.
fn wire(layers: &Layers, drawing: &Drawing, nodes: &[Node], edge: (usize, usize)) -> String {
    let is_upward = layers.layer_of[edge.1] < layers.layer_of[edge.0];
    let (sign, aside) = if is_upward { (-1.0, 14.0) } else { (1.0, 0.0) };
    let way = layers.way(edge);
    let ends: Vec<[(f64, f64); 2]> = way
        .into_iter()
        .map(|(layer, slot)| {
            let (x, y) = drawing.centre(layer, slot);
            let (x, half) = match slot {
                Slot::Node(node) => (x + aside, nodes[node].height() / 2.0),
                Slot::Passing(_) => (x, BOX / 2.0),
            };
            [(x, y - sign * half), (x, y + sign * half)]
        })
        .collect();
    let [_, (x, y)] = ends[0];
    let mut path = format!("M{},{}", coordinate(x), coordinate(y));
    for (number, pair) in ends.windows(2).enumerate() {
        let ((x0, y0), [(x1, y1), (_, leaves)]) = (pair[0][1], pair[1]);
        let bend = (y1 - y0) / 2.0;
        let [a, b, c, d, e, f] = [x0, y0 + bend, x1, y1 - bend, x1, y1].map(coordinate);
        path += &format!(" C{a},{b} {c},{d} {e},{f}");
        if number + 2 < ends.len() {
            path += &format!(" V{}", coordinate(leaves));
        }
    }
    path
}

fn in_words(module: &ModuleNetlist, connections: &Connections) -> Vec<[String; 3]> {
    let name = |end: &End| match end {
        End::Input(index) => module.inputs[*index].clone(),
        End::Output(index) => module.outputs[*index].clone(),
        End::Instance(index) => module.instances[*index].name.clone(),
        End::Own => "own registers".to_owned(),
    };
    let rows = connections.iter();
    rows.map(|((from, to), nets)| {
        let nets: Vec<&str> = nets.iter().map(String::as_str).collect();
        [name(from), name(to), nets.join(", ")]
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn those_of_one_kind_that_are_numbered_are_drawn_as_one() {
        let told = |names: &[(&str, &str)]| {
            let families = families(names.iter().copied()).into_iter();
            families.map(|family| (family.name, family.members)).collect::<Vec<_>>()
        };
        let bank = |numbers: std::ops::Range<usize>| {
            numbers.map(|number| format!("bank_{number}")).collect::<Vec<_>>()
        };
        let alike = bank(0..8);
        let alike: Vec<(&str, &str)> = alike.iter().map(|name| (name.as_str(), "bank")).collect();
        assert_eq!(told(&alike), [("bank_0 to 7".to_owned(), (0..8).collect::<Vec<_>>())]);
        // Two of a kind, numbers with a gap, and modules that differ stay apart.
        let apart = [
            vec![("a_0", "x"), ("a_1", "x")],
            vec![("a_0", "x"), ("a_2", "x"), ("a_3", "x")],
            vec![("a_0", "x"), ("a_1", "y"), ("a_2", "z")],
            vec![("a", "x"), ("b_1", "x"), ("_", "x")],
        ];
        for names in apart {
            assert_eq!(told(&names).len(), names.len(), "{names:?}");
        }
        let mixed = [("m", ""), ("c_9", ""), ("c_10", ""), ("c_11", ""), ("n", "")];
        let expected = [("m", vec![0]), ("c_9 to 11", vec![1, 2, 3]), ("n", vec![4])];
        let expected = expected.map(|(name, members)| (name.to_owned(), members));
        assert_eq!(told(&mixed), expected);
    }

    #[test]
    fn no_block_is_cut_or_covers_another_and_no_edge_passes_beneath_one() {
        for number in 2..24 {
            let nodes: Vec<Node> = (0..number)
                .map(|index| Node {
                    end: vec![End::Instance(index)],
                    lines: vec!["x".repeat(3 + index % 19)],
                    class: "block",
                })
                .collect();
            // Each to three others, wherever they are.
            let edges: Vec<(usize, usize)> = (0..number)
                .flat_map(|from| [1, 5, 11].map(|more| (from, (from * 7 + more) % number)))
                .filter(|(from, to)| from != to)
                .collect();
            let fits = |row: &[Slot]| {
                row.iter().map(|slot| width(*slot, &nodes) + GAP).sum::<f64>() - GAP <= ROOM
            };
            let layers = layers(number, &edges, &[0], &[], fits);
            let drawing = Drawing::of(&layers, &nodes);
            for (layer, row) in layers.rows.iter().enumerate() {
                let ends = row.iter().map(|slot| {
                    let (x, half) = (drawing.centre(layer, *slot).0, width(*slot, &nodes) / 2.0);
                    (x - half, x + half)
                });
                let ends: Vec<(f64, f64)> = ends.collect();
                assert!(ends[0].0 >= MARGIN - 1e-6, "{number} {ends:?}");
                assert!(ends[ends.len() - 1].1 <= WIDTH - MARGIN + 1e-6, "{number} {ends:?}");
                // What passes is a slot of its own: upright, and apart from the blocks beside it.
                let is_apart = |pair: &[(f64, f64)]| pair[1].0 - pair[0].1 >= GAP - 1e-6;
                assert!(ends.windows(2).all(is_apart), "{number} {ends:?}");
            }
        }
    }
}
