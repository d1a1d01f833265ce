//! The materials that come with the program.

macro_rules! materials {
    ($($name:literal),* $(,)?) => {
        /// Name and recipe of every built-in material, in alphabetical order.
        pub const MATERIALS: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../../../data/materials/", $name, ".toml")))),*];
    };
}

materials!["low-fat-milk", "skim-milk", "water", "water-b2", "water-fat", "water-protein", "whole-milk"];
