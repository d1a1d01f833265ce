//! The materials that come with the program.

macro_rules! materials {
    ($($name:literal),* $(,)?) => {
        /// Name and recipe of every built-in material, in alphabetical order.
        pub const MATERIALS: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../../../data/materials/", $name, ".toml")))),*];
    };
}

materials![
    "aerosol-continental",
    "aerosol-desert",
    "aerosol-urban",
    "cloud",
    "fog",
    "goat-milk",
    "haze",
    "ice-first-year",
    "ice-pure",
    "iceberg-green",
    "intralipid",
    "low-fat-milk",
    "paint-grey",
    "paint-red",
    "paint-tio2",
    "polystyrene-phantom",
    "raw-milk",
    "sea",
    "sea-atlantic",
    "sea-baltic",
    "sea-channel",
    "sea-ice",
    "sea-mediterranean",
    "sea-north",
    "skim-milk",
    "smoke",
    "smoke-coated",
    "snow-compacted",
    "water",
    "water-b2",
    "water-fat",
    "water-protein",
    "whole-milk",
];
