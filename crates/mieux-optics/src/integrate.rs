//! Adaptive quadrature of several integrands at once (Gauss-Kronrod 7-15, `piessens1983`).

/// Nodes of the 15-point Kronrod rule on [0, 1] of the half interval; the odd ones are the Gauss nodes.
const NODES: [f64; 8] = [
    0.9914553711208126,
    0.9491079123427585,
    0.8648644233597691,
    0.7415311855993945,
    0.5860872354676911,
    0.4058451513773972,
    0.20778495500789848,
    0.0,
];
const KRONROD: [f64; 8] = [
    0.022935322010529224,
    0.06309209262997856,
    0.10479001032225019,
    0.14065325971552592,
    0.1690047266392679,
    0.19035057806478542,
    0.20443294007529889,
    0.20948214108472782,
];
const GAUSS: [f64; 4] = [0.1294849661688697, 0.27970539148927664, 0.3818300505051189, 0.4179591836734694];

/// Panels beyond which the integral is given up.
const MAX_PANELS: usize = 20_000;

/// The integrals, and for each the error the rule believes it has made (usually a large overestimate).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Integral<const K: usize> {
    pub value: [f64; K],
    pub error: [f64; K],
}

/// Integrals, and the panels that were enough for them, ascending.
pub(crate) type Converged<const K: usize> = (Integral<K>, Vec<Panel<K>>);

/// A part of the range, and the integrals over it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Panel<const K: usize> {
    pub from: f64,
    pub to: f64,
    pub integral: Integral<K>,
}

/// Integrates `f` over consecutive panels between `knots`, halving panels until the error of every component is at most
/// `tolerance * (|value| + floor)`, where `floor` is given the integrals found so far. `f` is given many nodes at a time and
/// appends as many values. `Ok(None)` when that takes more than [`MAX_PANELS`] panels.
pub(crate) fn integrate_many<const K: usize, E>(
    knots: &[f64],
    tolerance: f64,
    floor: impl Fn(&[f64; K]) -> [f64; K],
    f: impl FnMut(&[f64], &mut Vec<[f64; K]>) -> Result<(), E>,
) -> Result<Option<Integral<K>>, E> {
    Ok(integrate_panels(knots, tolerance, floor, || false, f)?.map(|(integral, _)| integral))
}

/// As [`integrate_many`], with the panels that were enough: [`rule`] on them is a rule for integrands like
/// these. `spent` says that no more work is to be done: the integral is then what it is, with the error it has.
pub(crate) fn integrate_panels<const K: usize, E>(
    knots: &[f64],
    tolerance: f64,
    floor: impl Fn(&[f64; K]) -> [f64; K],
    spent: impl Fn() -> bool,
    mut f: impl FnMut(&[f64], &mut Vec<[f64; K]>) -> Result<(), E>,
) -> Result<Option<Converged<K>>, E> {
    let mut panels = Vec::with_capacity(2 * knots.len());
    let mut halves: Vec<(f64, f64)> = knots.windows(2).map(|pair| (pair[0], pair[1])).collect();
    let (mut nodes, mut values) = (Vec::new(), Vec::new());
    loop {
        nodes.clear();
        values.clear();
        nodes.extend(halves.iter().flat_map(|&(from, to)| kronrod_nodes(from, to)));
        f(&nodes, &mut values)?;
        let found = halves.iter().zip(values.chunks_exact(NODE_COUNT));
        panels.extend(found.map(|(&(from, to), values)| Panel { from, to, integral: kronrod(to - from, values) }));

        panels.sort_by(|a, b| a.from.total_cmp(&b.from));
        let total = sum(&panels);
        let floor = floor(&total.value);
        let allowed: [f64; K] = std::array::from_fn(|k| tolerance * (total.value[k].abs() + floor[k]));
        if (0..K).all(|k| total.error[k] <= allowed[k]) || spent() {
            return Ok(Some((total, panels)));
        }
        if panels.len() >= MAX_PANELS || !total.error.iter().all(|e| e.is_finite()) {
            return Ok(None);
        }
        // Halve every panel that carries more than its share: fewer passes than one at a time, same result.
        let share = 1.0 / panels.len() as f64;
        halves.clear();
        panels.retain(|panel| {
            let wanting = (0..K).any(|k| panel.integral.error[k] > share * allowed[k]);
            if wanting {
                let middle = 0.5 * (panel.from + panel.to);
                halves.extend([(panel.from, middle), (middle, panel.to)]);
            }
            !wanting
        });
    }
}

