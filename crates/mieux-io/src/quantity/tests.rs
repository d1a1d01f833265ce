use super::*;
use proptest::prelude::*;

#[test]
fn lengths_are_what_they_say() {
    for (text, metres) in [
        ("550nm", 550e-9),
        ("3 mm", 3e-3),
        ("0.5um", 0.5e-6),
        ("0.5 µm", 0.5e-6),
        ("0.5 \u{3bc}m", 0.5e-6),
        ("2cm", 0.02),
        ("1 m", 1.0),
        ("1e-6 m", 1e-6),
        (" +1E3 nm ", 1e-6),
        (".5km", 500.0),
        ("5.mm", 5e-3),
        ("0 m", 0.0),
    ] {
        assert_eq!(text.parse::<Length>().unwrap().metres(), metres, "{text}");
    }
}

#[test]
fn what_is_no_length_says_what_would_be() {
    let bare = "550".parse::<Length>().unwrap_err();
    assert!(matches!(bare, QuantityError::MissingUnit { .. }), "{bare:?}");
    assert_eq!(bare.to_string(), "`550` has no unit; add one of nm, um (or µm), mm, cm, dm, m, km, as in `550nm`");
    let unit = "5 feet".parse::<Length>().unwrap_err();
    assert!(matches!(&unit, QuantityError::UnknownUnit { unit, .. } if unit == "feet"), "{unit:?}");
    for text in ["", "nm", "-", "e5 m", ".", "inf m", "NaN nm", "\u{2212}5 nm", "µ"] {
        let error = text.parse::<Length>().unwrap_err();
        assert!(matches!(error, QuantityError::NotANumber { .. }), "{text}: {error:?}");
    }
    for text in ["-1 nm", "1e999 m", "-0.1 m"] {
        let error = text.parse::<Length>().unwrap_err();
        assert!(matches!(error, QuantityError::OutOfRange { .. }), "{text}: {error:?}");
    }
    for text in ["1e99999999999 m", "1,5 nm", "1 2 nm", "5 nm nm", "0x10 m", "1_000 nm"] {
        assert!(text.parse::<Length>().is_err(), "{text}");
    }
    assert!(Length::parse_positive("0 nm").is_err());
    assert!(Length::from_metres(f64::NAN).is_err());
}

#[test]
fn wavelengths_come_as_one_a_list_or_a_range() {
    let range = parse_wavelengths("400nm:700nm:25nm").unwrap();
    assert_eq!(range.len(), 13);
    for (i, wavelength) in range.iter().enumerate() {
        assert_eq!(wavelength, format!("{}e-9", 400 + 25 * i).parse::<f64>().unwrap());
    }
    assert_eq!(parse_wavelengths("0.4um : 0.7um : 0.1um").unwrap().as_slice(), [4e-7, 5e-7, 6e-7, 7e-7]);
    assert_eq!(parse_wavelengths("550nm, 450nm,0.55um").unwrap().as_slice(), [450e-9, 550e-9]);
    assert_eq!(parse_wavelengths(" 550 nm ").unwrap().as_slice(), [550e-9]);
    for text in ["", ",", "550nm,", "400nm:700nm", "400nm:700nm:25nm:1nm", "550", "0nm", "-5nm"] {
        assert!(parse_wavelengths(text).is_err(), "{text}");
    }
    for text in ["700nm:400nm:25nm", "400nm:700nm:1e-9nm"] {
        assert!(matches!(parse_wavelengths(text), Err(QuantityError::Grid { .. })), "{text}");
    }
}

#[test]
fn sizes_have_bounds() {
    let size: Size = "640x480".parse().unwrap();
    assert_eq!((size.width(), size.height(), size.pixels()), (640, 480, 307_200));
    assert_eq!("640 × 480".parse::<Size>().unwrap(), size);
    assert!("16384x1".parse::<Size>().is_ok() && "10000x10000".parse::<Size>().is_ok());
    for text in ["0x1", "1x0", "16385x1", "10001x10000", "99999999999x1", "4294967297x1"] {
        assert!(matches!(text.parse::<Size>(), Err(QuantityError::OutOfRange { .. })), "{text}");
    }
    for text in ["", "640", "x", "640x", "640x480x3", "-1x5", "1.5x2", "axb"] {
        assert!(matches!(text.parse::<Size>(), Err(QuantityError::Form { .. })), "{text}");
    }
}

#[test]
fn durations_add_up() {
    for (text, seconds) in
        [("60s", 60.0), ("2min", 120.0), ("1.5h", 5400.0), ("250 ms", 0.25), ("1h 30min", 5400.0), ("2 min 5 s", 125.0)]
    {
        assert_eq!(parse_duration(text).unwrap(), seconds, "{text}");
    }
    for text in ["", "60", "s", "0s", "-5s", "1h -30min", "1e999s", "5 weeks", "1h30"] {
        assert!(parse_duration(text).is_err(), "{text}");
    }
}

#[test]
fn fractions_lie_above_zero_and_up_to_one() {
    assert_eq!(parse_fraction("2%").unwrap(), 0.02);
    assert_eq!(parse_fraction("0.02").unwrap(), 0.02);
    assert_eq!(parse_fraction("3.5 %").unwrap(), 0.035);
    assert_eq!(parse_fraction("100%").unwrap(), 1.0);
    for text in ["0", "0%", "101%", "1.01", "-2%", "2 percent", "%", "", "nan", "inf"] {
        assert!(parse_fraction(text).is_err(), "{text}");
    }
}

