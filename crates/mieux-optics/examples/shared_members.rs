//! Processor time that coefficients, moments and phase function of one wavelength take, asked for one after the other.
use mieux_optics::Complex64;
use mieux_optics::material::milk::Milk;
use mieux_optics::medium::{Inclusion, Medium};
use mieux_optics::particle::{Gamma, SizeDistribution};
use mieux_optics::substance::{Conditions, Substance};

fn seconds() -> f64 {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64
}

fn main() {
    let water = Substance::named("water", Conditions::default()).unwrap();
    let sizes = SizeDistribution::Gamma(Gamma::new(6e-6, 0.15).unwrap());
    let air = Substance::Constant(Complex64::new(1.0, 0.0));
    let cloud = Medium::new(air, vec![Inclusion::new("droplets", water, sizes, 1e-6)]).unwrap();
    let milk = Milk::new([3.5, 3.4, 20.0, 0.17]).unwrap().medium().unwrap();
    for (name, medium) in [("cloud", cloud), ("milk", milk)] {
        let start = seconds();
        let optics = medium.optics_at(550e-9, 1e-3).unwrap();
        let first = seconds();
        let moments = medium.legendre_moments_at(550e-9, 64, 1e-3).unwrap();
        let second = seconds();
        let phase = medium.phase_at(550e-9, 1e-3).unwrap();
        let third = seconds();
        println!(
            "{name}: coefficients {:.3} s, moments {:.3} s, function {:.3} s; g {:.6} {:.6} {:.6}",
            first - start,
            second - first,
            third - second,
            optics.asymmetry,
            moments[1],
            phase.asymmetry()
        );
    }
}