/// [`integrate_many`] with one node at a time and constant floors.
pub(crate) fn integrate<const K: usize, E>(
    knots: &[f64],
    tolerance: f64,
    floor: [f64; K],
    mut f: impl FnMut(f64) -> Result<[f64; K], E>,
) -> Result<Option<Integral<K>>, E> {
    integrate_many(
        knots,
        tolerance,
        |_| floor,
        |nodes, values| {
            for node in nodes {
                values.push(f(*node)?);
            }
            Ok(())
        },
    )
}

/// Errors add up, though those of waves that the panels do not resolve would partly cancel: narrow resonances between the
/// nodes are missed alike in all panels, so that nothing less would be honest.
fn sum<const K: usize>(panels: &[Panel<K>]) -> Integral<K> {
    let mut total = Integral { value: [0.0; K], error: [0.0; K] };
    for panel in panels {
        for k in 0..K {
            total.value[k] += panel.integral.value[k];
            total.error[k] += panel.integral.error[k];
        }
    }
    total
}

const NODE_COUNT: usize = 2 * NODES.len() - 1;

/// Ascending.
fn kronrod_nodes(from: f64, to: f64) -> [f64; NODE_COUNT] {
    let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
    std::array::from_fn(|i| {
        let last = NODES.len() - 1;
        if i <= last { centre - half * NODES[i] } else { centre + half * NODES[2 * last - i] }
    })
}

/// Nodes and weights of the rule on a panel, ascending.
pub(crate) fn rule([from, to]: [f64; 2]) -> impl Iterator<Item = (f64, f64)> {
    let weight = move |i: usize| 0.5 * (to - from) * KRONROD[i.min(NODE_COUNT - 1 - i)];
    kronrod_nodes(from, to).into_iter().enumerate().map(move |(i, node)| (node, weight(i)))
}

/// From values at [`kronrod_nodes`] of a panel of the given width.
fn kronrod<const K: usize>(width: f64, values: &[[f64; K]]) -> Integral<K> {
    let (mut fine, mut coarse) = ([0.0; K], [0.0; K]);
    for (i, value) in values.iter().enumerate() {
        let node = i.min(NODE_COUNT - 1 - i);
        for k in 0..K {
            fine[k] += KRONROD[node] * value[k];
            if node % 2 == 1 {
                coarse[k] += GAUSS[node / 2] * value[k];
            }
        }
    }
    let half = 0.5 * width;
    Integral { value: fine.map(|v| v * half), error: std::array::from_fn(|k| ((fine[k] - coarse[k]) * half).abs()) }
}

