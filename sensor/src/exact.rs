//! Numbers in JSON to the last bit, also those that JSON lacks: for `#[serde(with)]`.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::DeserializeOwned};

/// A number, or the name of one that JSON lacks: `inf`, `-inf` or `NaN`.
#[derive(Serialize, Deserialize, schemars::JsonSchema)]
#[serde(untagged)]
pub enum ExactNumber {
    /// A number.
    Number(f64),
    /// One that JSON lacks.
    Name(String),
}

/// Numbers, as JSON has them and back.
pub trait ExactNumbers: Sized {
    /// What JSON has.
    type Told: Serialize + DeserializeOwned;
    /// For JSON.
    fn tell(&self) -> Self::Told;
    /// From JSON; none of what is not a number.
    fn read(told: Self::Told) -> Option<Self>;
}

impl ExactNumbers for f64 {
    type Told = ExactNumber;

    fn tell(&self) -> ExactNumber {
        if self.is_finite() {
            ExactNumber::Number(*self)
        } else {
            ExactNumber::Name(self.to_string())
        }
    }

    fn read(told: ExactNumber) -> Option<f64> {
        match told {
            ExactNumber::Number(number) => Some(number),
            ExactNumber::Name(name) => name.parse().ok().filter(|number: &f64| !number.is_finite()),
        }
    }
}

impl<N: ExactNumbers> ExactNumbers for Option<N> {
    type Told = Option<N::Told>;

    fn tell(&self) -> Self::Told {
        self.as_ref().map(N::tell)
    }

    fn read(told: Self::Told) -> Option<Option<N>> {
        told.map_or(Some(None), |told| N::read(told).map(Some))
    }
}

impl<N: ExactNumbers> ExactNumbers for [N; 2] {
    type Told = [N::Told; 2];

    fn tell(&self) -> Self::Told {
        self.each_ref().map(N::tell)
    }

    fn read([low, high]: Self::Told) -> Option<[N; 2]> {
        Some([N::read(low)?, N::read(high)?])
    }
}

/// Writes numbers.
pub fn serialize<N: ExactNumbers, S: Serializer>(numbers: &N, to: S) -> Result<S::Ok, S::Error> {
    numbers.tell().serialize(to)
}

/// Reads numbers.
pub fn deserialize<'de, N: ExactNumbers, D: Deserializer<'de>>(from: D) -> Result<N, D::Error> {
    let unknown = || serde::de::Error::custom("a text is a number only if it is inf, -inf or NaN");
    N::read(N::Told::deserialize(from)?).ok_or_else(unknown)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize, Deserialize)]
    struct Has {
        #[serde(with = "super")]
        value: f64,
        #[serde(with = "super")]
        ends: Option<[f64; 2]>,
    }

    #[test]
    fn numbers_come_back_with_every_bit() {
        let json = |has: &Has| serde_json::to_string(has).unwrap();
        let open = Has { value: 0.1 + 0.2, ends: Some([f64::NEG_INFINITY, 5e-324]) };
        let text = r#"{"value":0.30000000000000004,"ends":["-inf",5e-324]}"#;
        assert_eq!(json(&open), text);
        let back: Has = serde_json::from_str(text).unwrap();
        assert_eq!((back.value.to_bits(), back.ends), (open.value.to_bits(), open.ends));
        let none = r#"{"value":"NaN","ends":null}"#;
        let back: Has = serde_json::from_str(none).unwrap();
        assert!(back.value.is_nan() && back.ends.is_none());
        assert_eq!(json(&back), none);
        for wrong in [r#"{"value":"1","ends":null}"#, r#"{"value":"much","ends":null}"#] {
            assert!(serde_json::from_str::<Has>(wrong).is_err(), "{wrong}");
        }
    }
}
