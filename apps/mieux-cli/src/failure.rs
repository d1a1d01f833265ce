//! Errors as people see them: one report, pointing at the place where there is one.

use std::process::ExitCode;

use miette::{LabeledSpan, MietteDiagnostic, NamedSource, Report};
use mieux::io::TextError;
use mieux::io::index_file::IndexFileError;
use mieux::io::paint::PaintFileError;
use mieux::io::recipe::RecipeError;
use mieux::io::rxt::RxtError;
use mieux::io::slab_file::SlabFileError;
use mieux::jobs::JobError;

/// Anything that ends the program early.
#[derive(Debug)]
pub enum Failure {
    Job(Box<JobError>),
    /// Words that do not go together.
    Usage(clap::Error),
    /// Standard output is gone or full.
    Output(std::io::Error),
}

impl From<JobError> for Failure {
    fn from(error: JobError) -> Self {
        Self::Job(Box::new(error))
    }
}

impl From<clap::Error> for Failure {
    fn from(error: clap::Error) -> Self {
        Self::Usage(error)
    }
}

impl From<RecipeError> for Failure {
    fn from(error: RecipeError) -> Self {
        JobError::from(error).into()
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Self::Output(error)
    }
}

impl Failure {
    /// Prints the error and says how the program ends: 2 for input that cannot be, 130 when interrupted, else 1.
    #[allow(clippy::print_stderr)]
    pub fn report(self) -> ExitCode {
        let error = match self {
            // Whoever was reading has seen enough.
            Self::Output(e) if e.kind() == std::io::ErrorKind::BrokenPipe => return ExitCode::SUCCESS,
            Self::Output(e) => {
                eprintln!("Error: the result could not be printed: {e}");
                return ExitCode::FAILURE;
            }
            Self::Usage(error) => {
                // Where even the error cannot be printed, the code still says it.
                let _ = error.print();
                return ExitCode::from(2);
            }
            Self::Job(error) => error,
        };
        let code = match *error {
            JobError::Cancelled => 130,
            JobError::Output(_) | JobError::Image(_) | JobError::Threads { .. } => 1,
            _ => 2,
        };
        let mut diagnostic = MietteDiagnostic::new(error.to_string());
        diagnostic.help = error.help();
        let mut report = Report::new(diagnostic.clone());
        let place: Option<&TextError> = match error.as_ref() {
            JobError::Recipe(RecipeError::Text(text))
            | JobError::SlabFile(SlabFileError::Text(text))
            | JobError::Rxt(RxtError::Text(text))
            | JobError::IndexFile(IndexFileError::Text(text))
            | JobError::PaintFile(PaintFileError::Text(text)) => Some(text),
            _ => None,
        };
        if let Some(text) = place {
            let label = LabeledSpan::new_with_span(Some("here".into()), text.span.clone());
            let plain = matches!(*error, JobError::Rxt(_) | JobError::IndexFile(_));
            let language = if plain { "text" } else { "toml" };
            report = Report::new(diagnostic.with_label(label))
                .with_source_code(NamedSource::new(&text.name, text.text.clone()).with_language(language));
        }
        eprintln!("{report:?}");
        ExitCode::from(code)
    }
}
