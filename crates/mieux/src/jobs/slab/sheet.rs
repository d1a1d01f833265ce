//! Where the light goes in slabs, as it is shown, tabulated, plotted and written down.

use mieux_io::plot::{Figure, Panel, Scale, Series, srgb_hex};
use mieux_io::quantity::format_length;
use mieux_io::recipe::Material;
use mieux_io::table::Table;
use mieux_optics::spectrum::WavelengthGrid;
use mieux_optics::transfer::{Shares, Stack};
use serde_json::{Map, Value, json};

use super::super::JobError;
use super::colour::linear_srgb;
use super::stacks::Stacks;
use super::{Answer, Case, Slab, Solver};

/// Names of shares, and how to take them.
pub(super) type Quantity = (&'static str, fn(&Shares) -> f64);
pub(super) const QUANTITIES: [Quantity; 5] = [
    ("reflectance", |shares| shares.reflectance),
    ("transmittance", |shares| shares.transmittance),
    ("absorptance", |shares| shares.absorptance),
    ("reflectance_specular", |shares| shares.reflectance_specular),
    ("transmittance_unscattered", |shares| shares.transmittance_unscattered),
];

/// Slabs, and where the light goes in each.
#[derive(Debug, Clone, PartialEq)]
pub struct SlabSheet {
    /// What the slabs are made of.
    pub title: String,
    /// The material that was asked for.
    pub material: Option<Material>,
    /// The wavelengths; none for what is alike at all of them.
    pub grid: Option<WavelengthGrid>,
    /// The slabs.
    pub cases: Vec<Case>,
    /// Slab by slab, wavelength by wavelength.
    pub answers: Vec<Answer>,
    /// Total optical thickness, in the order of the answers; infinite for half-spaces.
    pub optical_thickness: Vec<f64>,
    /// How it was solved.
    pub solver: Solver,
    /// With how many streams, if with any.
    pub streams: Option<usize>,
    /// With how many photons for each answer, if with any.
    pub photons: Option<u64>,
    /// What was done to tables of phase functions.
    pub notes: Vec<String>,
    /// Light and surroundings: names and values.
    setting: Vec<(&'static str, String)>,
}

/// The colours of one slab under D65 for the CIE 1931 observer.
#[derive(Debug, Clone, PartialEq)]
pub struct Patch {
    /// Which slab: as [`Case::label`].
    pub label: String,
    /// Of the light that comes back, linear sRGB.
    pub reflected: [f64; 3],
    /// Of the light that passes, linear sRGB.
    pub transmitted: [f64; 3],
}

/// Optical thickness of all layers.
pub(super) fn depth(stack: &Stack) -> f64 {
    let sum: f64 = stack.layers.iter().map(|layer| layer.optical_thickness).sum();
    // What stands for a half-space.
    if sum >= super::stacks::ENDLESS { f64::INFINITY } else { sum }
}

impl SlabSheet {
    pub(super) fn new(slab: &Slab, stacks: Stacks, answers: Vec<Answer>) -> Self {
        let solver = slab.solver.resolved();
        let mut setting = vec![("light", slab.light.to_string()), ("backing", slab.backing.to_string())];
        if slab.contact {
            setting.push(("backing in contact", "yes".into()));
        }
        if slab.index_outside != 1.0 {
            setting.push(("index outside", slab.index_outside.to_string()));
        }
        if let Some(index) = slab.slides {
            setting.push(("index of slides", index.to_string()));
        }
        Self {
            title: stacks.title,
            material: stacks.material,
            grid: stacks.grid,
            cases: stacks.cases,
            answers,
            optical_thickness: stacks.stacks.iter().map(depth).collect(),
            solver,
            streams: solver.has_streams().then(|| slab.streams()),
            photons: solver.has_photons().then(|| slab.photons()),
            notes: stacks.notes,
            setting,
        }
    }

    /// How many wavelengths each slab has; 1 for what is alike at all.
    fn width(&self) -> usize {
        self.grid.as_ref().map_or(1, WavelengthGrid::len)
    }

    /// The answers of a slab.
    fn of_case(&self, case: usize) -> &[Answer] {
        &self.answers[case * self.width()..(case + 1) * self.width()]
    }

    /// One entry for each answer: what its slab says.
    fn by_case(&self, value: impl Fn(&Case) -> f64) -> Vec<f64> {
        self.cases.iter().flat_map(|case| std::iter::repeat_n(value(case), self.width())).collect()
    }

    /// The wavelengths of all answers in nanometres, a round number staying round.
    fn nanometres(&self) -> Option<Vec<f64>> {
        let grid = self.grid.as_ref()?;
        let round = || grid.iter().map(|w| (w * 1e9 * 1e6).round() / 1e6);
        Some((0..self.cases.len()).flat_map(|_| round()).collect())
    }

    fn has_errors(&self) -> bool {
        self.answers.iter().any(|answer| answer.errors.is_some())
    }

    /// One value for each answer.
    fn values(&self, pick: fn(&Shares) -> f64) -> Vec<f64> {
        self.answers.iter().map(|answer| pick(&answer.shares)).collect()
    }

    /// One standard error for each answer, where photons were counted.
    fn errors(&self, pick: fn(&Shares) -> f64) -> Vec<f64> {
        self.answers.iter().map(|answer| answer.errors.as_ref().map_or(f64::NAN, pick)).collect()
    }

    /// The colour of each slab.
    pub fn patches(&self) -> Vec<Patch> {
        let colour = |case: usize, pick: fn(&Shares) -> f64| {
            let shares: Vec<f64> = self.of_case(case).iter().map(|answer| pick(&answer.shares)).collect();
            linear_srgb(self.grid.as_ref(), &shares)
        };
        let patch = |(i, case): (usize, &Case)| Patch {
            label: case.label.clone(),
            reflected: colour(i, |shares| shares.reflectance),
            transmitted: colour(i, |shares| shares.transmittance),
        };
        self.cases.iter().enumerate().map(patch).collect()
    }

    fn solver_in_words(&self) -> String {
        if self.solver.is_approximate() { format!("{}, approximate", self.solver) } else { self.solver.to_string() }
    }

    /// What was computed and how, in words: names and values.
    pub fn settings(&self) -> Vec<(String, String)> {
        let mut all: Vec<(String, String)> = Vec::new();
        if let Some(material) = &self.material {
            all.push(("material".into(), material.name.clone()));
            all.extend(material.inputs.iter().map(|(i, value)| (i.name.to_string(), i.shown(*value))));
        }
        all.extend(self.setting.iter().map(|(name, value)| ((*name).to_owned(), value.clone())));
        all.push(("solver".into(), self.solver_in_words()));
        all.extend(self.streams.map(|streams| ("streams".to_owned(), streams.to_string())));
        all.extend(self.photons.map(|photons| ("photons".to_owned(), photons.to_string())));
        all.extend(self.notes.iter().map(|note| ("phase function".to_owned(), note.clone())));
        all
    }

    /// As a table, with units in the column names and what was computed in its head. Nothing for the thickness of what
    /// has none.
    ///
    /// # Errors
    /// Never; the table checks the lengths of its columns.
    pub fn table(&self) -> Result<Table, JobError> {
        let mut table = Table::new(self.title.clone());
        for (name, value) in self.settings() {
            table = table.with_metadata(name, value);
        }
        for Patch { label, reflected, transmitted } in self.patches() {
            let label = if label.is_empty() { "colour".to_owned() } else { format!("colour of {label}") };
            let colours = format!("reflected {}, transmitted {}", srgb_hex(reflected), srgb_hex(transmitted));
            table = table.with_metadata(label, colours);
        }
        if self.cases.iter().any(|case| case.thickness_m.is_some()) {
            table = table.with_column("thickness", "m", self.by_case(|case| case.thickness_m.unwrap_or(f64::NAN)))?;
        }
        table = table.with_column("optical_thickness", "", self.optical_thickness.clone())?;
        if let Some(wavelengths) = self.nanometres() {
            table = table.with_column("wavelength", "nm", wavelengths)?;
        }
        for (name, pick) in QUANTITIES {
            table = table.with_column(name, "", self.values(pick))?;
            if self.has_errors() {
                table = table.with_column(format!("{name}_se"), "", self.errors(pick))?;
            }
        }
        Ok(table)
    }

    /// As JSON: arrays of one length, an entry for each slab and wavelength; plain numbers for one abstract slab. What
    /// has no end, or no value, is null.
    pub fn json(&self) -> Value {
        let mut value = Map::new();
        value.insert("title".into(), json!(self.title));
        if let Some(material) = &self.material {
            let inputs: Map<String, Value> =
                material.inputs.iter().map(|(input, value)| (input.name.to_string(), json!(value))).collect();
            value.insert("material".into(), json!(material.name));
            value.insert("inputs".into(), Value::Object(inputs));
        }
        for (name, text) in &self.setting {
            value.insert(name.replace(' ', "_"), json!(text));
        }
        value.insert("solver".into(), json!(self.solver));
        value.insert("streams".into(), json!(self.streams));
        if self.photons.is_some() {
            value.insert("photons".into(), json!(self.photons));
        }
        let single = self.grid.is_none() && self.cases.len() == 1;
        let numbers = |values: Vec<f64>| if single { json!(values[0]) } else { json!(values) };
        value.insert("thickness_m".into(), numbers(self.by_case(|case| case.thickness_m.unwrap_or(f64::NAN))));
        value.insert("optical_thickness".into(), numbers(self.optical_thickness.clone()));
        if let Some(wavelengths) = self.nanometres() {
            value.insert("wavelength_nm".into(), json!(wavelengths));
        }
        for (name, pick) in QUANTITIES {
            value.insert(name.into(), numbers(self.values(pick)));
            if self.has_errors() {
                value.insert(format!("{name}_se"), numbers(self.errors(pick)));
            }
        }
        let patch = |patch: Patch, case: &Case| {
            json!({
                "label": patch.label,
                "thickness_m": case.thickness_m,
                "reflected": srgb_hex(patch.reflected),
                "transmitted": srgb_hex(patch.transmitted),
                "reflected_linear_srgb": patch.reflected,
                "transmitted_linear_srgb": patch.transmitted,
            })
        };
        let patches = self.patches().into_iter().zip(&self.cases).map(|(p, case)| patch(p, case));
        value.insert("swatches".into(), Value::Array(patches.collect()));
        if !self.notes.is_empty() {
            value.insert("notes".into(), json!(self.notes));
        }
        Value::Object(value)
    }

    /// The figure, as SVG: shares over wavelength, a line for each slab; of one wavelength, shares over thickness, or a bar
    /// of one slab; and the colours.
    ///
    /// # Errors
    /// [`JobError::Plot`].
    pub fn svg(&self) -> Result<String, JobError> {
        let mut title = self.title.clone();
        if let [case] = self.cases.as_slice()
            && !case.label.is_empty()
        {
            title += &format!(", {}", case.label);
        }
        if let Some([wavelength]) = self.grid.as_ref().map(WavelengthGrid::as_slice) {
            title += &format!(", {}", format_length(*wavelength));
        }
        let figure = if self.width() > 1 {
            self.spectra(&title)
        } else {
            self.over_thickness(&title).unwrap_or_else(|| self.bar(&title))
        };
        Ok(self.with_swatches(figure).to_svg()?)
    }

    fn spectra(&self, title: &str) -> Figure {
        let nanometres = self.nanometres().unwrap_or_default();
        let mut figure = Figure::new(title, if self.transmits() { 3 } else { 2 });
        for (name, pick) in &QUANTITIES[..3] {
            if *name == "transmittance" && !self.transmits() {
                continue;
            }
            let mut panel = Panel::new(capitalised(name), "Wavelength in vacuum (nm)", capitalised(name))
                .with_scales(Scale::Linear, Scale::LinearOver(0.0, 1.0));
            for (i, case) in self.cases.iter().enumerate() {
                let answers = self.of_case(i);
                let points = nanometres.iter().copied().zip(answers.iter().map(|answer| pick(&answer.shares)));
                let errors = answers.iter().filter_map(|answer| answer.errors.as_ref().map(pick));
                panel = panel.with_series(Series::new(case.label.clone(), points).with_errors(errors));
            }
            figure = figure.with_panel(panel);
        }
        figure
    }

    /// `None` unless there are at least two slabs of different finite thickness.
    fn over_thickness(&self, title: &str) -> Option<Figure> {
        let in_millimetres = self.cases.iter().all(|case| case.thickness_m.is_some());
        let x: Vec<f64> = match in_millimetres {
            true => self.cases.iter().map(|case| 1e3 * case.thickness_m.unwrap_or(f64::NAN)).collect(),
            false => self.optical_thickness.clone(),
        };
        let mut order: Vec<usize> = (0..x.len()).filter(|i| x[*i] > 0.0 && x[*i].is_finite()).collect();
        order.sort_by(|a, b| x[*a].total_cmp(&x[*b]));
        let (first, last) = (x[*order.first()?], x[*order.last()?]);
        if first == last {
            return None;
        }
        let label = if in_millimetres { "Thickness (mm)" } else { "Optical thickness" };
        let scale = if last > 5.0 * first { Scale::Log } else { Scale::Linear };
        let mut panel = Panel::new("", label, "Share of the light").with_scales(scale, Scale::LinearOver(0.0, 1.0));
        for (name, pick) in &QUANTITIES[..3] {
            let points = order.iter().map(|i| (x[*i], pick(&self.answers[*i].shares)));
            let errors = order.iter().filter_map(|i| self.answers[*i].errors.as_ref().map(pick));
            panel = panel.with_series(Series::new(*name, points).with_errors(errors));
        }
        Some(Figure::new(title, 1).with_panel(panel))
    }

    /// One slab at one wavelength: the first, where all are alike.
    fn bar(&self, title: &str) -> Figure {
        let Some(Answer { shares, .. }) = self.answers.first() else { return Figure::new(title, 1) };
        Figure::new(title, 1)
            .with_share("specular", shares.reflectance_specular)
            .with_share("scattered back", shares.reflectance - shares.reflectance_specular)
            .with_share("absorbed", shares.absorptance)
            .with_share("passed scattered", shares.transmittance - shares.transmittance_unscattered)
            .with_share("passed unscattered", shares.transmittance_unscattered)
    }

    fn with_swatches(&self, figure: Figure) -> Figure {
        let patches = self.patches();
        let named = |what: &str, label: &str| match label {
            "" => what.to_owned(),
            label => format!("{} {what}", label.replace(' ', "\u{a0}")),
        };
        let mut figure = patches
            .iter()
            .fold(figure, |figure, patch| figure.with_swatch(named("reflected", &patch.label), patch.reflected));
        if self.transmits() {
            for patch in &patches {
                figure = figure.with_swatch(named("transmitted", &patch.label), patch.transmitted);
            }
        }
        figure
    }

    /// Whether any light passes.
    fn transmits(&self) -> bool {
        self.answers.iter().any(|answer| answer.shares.transmittance > 1e-9)
    }

    /// A line that says how it was computed.
    pub fn summary(&self) -> String {
        let mut text: Vec<String> = self.setting.iter().map(|(name, value)| format!("{name} {value}")).collect();
        text.push(match (self.streams, self.photons) {
            (Some(streams), _) => format!("{}, {streams} streams", self.solver),
            (_, Some(photons)) => format!("{}, {photons} photons each", self.solver),
            _ => self.solver_in_words(),
        });
        text.join("; ")
    }

    /// What a slab is called in a list: its label, or else its thickness.
    pub fn name_of(case: &Case) -> String {
        match case.thickness_m {
            _ if !case.label.is_empty() => case.label.clone(),
            Some(metres) if metres.is_finite() => format_length(metres),
            _ => String::new(),
        }
    }
}

fn capitalised(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
