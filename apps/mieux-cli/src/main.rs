//! `mieux`: what a material looks like from what it is made of.

mod args;
mod diff;
mod export;
mod failure;
mod invert;
mod mie;
mod paint;
mod phase;
mod progress;
mod show;
mod sizes;
mod slab;
mod substances;

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Parser;
use mieux::jobs::{Context, Job, JobError, Merge, Report};

use args::{Cli, Command, Format};
use failure::Failure;
use progress::Bars;

fn main() -> ExitCode {
    match run(Cli::parse()) {
        Ok(code) => code,
        Err(failure) => failure.report(),
    }
}

fn run(cli: Cli) -> Result<ExitCode, Failure> {
    match cli.command {
        Command::Materials(args) => show::materials(&args)?,
        Command::Scenes => show::scenes()?,
        Command::Substances(args) => {
            let format = args.format;
            match args.job() {
                None => substances::list(format)?,
                Some(job) => {
                    if let Report::Substance(report) = run_job(&Job::Substance(job), format == Format::Table)? {
                        substances::show(&report, format)?;
                    }
                }
            }
        }
        Command::Completions { shell } => show::completions(shell),
        Command::Optics(args) => {
            let format = args.format;
            if let Report::Optics(report) = run_job(&Job::Optics(args.job()?), format == Format::Table)? {
                show::optics(&report, format)?;
            }
        }
        Command::Compare(args) => {
            let format = args.format;
            if let Report::Compare(report) = run_job(&Job::Compare(args.job()?), format == Format::Table)? {
                show::compare(&report, format)?;
            }
        }
        Command::Mie(args) => {
            let format = args.format;
            match run_job(&args.job(), format == Format::Table)? {
                Report::Mie(report) => mie::show(&report, format)?,
                Report::MieBatch(report) => mie::show_batch(&report)?,
                _ => {}
            }
        }
        Command::Sizes(args) => {
            let format = args.format;
            if let Report::Sizes(report) = run_job(&Job::Sizes(args.job()?), format == Format::Table)? {
                sizes::show(&report, format)?;
            }
        }
        Command::Phase(args) => {
            let format = args.format;
            if let Report::Phase(report) = run_job(&Job::Phase(args.job()?), format == Format::Table)? {
                phase::show(&report, format)?;
            }
        }
        Command::Slab(args) => {
            let format = args.format();
            match run_job(&args.job()?, format == Format::Table)? {
                Report::Slab(report) => slab::show(&report, format)?,
                Report::SlabCompare(report) => slab::show_comparison(&report, format)?,
                _ => {}
            }
        }
        Command::Paint(command) => {
            let (job, format) = command.job()?;
            match run_job(&job, format == Format::Table)? {
                Report::PaintFit(report) => paint::show_fit(&report, format)?,
                Report::PaintMix(report) => paint::show_mix(&report, format)?,
                Report::PaintMatch(report) => paint::show_match(&report, format)?,
                _ => {}
            }
        }
        Command::Invert(args) => {
            let format = args.format;
            if let Report::Invert(report) = run_job(&Job::Invert(args.job()), format == Format::Table)? {
                invert::show(&report, format)?;
            }
        }
        Command::Export(args) => {
            let format = args.format;
            if let Report::Export(report) = run_job(&Job::Export(args.job()?), format == Format::Table)? {
                export::show(&report, format)?;
            }
        }
        Command::Merge(args) => {
            let job = Merge { parts: args.parts, output: args.output };
            if let Report::Render(report) = run_job(&Job::Merge(job), true)? {
                show::render(&report, "");
            }
        }
        Command::Diff(args) => {
            let format = args.format;
            if let Report::Diff(report) = run_job(&Job::Diff(args.job()), format == Format::Table)? {
                return Ok(diff::show(&report, format)?);
            }
        }
        Command::Render(args) => {
            let again = args.resume_command();
            if let Report::Render(report) = run_job(&Job::Render(args.job()?), true)? {
                show::render(&report, &again);
                if report.interrupted {
                    return Ok(ExitCode::from(130));
                }
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Runs a job under progress bars; the first Ctrl-C asks it to stop at the next good point, the second ends at once.
fn run_job(job: &Job, bars: bool) -> Result<Report, JobError> {
    let cancel = Arc::new(AtomicBool::new(false));
    let bars = Bars::new(bars);
    let asked = Arc::clone(&cancel);
    let hint = bars.hint();
    // Without a handler Ctrl-C ends the program, as it does everywhere.
    let _ = ctrlc::set_handler(move || {
        if asked.swap(true, Ordering::Relaxed) {
            #[allow(clippy::exit)] // The user has asked twice.
            std::process::exit(130);
        }
        hint.stopping();
    });
    let report = job.run(&Context { sink: &|event| bars.hear(event), cancel: &cancel });
    bars.clear();
    report
}
