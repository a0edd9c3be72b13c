//! Numbers of the text: polynomials of parameters and loop indices.

/// A whole number that may depend on names: products of names, each of which comes so many times. A
/// product is the sorted list of its names, the empty one stands for the number 1; products are in order,
/// and none comes no times.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Num(Vec<(Vec<String>, i128)>);

impl From<i128> for Num {
    fn from(value: i128) -> Num {
        Num::default().plus(&[], value)
    }
}

impl From<u32> for Num {
    fn from(value: u32) -> Num {
        i128::from(value).into()
    }
}

impl Num {
    /// The number itself, if it depends on no name.
    pub fn constant(&self) -> Option<i128> {
        match &self.0[..] {
            [] => Some(0),
            [(names, times)] if names.is_empty() => Some(*times),
            _ => None,
        }
    }

    fn plus(mut self, names: &[String], times: i128) -> Num {
        match self.0.binary_search_by(|(known, _)| known[..].cmp(names)) {
            Ok(at) if self.0[at].1 + times == 0 => drop(self.0.remove(at)),
            Ok(at) => self.0[at].1 += times,
            Err(_) if times == 0 => {}
            Err(at) => self.0.insert(at, (names.to_vec(), times)),
        }
        self
    }

    /// The sum of both.
    pub fn add(&self, other: &Num) -> Num {
        other.0.iter().fold(self.clone(), |sum, (names, times)| sum.plus(names, *times))
    }

    /// The difference of both.
    pub fn sub(&self, other: &Num) -> Num {
        other.0.iter().fold(self.clone(), |sum, (names, times)| sum.plus(names, -times))
    }

    /// `self + slope * (name - at)`: what is `self` where the name's value is `at`.
    pub fn along(&self, slope: &Num, name: &str, at: i128) -> Num {
        slope.0.iter().fold(self.clone(), |sum, (names, times)| {
            let mut with_name = names.clone();
            with_name.push(name.to_owned());
            with_name.sort();
            sum.plus(&with_name, *times).plus(names, -times * at)
        })
    }

    /// The number where names have values.
    pub fn at(&self, values: &[(&str, u32)]) -> Num {
        let term = |sum: Num, (names, times): &(Vec<String>, i128)| {
            let mut left = Vec::new();
            let mut times = *times;
            for name in names {
                match values.iter().find(|(known, _)| known == name) {
                    Some((_, value)) => times *= i128::from(*value),
                    None => left.push(name.clone()),
                }
            }
            sum.plus(&left, times)
        };
        self.0.iter().fold(Num::default(), term)
    }

    /// Whether it differs from one trip of a loop to the next: parameters are in capitals.
    pub fn is_of_loop(&self) -> bool {
        self.0
            .iter()
            .flat_map(|(names, _)| names)
            .any(|name| name.chars().any(|c| c.is_ascii_lowercase()))
    }

    /// Whether it is a sum, which a product needs in brackets.
    pub fn is_sum(&self) -> bool {
        self.0.len() > 1
    }

    /// The number as Verilog.
    pub fn text(&self) -> String {
        let mut out = String::new();
        let mut terms: Vec<_> = self.0.iter().collect();
        // Positive ones first, and names before the number.
        terms.sort_by_key(|(names, times)| (*times < 0, names.is_empty()));
        for (names, times) in terms {
            let size = times.unsigned_abs();
            let sign = match (out.is_empty(), *times < 0) {
                (true, false) => "",
                (true, true) => "-",
                (false, false) => " + ",
                (false, true) => " - ",
            };
            out.push_str(sign);
            let mut factors: Vec<String> = names.clone();
            if size != 1 || names.is_empty() {
                factors.insert(0, size.to_string());
            }
            out.push_str(&factors.join("*"));
        }
        if out.is_empty() { "0".to_owned() } else { out }
    }
}
