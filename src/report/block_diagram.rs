//! The emitted modules and their connections, drawn.

use maud::{Markup, html};

use super::figure::{Figure, coordinate, label, shortened};
use super::layers::{Layers, Slot, layers};
use crate::rtl::back::{Connections, End, Netlist};

const WIDTH: f64 = 480.0;
const MARGIN: f64 = 8.0;
/// Height of a box, and from one layer to the next.
const BOX: f64 = 38.0;
const PITCH: f64 = 76.0;
/// From one line of a crowded row to the next, and the least space between two places.
const LINE: f64 = BOX + 6.0;
const LEAST_GAP: f64 = 2.0;
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

/// A drawing of one module, and its connections in words.
pub(super) struct Diagram {
    pub figure: Figure,
    /// From, to, nets.
    pub connections: Vec<[String; 3]>,
}

/// Draws each module that has others in it, the top module first.
pub(super) fn diagrams(modules: &[Netlist]) -> Vec<Diagram> {
    let with_others = modules.iter().rev().filter(|module| !module.instances.is_empty());
    with_others.map(diagram).collect()
}

fn diagram(module: &Netlist) -> Diagram {
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
    let placed = layers(nodes.len(), &edges, &inputs, &outputs);
    let places = Places::of(&placed, &nodes);
    let instances: Vec<String> = module
        .instances
        .iter()
        .map(|instance| format!("{} ({})", instance.name, instance.module))
        .collect();
    let id = format!("module-{}", module.name.replace('_', "-"));
    Diagram {
        figure: Figure {
            id: id.clone(),
            title: module.name.clone(),
            description: format!(
                "Block diagram of module {}: inputs above, outputs below, between them {}. Clock and \
                 reset go to every block and are not drawn.",
                module.name,
                instances.join(", ")
            ),
            size: (WIDTH, places.height),
            wide: false,
            content: drawing(&id, &placed, &places, &nodes, &edges),
        },
        connections: in_words(module, &connections),
    }
}

