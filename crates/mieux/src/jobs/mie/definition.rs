//! The definitions of scattering, by the names they are written down with.

use mieux_optics::mie::ScatteringDefinition;
use serde::{Deserialize, Serialize};

/// What scattering means where the host absorbs; in a lossless one the definitions agree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Definition {
    /// [`ScatteringDefinition::Frisvad2007`].
    #[default]
    Frisvad2007,
    /// [`ScatteringDefinition::MishchenkoYang2018`].
    MishchenkoYang2018,
}

impl Definition {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Frisvad2007, Self::MishchenkoYang2018];

    /// As it is written down.
    pub fn name(self) -> &'static str {
        match self {
            Self::Frisvad2007 => "frisvad2007",
            Self::MishchenkoYang2018 => "mishchenko-yang2018",
        }
    }

    /// What it means, in a few words.
    pub fn about(self) -> &'static str {
        match self {
            Self::Frisvad2007 => "power projected back to the particle's surface, over the mean incident power on it",
            Self::MishchenkoYang2018 => {
                "what a far detector receives, over the intensity that would be at the particle's centre"
            }
        }
    }
}

impl From<Definition> for ScatteringDefinition {
    fn from(definition: Definition) -> Self {
        match definition {
            Definition::Frisvad2007 => Self::Frisvad2007,
            Definition::MishchenkoYang2018 => Self::MishchenkoYang2018,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_what_is_written_down() {
        for definition in Definition::ALL {
            assert_eq!(serde_json::to_value(definition).unwrap(), definition.name());
        }
    }
}
