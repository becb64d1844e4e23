//! Random changes of inputs.

/// Words that readers treat specially.
const WORDS: [&str; 26] = [
    "0",
    "-1",
    "1e308",
    "-1e-308",
    "nan",
    "inf",
    "9223372036854775807",
    "18446744073709551616",
    "4294967295",
    "1e9",
    "\"\"",
    "\"\\u0000\"",
    "[]",
    "[[]]",
    "{}",
    "true",
    "null",
    "\n",
    "\0",
    "=",
    "..",
    "../..",
    "participant",
    "$Nodes\n",
    "$EndElements\n",
    "\u{202e}",
];

/// Makes changed inputs; the same name gives the same inputs.
pub struct Mutator(u64);

impl Mutator {
    /// Each name has its own sequence.
    pub fn new(name: &str) -> Mutator {
        let seed = name.bytes().fold(2026, |seed: u64, byte| {
            seed.wrapping_mul(31).wrapping_add(byte.into())
        });
        Mutator(seed)
    }

    /// A linear congruential generator (Knuth 1997, vol. 2, 3.3.4); below `end`.
    fn below(&mut self, end: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % end.max(1)
    }

    /// One of the inputs with one to four changes.
    pub fn change(&mut self, corpus: &[Vec<u8>]) -> Vec<u8> {
        let mut input = corpus[self.below(corpus.len())].clone();
        for _ in 0..=self.below(4) {
            let other = &corpus[self.below(corpus.len())];
            self.once(&mut input, other);
        }
        input
    }

    fn once(&mut self, input: &mut Vec<u8>, other: &[u8]) {
        let at = self.below(input.len() + 1);
        let length = 1 + self.below(64);
        let piece = at..(at + length).min(input.len());
        match self.below(8) {
            0 if !input.is_empty() => {
                let at = at.min(input.len() - 1);
                input[at] ^= 1 << self.below(8);
            }
            1 if !input.is_empty() => {
                let at = at.min(input.len() - 1);
                input[at] = self.below(256) as u8;
            }
            2 => input.truncate(at),
            3 => drop(input.drain(piece)),
            4 => {
                let copy = input[piece].to_vec();
                let to = self.below(input.len() + 1);
                input.splice(to..to, copy);
            }
            5 => {
                let from = self.below(other.len());
                let donor = &other[from..(from + length).min(other.len())];
                input.splice(piece, donor.iter().copied());
            }
            6 => self.number(input),
            _ => {
                let word = WORDS[self.below(WORDS.len())];
                input.splice(at..at, word.bytes());
            }
        }
    }

    /// Replaces the rest of a number by a word.
    fn number(&mut self, input: &mut Vec<u8>) {
        let digits: Vec<usize> = (0..input.len())
            .filter(|i| input[*i].is_ascii_digit())
            .collect();
        if digits.is_empty() {
            return;
        }
        let start = digits[self.below(digits.len())];
        let end = (start..input.len()).find(|i| !input[*i].is_ascii_digit());
        let word = WORDS[self.below(10)];
        input.splice(start..end.unwrap_or(input.len()), word.bytes());
    }
}
