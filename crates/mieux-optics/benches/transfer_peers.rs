//! Slabs timed beside other programs by `benches/peers/transfer/run.py`, which describes the workloads and writes the
//! problems; its README says what is read and printed here.
//!
//! `cargo bench -p mieux-optics --bench transfer_peers -- --workload NAME --problems FILE`

#![allow(clippy::print_stdout)]

use std::error::Error;

use mieux_optics::transfer::inverse::{Estimate, Inversion, Measured, Sample};
use mieux_optics::transfer::{
    AddingDoubling, DiscreteOrdinates, Ground, Incidence, Layer, Light, Moments, Place, Radiances, Stack, Views,
};
use rustix::time::{ClockId, clock_gettime};

/// Processor time used so far, s.
fn cpu_seconds() -> f64 {
    let t = clock_gettime(ClockId::ProcessCPUTime);
    t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64
}

/// The file, line by line.
#[derive(Debug, Default)]
struct Problems {
    task: String,
    streams: usize,
    beam: f64,
    index: f64,
    slides: f64,
    moments: usize,
    correction: bool,
    /// Negative downward.
    cosines: Vec<f64>,
    /// Degrees.
    azimuths: Vec<f64>,
    rows: Vec<Vec<f64>>,
}

impl Problems {
    fn parse(text: &str) -> Result<Self, Box<dyn Error>> {
        let mut found = Self::default();
        for line in text.lines() {
            let (name, rest) = line.split_once(' ').unwrap_or((line, ""));
            let numbers = || rest.split_whitespace().map(str::parse).collect::<Result<Vec<f64>, _>>();
            match name {
                "task" => found.task = rest.to_owned(),
                "streams" => found.streams = rest.parse()?,
                "beam" => found.beam = rest.parse()?,
                "index" => found.index = rest.parse()?,
                "slides" => found.slides = rest.parse()?,
                "moments" => found.moments = rest.parse()?,
                "correction" => found.correction = rest == "1",
                "cosines" => found.cosines = numbers()?,
                "azimuths" => found.azimuths = numbers()?,
                "problem" => found.rows.push(numbers()?),
                other => return Err(format!("unknown field {other:?}").into()),
            }
        }
        Ok(found)
    }

    fn incidence(&self) -> Incidence {
        Incidence::Beam(self.beam)
    }

    /// The stacks of all tasks but inversion, moments included: making them is no part of the peers' time either.
    fn stacks(&self) -> Result<Vec<Stack>, Box<dyn Error>> {
        self.rows.iter().map(|row| self.stack(row)).collect()
    }

    fn stack(&self, row: &[f64]) -> Result<Stack, Box<dyn Error>> {
        let layer = |numbers: &[f64]| {
            let &[tau, albedo, g] = numbers else { return Err("a layer is three numbers".into()) };
            let moments: Vec<f64> = (0..=self.moments).map(|degree| g.powi(degree as i32)).collect();
            Ok::<_, Box<dyn Error>>(Layer::new(tau, albedo, Moments::new(moments)?).with_index(self.index))
        };
        let mut layers = row.chunks(3).map(layer).collect::<Result<Vec<_>, _>>()?;
        if self.slides != 1.0 {
            layers.insert(0, Layer::pane(self.slides, 0.0));
            layers.push(Layer::pane(self.slides, 0.0));
        }
        let stack = Stack { above: 1.0, layers, below: 1.0, ground: Ground::Black };
        stack.check()?;
        Ok(stack)
    }
}

/// A row of answers for each problem.
type Values = Vec<Vec<f64>>;

/// Answers, and the processor time they took, s; `None` for a task that has no solver.
fn solve(problems: &Problems) -> Result<Option<(f64, Values)>, Box<dyn Error>> {
    match problems.task.as_str() {
        "flux" => flux(problems).map(Some),
        "radiance" => radiance(problems).map(Some),
        "adding" => adding(problems).map(Some),
        "inversion" => inversion(problems).map(Some),
        other => Err(format!("unknown task {other:?}").into()),
    }
}

