//! Whether triangles close a volume.

use std::collections::HashMap;

/// How triangles hang together, once vertices at exactly the same place are taken for one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Topology {
    /// Places where there are vertices of a triangle.
    pub vertices: usize,
    /// Edges with a triangle on one side only.
    pub boundary_edges: usize,
    /// Edges with more than two triangles.
    pub crowded_edges: usize,
    /// Edges whose two triangles disagree about which side is outside.
    pub turned_edges: usize,
}

impl Topology {
    /// Whether the surface has an inside: no edge is open, crowded or between triangles that face opposite ways.
    pub fn is_closed(&self) -> bool {
        self.boundary_edges == 0 && self.crowded_edges == 0 && self.turned_edges == 0
    }

    /// Triangles that come to an edge or a point once vertices are welded count for nothing. Indices must be in range.
    pub(super) fn of(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        let mut places: HashMap<[u32; 3], u32> = HashMap::new();
        let mut welded = vec![u32::MAX; positions.len()];
        let mut edges: Vec<(u64, bool)> = Vec::with_capacity(3 * triangles.len());
        for corners in triangles {
            let [a, b, c] = corners.map(|i| {
                let known = &mut welded[i as usize];
                if *known == u32::MAX {
                    // Adding zero makes one of both zeros.
                    let key = positions[i as usize].map(|x| (x + 0.0).to_bits());
                    let next = places.len() as u32;
                    *known = *places.entry(key).or_insert(next);
                }
                *known
            });
            if a == b || b == c || c == a {
                continue;
            }
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let (low, high) = (from.min(to), from.max(to));
                edges.push(((u64::from(low) << 32) | u64::from(high), from < to));
            }
        }
        edges.sort_unstable();
        let mut topology = Self { vertices: places.len(), ..Self::default() };
        for edge in edges.chunk_by(|a, b| a.0 == b.0) {
            match edge {
                [_] => topology.boundary_edges += 1,
                [one, other] => topology.turned_edges += usize::from(one.1 == other.1),
                _ => topology.crowded_edges += 1,
            }
        }
        topology
    }
}
