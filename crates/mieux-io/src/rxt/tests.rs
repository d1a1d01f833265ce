use super::*;

const HEAD: &str =
    "IAD1 # a file\n1.4 1.5\n2.0 1.0 # mm\n2 0.99\n0\n203.2 25.4 12.7 12.7 0.96\n203.2 25.4 12.7 12.7 0.96\n";

fn parse(rows: &str) -> Result<Rxt, Box<TextError>> {
    Rxt::parse("a.rxt", &format!("{HEAD}{rows}"))
}

#[test]
fn rows_by_count_with_and_without_wavelength() {
    let file = parse("2 # measurements\n\n#nm R T\n 800\t0.168 0.249 # one\n0.2 0.3\n").unwrap();
    assert_eq!((file.spheres, file.rows.len()), (0, 2));
    let row = &file.rows[0];
    assert_eq!((row.line, row.reflectance, row.transmittance, row.unscattered), (11, Some(0.168), Some(0.249), None));
    assert_eq!((row.refractive_index, row.slide_index, row.thickness), (1.4, 1.5, 2e-3));
    assert!((row.wavelength.unwrap() - 800e-9).abs() < 1e-20 && file.rows[1].wavelength.is_none());
    // What belongs to spheres is read and left.
    let file = parse("4\n500 0.1 0.2 0.01 0.97\n").unwrap();
    assert_eq!(file.rows[0].unscattered, Some(0.01));
}

#[test]
fn rows_by_letters() {
    let file = parse(" L r  t-u d n N g c C b D\r\n500 .3 .2 .1 0.5 1.33 0 .8 0 .5 7 1\r\n").unwrap();
    let row = &file.rows[0];
    assert_eq!((row.reflectance, row.transmittance, row.unscattered), (Some(0.3), Some(0.2), Some(0.1)));
    assert_eq!((row.thickness, row.refractive_index, row.slide_index), (5e-4, 1.33, 1.0));
    assert_eq!((row.asymmetry, row.optical_thickness), (Some(0.8), Some(7.0)));
    assert_eq!((row.specular_in_reflectance, row.unscattered_in_transmittance), (0.0, 0.5));
    assert_eq!(parse("r S\n.3 1\n").unwrap().spheres, 1);
}

#[test]
fn errors_point_at_the_place() {
    let at = |rows: &str| {
        let error = parse(rows).unwrap_err();
        (error.line, error.column, error.message.clone())
    };
    let (line, column, message) = at("2\n800 0.1 0.2\n810 0.1\n820 0.1 0.2 0.3\n");
    assert_eq!((line, column), (11, 1));
    assert!(message.contains("4 numbers, not 2 (or 3 with a wavelength)"), "{message}");
    assert_eq!(at("2\n0.1\n").0, 9);
    assert_eq!(at("2\n0.1 x\n"), (9, 5, "`x` is not a number; here stands the total transmittance".into()));
    assert!(at("2\n-5 0.1 0.1\n").2.contains("wavelength -5"));
    assert!(at("0.5\n0.1 0.2\n").2.contains("neither a number of measurements"));
    assert!(at("8\n0.1 0.2\n").2.contains("neither a number of measurements"));
    assert!(at("r z\n0.1 0.2\n").2.contains("`z`") && at("r r\n0.1 0.2\n").2.contains("two columns"));
    assert!(at("L g\n500 0.2\n").2.contains("no column is a measurement"));
    assert!(at("2\n").2.contains("no measurements") && at("").2.contains("ends after its header"));
    let error = |text: &str| Rxt::parse("a.rxt", text).unwrap_err();
    assert!(error("IAD2\n").message.contains("IAD1") && error("").message.contains("IAD1"));
    let short = error("IAD1\n1.4 1.5\n");
    assert!(short.message.contains("2 of the 17") && short.help.clone().unwrap().contains("thickness"), "{short:?}");
    assert!(error("IAD1\n1.4 glass\n").to_string().starts_with("a.rxt, line 2, column 5"));
    assert!(error(&HEAD.replace("\n0\n", "\n3\n")).message.contains("3 spheres"));
}

proptest::proptest! {
    #[test]
    fn no_text_panics(text in "(IAD1)?[ \n\r0-9.eErtuLSgx#é-]{0,200}") {
        let _ = Rxt::parse("a.rxt", &text);
        let _ = parse(&text);
    }
}
