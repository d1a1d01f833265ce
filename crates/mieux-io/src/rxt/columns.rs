//! What stands in the columns of a row.

use super::{RxtRow, Word, Words};
use crate::text_error::TextError;

/// The columns of a file.
pub(super) enum Columns {
    /// So many measurements in the customary order, perhaps after a wavelength.
    Count(usize),
    /// One letter each.
    Letters(Vec<char>),
}

/// What the letters mean. Those that are only looked at with spheres are read and left.
const LETTERS: [(char, &str); 21] = [
    ('L', "the wavelength in nm"),
    ('r', "the total reflectance"),
    ('t', "the total transmittance"),
    ('u', "the unscattered transmittance"),
    ('b', "the optical thickness"),
    ('B', "the diameter of the beam"),
    ('c', "the fraction of unscattered light in the reflectance"),
    ('C', "the fraction of unscattered light in the transmittance"),
    ('d', "the thickness of the sample in mm"),
    ('D', "the thickness of the slides in mm"),
    ('e', "a tolerance"),
    ('g', "the asymmetry"),
    ('M', "the number of spheres"),
    ('n', "the refractive index of the sample"),
    ('N', "the refractive index of the slides"),
    ('q', "a number of quadrature points"),
    ('R', "the reflectance of the standard"),
    ('S', "the number of spheres"),
    ('T', "the reflectance of the transmission standard"),
    ('w', "the reflectance of the wall"),
    ('W', "the reflectance of the wall of the transmission sphere"),
];

/// What the measurements of a row are, in the customary order.
const MEASUREMENTS: [&str; 7] = [
    "the total reflectance",
    "the total transmittance",
    "the unscattered transmittance",
    "the reflectance of the wall",
    "the reflectance of the wall of the transmission sphere",
    "the reflectance of the standard",
    "the reflectance of the transmission standard",
];

impl Columns {
    /// From the line after the header.
    ///
    /// # Errors
    /// Where it is neither a number of measurements nor letters that mean something.
    pub fn parse(words: &Words, legend: &[Word]) -> Result<Self, Box<TextError>> {
        let (Some(first), Some(last)) = (legend.first(), legend.last()) else {
            return Err(words.at_end("the file ends after its header".into()).with_help(HELP));
        };
        let span = first.span.start..last.span.end;
        if let ([_], Ok(count)) = (legend, first.text.parse::<usize>())
            && (1..=7).contains(&count)
        {
            return Ok(Self::Count(count));
        }
        if first.text.starts_with(|c: char| !c.is_alphabetic()) {
            let text: Vec<&str> = legend.iter().map(|word| word.text).collect();
            let message = format!("`{}` is neither a number of measurements nor column letters", text.join(" "));
            return Err(words.at(span, message).with_help(HELP));
        }
        let mut letters = Vec::new();
        for word in legend {
            for letter in word.text.chars().filter(|c| *c != '-') {
                if !LETTERS.iter().any(|(known, _)| *known == letter) {
                    let message = format!("no column is called `{letter}`");
                    let known: Vec<String> = LETTERS.iter().map(|(letter, what)| format!("{letter}: {what}")).collect();
                    return Err(words.at(word.span.clone(), message).with_help(known.join("; ")));
                }
                if letters.contains(&letter) {
                    return Err(words.at(word.span.clone(), format!("there are two columns `{letter}`")));
                }
                letters.push(letter);
            }
        }
        if !letters.iter().any(|letter| "rtu".contains(*letter)) {
            return Err(words.at(span, "no column is a measurement".into()).with_help("r, t or u is needed"));
        }
        Ok(Self::Letters(letters))
    }

    /// From one line.
    ///
    /// # Errors
    /// Where it has more or fewer words than columns, or a word is no number.
    pub fn row(
        &self,
        words: &Words,
        line: &[Word],
        mut row: RxtRow,
        spheres: &mut u32,
    ) -> Result<RxtRow, Box<TextError>> {
        match self {
            Self::Count(count) => {
                let measured = match line {
                    [wavelength, rest @ ..] if line.len() == count + 1 => {
                        let value = words.number(wavelength, "the wavelength in nm")?;
                        row.wavelength = Some(positive(words, wavelength, value, "the wavelength")? * 1e-9);
                        rest
                    }
                    all if all.len() == *count => all,
                    _ => {
                        let expected = format!("{count} (or {} with a wavelength)", count + 1);
                        return Err(ragged(words, line, &expected));
                    }
                };
                let mut values = [None; 7];
                for ((value, word), what) in values.iter_mut().zip(measured).zip(MEASUREMENTS) {
                    *value = Some(words.number(word, what)?);
                }
                [row.reflectance, row.transmittance, row.unscattered, ..] = values;
            }
            Self::Letters(letters) => {
                if line.len() != letters.len() {
                    return Err(ragged(words, line, &letters.len().to_string()));
                }
                for (letter, word) in letters.iter().zip(line) {
                    set(words, *letter, word, &mut row, spheres)?;
                }
            }
        }
        Ok(row)
    }
}

const HELP: &str = "after the 17 numbers of the header comes the number of measurements in a row (1 to 7), or a letter for \
                    each column as in `L r t u`";

fn ragged(words: &Words, line: &[Word], expected: &str) -> Box<TextError> {
    let span = line.first().map_or(0, |w| w.span.start)..line.last().map_or(0, |w| w.span.end);
    let message = format!("the row has {} numbers, not {expected}", line.len());
    words.at(span, message).with_help("what is not meant to be read stands after `#`")
}

fn positive(words: &Words, word: &Word, value: f64, what: &str) -> Result<f64, Box<TextError>> {
    if value > 0.0 {
        return Ok(value);
    }
    Err(words.at(word.span.clone(), format!("{what} {value} is not more than 0")))
}

fn set(words: &Words, letter: char, word: &Word, row: &mut RxtRow, spheres: &mut u32) -> Result<(), Box<TextError>> {
    let what = LETTERS.iter().find(|(known, _)| *known == letter).map_or("a number", |(_, what)| what);
    let value = words.number(word, what)?;
    match letter {
        'L' => row.wavelength = Some(positive(words, word, value, "the wavelength")? * 1e-9),
        'r' => row.reflectance = Some(value),
        't' => row.transmittance = Some(value),
        'u' => row.unscattered = Some(value),
        'b' => row.optical_thickness = Some(value),
        'c' => row.specular_in_reflectance = value,
        'C' => row.unscattered_in_transmittance = value,
        'd' => row.thickness = value * 1e-3,
        'D' if value == 0.0 => row.slide_index = 1.0,
        'g' => row.asymmetry = Some(value),
        'n' => row.refractive_index = value,
        'N' => row.slide_index = if value == 0.0 { 1.0 } else { value },
        'M' | 'S' => {
            if ![0.0, 1.0, 2.0].contains(&value) {
                let message = format!("{value} spheres: 0, 1 or 2 are used at a time");
                return Err(words.at(word.span.clone(), message));
            }
            *spheres = (*spheres).max(value as u32);
        }
        _ => {}
    }
    Ok(())
}
