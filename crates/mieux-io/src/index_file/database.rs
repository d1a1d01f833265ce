//! The database as a folder: a catalogue of shelves, books and pages.

use std::path::{Path, PathBuf};

use mieux_optics::substance::Dispersion;

use super::yaml::{self, Node};
use super::{IndexFileError, parse_index, read_text};
use crate::text_error::{did_you_mean, nearest_names};

/// A copy of the refractiveindex.info database.
#[derive(Debug, Clone, PartialEq)]
pub struct IndexDatabase {
    folder: PathBuf,
    pages: Vec<Page>,
}

/// A page: one index of one substance.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Page {
    /// Shelf, book and page, joined by `/`: `main/TiO2/Devore-o`.
    pub name: String,
    /// What its heading says.
    pub title: String,
    /// Its file, below the folder `data`.
    pub file: PathBuf,
}

impl IndexDatabase {
    /// The database in a folder, which holds `catalog-nk.yml` and `data` or has a folder `database` that does.
    ///
    /// # Errors
    /// [`IndexFileError`].
    pub fn open(folder: &Path) -> Result<Self, IndexFileError> {
        let places = [folder.to_path_buf(), folder.join("database")];
        let Some(folder) = places.into_iter().find(|place| place.join("catalog-nk.yml").is_file()) else {
            return Err(IndexFileError::NoDatabase { path: folder.into() });
        };
        let path = folder.join("catalog-nk.yml");
        let root = yaml::read(&path.to_string_lossy(), &read_text(&path)?)?;
        let mut pages = Vec::new();
        for shelf in root.iter().flat_map(children) {
            for book in contents(shelf) {
                for page in contents(book) {
                    let names = [shelf.text_of("SHELF"), book.text_of("BOOK"), page.text_of("PAGE")];
                    let [Some(shelf), Some(book), Some(name)] = names else { continue };
                    let Some(file) = page.text_of("data") else { continue };
                    pages.push(Page {
                        name: format!("{shelf}/{book}/{name}"),
                        title: page.text_of("name").unwrap_or(name).into(),
                        file: file.into(),
                    });
                }
            }
        }
        Ok(Self { folder, pages })
    }

    /// All its pages, in the order of the catalogue.
    pub fn pages(&self) -> &[Page] {
        &self.pages
    }

    /// The page of that name: `main/TiO2/Devore-o`, or `TiO2/Devore-o` where one shelf alone has it. Case does not matter,
    /// nor whether a blank is an underscore.
    ///
    /// # Errors
    /// [`IndexFileError::Page`], with the nearest names.
    pub fn find(&self, name: &str) -> Result<&Page, IndexFileError> {
        let wanted = plain(name);
        let full = |page: &&Page| plain(&page.name) == wanted;
        if let Some(page) = self.pages.iter().find(full) {
            return Ok(page);
        }
        let short = |page: &&Page| plain(&page.name).split_once('/').is_some_and(|(_, short)| short == wanted);
        let found: Vec<&Page> = self.pages.iter().filter(short).collect();
        match found[..] {
            [page] => Ok(page),
            [] => Err(self.unknown(name, &wanted)),
            _ => {
                let names: Vec<&str> = found.iter().map(|page| page.name.as_str()).collect();
                let message = format!("more than one page of the database is called `{name}`");
                Err(IndexFileError::Page { message, help: format!("say which: {}", names.join(", ")) })
            }
        }
    }

    /// The index on a page.
    ///
    /// # Errors
    /// [`IndexFileError`].
    pub fn read(&self, page: &Page) -> Result<Dispersion, IndexFileError> {
        let path = self.folder.join("data").join(&page.file);
        parse_index(&page.name, &path.to_string_lossy(), &read_text(&path)?)
    }

