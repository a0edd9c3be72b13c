//! Nodes of a graph in layers, so that edges lead from one to the next: longest paths for the layers,
//! barycentres for the order in them, and for the places least squares of how far edges lead aside
//! (K. Sugiyama, S. Tagawa and M. Toda, IEEE Trans. Syst. Man Cybern. 11, 109, 1981).

use std::collections::{BTreeMap, BTreeSet};

/// Times that each layer is ordered by its neighbours, and placed.
const SWEEPS: usize = 12;

/// What passes a layer on its way: all edges of one node in one direction, which are drawn as one
/// until they part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Bundle {
    from: usize,
    is_upward: bool,
}

/// A node in its layer: of the graph, or where edges pass a layer on their way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Slot {
    /// A node, by its number.
    Node(usize),
    /// Edges on their way.
    Passing(Bundle),
}

/// A graph in layers.
#[derive(Debug, Clone)]
pub(super) struct Layers<'e> {
    /// The layers from first to last, each in order.
    pub rows: Vec<Vec<Slot>>,
    /// Layer of each node.
    pub layer_of: Vec<usize>,
    edges: &'e [(usize, usize)],
}

/// Puts nodes in layers. Those `first` are in the first one, those `last` in the last. Edges that would
/// close a circle lead backwards. A layer that has no room for all that is in it, as `fits` says, becomes
/// two, so that no edge has to pass beneath a node.
pub(super) fn layers<'e>(
    nodes: usize,
    edges: &'e [(usize, usize)],
    first: &[usize],
    last: &[usize],
    fits: impl Fn(&[Slot]) -> bool,
) -> Layers<'e> {
    let mut layers = Layers::in_order(longest_paths(nodes, edges, first, last), edges);
    while let Some((row, moved)) = layers.crowded(&fits) {
        let mut layer_of = layers.layer_of;
        let behind = |layer: usize, node: usize| layer > row || moved.contains(&node);
        (0..nodes).for_each(|node| layer_of[node] += usize::from(behind(layer_of[node], node)));
        layers = Layers::in_order(layer_of, edges);
    }
    layers
}

