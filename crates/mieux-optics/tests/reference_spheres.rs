//! Published and arbitrary-precision values for single spheres, read in place from the shared reference tables.

mod shared;

use std::f64::consts::PI;

use mieux_optics::Complex64;
use mieux_optics::mie::scatter_sphere;

fn complex(text: &str) -> Option<Complex64> {
    let text = text.trim().strip_suffix('i')?;
    let split = text
        .char_indices()
        .rev()
        .find(|&(i, c)| i > 0 && (c == '+' || c == '-') && !text[..i].ends_with(['e', 'E']))?;
    Some(Complex64::new(text[..split.0].parse().ok()?, text[split.0..].parse().ok()?))
}

#[test]
fn spheres_agree_with_the_reference_table() {
    let Some(text) = shared::text("mie/reference_cases.csv") else { return };
    let (mut spheres, mut hosts) = (0, 0);
    for line in text.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let (id, kind) = (cells[0], cells[1]);
        let number = |i: usize| cells[i].parse::<f64>().ok();
        let (host, particle, k0r) = match kind {
            "homogeneous" => {
                let (Some(x), Some(m)) = (number(2), complex(cells[3])) else { continue };
                spheres += 1;
                (Complex64::ONE, m, x)
            }
            "absorbing host" => {
                let x0 = cells[2].trim_start_matches("x0=").split(' ').next().unwrap().parse().unwrap();
                let mut words = cells[3].split(' ');
                let host = words.by_ref().nth(1).and_then(complex).unwrap();
                hosts += 1;
                (host, words.nth(1).and_then(complex).unwrap(), x0)
            }
            _ => continue,
        };
        let radius = 1e-6;
        let s = scatter_sphere(radius, 2.0 * PI * radius / k0r, host, particle).unwrap();
        let area = PI * radius * radius;
        let columns = [(10, s.extinction / area), (11, s.scattering / area), (12, s.asymmetry)];
        for (column, value) in columns {
            if let Some(expected) = number(column) {
                assert!((value / expected - 1.0).abs() < 1e-10, "{id}, column {column}: {value} against {expected}");
            }
        }
    }
    assert!(spheres >= 30 && hosts >= 3, "{spheres} spheres and {hosts} absorbing hosts read");
}