/// Nodes and weights of the Gauss-Legendre rule of `count` points on [-1, 1], ascending and mirrored exactly: it integrates
/// polynomials up to degree `2 count - 1`. Newton's method on the Legendre polynomial; the work grows with the square of
/// `count`.
pub(crate) fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let mut rule = vec![(0.0, 0.0); count];
    for i in 0..count.div_ceil(2) {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 0.0;
        for _ in 0..8 {
            let (mut before, mut here) = (1.0, x);
            for l in 1..count {
                let l = l as f64;
                (before, here) = (here, ((2.0 * l + 1.0) * x * here - l * before) / (l + 1.0));
            }
            if count == 1 {
                before = 1.0;
            }
            slope = n * (x * here - before) / ((x - 1.0) * (x + 1.0));
            let change = here / slope;
            x -= change;
            if change.abs() < 1e-15 {
                break;
            }
        }
        if 2 * i + 1 == count {
            x = 0.0;
        }
        let weight = 2.0 / ((1.0 - x) * (1.0 + x) * slope * slope);
        rule[i] = (-x, weight);
        rule[count - 1 - i] = (x, weight);
    }
    rule
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    #[test]
    fn polynomials_are_exact_and_peaks_are_found() {
        let poly =
            integrate::<2, Infallible>(&[0.0, 2.0], 1e-12, [0.0; 2], |x| Ok([x.powi(13), 1.0])).unwrap().unwrap();
        assert!((poly.value[0] / (2f64.powi(14) / 14.0) - 1.0).abs() < 1e-14);
        assert!((poly.value[1] - 2.0).abs() < 1e-14);
        let peak = integrate::<1, Infallible>(&[-1.0, 0.0, 1.0], 1e-10, [0.0], |x| Ok([1.0 / (1e-6 + x * x)]));
        let exact = 2.0 * 1e3 * (1e3f64).atan();
        assert!((peak.unwrap().unwrap().value[0] / exact - 1.0).abs() < 1e-10);
    }

    #[test]
    fn the_panels_make_a_rule() {
        let peak = |x: f64| 1.0 / (1e-6 + x * x);
        let fill = |nodes: &[f64], values: &mut Vec<[f64; 1]>| {
            values.extend(nodes.iter().map(|x| [peak(*x)]));
            Ok::<_, Infallible>(())
        };
        let (integral, panels) =
            integrate_panels(&[-1.0, 0.5, 1.0], 1e-10, |_| [0.0], || false, fill).unwrap().unwrap();
        assert_eq!((panels[0].from, panels[panels.len() - 1].to), (-1.0, 1.0));
        assert!(panels.windows(2).all(|pair| pair[0].to == pair[1].from) && panels.len() > 8);
        let sum: f64 = panels.iter().flat_map(|panel| rule([panel.from, panel.to])).map(|(x, w)| w * peak(x)).sum();
        assert!((sum / integral.value[0] - 1.0).abs() < 1e-13);
    }

    /// The error of what is left undone is told, and is no less than the one made.
    #[test]
    fn no_more_work_is_done_than_asked_for() {
        let wild = |x: f64| x * x + 0.05 * (1e6 * x * x).sin();
        let rounds = std::cell::Cell::new(0);
        let fill = |nodes: &[f64], values: &mut Vec<[f64; 1]>| {
            rounds.set(rounds.get() + 1);
            values.extend(nodes.iter().map(|x| [wild(*x)]));
            Ok::<_, Infallible>(())
        };
        let (integral, _) =
            integrate_panels(&[0.0, 1.0], 1e-9, |_| [0.0], || rounds.get() == 5, fill).unwrap().unwrap();
        assert!(integral.error[0] > 1e-9 && rounds.get() == 5);
        assert!((integral.value[0] - 1.0 / 3.0).abs() < integral.error[0]);
    }

    #[test]
    fn what_does_not_converge_says_so() {
        let wild = |x: f64| Ok::<_, Infallible>([if x > 0.123_456_7 { 1.0 / (x - 0.123_456_7) } else { 0.0 }]);
        assert!(integrate(&[0.0, 1.0], 1e-12, [0.0], wild).unwrap().is_none());
        let nan = |_: f64| Ok::<_, Infallible>([f64::NAN]);
        assert!(integrate(&[0.0, 1.0], 1e-3, [0.0], nan).unwrap().is_none());
        let broken = integrate::<1, &str>(&[0.0, 1.0], 1e-3, [0.0], |_| Err("no"));
        assert_eq!(broken.unwrap_err(), "no");
    }

    #[test]
    fn gauss_legendre_is_exact_to_its_degree() {
        for count in [1usize, 2, 3, 10, 101] {
            let rule = gauss_legendre(count);
            assert!((rule.iter().map(|(_, w)| w).sum::<f64>() - 2.0).abs() < 1e-13);
            let degree = (2 * count - 2).min(40) as i32;
            let even: f64 = rule.iter().map(|(x, w)| w * x.powi(degree)).sum();
            assert!((even - 2.0 / f64::from(degree + 1)).abs() < 1e-13, "{count}");
            assert!(rule.iter().zip(rule.iter().rev()).all(|(a, b)| a.0 == -b.0));
        }
    }
}
