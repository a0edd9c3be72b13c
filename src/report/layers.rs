//! Nodes of a graph in layers, so that edges lead from one to the next: longest paths
//! for the layers, barycentres for the order in them.

use std::collections::BTreeMap;

/// Times that each layer is ordered by its neighbours.
const SWEEPS: usize = 8;

/// A node in its layer: of the graph, or where an edge passes a layer on its way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Slot {
    /// A node, by its number.
    Node(usize),
    /// An edge, by its number.
    Passing(usize),
}

/// A graph in layers.
#[derive(Debug, Clone)]
pub(super) struct Layers {
    /// The layers from first to last, each in order.
    pub rows: Vec<Vec<Slot>>,
    /// Layer of each node.
    pub layer_of: Vec<usize>,
}

/// Puts nodes in layers. Those `first` are in the first one, those `last` in the last.
/// Edges that would close a circle lead backwards.
pub(super) fn layers(
    nodes: usize,
    edges: &[(usize, usize)],
    first: &[usize],
    last: &[usize],
) -> Layers {
    let forward = without_circles(nodes, edges);
    let mut layer_of = vec![usize::from(!first.is_empty()); nodes];
    first.iter().for_each(|&node| layer_of[node] = 0);
    for _ in 0..nodes {
        for &(from, to) in &forward {
            if !first.contains(&to) {
                layer_of[to] = layer_of[to].max(layer_of[from] + 1);
            }
        }
    }
    let inner = (0..nodes).filter(|node| !last.contains(node));
    let deepest = inner.map(|node| layer_of[node]).max().unwrap_or(0);
    last.iter().for_each(|&node| layer_of[node] = deepest + 1);

    let depth = layer_of.iter().max().map_or(0, |deepest| deepest + 1);
    let mut rows: Vec<Vec<Slot>> = vec![Vec::new(); depth];
    for (node, &layer) in layer_of.iter().enumerate() {
        rows[layer].push(Slot::Node(node));
    }
    for (number, &(from, to)) in edges.iter().enumerate() {
        let (low, high) = ends(layer_of[from], layer_of[to]);
        for row in &mut rows[(low + 1).min(high)..high] {
            row.push(Slot::Passing(number));
        }
    }
    let mut layers = Layers { rows, layer_of };
    for sweep in 0..SWEEPS {
        layers.order(edges, sweep % 2 == 0);
    }
    layers
}

fn ends(a: usize, b: usize) -> (usize, usize) {
    (a.min(b), a.max(b))
}

/// The edges, those that close a circle turned round.
fn without_circles(nodes: usize, edges: &[(usize, usize)]) -> Vec<(usize, usize)> {
    let mut state = vec![0_u8; nodes];
    let mut turned = vec![false; edges.len()];
    for node in 0..nodes {
        visit(node, edges, &mut state, &mut turned);
    }
    let edges = edges.iter().zip(turned);
    edges
        .filter(|((from, to), _)| from != to)
        .map(|(&(from, to), turned)| if turned { (to, from) } else { (from, to) })
        .collect()
}

/// Depth first; an edge to a node that is being visited closes a circle.
fn visit(node: usize, edges: &[(usize, usize)], state: &mut [u8], turned: &mut [bool]) {
    if state[node] != 0 {
        return;
    }
    state[node] = 1;
    for (number, &(from, to)) in edges.iter().enumerate() {
        if from == node && state[to] == 1 {
            turned[number] = true;
        } else if from == node {
            visit(to, edges, state, turned);
        }
    }
    state[node] = 2;
}

impl Layers {
    /// Places of the nodes and of edges on their way, as shares of their rows.
    fn shares(&self) -> BTreeMap<(usize, usize), f64> {
        let mut shares = BTreeMap::new();
        for (layer, row) in self.rows.iter().enumerate() {
            for (index, place) in row.iter().enumerate() {
                let share = (index as f64 + 0.5) / row.len() as f64;
                shares.insert(key(*place, layer), share);
            }
        }
        shares
    }

    /// Orders rows by the mean place of what their nodes are joined to in the row
    /// before, or behind.
    fn order(&mut self, edges: &[(usize, usize)], downward: bool) {
        let number = self.rows.len();
        let order: Vec<usize> = match downward {
            true => (1..number).collect(),
            false => (0..number.saturating_sub(1)).rev().collect(),
        };
        for layer in order {
            let shares = self.shares();
            let beside = if downward { layer - 1 } else { layer + 1 };
            let mean = |place: &Slot| {
                let mut places = Vec::new();
                for (number, &(from, to)) in edges.iter().enumerate() {
                    let at_edge = match *place {
                        Slot::Node(node) => from == node || to == node,
                        Slot::Passing(edge) => edge == number,
                    };
                    if !at_edge {
                        continue;
                    }
                    let passing = shares.get(&key(Slot::Passing(number), beside));
                    let ends = [from, to].into_iter().filter(|&end| self.layer_of[end] == beside);
                    let ends = ends.filter_map(|end| shares.get(&key(Slot::Node(end), beside)));
                    places.extend(passing.into_iter().chain(ends).copied());
                }
                match places.len() {
                    0 => shares.get(&key(*place, layer)).copied().unwrap_or(0.5),
                    number => places.iter().sum::<f64>() / number as f64,
                }
            };
            let mut keyed: Vec<(f64, Slot)> =
                self.rows[layer].iter().map(|place| (mean(place), *place)).collect();
            keyed.sort_by(|a, b| a.0.total_cmp(&b.0));
            self.rows[layer] = keyed.into_iter().map(|(_, place)| place).collect();
        }
    }
}

/// Passing edges are counted from the other end of all numbers.
fn key(place: Slot, layer: usize) -> (usize, usize) {
    match place {
        Slot::Node(node) => (layer, node),
        Slot::Passing(edge) => (layer, usize::MAX - edge),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_lead_downward_and_pass_the_layers_between() {
        // 0 -> 1 -> 2 -> 3, 0 -> 3, and 2 -> 1 back.
        let edges = [(0, 1), (1, 2), (2, 3), (0, 3), (2, 1)];
        let layers = layers(4, &edges, &[0], &[3]);
        assert_eq!(layers.layer_of, [0, 1, 2, 3]);
        for row in &layers.rows[1..3] {
            assert!(row.contains(&Slot::Passing(3)), "{row:?}");
        }
        assert_eq!(layers.rows[1].len(), 2);
    }
}