    fn unknown(&self, name: &str, wanted: &str) -> IndexFileError {
        // Pages of the book that was meant say more than names that look alike.
        let book = wanted.rsplit('/').nth(1).unwrap_or(wanted);
        let of_book = |page: &&Page| plain(&page.name).split('/').nth(1) == Some(book);
        let pages: Vec<&str> = self.pages.iter().filter(of_book).map(|page| page.name.as_str()).collect();
        let message = format!("the database has no page `{name}`");
        let help = if pages.is_empty() {
            let full = wanted.split('/').count() > 2;
            let named = |page: &Page| {
                let plain = plain(&page.name);
                if full { plain } else { plain.split_once('/').map_or(plain.clone(), |(_, short)| short.into()) }
            };
            let names: Vec<String> = self.pages.iter().map(named).collect();
            let nearest = nearest_names(wanted, names.iter().map(String::as_str));
            let written: Vec<&str> = nearest
                .iter()
                .filter_map(|near| names.iter().position(|n| n == near))
                .map(|i| self.pages[i].name.as_str())
                .collect();
            let hint = did_you_mean(&written);
            format!("{hint} a page is shelf/book/page, as in main/SiO2/Malitson").trim_start().to_owned()
        } else {
            let shown = pages.len().min(12);
            let more = if pages.len() > shown { ", ..." } else { "" };
            format!("that book has {}{more}", pages[..shown].join(", "))
        };
        IndexFileError::Page { message, help }
    }
}

/// A name as it is compared.
fn plain(name: &str) -> String {
    name.trim().to_lowercase().replace(' ', "_")
}

fn children(node: &Node) -> &[Node] {
    node.list().unwrap_or_default()
}

fn contents(node: &Node) -> &[Node] {
    node.get("content").map(children).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CATALOGUE: &str = r#"
- DIVIDER: "Research data"
- SHELF: main
  name: "MAIN"
  content:
    - DIVIDER: "x"
    - BOOK: SiO2
      name: "silica"
      content:
        - DIVIDER: "Experiments"
        - PAGE: Malitson
          name: "Malitson 1965"
          data: main/SiO2/nk/Malitson.yml
        - PAGE: Rodriguez-de Marcos
          name: "2016"
          data: "main/SiO2/nk/Rodriguez-de Marcos.yml"
- SHELF: glass
  content:
    - BOOK: SiO2
      content:
        - PAGE: Malitson
          data: glass/Malitson.yml
"#;

    #[test]
    fn pages_are_found_by_their_names() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(IndexDatabase::open(folder.path()), Err(IndexFileError::NoDatabase { .. })));
        let nested = folder.path().join("database/data/main/SiO2/nk");
        std::fs::create_dir_all(&nested).unwrap();
        std::fs::write(folder.path().join("database/catalog-nk.yml"), CATALOGUE).unwrap();
        let silica = "DATA:\n- type: formula 1\n  wavelength_range: 0.21 6.7\n  coefficients: \
                      0 0.6961663 0.0684043 0.4079426 0.1162414 0.8974794 9.896161\n";
        std::fs::write(nested.join("Malitson.yml"), silica).unwrap();
        let database = IndexDatabase::open(folder.path()).unwrap();
        assert_eq!(database.pages().len(), 3);
        let page = database.find("main/SiO2/Malitson").unwrap();
        assert_eq!(page.title, "Malitson 1965");
        let index = database.read(page).unwrap().assume_transparent().index(587.56e-9).unwrap();
        assert!((index.re - 1.45846).abs() < 1e-5);
        assert_eq!(database.find("sio2/rodriguez-de_marcos").unwrap().name, "main/SiO2/Rodriguez-de Marcos");
        let help = |name: &str| database.find(name).unwrap_err().help().unwrap();
        assert_eq!(help("SiO2/Malitson"), "say which: main/SiO2/Malitson, glass/SiO2/Malitson");
        assert!(help("main/SiO2/Malison").starts_with("that book has main/SiO2/Malitson"));
        assert!(help("main/SiO/Malitson").starts_with("did you mean `main/SiO2/Malitson`"));
    }
}
