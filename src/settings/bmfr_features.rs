//! The features that BMFR fits, by name.

use std::fmt::{Debug, Display, Formatter, Result as FormatResult};

use toml::Value;

use super::value::{MOST_FEATURES, SettingType};

/// Features of a surface; a code is the place plus one. Twin: `factor_of` in shaders/denoise/bmfr_features.glsl.
const FACTORS: [&str; 11] = ["nx", "ny", "nz", "wx", "wy", "wz", "d", "ar", "ag", "ab", "r"];
/// The bit of a code for the root of the magnitude.
const ROOT: u16 = 16;
/// Bits of a code.
const BITS: usize = 5;
/// Factors of a feature.
const MOST_FACTORS: usize = 3;

/// A list of features, each a product of at most three factors.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct BmfrFeatures {
    /// 5 bits a factor, the first lowest; 0: the constant 1.
    codes: [u16; MOST_FEATURES],
    count: usize,
}

impl BmfrFeatures {
    /// Reads names with commas between; none if one is unknown, or there are none or too many.
    pub fn parse(text: &str) -> Option<Self> {
        let mut features = Self { codes: [0; MOST_FEATURES], count: 0 };
        for name in text.split(',') {
            *features.codes.get_mut(features.count)? = code_of(name.trim())?;
            features.count += 1;
        }
        Some(features)
    }

    /// How many there are.
    #[allow(clippy::len_without_is_empty, reason = "it is never empty")]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Codes, two a word, as shaders read them.
    pub fn words(&self) -> [u32; MOST_FEATURES / 2] {
        std::array::from_fn(|i| u32::from(self.codes[2 * i]) | u32::from(self.codes[2 * i + 1]) << 16)
    }

    fn names(&self) -> impl Iterator<Item = String> + '_ {
        self.codes[..self.count].iter().map(|&code| name_of(code))
    }
}

/// The features of Koskela et al. 2019.
impl Default for BmfrFeatures {
    fn default() -> Self {
        Self::parse("1,nx,ny,nz,wx,wy,wz,wx*wx,wy*wy,wz*wz").unwrap_or_else(|| unreachable!())
    }
}

fn code_of(name: &str) -> Option<u16> {
    let mut code = 0;
    let mut factors = 0;
    for factor in name.split('*').map(str::trim) {
        let (inner, root) = match factor.strip_prefix("sqrt(").and_then(|rest| rest.strip_suffix(')')) {
            Some(inner) => (inner, ROOT),
            None => (factor, 0),
        };
        if inner == "1" {
            continue;
        }
        let place = FACTORS.iter().position(|known| *known == inner)?;
        if factors == MOST_FACTORS {
            return None;
        }
        code |= ((place as u16 + 1) | root) << (BITS * factors);
        factors += 1;
    }
    Some(code)
}

fn name_of(mut code: u16) -> String {
    let mut factors = Vec::new();
    while code != 0 {
        let name = FACTORS.get(usize::from(code & (ROOT - 1)).wrapping_sub(1)).unwrap_or(&"1");
        factors.push(if code & ROOT == 0 { (*name).to_owned() } else { format!("sqrt({name})") });
        code >>= BITS;
    }
    if factors.is_empty() { "1".to_owned() } else { factors.join("*") }
}

impl Display for BmfrFeatures {
    fn fmt(&self, text: &mut Formatter<'_>) -> FormatResult {
        text.write_str(&self.names().collect::<Vec<_>>().join(","))
    }
}

impl Debug for BmfrFeatures {
    fn fmt(&self, text: &mut Formatter<'_>) -> FormatResult {
        Display::fmt(self, text)
    }
}

impl SettingType for BmfrFeatures {
    fn read(text: &str) -> Option<Self> {
        Self::parse(text)
    }

    fn value(self) -> Value {
        self.names().map(Value::from).collect::<Vec<_>>().into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_and_written() {
        let text = "1,nx,sqrt(nx),wx*wy,d*d*sqrt(r),ab";
        let features = BmfrFeatures::parse(" 1, nx,sqrt(nx) ,wx * wy,d*1*d*sqrt(r),ab").unwrap();
        assert_eq!((features.to_string().as_str(), features.len()), (text, 6));
        assert_eq!(BmfrFeatures::parse(text), Some(features));
        assert_eq!(
            features.words()[..3],
            [1 << 16, 17 | (4 | 5 << 5) << 16, (7 | 7 << 5 | 27 << 10) | 10 << 16]
        );
    }

    #[test]
    fn what_is_no_list_of_features_is_refused() {
        for wrong in ["", "nx,", "q", "nx*ny*nz*nx", "sqrt(nx", "nx ny", &vec!["1"; 65].join(",")] {
            assert_eq!(BmfrFeatures::parse(wrong), None, "{wrong}");
        }
        assert_eq!(BmfrFeatures::parse(&vec!["nx"; 64].join(",")).unwrap().len(), 64);
    }
}