/// Ports of one interface together, instances, and the module's own registers. What is
/// numbered and of one kind is one node.
fn nodes(module: &Netlist, connections: &Connections) -> Vec<Node> {
    let mut nodes: Vec<Node> = Vec::new();
    let mut ports = |names: &[String], end: fn(usize) -> End| {
        let of_stream = |name: &str| name.starts_with("m_axis_");
        let stream: Vec<usize> = (0..names.len()).filter(|&i| of_stream(&names[i])).collect();
        let mut groups = families(names.iter().map(|name| (name.as_str(), "")));
        groups.retain(|family| !of_stream(&names[family.members[0]]));
        if let Some(&first) = stream.first() {
            let before = groups.iter().filter(|family| family.members[0] < first);
            let family = Family { name: "m_axis".to_owned(), members: stream };
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
struct Family {
    name: String,
    members: Vec<usize>,
}

/// Names that differ in a number alone, which grows by one from each to the next, and that are
/// of one kind: `bank_0 to 7`. Each of the others is alone.
fn families<'a>(names: impl Iterator<Item = (&'a str, &'a str)>) -> Vec<Family> {
    let names: Vec<(&str, &str)> = names.collect();
    let numbered = |index: usize| {
        let (name, kind) = *names.get(index)?;
        let (stem, number) = name.rsplit_once('_')?;
        Some((stem, kind, number.parse::<usize>().ok()?))
    };
    let mut families = Vec::new();
    let mut first = 0;
    while let Some((name, _)) = names.get(first) {
        let mut family = Family { name: (*name).to_owned(), members: vec![first] };
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

/// Centres of what stands in the rows.
struct Places {
    /// Row by row, as in the layers.
    centres: Vec<Vec<(f64, f64)>>,
    height: f64,
}

impl Places {
    fn of(layers: &Layers, nodes: &[Node]) -> Places {
        let mut y = MARGIN + BOX / 2.0;
        let mut centres = Vec::new();
        for row in &layers.rows {
            let widths: Vec<f64> = row.iter().map(|place| width(place, nodes)).collect();
            let lines = lines(&widths);
            let mut places = vec![(0.0, 0.0); row.len()];
            for line in 0..lines {
                let on_line: Vec<usize> = (line..row.len()).step_by(lines).collect();
                let gap = gap(on_line.iter().map(|&index| widths[index]));
                let mut x = MARGIN + gap;
                for index in on_line {
                    places[index] = (x + widths[index] / 2.0, y + line as f64 * LINE);
                    x += widths[index] + gap;
                }
            }
            centres.push(places);
            y += PITCH + (lines - 1) as f64 * LINE;
        }
        Places { centres, height: y - PITCH + BOX / 2.0 + MARGIN }
    }

    fn centre(&self, layers: &Layers, layer: usize, place: Slot) -> (f64, f64) {
        let index = layers.rows[layer].iter().position(|&other| other == place);
        index.map_or((0.0, 0.0), |index| self.centres[layer][index])
    }
}

/// Space between what stands on a line, and beside it.
fn gap(widths: impl Iterator<Item = f64>) -> f64 {
    let (number, taken) = widths.fold((0.0, 0.0), |(n, sum), width| (n + 1.0, sum + width));
    (WIDTH - 2.0 * MARGIN - taken) / (number + 1.0)
}

/// Lines that a row needs, on which its places take turns.
fn lines(widths: &[f64]) -> usize {
    let fits = |lines: &usize| {
        (0..*lines).all(|line| {
            let on_line = widths.iter().skip(line).step_by(*lines);
            gap(on_line.copied()) >= LEAST_GAP
        })
    };
    (1..widths.len()).find(fits).unwrap_or(widths.len().max(1))
}

fn width(place: &Slot, nodes: &[Node]) -> f64 {
    match place {
        Slot::Passing(_) => 8.0,
        Slot::Node(node) => {
            let lines = &nodes[*node].lines;
            let is_bold = |line: usize| line == 0 && lines.len() > 1;
            let widths = lines.iter().enumerate().map(|(number, line)| {
                let character = if is_bold(number) { BOLD_CHARACTER } else { CHARACTER };
                line.chars().count() as f64 * character
            });
            widths.fold(0.0, f64::max) + 14.0
        }
    }
}

fn drawing(
    id: &str,
    layers: &Layers,
    places: &Places,
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
        @for (number, edge) in edges.iter().enumerate() {
            path class="wire" d=(wire(layers, places, number, *edge)) marker-end={ "url(#" (arrow) ")" } {}
        }
        @for (layer, row) in layers.rows.iter().enumerate() {
            @for place in row {
                @if let Slot::Node(node) = place {
                    (block(&nodes[*node], places.centre(layers, layer, *place), width(place, nodes)))
                }
            }
        }
    }
}

fn block(node: &Node, (x, y): (f64, f64), width: f64) -> Markup {
    let height = if node.class == "port" { 22.0 } else { BOX };
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

/// A smooth line through the layers between.
fn wire(layers: &Layers, places: &Places, number: usize, (from, to): (usize, usize)) -> String {
    let [first, last] = [from, to].map(|node| layers.layer_of[node]);
    let half = |layer: usize, node: usize| {
        let (_, y) = places.centre(layers, layer, Slot::Node(node));
        (y, BOX / 2.0)
    };
    let upward = last < first;
    let between: Vec<usize> = match upward {
        true => (last + 1..first).rev().collect(),
        false => (first + 1..last).collect(),
    };
    let (start_x, _) = places.centre(layers, first, Slot::Node(from));
    let (end_x, _) = places.centre(layers, last, Slot::Node(to));
    let sign = if upward { -1.0 } else { 1.0 };
    let side = if upward { 14.0 } else { 0.0 };
    let mut stops = vec![(start_x + side, half(first, from).0 + sign * half(first, from).1)];
    for layer in between {
        stops.push(places.centre(layers, layer, Slot::Passing(number)));
    }
    stops.push((end_x + side, half(last, to).0 - sign * (half(last, to).1 + 1.0)));
    let mut path = format!("M{},{}", coordinate(stops[0].0), coordinate(stops[0].1));
    for pair in stops.windows(2) {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        let bend = (y1 - y0) / 2.0;
        let [a, b, c, d, e, f] = [x0, y0 + bend, x1, y1 - bend, x1, y1].map(coordinate);
        path += &format!(" C{a},{b} {c},{d} {e},{f}");
    }
    path
}

fn in_words(module: &Netlist, connections: &Connections) -> Vec<[String; 3]> {
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
    fn however_many_stand_in_a_row_none_is_cut_or_covers_another() {
        for number in 1..40 {
            let nodes: Vec<Node> = (0..number)
                .map(|index| Node {
                    end: vec![End::Instance(index)],
                    lines: vec!["x".repeat(3 + index % 19)],
                    class: "block",
                })
                .collect();
            let all: Vec<usize> = (0..number).collect();
            let layers = layers(number, &[], &all, &[]);
            let places = Places::of(&layers, &nodes);
            let boxes: Vec<(f64, f64, f64)> = all
                .iter()
                .map(|&node| {
                    let (x, y) = places.centre(&layers, 0, Slot::Node(node));
                    (x, y, width(&Slot::Node(node), &nodes) / 2.0)
                })
                .collect();
            for (index, &(x, y, half)) in boxes.iter().enumerate() {
                assert!(x - half >= 0.0 && x + half <= WIDTH, "{number}: {index}");
                assert!(y + BOX / 2.0 <= places.height, "{number}: {index}");
                for &(other_x, other_y, other_half) in &boxes[..index] {
                    let is_apart =
                        (x - other_x).abs() >= half + other_half || (y - other_y).abs() >= BOX;
                    assert!(is_apart, "{number}: {index}");
                }
            }
        }
    }
}