/// The layer of each node.
fn longest_paths(
    nodes: usize,
    edges: &[(usize, usize)],
    first: &[usize],
    last: &[usize],
) -> Vec<usize> {
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
    layer_of
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

impl Layers<'_> {
    /// Nodes and passing edges row by row, in an order with few crossings.
    fn in_order(layer_of: Vec<usize>, edges: &[(usize, usize)]) -> Layers<'_> {
        let depth = layer_of.iter().max().map_or(0, |deepest| deepest + 1);
        let mut rows: Vec<BTreeSet<Slot>> = vec![BTreeSet::new(); depth];
        for (node, &layer) in layer_of.iter().enumerate() {
            rows[layer].insert(Slot::Node(node));
        }
        let mut layers = Layers { rows: Vec::new(), layer_of, edges };
        for &edge in edges {
            for layer in layers.between(edge) {
                rows[layer].insert(layers.passing(edge));
            }
        }
        layers.rows = rows.into_iter().map(|row| row.into_iter().collect()).collect();
        let mut best = (layers.crossings(), layers.rows.clone());
        for sweep in 0..SWEEPS {
            for (layer, beside) in layers.order_of(sweep) {
                let share = layers.shares(beside);
                let own = layers.shares(layer);
                let mean = |slot: &Slot| layers.mean(*slot, layer, beside, &share);
                let mut keyed: Vec<(f64, Slot)> =
                    layers.rows[layer].iter().map(|s| (mean(s).unwrap_or(own[s]), *s)).collect();
                keyed.sort_by(|a, b| a.0.total_cmp(&b.0));
                layers.rows[layer] = keyed.into_iter().map(|(_, slot)| slot).collect();
            }
            let crossings = layers.crossings();
            if crossings < best.0 {
                best = (crossings, layers.rows.clone());
            }
        }
        layers.rows = best.1;
        layers
    }

    /// The first row without room, and every other of its nodes, which are to go a layer on.
    fn crowded(&self, fits: impl Fn(&[Slot]) -> bool) -> Option<(usize, Vec<usize>)> {
        let nodes = |row: &[Slot]| -> Vec<usize> {
            let node = |slot: &Slot| match slot {
                Slot::Node(node) => Some(*node),
                Slot::Passing(_) => None,
            };
            row.iter().filter_map(node).collect()
        };
        let rows = self.rows.iter().map(|row| nodes(row)).enumerate();
        let mut crowded =
            rows.filter(|(number, nodes)| nodes.len() > 1 && !fits(&self.rows[*number]));
        let (row, nodes) = crowded.next()?;
        Some((row, nodes.into_iter().skip(1).step_by(2).collect()))
    }

    /// What an edge passes as, on its way.
    fn passing(&self, (from, to): (usize, usize)) -> Slot {
        Slot::Passing(Bundle { from, is_upward: self.layer_of[to] < self.layer_of[from] })
    }

    /// The layers that an edge passes, from the upper to the lower.
    fn between(&self, (from, to): (usize, usize)) -> std::ops::Range<usize> {
        let (a, b) = (self.layer_of[from], self.layer_of[to]);
        let (upper, lower) = (a.min(b), a.max(b));
        (upper + 1).min(lower)..lower
    }

    /// The slots of an edge from its beginning to its end, each with its layer.
    pub fn way(&self, edge: (usize, usize)) -> Vec<(usize, Slot)> {
        let [first, last] = [edge.0, edge.1].map(|node| (self.layer_of[node], Slot::Node(node)));
        let mut between: Vec<(usize, Slot)> =
            self.between(edge).map(|layer| (layer, self.passing(edge))).collect();
        if last.0 < first.0 {
            between.reverse();
        }
        [first].into_iter().chain(between).chain([last]).collect()
    }

    /// The slot of an edge in a layer.
    fn slot_of(&self, edge: (usize, usize), layer: usize) -> Option<Slot> {
        let end = [edge.0, edge.1].into_iter().find(|&node| self.layer_of[node] == layer);
        let passes = self.between(edge).contains(&layer);
        end.map(Slot::Node).or_else(|| passes.then(|| self.passing(edge)))
    }

    /// Rows in the order of a sweep, each with the one by which it is arranged.
    fn order_of(&self, sweep: usize) -> Vec<(usize, usize)> {
        let pairs = 1..self.rows.len();
        match sweep.is_multiple_of(2) {
            true => pairs.map(|layer| (layer, layer - 1)).collect(),
            false => pairs.rev().map(|layer| (layer - 1, layer)).collect(),
        }
    }

    /// Mean of what a slot is joined to in the row beside.
    fn mean(
        &self,
        slot: Slot,
        layer: usize,
        beside: usize,
        places: &BTreeMap<Slot, f64>,
    ) -> Option<f64> {
        let own = |edge: &&(usize, usize)| self.slot_of(**edge, layer) == Some(slot);
        let joined = self.edges.iter().filter(own).filter_map(|edge| self.slot_of(*edge, beside));
        // Edges that go together count once.
        let joined: BTreeSet<Slot> = joined.collect();
        let sum: f64 = joined.iter().map(|slot| places[slot]).sum();
        (!joined.is_empty()).then(|| sum / joined.len() as f64)
    }

    /// Places of a row's slots, as shares of it.
    fn shares(&self, layer: usize) -> BTreeMap<Slot, f64> {
        let row = &self.rows[layer];
        let share = |index: usize| (index as f64 + 0.5) / row.len() as f64;
        row.iter().enumerate().map(|(index, slot)| (*slot, share(index))).collect()
    }

    /// Pairs of edges that cross between one row and the next.
    fn crossings(&self) -> usize {
        let of_row = |layer: usize| {
            let [upper, lower] = [layer - 1, layer].map(|layer| self.shares(layer));
            let ends = self.edges.iter().filter_map(|&edge| {
                Some((self.slot_of(edge, layer - 1)?, self.slot_of(edge, layer)?))
            });
            let ends: BTreeSet<(Slot, Slot)> = ends.collect();
            let ends: Vec<(f64, f64)> = ends.iter().map(|(a, b)| (upper[a], lower[b])).collect();
            let crosses = |a: &(f64, f64), b: &(f64, f64)| (a.0 - b.0) * (a.1 - b.1) < 0.0;
            let pairs = ends.iter().enumerate();
            pairs.map(|(i, a)| ends[..i].iter().filter(|b| crosses(a, b)).count()).sum::<usize>()
        };
        (1..self.rows.len()).map(of_row).sum()
    }

    /// Places of all slots, row by row, from 0 to `room`: each as near to the mean of what it is joined
    /// to as the others leave it, `width` and a gap apart.
    pub fn places(
        &self,
        room: f64,
        gap: f64,
        width: impl Fn(Slot) -> f64,
    ) -> Vec<BTreeMap<Slot, f64>> {
        let arrange = |row: &[Slot], wished: &dyn Fn(&Slot) -> f64| {
            let widths: Vec<f64> = row.iter().map(|slot| width(*slot)).collect();
            let wished: Vec<f64> = row.iter().map(wished).collect();
            let places = apart(&wished, &widths, gap, room);
            row.iter().copied().zip(places).collect::<BTreeMap<_, _>>()
        };
        let mut places: Vec<BTreeMap<Slot, f64>> = (0..self.rows.len())
            .map(|layer| {
                let shares = self.shares(layer);
                arrange(&self.rows[layer], &|slot| shares[slot] * room)
            })
            .collect();
        for sweep in 0..SWEEPS {
            for (layer, beside) in self.order_of(sweep) {
                let wished = |slot: &Slot| {
                    let mean = self.mean(*slot, layer, beside, &places[beside]);
                    mean.unwrap_or(places[layer][slot])
                };
                places[layer] = arrange(&self.rows[layer], &wished);
            }
        }
        places
    }
}