/// Up at the top, down at the bottom.
fn flux(problems: &Problems) -> Result<(f64, Values), Box<dyn Error>> {
    let stacks = problems.stacks()?;
    let solver = DiscreteOrdinates::with_streams(problems.streams)?;
    let start = cpu_seconds();
    let shares = solver.shares_of(&stacks, &[problems.incidence()])?;
    let seconds = cpu_seconds() - start;
    Ok((seconds, shares.iter().map(|s| vec![s[0].reflectance, s[0].transmittance]).collect()))
}

/// By cosine, depth (the top, the bottom) and azimuth.
fn radiance(problems: &Problems) -> Result<(f64, Values), Box<dyn Error>> {
    let stacks = problems.stacks()?;
    let solver = DiscreteOrdinates {
        correct_radiance: problems.correction,
        ..DiscreteOrdinates::with_streams(problems.streams)?
    };
    let light = Light { beam: Some((problems.beam, 1.0)), ..Light::default() };
    let azimuths: Vec<f64> = problems.azimuths.iter().map(|degrees| degrees.to_radians()).collect();
    // The problems have positive cosines upward.
    let cosines: Vec<f64> = problems.cosines.iter().map(|cosine| -cosine).collect();
    let views = Views { places: &[Place::Above, Place::Below], cosines: &cosines, azimuths: &azimuths };
    let start = cpu_seconds();
    let found = stacks.iter().map(|stack| solver.radiance(stack, &light, &views)).collect::<Result<Vec<_>, _>>()?;
    let seconds = cpu_seconds() - start;
    let row = |radiances: &Radiances| {
        let mut row = Vec::with_capacity(radiances.as_slice().len());
        for cosine in 0..cosines.len() {
            for place in 0..2 {
                row.extend((0..azimuths.len()).filter_map(|azimuth| radiances.get(place, cosine, azimuth)));
            }
        }
        row
    };
    Ok((seconds, found.iter().map(row).collect()))
}

/// R and T of a beam, R and T of diffuse light. The streams asked for are those of one hemisphere.
fn adding(problems: &Problems) -> Result<(f64, Values), Box<dyn Error>> {
    let stacks = problems.stacks()?;
    let solver = AddingDoubling::with_streams(2 * problems.streams)?;
    let start = cpu_seconds();
    let shares = solver.shares_of(&stacks, &[problems.incidence(), Incidence::Diffuse])?;
    let seconds = cpu_seconds() - start;
    let values = shares.iter().map(|s| s.iter().flat_map(|s| [s.reflectance, s.transmittance]).collect()).collect();
    Ok((seconds, values))
}

/// Albedo, optical thickness and g; what is made ready once for all measurements counts.
fn inversion(problems: &Problems) -> Result<(f64, Values), Box<dyn Error>> {
    let measured = |row: &Vec<f64>| {
        let &[r, t, u] = row.as_slice() else { return Err("a measurement is three numbers") };
        let exact = |value| Some(Estimate { value, error: 0.0 });
        Ok(Measured { reflectance: exact(r), transmittance: exact(t), unscattered: exact(u) })
    };
    let all = problems.rows.iter().map(measured).collect::<Result<Vec<_>, _>>()?;
    let sample = Sample { refractive_index: problems.index, slide_index: problems.slides, ..Sample::default() };
    let start = cpu_seconds();
    let inversion = Inversion::new(sample, 2 * problems.streams)?;
    let found = all.iter().map(|measured| inversion.invert(measured)).collect::<Result<Vec<_>, _>>()?;
    let seconds = cpu_seconds() - start;
    Ok((seconds, found.iter().map(|f| vec![f.albedo, f.optical_thickness, f.asymmetry.value]).collect()))
}

/// What follows a word on the command line.
fn argument(name: &str) -> Option<String> {
    std::env::args().skip_while(|word| word != name).nth(1)
}

fn main() -> Result<(), Box<dyn Error>> {
    // Without problems there is nothing to time: `run.py` writes them.
    let (Some(workload), Some(file)) = (argument("--workload"), argument("--problems")) else { return Ok(()) };
    let problems = Problems::parse(&std::fs::read_to_string(file)?)?;
    let head = format!("\"workload\": {workload:?}, \"problems\": {}", problems.rows.len());
    match solve(&problems)? {
        None => println!("{{{head}}}"),
        // Debug prints lists as JSON has them, with all digits.
        Some((seconds, values)) => println!("{{{head}, \"cpu_seconds\": {seconds:e}, \"values\": {values:?}}}"),
    }
    Ok(())
}