#[test]
fn refractive_indices_absorb_with_a_plus() {
    for (text, re, im) in [
        ("1.5+0.01i", 1.5, 0.01),
        ("1.33", 1.33, 0.0),
        ("1.33+1e-9i", 1.33, 1e-9),
        (" 1.33 + 1E-9 j ", 1.33, 1e-9),
        ("1.33-0i", 1.33, 0.0),
        ("1e0+2e+1i", 1.0, 20.0),
    ] {
        let n = parse_complex_index(text).unwrap();
        assert_eq!((n.re, n.im), (re, im), "{text}");
        assert!(n.im.is_sign_positive());
    }
    let negative = parse_complex_index("0.2-3i").unwrap_err();
    assert!(negative.to_string().contains("`0.2-3i`") && negative.to_string().contains("absorbs"), "{negative}");
    for text in ["", "i", "0.01i", "1.5+i", "1.5+0.01", "0+1i", "-1.33", "1.5++1i", "1.5+-1i", "1.5 0.1i", "1.3+1e999i"]
    {
        assert!(parse_complex_index(text).is_err(), "{text}");
    }
}

#[test]
fn lengths_read_well() {
    for (metres, text) in [
        (17.3e-6, "17.3 µm"),
        (550e-9, "550 nm"),
        (999.96e-9, "1 µm"),
        (1.23456e-3, "1.235 mm"),
        (0.25, "250 mm"),
        (2.5, "2.5 m"),
        (12_346.0, "12.35 km"),
        (0.0, "0 m"),
        (1e-15, "1e-15 m"),
        (f64::INFINITY, "inf m"),
    ] {
        assert_eq!(format_length(metres), text);
    }
    assert_eq!("0.1nm".parse::<Length>().unwrap().to_string(), "0.1 nm");
}

#[test]
fn areas_read_well() {
    for (square_metres, text) in [
        (1.23456e-12, "1.235 µm²"),
        (2e-14, "0.02 µm²"),
        (-7.5e-16, "-750 nm²"),
        (5e-28, "5e-10 nm²"),
        (3e-7, "0.3 mm²"),
        (0.5, "0.5 m²"),
        (0.0, "0 m²"),
    ] {
        assert_eq!(format_area(square_metres), text);
    }
}

#[test]
fn coefficients_and_times_read_well() {
    for (value, text) in [
        (57_837.2, "57840 /m"),
        (0.0123456, "0.01235 /m"),
        (5.7837e9, "5.784e9 /m"),
        (0.0, "0 /m"),
        (-2.5e-9, "-2.5e-9 /m"),
    ] {
        assert_eq!(format_per_length(value), text);
    }
    for (seconds, text) in [
        (0.0, "0 s"),
        (0.00085, "0.85 ms"),
        (0.9999, "1 s"),
        (12.34, "12.3 s"),
        (59.97, "1 min"),
        (125.0, "2 min 5 s"),
        (3599.7, "1 h"),
        (3725.0, "1 h 2 min"),
        (90_000.0, "1 d 1 h"),
    ] {
        assert_eq!(format_duration(seconds), text);
    }
}

proptest! {
    #[test]
    fn a_printed_length_parses_to_the_same_bits(mantissa in 1.0..10.0f64, exponent in -20..20i32) {
        let length = Length::from_metres(format!("{mantissa}e{exponent}").parse().unwrap()).unwrap();
        prop_assert_eq!(length.to_string().parse::<Length>().unwrap(), length);
    }

    #[test]
    fn a_short_length_parses_to_four_digits(mantissa in 1.0..10.0f64, exponent in -15..10i32) {
        let metres = mantissa * 10f64.powi(exponent);
        let parsed = format_length(metres).parse::<Length>().unwrap().metres();
        prop_assert!((parsed / metres - 1.0).abs() < 5.1e-4);
    }

    #[test]
    fn a_short_coefficient_keeps_four_digits(mantissa in 1.0..10.0f64, exponent in -15..15i32) {
        let value = mantissa * 10f64.powi(exponent);
        let parsed: f64 = format_per_length(value).trim_end_matches(" /m").parse().unwrap();
        prop_assert!((parsed / value - 1.0).abs() < 5.1e-4);
    }

    #[test]
    fn a_printed_size_parses_to_itself(width in 1..=10_000u32, height in 1..=10_000u32) {
        let size = Size::new(width, height).unwrap();
        prop_assert_eq!(size.to_string().parse::<Size>().unwrap(), size);
    }

    #[test]
    fn a_printed_duration_parses_nearly(mantissa in 1.0..10.0f64, exponent in -3..6i32) {
        let seconds = mantissa * 10f64.powi(exponent);
        let parsed = parse_duration(&format_duration(seconds)).unwrap();
        prop_assert!((parsed / seconds - 1.0).abs() < 0.03, "{seconds} {}", format_duration(seconds));
    }

    #[test]
    fn a_printed_index_parses_to_the_same_bits(re in 1e-9..1e9f64, im in 1.0..10.0f64, exponent in -300..300i32) {
        let index = Complex64::new(re, im * 10f64.powi(exponent));
        prop_assert_eq!(parse_complex_index(&format_complex_index(index)).unwrap(), index);
        let clear = Complex64::new(re, 0.0);
        prop_assert_eq!(parse_complex_index(&format_complex_index(clear)).unwrap(), clear);
    }

    #[test]
    fn no_text_panics(text in "[-+0-9.eEinfx%:, µm×sh]{0,12}|\\PC{0,8}") {
        let _ = text.parse::<Length>();
        let _ = text.parse::<Size>();
        let _ = parse_wavelengths(&text);
        let _ = parse_duration(&text);
        let _ = parse_fraction(&text);
        let _ = parse_complex_index(&text);
    }
}
