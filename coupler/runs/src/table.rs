//! Tables of numbers: the comma-separated files of a run.

use std::path::Path;

use scenario::error::{Error, Refusal};

/// Columns of numbers, in the order of the file. Columns with a word in any row are left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Name and numbers of each column, all of one length.
    pub columns: Vec<(String, Vec<f64>)>,
}

impl Table {
    /// Reads a file; `None` if it does not exist.
    ///
    /// # Errors
    /// The file cannot be read, or a row has more or fewer cells than there are names.
    pub fn read(path: &Path) -> Result<Option<Table>, Error> {
        if !path.exists() {
            return Ok(None);
        }
        let text = std::fs::read_to_string(path).map_err(Error::input(path.display()))?;
        let table = Table::parse(&text).map(Some);
        Ok(table.map_err(|problem| Refusal::file(path, problem))?)
    }

    /// Reads the complete rows of a file; empty if it cannot be read. A killed run may have left a part of its last
    /// row.
    pub fn read_whole_rows(path: &Path) -> Table {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        let names = text.lines().next().unwrap_or_default().split(',').count();
        let whole = text.lines().filter(|line| line.split(',').count() == names);
        Table::parse(&Vec::from_iter(whole).join("\n")).unwrap_or_default()
    }

    /// The columns of a text; the error says what is wrong.
    pub fn parse(text: &str) -> Result<Table, String> {
        let mut lines = text.lines();
        let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
        let mut columns: Vec<Option<Vec<f64>>> = vec![Some(Vec::new()); names.len()];
        for (row, line) in lines.enumerate() {
            let cells: Vec<&str> = line.split(',').collect();
            if cells.len() != names.len() {
                let (line, cells, columns) = (row + 2, cells.len(), names.len());
                return Err(format!(
                    "line {line} has {cells} cells, but the first line names {columns} columns"
                ));
            }
            for (column, cell) in columns.iter_mut().zip(cells) {
                match (&mut *column, cell.parse::<f64>()) {
                    (Some(numbers), Ok(number)) => numbers.push(number),
                    _ => *column = None,
                }
            }
        }
        let named = names.into_iter().zip(columns);
        let numbers = named.filter_map(|(name, column)| Some((name.to_string(), column?)));
        Ok(Table {
            columns: numbers.collect(),
        })
    }

    /// Adds a column.
    pub fn add(&mut self, name: &str, numbers: Vec<f64>) {
        self.columns.push((name.into(), numbers));
    }

    /// The chosen columns, in the order of their names.
    pub fn chosen(&self, is_chosen: impl Fn(&str) -> bool) -> Vec<(&str, &[f64])> {
        let all = self.columns.iter();
        let all = all.map(|(name, numbers)| (name.as_str(), &numbers[..]));
        let mut chosen: Vec<(&str, &[f64])> = all.filter(|(name, _)| is_chosen(name)).collect();
        chosen.sort_by_key(|(name, _)| *name);
        chosen
    }

    /// The numbers of a column.
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        let mut columns = self.columns.iter();
        let found = columns.find(|(known, _)| known == name);
        found.map(|(_, numbers)| numbers.as_slice())
    }

    /// The name in this table of a column of another run. It is the same name or, if only one participant of each run
    /// has it, the name with another prefix: a run of one solver leaves out the participant's name.
    pub fn name_of(&self, name: &str, other: &Table) -> Option<&str> {
        if let Some((own, _)) = self.columns.iter().find(|(own, _)| own == name) {
            return Some(own);
        }
        let only = |table: &'_ Table| {
            let alike = table.columns.iter().enumerate();
            let mut alike = alike.filter(|(_, (known, _))| last_part(known) == last_part(name));
            let found = alike.next().map(|(index, _)| index);
            found.filter(|_| alike.next().is_none())
        };
        only(other)?;
        Some(&self.columns[only(self)?].0)
    }

    /// Renames a column; false if there is no column of the old name.
    pub fn rename(&mut self, old: &str, new: &str) -> bool {
        let mut columns = self.columns.iter_mut();
        let found = columns.find(|(name, _)| name == old);
        found.map(|(name, _)| *name = new.into()).is_some()
    }
}

/// A name without its participant.
fn last_part(name: &str) -> &str {
    name.rsplit('.').next().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_of_one_participant_is_found_under_another_prefix() {
        let table = |names: &str| Table::parse(names).expect("a table");
        let coupled = table("t_s,rail.kinetic_j,grains.kinetic_j,grains.wheel_y_m");
        let alone = table("t_s,kinetic_j,wheel_y_m,a.b_m,c.b_m");
        let name = |name| alone.name_of(name, &coupled);
        assert_eq!(name("grains.wheel_y_m"), Some("wheel_y_m"));
        assert_eq!(
            coupled.name_of("wheel_y_m", &alone),
            Some("grains.wheel_y_m")
        );
        assert_eq!(name("t_s"), Some("t_s"));
        // Two participants have it, here or there.
        assert_eq!(name("rail.kinetic_j"), None);
        assert_eq!(coupled.name_of("kinetic_j", &alone), None);
        assert_eq!(alone.name_of("d.b_m", &table("d.b_m")), None);
    }

    #[test]
    fn a_column_is_renamed() {
        let mut table = Table::parse("t_s,y_m\n0,1").expect("a table");
        assert!(table.rename("y_m", "a.y_m") && !table.rename("y_m", "z"));
        assert_eq!(table.get("a.y_m"), Some(&[1.0][..]));
    }
    use kit::scratch::Scratch;

    #[test]
    fn columns_of_numbers_are_read_and_words_are_left_out() {
        let table = Table::parse("x_m,status,p_pa\n-1e-3,open,0e0\n2e-3,tied,5e6\n");
        let table = table.expect("it is one");
        assert_eq!(table.get("x_m"), Some([-1e-3, 2e-3].as_slice()));
        assert_eq!(table.get("p_pa"), Some([0.0, 5e6].as_slice()));
        assert_eq!(table.get("status"), None);
    }

    #[test]
    fn a_row_that_was_cut_off_is_an_error_with_its_line() {
        let error = Table::parse("a,b\n1,2\n3").expect_err("a cell is missing");
        assert!(
            error.contains("line 3") && error.contains("1 cells"),
            "{error}"
        );
    }

    #[test]
    fn an_incomplete_last_row_of_a_killed_run_is_not_read() {
        let scratch = Scratch::new("table", 1);
        std::fs::create_dir_all(scratch.path()).expect("a folder");
        let path = scratch.path().join("signals.csv");
        std::fs::write(&path, "b.x,a.x\n1,2\n3").expect("a file");
        let table = Table::read_whole_rows(&path);
        let chosen = table.chosen(|name| name.ends_with(".x"));
        assert_eq!(chosen, [("a.x", &[2.0][..]), ("b.x", &[1.0][..])]);
        let none = Table::read_whole_rows(&scratch.path().join("profile.csv"));
        assert_eq!(none.get("t_s"), None);
    }
}
