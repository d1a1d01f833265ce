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
const MAX_PANELS: usize = 4000;

/// The integrals, and for each the error the rule believes it has made (usually a large overestimate).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Integral<const K: usize> {
    pub value: [f64; K],
    pub error: [f64; K],
}

struct Panel<const K: usize> {
    from: f64,
    to: f64,
    integral: Integral<K>,
}

/// Integrates `f` over consecutive panels between `knots`, halving the worst panel until the error of every component
/// is at most `tolerance * (|value| + floor)`. `Ok(None)` when that takes more than [`MAX_PANELS`] panels.
pub(crate) fn integrate<const K: usize, E>(
    knots: &[f64],
    tolerance: f64,
    floor: [f64; K],
    mut f: impl FnMut(f64) -> Result<[f64; K], E>,
) -> Result<Option<Integral<K>>, E> {
    let mut panels = Vec::with_capacity(2 * knots.len());
    for pair in knots.windows(2) {
        panels.push(Panel { from: pair[0], to: pair[1], integral: kronrod(pair[0], pair[1], &mut f)? });
    }
    loop {
        let total = sum(&panels);
        let allowed: [f64; K] = std::array::from_fn(|k| tolerance * (total.value[k].abs() + floor[k]));
        if (0..K).all(|k| total.error[k] <= allowed[k]) {
            return Ok(Some(total));
        }
        if panels.len() >= MAX_PANELS || !total.error.iter().all(|e| e.is_finite()) {
            return Ok(None);
        }
        // Halve every panel that carries more than its share: fewer passes than one at a time, same result.
        let share = 1.0 / panels.len() as f64;
        let count = panels.len();
        for i in 0..count {
            let Panel { from, to, integral } = &panels[i];
            if (0..K).any(|k| integral.error[k] > share * allowed[k]) {
                let (from, to) = (*from, *to);
                let middle = 0.5 * (from + to);
                panels[i] = Panel { from, to: middle, integral: kronrod(from, middle, &mut f)? };
                panels.push(Panel { from: middle, to, integral: kronrod(middle, to, &mut f)? });
            }
        }
    }
}

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

fn kronrod<const K: usize, E>(
    from: f64,
    to: f64,
    f: &mut impl FnMut(f64) -> Result<[f64; K], E>,
) -> Result<Integral<K>, E> {
    let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
    let mut fine = [0.0; K];
    let mut coarse = [0.0; K];
    let mut add = |value: [f64; K], i: usize| {
        for k in 0..K {
            fine[k] += KRONROD[i] * value[k];
            if i % 2 == 1 {
                coarse[k] += GAUSS[i / 2] * value[k];
            }
        }
    };
    for (i, node) in NODES.iter().enumerate() {
        add(f(centre + half * node)?, i);
        if *node > 0.0 {
            add(f(centre - half * node)?, i);
        }
    }
    Ok(Integral { value: fine.map(|v| v * half), error: std::array::from_fn(|k| ((fine[k] - coarse[k]) * half).abs()) })
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
    fn what_does_not_converge_says_so() {
        let wild = |x: f64| Ok::<_, Infallible>([if x > 0.123_456_7 { 1.0 / (x - 0.123_456_7) } else { 0.0 }]);
        assert!(integrate(&[0.0, 1.0], 1e-12, [0.0], wild).unwrap().is_none());
        let nan = |_: f64| Ok::<_, Infallible>([f64::NAN]);
        assert!(integrate(&[0.0, 1.0], 1e-3, [0.0], nan).unwrap().is_none());
        let broken = integrate::<1, &str>(&[0.0, 1.0], 1e-3, [0.0], |_| Err("no"));
        assert_eq!(broken.unwrap_err(), "no");
    }
}
