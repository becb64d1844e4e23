//! Numbers as text for the page: codes of 8 or 16 bits over a range, or whole numbers, little-endian, in base64.

use serde_json::{Value, json};

/// Equal steps over a range: the error of a number is at most half a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Codes {
    /// The number with code 0.
    pub low: f64,
    /// Distance between two codes.
    pub step: f64,
    /// The code of absent numbers, and in fine scales of numbers out of range.
    absent: u32,
}

impl Codes {
    /// 65 535 codes over a range.
    pub fn fine(range: [f64; 2]) -> Codes {
        Codes::with(range, u32::from(u16::MAX))
    }

    /// 255 codes over a range; numbers beyond it have the codes of its ends.
    pub fn coarse(range: [f64; 2]) -> Codes {
        Codes::with(range, u32::from(u8::MAX))
    }

    fn with([low, high]: [f64; 2], absent: u32) -> Codes {
        let step = (high - low) / f64::from(absent - 1);
        Codes {
            low,
            // A range without length has one number, which is exact for any step.
            step: if step > 0.0 { step } else { 1.0 },
            absent,
        }
    }

    /// Codes of numbers, in base64.
    pub fn encode(&self, numbers: impl Iterator<Item = f64>) -> String {
        let codes = numbers.map(|number| self.code(number));
        if self.absent == u32::from(u8::MAX) {
            return base64(codes.map(|code| code as u8));
        }
        base64(codes.flat_map(|code| (code as u16).to_le_bytes()))
    }

    fn code(&self, number: f64) -> u32 {
        let mut code = ((number - self.low) / self.step).round();
        if self.absent == u32::from(u8::MAX) {
            code = code.clamp(0.0, f64::from(self.absent - 1));
        }
        let inside = (0.0..f64::from(self.absent)).contains(&code);
        if inside { code as u32 } else { self.absent }
    }

    /// Offset and step from which the page computes numbers in another unit, `factor` times as large.
    pub fn json(&self, factor: f64) -> Value {
        json!([factor * self.low, factor * self.step])
    }
}

/// Whole numbers of 32 bits, in base64.
pub fn whole(numbers: impl Iterator<Item = u32>) -> String {
    base64(numbers.flat_map(u32::to_le_bytes))
}

/// Base64 with padding (RFC 4648, section 4).
pub fn base64(bytes: impl Iterator<Item = u8>) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let bytes: Vec<u8> = bytes.collect();
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |k: usize| u32::from(three.get(k).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for letter in 0..4 {
            let six = LETTERS[(bits >> (18 - 6 * letter) & 63) as usize];
            let there = letter <= three.len();
            text.push(if there { six as char } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bytes of a text in base64.
    fn bytes(text: &str) -> Vec<u8> {
        let six = |letter: u8| match letter {
            b'A'..=b'Z' => letter - b'A',
            b'a'..=b'z' => letter - b'a' + 26,
            b'0'..=b'9' => letter - b'0' + 52,
            b'+' => 62,
            _ => 63,
        };
        let letters = text.bytes().filter(|letter| *letter != b'=').map(six);
        let bits: Vec<bool> = letters
            .flat_map(|six| (0..6).rev().map(move |k| six >> k & 1 == 1))
            .collect();
        let byte = |bits: &[bool]| bits.iter().fold(0, |byte, bit| byte << 1 | u8::from(*bit));
        bits.chunks_exact(8).map(byte).collect()
    }

    #[test]
    fn base64_follows_the_standard() {
        let of = |text: &str| base64(text.bytes());
        let words = ["", "f", "fo", "foo", "foob", "fooba", "foobar"];
        let expected = [
            "", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy",
        ];
        assert_eq!(words.map(of), expected);
    }

    #[test]
    fn numbers_come_back_within_half_a_step() {
        let range = [-32.5, 32.5];
        let numbers: Vec<f64> = (0..=1000).map(|k| -32.5 + 0.065 * f64::from(k)).collect();
        let scale = Codes::fine(range);
        assert_eq!(scale.step, 65.0 / 65534.0);
        let text = scale.encode(numbers.iter().copied());
        let codes = bytes(&text);
        let codes = codes
            .chunks_exact(2)
            .map(|two| u16::from_le_bytes([two[0], two[1]]));
        let back = codes.map(|code| scale.low + scale.step * f64::from(code));
        let mut count = 0;
        for (number, back) in numbers.iter().zip(back) {
            assert!((number - back).abs() <= 0.5 * scale.step * (1.0 + 1e-9));
            count += 1;
        }
        assert_eq!(count, 1001);
    }

    #[test]
    fn an_absent_number_has_the_last_code() {
        let numbers = [f64::NAN, -0.1, 0.0, 1.0, 1.1];
        let fine = bytes(&Codes::fine([0.0, 1.0]).encode(numbers.into_iter()));
        assert_eq!(fine, [255, 255, 255, 255, 0, 0, 254, 255, 255, 255]);
        let coarse = bytes(&Codes::coarse([0.0, 1.0]).encode(numbers.into_iter()));
        assert_eq!(coarse, [255, 0, 0, 254, 254]);
        let flat = Codes::coarse([2.0, 2.0]);
        assert_eq!((flat.low, flat.code(2.0)), (2.0, 0));
    }

    #[test]
    fn whole_numbers_keep_their_bits() {
        assert_eq!(bytes(&whole([73_823].into_iter())), 73_823u32.to_le_bytes());
    }
}