/// Places in order, as near to those that are wished as may be by least squares, where neighbours of
/// these widths stand at least a gap apart and all within the room: isotonic regression by pooling
/// neighbours that are too near.
fn apart(wished: &[f64], widths: &[f64], gap: f64, room: f64) -> Vec<f64> {
    let mut offsets = Vec::with_capacity(widths.len());
    let mut end = 0.0;
    for width in widths {
        offsets.push(end + width / 2.0);
        end += width + gap;
    }
    let spare = room - (end - gap);
    // Sum of the wishes beyond the offsets, and how many there are, of those that move together.
    let mut pools: Vec<(f64, usize)> = Vec::new();
    for (wish, offset) in wished.iter().zip(&offsets) {
        pools.push((wish - offset, 1));
        while let [.., (a, m), (b, n)] = pools[..] {
            if a / m as f64 <= b / n as f64 {
                break;
            }
            pools.truncate(pools.len() - 2);
            pools.push((a + b, m + n));
        }
    }
    let beyond = pools.iter().flat_map(|&(sum, n)| std::iter::repeat_n(sum / n as f64, n));
    beyond.zip(offsets).map(|(beyond, offset)| offset + beyond.min(spare).max(0.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_lead_downward_and_pass_the_layers_between() {
        // 0 -> 1 -> 2 -> 3, 0 -> 3, and 2 -> 1 back.
        let edges = [(0, 1), (1, 2), (2, 3), (0, 3), (2, 1)];
        let layers = layers(4, &edges, &[0], &[3], |_| true);
        assert_eq!(layers.layer_of, [0, 1, 2, 3]);
        let passing = layers.passing((0, 3));
        for row in &layers.rows[1..3] {
            assert!(row.contains(&passing), "{row:?}");
        }
        assert_eq!(layers.rows[1].len(), 2);
        assert_eq!(
            layers.way((0, 3)),
            [(0, Slot::Node(0)), (1, passing), (2, passing), (3, Slot::Node(3))]
        );
    }

    #[test]
    fn a_row_without_room_becomes_several_and_edges_pass_them() {
        // One to six, of which two have room beside two edges that pass.
        let edges: Vec<(usize, usize)> = (1..=6).map(|to| (0, to)).collect();
        let nodes = |row: &[Slot]| row.iter().filter(|s| matches!(s, Slot::Node(_))).count();
        let layers = layers(7, &edges, &[0], &[], |row| nodes(row) <= 2);
        assert!(layers.rows.iter().all(|row| nodes(row) <= 2), "{:?}", layers.rows);
        let told: usize = layers.rows.iter().map(|row| nodes(row)).sum();
        assert_eq!(told, 7);
        for &edge in &edges {
            for (layer, slot) in layers.way(edge) {
                assert!(layers.rows[layer].contains(&slot));
            }
        }
    }

    #[test]
    fn crossings_that_need_not_be_are_gone() {
        // Two ladders, whose rungs are crosswise in the order of their numbers.
        let edges = [(0, 3), (1, 2), (2, 5), (3, 4)];
        let layers = layers(6, &edges, &[0, 1], &[], |_| true);
        assert_eq!(layers.crossings(), 0);
    }

    #[test]
    fn places_are_the_wished_ones_or_as_near_as_there_is_room() {
        assert_eq!(apart(&[10.0, 50.0], &[10.0, 10.0], 2.0, 100.0), [10.0, 50.0]);
        // Both wish for 50: 6 to either side.
        assert_eq!(apart(&[50.0, 50.0], &[10.0, 10.0], 2.0, 100.0), [44.0, 56.0]);
        assert_eq!(apart(&[-5.0, 200.0], &[10.0, 10.0], 2.0, 100.0), [5.0, 95.0]);
    }
}
