//! Columns as the caller lists them: by number or by name.

use super::IoError;
use super::columns::{ImuColumns, SLOTS};
use super::names::missing;
use super::rows::Header;
use std::path::Path;
use std::str::FromStr;

/// One column.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Column {
    /// Its index from 0.
    At(usize),
    /// Its name in the header, whatever the case.
    Named(String),
}

/// Seven columns in ASL's order: stamp, gyroscope x y z, accelerometer x y z. Read from text such as `1,2,3,4,5,6,7` (from 1) or
/// `time,wx,wy,wz,5,6,7`; six of a log without stamps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnChoice {
    time: Option<Column>,
    axes: [Column; 6],
}

impl FromStr for ColumnChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let column = |text: &str| match text.trim().parse::<usize>() {
            Ok(0) => None,
            Ok(number) => Some(Column::At(number - 1)),
            Err(_) => {
                Some(text.trim()).filter(|name| !name.is_empty()).map(|name| Column::Named(name.to_owned()))
            }
        };
        let all: Option<Vec<Column>> = text.split(',').map(column).collect();
        let wrong = || {
            "seven columns, by number from 1 or by the header's names: stamp (not with --rate), gyroscope x y z, accelerometer x y z, \
             for example 1,2,3,4,5,6,7 or time,gx,gy,gz,ax,ay,az"
                .to_owned()
        };
        let mut all = all.filter(|all| all.len() == 6 || all.len() == 7).ok_or_else(wrong)?;
        match (1..all.len()).find(|&i| all[..i].contains(&all[i])) {
            Some(i) => {
                let column = text.split(',').nth(i).expect("it was read from there").trim();
                Err(format!("column {column} is there twice; seven columns that differ are needed"))
            }
            None => {
                let time = (all.len() == 7).then(|| all.remove(0));
                Ok(Self { time, axes: all.try_into().expect("six are left") })
            }
        }
    }
}

impl From<ImuColumns> for ColumnChoice {
    fn from(columns: ImuColumns) -> Self {
        let ImuColumns { time, gyro: [gx, gy, gz], accel: [ax, ay, az], .. } = columns;
        Self { time: Some(Column::At(time)), axes: [gx, gy, gz, ax, ay, az].map(Column::At) }
    }
}

impl ColumnChoice {
    /// As indices; `counted` where stamps are, and a column of them is not needed.
    ///
    /// # Errors
    /// A name that the header, or a file without one, does not have.
    pub(crate) fn resolve(
        &self,
        header: Option<&Header>,
        path: &Path,
        counted: bool,
    ) -> Result<ImuColumns, IoError> {
        let empty = Header { line: 1, names: Vec::new() };
        let header = header.unwrap_or(&empty);
        if self.time.is_none() && !counted {
            return Err(missing(header, path, SLOTS[0]));
        }
        let mut at = [0; 7];
        let first = usize::from(self.time.is_none());
        for (at, column) in at[first..].iter_mut().zip(self.time.iter().chain(&self.axes)) {
            *at = match column {
                Column::At(index) if !header.names.is_empty() && *index >= header.names.len() => {
                    return Err(missing(header, path, &(index + 1).to_string()));
                }
                Column::At(index) => *index,
                Column::Named(name) => {
                    let exact = header.names.iter().position(|one| one == name);
                    let similar = || header.names.iter().position(|one| one.eq_ignore_ascii_case(name));
                    // A unit in brackets need not be typed.
                    let bare = |one: &String| {
                        one.split(['[', '(']).next().expect("a split has a first part").trim().to_owned()
                    };
                    let without = || header.names.iter().position(|one| bare(one).eq_ignore_ascii_case(name));
                    exact.or_else(similar).or_else(without).ok_or_else(|| missing(header, path, name))?
                }
            };
        }
        Ok(ImuColumns::new(at[0], [at[1], at[2], at[3]], [at[4], at[5], at[6]]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_names_mix_and_what_is_neither_says_what_is_wanted() {
        let header =
            Header { line: 3, names: ["T", "p", "q", "r", "u", "v", "w"].map(str::to_owned).to_vec() };
        let resolve = |text: &str| {
            text.parse::<ColumnChoice>().unwrap().resolve(Some(&header), Path::new("f.csv"), false)
        };
        assert_eq!(resolve("1,2,3,4,5,6,7").unwrap(), ImuColumns::ASL);
        assert_eq!(resolve("t, u,v,w, 2,3,4").unwrap(), ImuColumns::new(0, [4, 5, 6], [1, 2, 3]));
        let error = resolve("t,u,v,x,2,3,4").unwrap_err().to_string();
        assert_eq!(error, "f.csv:3: no column `x`; the header names T, p, q, r, u, v, w");
        let named =
            Header { names: header.names.iter().map(|n| format!("{n} [m/s]")).collect(), ..header.clone() };
        let by_name = "T,p,q,r,u,v,w".parse::<ColumnChoice>().unwrap();
        assert_eq!(by_name.resolve(Some(&named), Path::new("f.csv"), false).unwrap(), ImuColumns::ASL);
        let six = "2,3,4,5,6,7".parse::<ColumnChoice>().unwrap();
        assert_eq!(six.resolve(None, Path::new("f.csv"), true).unwrap(), ImuColumns::ASL);
        assert!(six.resolve(None, Path::new("f.csv"), false).is_err());
        assert!(resolve("1,2,3,4,5,6,9").unwrap_err().to_string().starts_with("f.csv:3: no column `9`"));
        let twice = "1,2,3,4,5,6,6".parse::<ColumnChoice>().unwrap_err();
        assert!(twice.starts_with("column 6 is there twice"), "{twice}");
        for bad in ["", "1,2,3", "0,1,2,3,4,5,6", "1,2,3,4,5,6,", "1,2,3,4,5,6,7,8"] {
            assert!(bad.parse::<ColumnChoice>().unwrap_err().starts_with("seven columns"), "{bad}");
        }
        assert!(
            "t,2,3,4,5,6,7"
                .parse::<ColumnChoice>()
                .unwrap()
                .resolve(None, Path::new("f.csv"), false)
                .is_err()
        );
    }
}
